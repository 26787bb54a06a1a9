#include "clay/brush/swept_tip.h"

#include <algorithm>
#include <cmath>

#include "clay/brush/brush_method.h"
#include "clay/brush/stamp_shape.h"
#include "clay/kernels/tip_kernels.h"
#include "clay/kernels/warp_kernels.h"

namespace argil::clay {

namespace {

constexpr int kMostPlaces = 64;  // of a shape on one stamp's way

SweptAxes sweptAxes(const Brush& brush, const Stamp& s, Coord coord) {
  SweptAxes tip{};
  const Vec3f a = (s.a - ((coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5))).cast<float>(),
              d = (s.b - s.a).cast<float>();
  for (int i = 0; i < 3; ++i) {
    const Vec3f axis = s.axes.col(i);
    for (int k = 0; k < 3; ++k) tip.axes[3 * i + k] = axis[k];
    tip.a[i] = a[i];
    tip.d[i] = (d.x() * axis.x() + d.y() * axis.y()) + d.z() * axis.z();
    tip.half[i] = static_cast<float>(s.radius) * brush.proportions[i];
  }
  tip.growth = static_cast<float>(s.radiusAtEnd() / s.radius - 1);
  tip.round = brush.round * std::min({tip.half[0], tip.half[1], tip.half[2]});
  return tip;
}

// The least over places of the way of the shape's distance there. Far from its surface the nearest sample will do.
void shapeDistances(const Brush& brush, const Stamp& s, Coord coord, float (&distance)[kBrickVoxels]) {
  const SweptAxes tip = sweptAxes(brush, s, coord);
  const StampShape::Level& level = brush.shape->level(std::min(s.radius, s.radiusAtEnd()));
  const int places = std::clamp(static_cast<int>(std::ceil((s.b - s.a).norm())), 0, kMostPlaces - 1) + 1;
  const auto strideX = static_cast<ptrdiff_t>(level.size[1]) * level.size[2],
             strideY = static_cast<ptrdiff_t>(level.size[2]);
  std::fill(std::begin(distance), std::end(distance), INFINITY);
  FieldSample samples[kBrickVoxels];
  float values[kBrickVoxels];
  int voxels[kBrickVoxels];
  // A brick far from the surface for all of the way is told by its middle.
  {
    const float voxel = level.cell * static_cast<float>(s.radius),
                slack = 7 + 5 + 2 * voxel + static_cast<float>((s.b - s.a).norm());
    float away2 = 0;
    int at[3];
    for (int k = 0; k < 3; ++k) {
      const float* axis = tip.axes + 3 * k;
      const float cell = level.middle[k] - ((tip.a[0] * axis[0] + tip.a[1] * axis[1]) + tip.a[2] * axis[2]) / voxel;
      const float within = std::min(std::max(cell, 0.0f), static_cast<float>(level.size[k] - 1));
      away2 += (cell - within) * (cell - within);
      at[k] = static_cast<int>(within + 0.5f);
    }
    const float middle = level.distance[static_cast<size_t>(at[0] * strideX + at[1] * strideY + at[2])],
                away = std::sqrt(away2);
    const float far = away > 0 ? std::max(middle, away) : middle;
    if (tip.growth == 0 && std::abs(far) * voxel > slack) {
      std::fill(std::begin(distance), std::end(distance), far * voxel);
      return;
    }
  }
  for (int place = 0; place < places; ++place) {
    const float t = places > 1 ? static_cast<float>(place) / static_cast<float>(places - 1) : 0;
    // voxels a cell
    const float radius = static_cast<float>(s.radius) * (1 + t * tip.growth), voxel = level.cell * radius;
    const float inverse = 1 / voxel;
    size_t count = 0;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float v[3] = {(static_cast<float>(i >> 6) - 3.5f) - tip.a[0],
                          (static_cast<float>((i >> 3) & 7) - 3.5f) - tip.a[1],
                          (static_cast<float>(i & 7) - 3.5f) - tip.a[2]};
      int base[3];
      float part[3], away2 = 0;
      for (int k = 0; k < 3; ++k) {
        const float* axis = tip.axes + 3 * k;
        const float along = ((v[0] * axis[0] + v[1] * axis[1]) + v[2] * axis[2]) - t * tip.d[k];
        const float cell = along * inverse + level.middle[k], last = static_cast<float>(level.size[k] - 3);
        const float within = std::min(std::max(cell, 1.0f), last);
        away2 += (cell - within) * (cell - within);
        base[k] = std::min(static_cast<int>(within), level.size[k] - 3);
        part[k] = within - static_cast<float>(base[k]);
      }
      const float* corner = level.distance.data() + (base[0] - 1) * strideX + (base[1] - 1) * strideY + base[2] - 1;
      const float near = corner[strideX + strideY + 1];
      // Beyond the samples: as far as their box, and from there on.
      const float away = std::sqrt(away2);
      if (away > 0 || std::abs(near) * voxel > 5 + 2 * voxel) {
        distance[i] = std::min(distance[i], (near + away) * voxel);
        continue;
      }
      samples[count] = {corner, part[0], part[1], part[2]};
      voxels[count++] = i;
    }
    sampleValues(std::span(samples, count), strideX, strideY, values);
    for (size_t k = 0; k < count; ++k) distance[voxels[k]] = std::min(distance[voxels[k]], values[k] * voxel);
  }
}

}  // namespace

void tipDistances(const Brush& brush, const Stamp& stamp, Coord coord, float (&distance)[kBrickVoxels]) {
  switch (brush.tip) {
    case Tip::ball:
      ballDistances(sweptBall(stamp, coord), distance);
      break;
    case Tip::ellipsoid:
      ellipsoidDistances(sweptAxes(brush, stamp, coord), distance);
      break;
    case Tip::box:
      boxDistances(sweptAxes(brush, stamp, coord), distance);
      break;
    case Tip::shape:
      shapeDistances(brush, stamp, coord, distance);
      break;
  }
}

double aroundTip(const Brush& brush) {
  return brush.tip == Tip::box ? static_cast<double>(brush.proportions.norm()) : 1;
}

double withinTip(const Brush& brush) {
  switch (brush.tip) {
    case Tip::ball:
      return 1;
    case Tip::shape:
      return -1e9;
    default:
      return static_cast<double>(brush.proportions.minCoeff());
  }
}

}  // namespace argil::clay
