// Which bricks an application has to look at.

#include <algorithm>
#include <cmath>

#include "clay/brush/brush_method.h"
#include "clay/store/brick_set.h"

namespace argil::clay {
namespace {

// Where clay may come farther than so many bricks, cubes of them are asked first: by rings most bricks would be far
// from where it comes.
constexpr int kMostRings = 2;
constexpr int kRegion = 8, kLeastCube = 2;

bool isReached(const DistanceMethod& method, std::span<const Stamp> images, Coord first, int edge) {
  return std::any_of(images.begin(), images.end(), [&](const Stamp& s) {
    return segmentDistance(s, middleOf(first, edge)) - halfDiagonal(edge) < method.reach(s);
  });
}

// Those of regions of `surface` and `voxels` around them in which the method may change anything, by halving.
std::vector<Coord> byCubes(const Editor& editor, const DistanceMethod& method, std::span<const Stamp> images,
                           std::span<const Coord> surface, double voxels) {
  BrickSet set;
  for (const Coord coord : surface) set.add(coord >> 3);
  std::vector<Coord> regions = set.sorted();
  for (double far = 0; far < voxels; far += kRegion * kBrickEdge) regions = withNeighbours(regions);
  std::vector<Coord> all;
  Sampler field(editor);
  const auto halve = [&](const auto& again, Coord first, int edge) -> void {
    if (!isReached(method, images, first, edge) || !method.mayChange(field, first, edge)) return;
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i) {
      const Coord part = first + Coord{i >> 2, i >> 1 & 1, i & 1} * half;
      if (edge > kLeastCube)
        again(again, part, half);
      else if (isReached(method, images, part, 1))
        all.push_back(part);
    }
  };
  for (const Coord region : regions) halve(halve, region * kRegion, kRegion);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

std::vector<Coord> reachedBricks(const Editor& editor, const DistanceMethod& method, std::span<const Stamp> images,
                                 double moved, Tile goal) {
  std::vector<Coord> all;
  Sampler field(editor);  // as near reads are cheap by it
  // The band moves along.
  const double travel = method.travel(moved), voxels = travel + static_cast<double>(editor.grid().band);
  const int rings = travel < 0 ? 0 : std::max(1, static_cast<int>(std::ceil(voxels / kBrickEdge)));
  for (const Stamp& s : images) {
    const double reach = method.reach(s), margin = kBrickEdge * rings;
    const auto enter = [&](Coord region, double middle) {
      return middle - kRegionHalfDiagonal - margin < reach && !field.isTileRegion(region);
    };
    forBricks(s, reach + margin, enter, [&](Coord coord) {
      if (!field.slot(coord).isTile()) all.push_back(coord);
    });
  }
  if (method.everywhere())
    for (const Stamp& s : images)
      forBricks(
          s, method.reach(s), [](Coord, double) { return true; },
          [&](Coord coord) {
            if (field.slot(coord) != Slot(goal)) all.push_back(coord);
          });
  if (rings > kMostRings) return byCubes(editor, method, images, all, voxels);
  for (int ring = 0; ring < rings; ++ring) all = withNeighbours(all);
  if (rings == 0) {
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
  }
  std::erase_if(all, [&](Coord coord) { return !isReached(method, images, coord, 1); });
  return all;
}

}  // namespace argil::clay
