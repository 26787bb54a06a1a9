#pragma once
// Coarser stand-ins for the vertices of a brick.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clay/surface/surface.h"

namespace argil::render {

/// How many cells of a brick are taken together along each axis, level by level; level 0 is the surface itself. (Of 3,
/// the last group along an axis has 2.)
inline constexpr std::array<int, 5> kGroupCells{1, 2, 3, 4, 8};
inline constexpr int kLevels = int(kGroupCells.size());

/// Vertices lie at this many units a voxel, counted from voxel (0, 0, 0): a brick's reach of ±131 072 voxels fills 32
/// bits.
inline constexpr int kUnitsPerVoxel = 1 << 14;
using Units = std::array<int32_t, 3>;
/// The nearest units of a place in a brick, or less than two bricks outside of it.
[[nodiscard]] Units inUnits(const Vec3f& voxels);
/// Vertices of a brick's last layer of cells lie behind this.
inline constexpr int32_t kLastLayerUnits = 6 * kUnitsPerVoxel;
/// Those of them that stand on creases lie behind this.
inline constexpr int32_t kLastCreaseUnits = 7 * kUnitsPerVoxel / 2;

/// The vertex that stands for each vertex of `mesh` at `level` (1 to 4): of those in one group of cells that face the
/// same half, the one nearest to their mean. Vertices that may belong to the brick's last layer of cells along an axis
/// of `locked` (bits x, y, z) stand for themselves; on creases they lie up to clay::kVertexReach before that layer.
/// Depends on the mesh alone, by whole numbers: shaders/level_stand.comp finds the same. The mesh has normals. About 30
/// ns a vertex.
void representatives(const clay::BrickMesh& mesh, int level, unsigned locked, std::vector<uint16_t>& out);

/// What a cone is wider than what was added: rounding of normals is 0.006°; their lengths may be off by as much.
inline constexpr float kConeSlack = 2e-4f;

/// Directions in which triangles face: all within an angle of an axis.
struct NormalCone {
  Vec3f axis = Vec3f::UnitZ();
  float cosine = -1;  ///< Of the angle; -1: no bound.

  /// Whether no triangle in a ball can be seen from `eye`: the front of each faces away.
  [[nodiscard]] bool facesAway(const Vec3d& centre, double radius, const Vec3d& eye) const;
  /// The same for parallel rays along the unit vector `direction`.
  [[nodiscard]] bool facesAway(const Vec3d& direction) const;
};

/// The narrowest cone about the mean of what was added.
class ConeBuilder {
 public:
  /// A triangle; those without an area do not count.
  void add(const Vec3f& a, const Vec3f& b, const Vec3f& c);
  [[nodiscard]] NormalCone cone() const;

 private:
  std::vector<Vec3f> normals_;
  Vec3f sum_ = Vec3f::Zero();
};

}  // namespace argil::render
