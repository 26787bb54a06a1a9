#include "ui3d/studio/view/clay_ray.h"

#include <algorithm>
#include <cmath>

#include "clay/store/sampler.h"

namespace argil::studio {
namespace {

constexpr double kShortestStep = 0.25;  // Voxels: a march never stands still.
constexpr double kMarginVoxels = 4;     // Around the surface's box: the march begins outside.
constexpr int kHalvings = 12;

// Part of the line inside a box that is grown by the margin.
std::optional<std::array<double, 2>> inside(const render::Box& box, double margin, const Vec3d& origin,
                                            const Vec3d& direction) {
  double first = 0, last = 1e12;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis] - margin - origin[axis], high = box.max[axis] + margin - origin[axis];
    if (std::abs(direction[axis]) < 1e-12) {
      if (low > 0 || high < 0) return std::nullopt;
      continue;
    }
    const double a = low / direction[axis], b = high / direction[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  if (first > last) return std::nullopt;
  return std::array{first, last};
}

bool hidden(const clay::Version& version, const Vec3d& p) {
  const auto near = [](double v) { return static_cast<int32_t>(std::floor(v + 0.5)); };
  const Coord voxel{near(p.x()), near(p.y()), near(p.z())};
  return version.find(clay::Channel::mask, voxel >> 3)
             .value(clay::Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7)) > 127;
}

}  // namespace

std::optional<double> PinnedClay::distance(const Vec3d& origin, const Vec3d& direction, double fromMm) const {
  std::optional<double> nearest;
  for (const Pinned& piece : pieces_) {
    if (piece.bounds.empty()) continue;
    const clay::Grid& grid = piece.version.grid();
    const auto part = inside(piece.bounds, kMarginVoxels * grid.voxelMm, origin, direction);
    if (!part) continue;
    clay::Sampler sampler(piece.version);
    const bool hides = piece.hideMasked && piece.version.has(clay::Channel::mask);
    const Vec3d start = grid.toVoxel(piece.pose.applyInverse(origin)),
                step = piece.pose.rotation.conjugate() * direction;
    const double end = (*part)[1] / grid.voxelMm;
    double before = std::max((*part)[0], fromMm) / grid.voxelMm;
    // Beyond the band the field says "at least the band", so that is the longest step: a wall is not missed.
    double value = sampler.trilinear(start + before * step);
    if (value < 0 && !hides) {  // A section begins inside: what is seen is the cut face.
      if (!nearest || before * grid.voxelMm < *nearest) nearest = before * grid.voxelMm;
      continue;
    }
    for (double at = before; at < end; before = at) {
      const bool wasInside = value < 0;  // Only where it went in through what is hidden.
      at += std::max(std::abs(value), kShortestStep);
      value = sampler.trilinear(start + at * step);
      if ((value < 0) == wasInside) continue;
      for (int i = 0; i < kHalvings; ++i) {
        const double middle = (before + at) / 2;
        ((sampler.trilinear(start + middle * step) < 0) != wasInside ? at : before) = middle;
      }
      if (hides && hidden(piece.version, start + at * step)) continue;
      if (!nearest || at * grid.voxelMm < *nearest) nearest = at * grid.voxelMm;
      break;
    }
  }
  return nearest;
}

}  // namespace argil::studio
