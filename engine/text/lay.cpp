#include "engine/text/lay.h"

#include <algorithm>
#include <cmath>

#include "clay/store/sampler.h"

namespace argil::engine {
namespace {

constexpr double kShortestStep = 0.25;  // voxels: a march never stands still
constexpr double kFarVoxels = 70000;    // beyond the largest model
constexpr int kHalvings = 20;
constexpr double kStepRadii = 2;  // a step in depth that is an edge, not a slope

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

double length(const std::vector<PathPoint>& path) {
  double sum = 0;
  for (size_t i = 1; i < path.size(); ++i) sum += (path[i].mm - path[i - 1].mm).norm();
  return sum;
}

}  // namespace

std::vector<LaidStroke> lay(const clay::Version& version, const ScriptStroke& stroke) {
  if (!stroke.onto) return {{stroke, {}, {}}};
  const Eigen::AlignedBox3d box = bounds(version);
  if (box.isEmpty()) return {};
  clay::Sampler sampler(version);
  const clay::Grid& grid = version.grid();
  const Vec3d direction = stroke.onto->direction.normalized();
  const double step = kStepRadii * stroke.tool.radiusMm;

  std::vector<LaidStroke> parts;
  double depth = 0;
  bool open = false;
  for (const PathPoint& point : stroke.path) {
    const Vec3d start = grid.toVoxel(point.mm);
    const double end = std::min(box.exteriorDistance(start) + box.diagonal().norm(), kFarVoxels);
    const std::optional<double> hit = firstHit(sampler, start, direction, end);
    if (!hit) {
      open = false;
      continue;
    }
    const double mm = *hit * grid.voxelMm + stroke.onto->pressMm - stroke.tool.radiusMm;
    // Depth is measured from the plane through zero: paths need not be written in a plane.
    const double at = point.mm.dot(direction) + mm;
    if (!open || std::abs(at - depth) > step) {
      parts.push_back({stroke, point.mm, {}});
      parts.back().stroke.onto.reset();
      parts.back().stroke.path.clear();
    }
    PathPoint there = point;
    there.mm = point.mm + mm * direction;
    parts.back().stroke.path.push_back(there);
    parts.back().to = point.mm;
    depth = at;
    open = true;
  }
  if (parts.size() > 1) {
    std::erase_if(parts, [step](const LaidStroke& part) { return length(part.stroke.path) < step; });
  }
  return parts;
}

}  // namespace argil::engine
