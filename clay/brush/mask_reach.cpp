#include "clay/brush/mask_reach.h"

#include <algorithm>
#include <cmath>

namespace argil::clay {
namespace {

constexpr float kNear = 0.5f;  // of the surface: some voxel of every place of it is
// voxels: places that are farther than the nearest by less count too, as a rim would be jagged without
constexpr double kBlend = 1;
constexpr int kRegionBits = 3, kRegion = 1 << kRegionBits;  // bricks along an edge of what is read at once
constexpr int kPart = 4;                                    // voxels along an edge of what is decided at once
// So far from the surface (voxels, squared) a cover is a mean over many places, up to √(2·distance) to each side on
// flat clay. It changes slowly there: the corners of a part are enough, or those of a whole brick farther out.
constexpr int64_t kPartsByCorners = 12 * 12, kBricksByCorners = 64 * 64;
// Reaches that are looked for: each half as large again as the one before.
constexpr double kLeastReach = 16, kReachStep = 1.5;

// The farthest place that may count where one is known to be within the root of `nearest`.
double farthest(int64_t nearest) {
  const double root = std::sqrt(static_cast<double>(nearest)) + kBlend;
  return root * root;
}

}  // namespace

const std::vector<MaskReach::BrickPlaces>& MaskReach::region(Coord region) {
  const auto [entry, fresh] = regions_.try_emplace(region);
  if (!fresh) return entry->second;
  for (int i = 0; i < kRegion * kRegion * kRegion; ++i) {
    const Coord coord = region * kRegion + Coord{i / (kRegion * kRegion), i / kRegion % kRegion, i % kRegion};
    const Slot slot = start_.find(coord);
    if (slot.isTile()) continue;
    const ChannelSlot mask = start_.find(Channel::mask, coord);
    const Coord low = coord * kBrickEdge;
    std::array<Places, 8> parts;
    BrickPlaces found;
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (!(std::abs(slot.brick()->phi(v)) <= kNear)) continue;
      const Coord in{v >> 6, (v >> 3) & 7, v & 7}, voxel = low + in;
      Places& part = parts[static_cast<size_t>(in.x / kPart * 4 + in.y / kPart * 2 + in.z / kPart)];
      if (part.places.empty()) part.box = {voxel, voxel};
      part.box.low = {std::min(part.box.low.x, voxel.x), std::min(part.box.low.y, voxel.y),
                      std::min(part.box.low.z, voxel.z)};
      part.box.high = {std::max(part.box.high.x, voxel.x), std::max(part.box.high.y, voxel.y),
                       std::max(part.box.high.z, voxel.z)};
      const int cover = mask.value(v);
      part.least = std::min(part.least, cover);
      part.most = std::max(part.most, cover);
      part.places.push_back({voxel, cover});
    }
    for (Places& part : parts) {
      if (part.places.empty()) continue;
      found.least = std::min(found.least, part.least);
      found.most = std::max(found.most, part.most);
      found.parts.push_back(std::move(part));
    }
    if (found.parts.empty()) continue;
    found.box = {low, low + Coord{kBrickEdge - 1, kBrickEdge - 1, kBrickEdge - 1}};
    entry->second.push_back(std::move(found));
  }
  return entry->second;
}

// Bricks with places that may count for a voxel of the box, from the inside outwards until no farther one may.
std::vector<const MaskReach::BrickPlaces*> MaskReach::around(const Box& box, double reach) {
  constexpr int kEdge = kRegion * kBrickEdge;
  std::vector<const BrickPlaces*> found;
  const auto limit = static_cast<int64_t>(reach * reach);
  int64_t nearest = limit;
  const Coord middle = (box.low >> kBrickBits) >> kRegionBits;
  for (int ring = 0;; ++ring) {
    // All regions of this ring and farther ones lie beyond so many voxels.
    const double beyond = static_cast<double>(ring - 1) * kEdge;
    if (ring > 0 && (beyond > reach || beyond * beyond > farthest(nearest))) break;
    for (int x = -ring; x <= ring; ++x)
      for (int y = -ring; y <= ring; ++y) {
        const bool side = std::abs(x) == ring || std::abs(y) == ring;
        for (int z = -ring; z <= ring; z += side || ring == 0 ? 1 : 2 * ring) {
          const Coord at = middle + Coord{x, y, z}, low = at * kEdge;
          const Box whole{low, low + Coord{kEdge - 1, kEdge - 1, kEdge - 1}};
          if (static_cast<double>(leastBetween(whole, box)) > farthest(nearest)) continue;
          for (const BrickPlaces& each : region(at)) {
            const int64_t least = leastBetween(each.box, box);
            if (least > limit || static_cast<double>(least) > farthest(nearest)) continue;
            found.push_back(&each);
            nearest = std::min(nearest, mostBetween(each.box, box));
          }
        }
      }
  }
  return found;
}

// Drops groups of which no place may count for a voxel of the box; `nearest`: one of the others is within its root of
// every voxel, or it is `limit`.
template <class Group>
void MaskReach::keepNearest(const Box& box, int64_t limit, std::vector<const Group*>& groups, int64_t& nearest) {
  nearest = limit;
  for (const Group* each : groups) nearest = std::min(nearest, mostBetween(each->box, box));
  const double most = farthest(nearest);
  std::erase_if(groups, [&](const Group* each) { return static_cast<double>(leastBetween(each->box, box)) > most; });
}

