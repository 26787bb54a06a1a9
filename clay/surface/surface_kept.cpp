// Meshes that an update replaced, kept for the way back.

#include <iterator>

#include "clay/surface/surface_state.h"

namespace argil::clay {

uint64_t bytesOf(const HeldMesh& held) {
  return sizeof(HeldMesh) + held.positions.size_bytes() + held.normals.size_bytes() + held.quads.size_bytes() +
         held.table.specials.size_bytes() + held.table.sharp.size_bytes();
}

std::vector<ReplacedMeshes>::iterator Surface::State::findKept(const Version& next) {
  return std::find_if(kept.begin(), kept.end(), [&](const ReplacedMeshes& each) {
    return version && each.from == version.id() && each.to == next.id();
  });
}

void Surface::State::swap(ReplacedMeshes& replaced, SurfaceDelta& delta) {
  Coord last{INT32_MIN, 0, 0};
  SurfaceRegion* in = nullptr;
  std::vector<Coord> empty;
  const auto count = [&](const HeldMesh& held, int64_t sign) {
    in->count += static_cast<int>(sign);
    vertexCount += static_cast<uint64_t>(sign * held.table.vertices);
    quadCount += static_cast<uint64_t>(sign * static_cast<int64_t>(held.quads.size()));
    bricksThatReadBeyond += static_cast<uint64_t>(sign * held.table.readsBeyond);
  };
  replaced.bytes = 0;
  delta.changed.reserve(replaced.meshes.size());
  for (auto& [brick, mesh] : replaced.meshes) {
    if (brick >> 3 != last || !in) {
      if (in && in->count == 0) empty.push_back(last);
      last = brick >> 3;
      std::unique_ptr<SurfaceRegion>& region = regions[last];
      if (!region) region = std::make_unique<SurfaceRegion>();
      in = region.get();
    }
    HeldPtr& held = in->held.at(static_cast<size_t>(Brick::offset(brick.x & 7, brick.y & 7, brick.z & 7)));
    std::swap(held, mesh);
    if (mesh) {
      count(*mesh, -1);
      replaced.bytes += bytesOf(*mesh);
    }
    if (held) {
      count(*held, 1);
      delta.changed.push_back(held);
      continue;
    }
    auto none = std::make_shared<BrickMesh>();
    none->brick = brick;
    none->serial = none->vertexSerial = nextSerial++;
    delta.changed.push_back(std::move(none));
  }
  if (in && in->count == 0) empty.push_back(last);
  for (const Coord region : empty) regions.erase(region);
  std::swap(replaced.from, replaced.to);
}

void Surface::State::keep(ReplacedMeshes replaced, uint64_t most) {
  kept.push_back(std::move(replaced));
  uint64_t bytes = 0;
  auto first = kept.end();
  while (first != kept.begin() && bytes + std::prev(first)->bytes <= most) bytes += (--first)->bytes;
  kept.erase(kept.begin(), first);
}

bool Surface::keeps(const Version& version) const {
  return state_->findKept(version) != state_->kept.end() && !hasChannels(version) && !hasChannels(state_->version);
}

}  // namespace argil::clay
