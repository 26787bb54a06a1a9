#pragma once
// The creases of a clay's surface, for cages whose edges follow them.

#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/surface/surface.h"

namespace argil::clay {

/// Where a surface turns by kCreaseDegrees and more, as pieces of lines. Any number of threads may ask.
class CreaseMap {
 public:
  /// Of a surface of the fine grade with normals. Lines shorter than `leastMm` in all are left out.
  CreaseMap(const Surface& fine, double leastMm);
  CreaseMap(const CreaseMap&) = delete;
  CreaseMap& operator=(const CreaseMap&) = delete;

  [[nodiscard]] bool empty() const { return pieces_.triangles.empty(); }
  /// The ends of the pieces, mm.
  [[nodiscard]] const std::vector<Vec3d>& places() const { return pieces_.positions; }
  struct Hit {
    Vec3d mm = Vec3d::Zero(), along = Vec3d::UnitX();  ///< The place, and the direction of the crease there.
    double squared = HUGE_VAL;                         ///< mm²; infinite where there is none.
  };
  /// The nearest place. `hint`: of the place before, UINT32_MAX at first.
  [[nodiscard]] Hit nearest(const Vec3d& mm, uint32_t& hint) const;
  /// The number of the nearest corner (where creases meet, end or turn sharply) within `most` mm; none of those in
  /// `but`.
  [[nodiscard]] std::optional<uint32_t> cornerNear(const Vec3d& mm, double most, const std::set<uint32_t>& but) const;
  [[nodiscard]] const Vec3d& corner(uint32_t number) const { return corners_[number]; }
  /// Fills mesh.creases, for a mesh much finer than a cage, itself of the fine grade: its quads are sorted into faces
  /// that smooth sides hold together, and creases are what lies between two faces. So they form closed networks; those
  /// that end within a face are left out, and gaps of two or three quads are bridged.
  void mark(QuadMesh& mesh) const;

 private:
  void findCorners();

  TriangleMesh pieces_;  // triangles without area
  std::vector<Vec3d> corners_;
  std::unique_ptr<NearestTriangle> tree_;
};

/// Where a surface turns by less there is no crease for a cage.
inline constexpr double kCreaseDegrees = 30;

}  // namespace argil::clay