const MaskCover& MaskReach::at(Coord brick, double reach) {
  Known& known = known_[brick];
  if (known.reach >= reach) return known.cover;
  known.reach = kLeastReach;
  while (known.reach < reach) known.reach *= kReachStep;
  MaskCover& cover = known.cover = {};
  const auto limit = static_cast<int64_t>(known.reach * known.reach);
  const Coord low = brick * kBrickEdge;
  const Box box{low, low + Coord{kBrickEdge - 1, kBrickEdge - 1, kBrickEdge - 1}};
  std::vector<const BrickPlaces*> bricks = around(box, known.reach);
  int64_t nearest = 0;
  keepNearest(box, limit, bricks, nearest);
  if (std::all_of(bricks.begin(), bricks.end(), [](const BrickPlaces* each) { return each->most == 0; })) return cover;
  cover.none = false;
  if (nearest < limit &&
      std::all_of(bricks.begin(), bricks.end(), [](const BrickPlaces* each) { return each->least == 255; })) {
    cover.whole = true;
    cover.value.fill(255);
    return cover;
  }
  const auto isFar = [&](const BrickPlaces* each) { return leastBetween(each->box, box) >= kBricksByCorners; };
  if (std::all_of(bricks.begin(), bricks.end(), isFar)) {
    coverBox(box, low, limit, bricks, cover);
  } else {
    for (int i = 0; i < 8; ++i) {
      const Coord from = low + Coord{i >> 2, (i >> 1) & 1, i & 1} * kPart;
      coverBox({from, from + Coord{kPart - 1, kPart - 1, kPart - 1}}, low, limit, bricks, cover);
    }
  }
  cover.none = std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 0; });
  cover.whole = std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 255; });
  return cover;
}

void MaskReach::coverBox(const Box& box, Coord low, int64_t limit, const std::vector<const BrickPlaces*>& around,
                         MaskCover& cover) {
  std::vector<const Places*> near;
  for (const BrickPlaces* each : around)
    for (const Places& places : each->parts) near.push_back(&places);
  int64_t nearest = 0;
  keepNearest(box, limit, near, nearest);
  if (std::all_of(near.begin(), near.end(), [](const Places* each) { return each->most == 0; })) return;
  const auto value = [&](Coord in) -> uint8_t& {
    return cover.value[static_cast<size_t>(Brick::offset(in.x, in.y, in.z))];
  };
  const Coord first = box.low - low, last = box.high - low;
  const auto forEach = [&](const auto& visit) {
    for (int x = first.x; x <= last.x; ++x)
      for (int y = first.y; y <= last.y; ++y)
        for (int z = first.z; z <= last.z; ++z) visit(Coord{x, y, z});
  };
  if (nearest < limit && std::all_of(near.begin(), near.end(), [](const Places* each) { return each->least == 255; }))
    return forEach([&](Coord in) { value(in) = 255; });
  candidates_.clear();
  int64_t beyond = INT64_MAX;
  for (const Places* each : near) {
    beyond = std::min(beyond, leastBetween(each->box, box));
    for (const Place& place : each->places) {
      const Coord from = place.voxel - low;
      candidates_.add(from.x, from.y, from.z, place.cover);
    }
  }
  candidates_.close();
  if (beyond < kPartsByCorners) return forEach([&](Coord in) { value(in) = coverAt(in, limit); });
  int corner[8];
  for (int i = 0; i < 8; ++i) {
    corner[i] = coverAt({i & 4 ? last.x : first.x, i & 2 ? last.y : first.y, i & 1 ? last.z : first.z}, limit);
  }
  // Whole numbers: mirrored clay has mirrored covers.
  const int edge = last.x - first.x, all = edge * edge * edge;
  forEach([&](Coord in) {
    const Coord to = in - first;
    int sum = 0;
    for (int i = 0; i < 8; ++i)
      sum += corner[i] * (i & 4 ? to.x : edge - to.x) * (i & 2 ? to.y : edge - to.y) * (i & 1 ? to.z : edge - to.z);
    value(in) = static_cast<uint8_t>((sum + all / 2) / all);
  });
}

uint8_t MaskReach::coverAt(Coord at, int64_t limit) {
  compared_ += candidates_.size();
  const double nearest = candidates_.nearestSquared(at.x, at.y, at.z);
  if (nearest > static_cast<double>(limit)) return 0;
  compared_ += candidates_.size();
  return static_cast<uint8_t>(candidates_.mean(at.x, at.y, at.z, nearest, kBlend));
}

// A tool that stands on the surface reaches clay as deep as it is wide.
std::optional<MaskCover> coverDuring(const Editor& editor, MaskReach* reach, Coord coord, double radius) {
  const float band = editor.grid().band;
  const ChannelSlot mask = editor.find(Channel::mask, coord);
  MaskCover cover;
  Slot began;
  if (reach && mask != ChannelSlot(true)) {
    cover = reach->at(coord, 2 * radius + static_cast<double>(band));
    began = reach->start().find(coord);
  }
  if (began.isTile() && mask == ChannelSlot()) return cover.none ? std::nullopt : std::optional(cover);
  for (int i = 0; i < kBrickVoxels; ++i) {
    uint8_t& value = cover.value[static_cast<size_t>(i)];
    value = std::abs(began.phi(i, band)) < band ? mask.value(i) : std::max(value, mask.value(i));
  }
  if (std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 0; })) return std::nullopt;
  cover.none = false;
  cover.whole = std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 255; });
  return cover;
}

void putBack(const MaskCover& mask, bool inPart, const float* source, float (&value)[kBrickVoxels]) {
  for (int i = 0; i < kBrickVoxels; ++i) {
    const uint8_t cover = mask.value[static_cast<size_t>(i)];
    if (cover == 255)
      value[i] = source[i];
    else if (cover > 0 && inPart)
      value[i] = source[i] + (value[i] - source[i]) * (static_cast<float>(255 - cover) / 255.0f);
  }
}

}  // namespace argil::clay
