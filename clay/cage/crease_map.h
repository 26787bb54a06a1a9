#pragma once
// The creases of a clay's surface, for cages whose edges follow them.

#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "clay/cage/guide_ways.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/surface/surface.h"

namespace argil::clay {

/// A plane that a clay ends at: what lies in it, within `nearMm`, is a face of its own whatever turns beside it.
struct EndPlane {
  int axis = 0;  ///< 0 to 2: x, y, z; the clay lies below.
  double atMm = 0, nearMm = 0;

  [[nodiscard]] bool has(const Vec3d& p) const { return std::abs(p[axis] - atMm) < nearMm; }
};

/// Where a surface turns by kCreaseDegrees and more, as pieces of lines between its faces. Any number of threads may
/// ask.
class CreaseMap {
 public:
  /// Of a surface of the fine grade with normals, and the mesh that it gives, for cages with edges of about `evenMm`:
  /// short lines and narrow faces are left out, and so is what ends within a face. Throws Error for a surface that is
  /// not closed.
  /// `end`: what lies in that plane is a face whatever turns beside it. `guides`: what lies on either side of such a
  /// curve are two faces as well, and the curve is a crease between them until clearGuides(). One of which some place
  /// lies farther from the surface than a quarter of `evenMm`, and than a fiftieth of its length, is left out, and so
  /// is a face that is too narrow.
  CreaseMap(const Surface& fine, const TriangleMesh& mesh, double evenMm, const std::optional<EndPlane>& end = {},
            const std::vector<GuideLoop>& guides = {});
  CreaseMap(const CreaseMap&) = delete;
  CreaseMap& operator=(const CreaseMap&) = delete;

  [[nodiscard]] bool empty() const { return pieces_.triangles.empty(); }
  /// In all, mm.
  [[nodiscard]] double lengthMm() const;
  /// The ends of the pieces, mm.
  [[nodiscard]] const std::vector<Vec3d>& places() const { return pieces_.positions; }
  struct Hit {
    Vec3d mm = Vec3d::Zero(), along = Vec3d::UnitX();  ///< The place, and the direction of the crease there.
    double squared = HUGE_VAL;                         ///< mm²; infinite where there is none.
  };
  /// The nearest place. `hint`: of the place before, UINT32_MAX at first.
  [[nodiscard]] Hit nearest(const Vec3d& mm, uint32_t& hint) const;
  /// Where more than two faces meet, the first `meetings` of them, or a crease turns sharply, mm.
  [[nodiscard]] const std::vector<Vec3d>& corners() const { return corners_; }
  [[nodiscard]] size_t meetings() const { return meetings_; }
  /// Fills mesh.creases of a closed mesh much finer than a cage: each quad belongs to the face of the clay that most of
  /// it lies on, and creases are what lies between two faces. So they are closed networks. `tree` searches the mesh
  /// that this was made of.
  void mark(QuadMesh& mesh, const NearestTriangle& tree) const;
  /// Guides that lie on the surface: how many, and how long they are in all.
  [[nodiscard]] size_t guides() const { return guides_; }
  [[nodiscard]] double guidesMm() const { return guidesMm_; }
  /// Edges that follow guides and no crease are creases no longer. How long they are, mm.
  double clearGuides(QuadMesh& mesh) const;

 private:
  void findCorners(const std::vector<std::set<uint32_t>>& faces);
  void joinMeetings(const SurfaceCells& cells, const QuadMesh& mesh, std::vector<uint32_t>& face) const;

  TriangleMesh pieces_;                     // triangles without area
  std::vector<bool> guide_;                 // of each: it follows a guide and no crease
  std::vector<uint32_t> face_;              // of each triangle of the surface
  std::vector<Vec3d> corners_, crossings_;  // crossings: of guides
  size_t meetings_ = 0, guides_ = 0;
  double guidesMm_ = 0;
  std::unique_ptr<NearestTriangle> tree_;
};

/// Where a surface turns by less there is no crease for a cage.
inline constexpr double kCreaseDegrees = 30;

}  // namespace argil::clay
