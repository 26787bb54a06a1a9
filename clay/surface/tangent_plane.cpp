#include "clay/surface/tangent_plane.h"

#include <cmath>

namespace argil::clay {

namespace {

// A field much flatter than a distance says little of where the surface is.
constexpr float kSteep = 0.5f;
// Cells farther from the surface than this, in voxels, see other faces too.
constexpr float kNear = 1.5f;

}  // namespace

bool TangentPlanes::fit(int x, int y, int z, TangentPlane& out) const {
  constexpr int X = BrickSurroundings::kStepX, Y = BrickSurroundings::kStepY;
  const float* v = around_.at(x, y, z);
  const float bend = bendOf(v, X, Y);
  if (bend > flat2_) return false;
  const float a = v[0] + v[1], b = v[Y] + v[Y + 1], c = v[X] + v[X + 1], d = v[X + Y] + v[X + Y + 1];
  const float low = a + b, high = c + d;
  const Vec3f slope =
      0.25f * Vec3f(high - low, (b + d) - (a + c),
                    ((v[1] + v[Y + 1]) + (v[X + 1] + v[X + Y + 1])) - ((v[0] + v[Y]) + (v[X] + v[X + Y])));
  const float length = std::sqrt(slope.squaredNorm());
  if (length < kSteep) return false;
  const float scale = 1 / length;
  const Vec3f centre = Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) +
                       Vec3f::Constant(0.5f - static_cast<float>(BrickSurroundings::kMargin));
  out = {centre, slope * scale, (low + high) * (0.125f * scale), 1 - bend / flat2_};
  return std::abs(out.distance) < kNear;
}

}  // namespace argil::clay
