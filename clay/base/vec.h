#pragma once
// Vectors and integer coordinates that every module uses.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <compare>
#include <cstdint>

namespace argil {

using Vec3d = Eigen::Vector3d;  ///< World positions in mm, or voxel coordinates.
using Vec3f = Eigen::Vector3f;  ///< Positions inside a brick in voxels, directions.

/// Integer coordinate of a voxel or of a brick (the header that takes one says which). Orders by x, then y, then z.
struct Coord {
  int32_t x = 0, y = 0, z = 0;

  friend constexpr auto operator<=>(const Coord&, const Coord&) = default;
  friend constexpr Coord operator+(Coord a, Coord b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Coord operator-(Coord a, Coord b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Coord operator*(Coord a, int32_t s) { return {a.x * s, a.y * s, a.z * s}; }
  /// Floor division by 2^bits, component by component.
  friend constexpr Coord operator>>(Coord a, int bits) { return {a.x >> bits, a.y >> bits, a.z >> bits}; }
  [[nodiscard]] Vec3d toVec3d() const { return {double(x), double(y), double(z)}; }
};

}  // namespace argil
