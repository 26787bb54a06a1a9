#include "engine/lay.h"

#include <algorithm>
#include <cmath>

#include "clay/sampler.h"

namespace argil::engine {
namespace {

constexpr double kShortestStep = 0.25;  // voxels: a march never stands still
constexpr double kFarVoxels = 70000;    // beyond the largest model
constexpr int kHalvings = 20;

// Where the ray from `start` meets the surface, in voxels along it. Beyond the band the field says only "at least the
// band", so the march takes that as its longest step and cannot miss a wall thicker than the shortest one.
std::optional<double> firstHit(clay::Sampler& sampler, const Vec3d& start, const Vec3d& direction, double endVoxels) {
  double before = 0, value = sampler.trilinear(start);
  if (value < 0) return 0;
  for (double at = 0; at < endVoxels;) {
    before = at;
    at += std::max(value, kShortestStep);
    value = sampler.trilinear(start + at * direction);
    if (value >= 0) continue;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (before + at) / 2;
      (sampler.trilinear(start + middle * direction) < 0 ? at : before) = middle;
    }
    return at;
  }
  return std::nullopt;
}

// Bounds of all bricks, voxels: how far a march has to go.
Eigen::AlignedBox3d bounds(const clay::Version& version) {
  Eigen::AlignedBox3d box;
  version.forEachBrick([&](const clay::Brick& brick) {
    box.extend((brick.coord * clay::kBrickEdge).toVec3d());
    box.extend((brick.coord * clay::kBrickEdge).toVec3d() + Vec3d::Constant(clay::kBrickEdge));
  });
  return box;
}

}  // namespace

LaidStroke lay(const clay::Version& version, const ScriptStroke& stroke) {
  LaidStroke laid;
  laid.stroke = stroke;
  if (!stroke.onto) return laid;
  laid.stroke.onto.reset();
  laid.stroke.path.clear();
  laid.from = stroke.path.front().mm;
  laid.to = stroke.path.back().mm;
  const Eigen::AlignedBox3d box = bounds(version);
  if (box.isEmpty()) return laid;
  clay::Sampler sampler(version);
  const clay::Grid& grid = version.grid();
  const Vec3d direction = stroke.onto->direction.normalized();
  for (const PathPoint& point : stroke.path) {
    const Vec3d start = grid.toVoxel(point.mm);
    const double end = std::min(box.exteriorDistance(start) + box.diagonal().norm(), kFarVoxels);
    if (const auto hit = firstHit(sampler, start, direction, end)) {
      const double mm = *hit * grid.voxelMm + stroke.onto->pressMm - stroke.tool.radiusMm;
      laid.stroke.path.push_back({point.timeS, point.mm + mm * direction});
    }
  }
  return laid;
}

}  // namespace argil::engine
