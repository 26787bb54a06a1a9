#include "clay/surface/tangent_plane.h"

#include <bit>

namespace argil::clay {

namespace {

// Of a cell, from the brick's lowest voxel.
Vec3f middleOf(int x, int y, int z) {
  return Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) +
         Vec3f::Constant(0.5f - static_cast<float>(BrickSurroundings::kMargin));
}

}  // namespace

TangentPlanes::TangentPlanes(const BrickSurroundings& around, float flat, float slight, float strong) {
  fitCells(around.at(0, 0, 0), BrickSurroundings::kStepX, BrickSurroundings::kStepY,
           {.slight = slight, .strong = strong, .flat = flat}, fits_);
}

size_t TangentPlanes::around(int x, int y, int z, TangentPlane* out) const {
  size_t count = 0;
  for (int i = x - 2; i <= x + 2; ++i)
    for (int j = y - 2; j <= y + 2; ++j)
      for (unsigned left = fits_.flat[i][j] & 0x1fu << (z - 2); left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        out[count++] = {middleOf(i, j, k),
                        {fits_.x[i][j][k], fits_.y[i][j][k], fits_.z[i][j][k]},
                        fits_.distance[i][j][k],
                        fits_.quality[i][j][k]};
      }
  return count;
}

bool TangentPlanes::agreeAround(int x, int y, int z, const Vec3f& p, float most) const {
  const Vec3f from = p - middleOf(0, 0, 0);
  return normalsAgree(fits_, x, y, z, from.data(), most);
}

}  // namespace argil::clay
