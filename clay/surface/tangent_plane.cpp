#include "clay/surface/tangent_plane.h"

#include <cmath>

namespace argil::clay {

namespace {

// A field much flatter than a distance says little of where the surface is.
constexpr float kSteep = 0.5f;
// Cells farther from the surface than this, in voxels, see other faces too.
constexpr float kNear = 1.5f;
// No distance is steeper: what is farther by this is not near.
constexpr float kSteepest = 1.25f;

// Of a cell, from the brick's lowest voxel.
Vec3f middleOf(int x, int y, int z) {
  return Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) +
         Vec3f::Constant(0.5f - static_cast<float>(BrickSurroundings::kMargin));
}

}  // namespace

TangentPlanes::TangentPlanes(const BrickSurroundings& around, float flat, float slight, float strong)
    : around_(around), flat2_(flat * flat) {
  sortCells(around.at(0, 0, 0), BrickSurroundings::kStepX, BrickSurroundings::kStepY,
            {.slight = slight, .strong = strong, .flat = flat, .near = kNear * kSteepest}, cells_);
}

size_t TangentPlanes::around(int x, int y, int z, TangentPlane* out) {
  size_t count = 0;
  for (int dx = -2; dx <= 2; ++dx)
    for (int dy = -2; dy <= 2; ++dy)
      for (unsigned left = known(x + dx, y + dy, 0x1fu << (z - 2)); left != 0; left &= left - 1)
        out[count++] = planes_[x + dx][y + dy][std::countr_zero(left)];
  return count;
}

bool TangentPlanes::agreeAround(int x, int y, int z, const Vec3f& p, float most) {
  for (int dx = -2; dx <= 2; ++dx)
    for (int dy = -2; dy <= 2; ++dy) known(x + dx, y + dy, 0x1fu << (z - 2));
  const Vec3f from = p - middleOf(0, 0, 0);
  return normalsAgree(normals_, x, y, z, from.data(), most);
}

bool TangentPlanes::fit(int x, int y, int z) {
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
  const TangentPlane plane{middleOf(x, y, z), slope * scale, (low + high) * (0.125f * scale), 1 - bend / flat2_};
  if (!(std::abs(plane.distance) < kNear)) return false;
  planes_[x][y][z] = plane;
  normals_.x[x][y][z] = plane.normal.x(), normals_.y[x][y][z] = plane.normal.y();
  normals_.z[x][y][z] = plane.normal.z(), normals_.quality[x][y][z] = plane.quality;
  return true;
}

}  // namespace argil::clay
