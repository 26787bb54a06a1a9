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
  constexpr size_t kAhead = 8;
  Coord last{INT32_MIN, 0, 0};
  SurfaceRegion* in = nullptr;
  std::vector<Coord> empty;
  delta.changed.reserve(replaced.meshes.size());
  for (size_t i = 0; i < replaced.meshes.size(); ++i) {
    // Handing a mesh out counts it, which is all that is done with it.
    if (i + kAhead < replaced.meshes.size()) __builtin_prefetch(replaced.meshes[i + kAhead].second.get(), 1);
    auto& [brick, mesh] = replaced.meshes[i];
    if (brick >> 3 != last || !in) {
      if (in && in->count == 0) empty.push_back(last);
      last = brick >> 3;
      std::unique_ptr<SurfaceRegion>& region = regions[last];
      if (!region) region = std::make_unique<SurfaceRegion>();
      in = region.get();
    }
    HeldPtr& held = in->held.at(static_cast<size_t>(Brick::offset(brick.x & 7, brick.y & 7, brick.z & 7)));
    in->count += (mesh ? 1 : 0) - (held ? 1 : 0);
    std::swap(held, mesh);
    if (held) {
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
  vertexCount += static_cast<uint64_t>(replaced.vertices);
  quadCount += static_cast<uint64_t>(replaced.quads);
  bricksThatReadBeyond += static_cast<uint64_t>(replaced.readBeyond);
  replaced.vertices = -replaced.vertices;
  replaced.quads = -replaced.quads;
  replaced.readBeyond = -replaced.readBeyond;
  std::swap(replaced.bytes, replaced.bytesThere);
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
