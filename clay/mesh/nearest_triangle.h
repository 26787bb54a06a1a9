#pragma once
// The nearest point of a mesh, exact.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/kernels/box_kernels.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// The point of the triangle that is nearest to p; a triangle without area counts as its edges. Ericson, Real-Time
/// Collision Detection, 5.1.5.
[[nodiscard]] Vec3d nearestOnTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// Triangles in a hierarchy of boxes: sorted along a Morton curve, leaves of two, a complete tree of eight children a
/// node above them (no pointers). Each box has a slab too, along the mean normal of what is in it: where everything is
/// about equally far, as from the middle of a ball, boxes alone exclude nothing and a search would look at all
/// triangles. Of triangles that are equally near the first in the tree's order is taken, whatever the hint: answers do
/// not depend on what was asked before, nor on the CPU. A place that is not finite is near nothing, which costs no
/// search. The mesh must outlive it and stay as it is. 41 bytes a triangle beside the mesh. nearest() from any number
/// of threads.
class NearestTriangle {
 public:
  /// At least one triangle, indices in range, finite coordinates. Cost: about 0.2 s for 10^6 triangles.
  explicit NearestTriangle(const TriangleMesh& mesh);

  struct Hit {
    uint32_t triangle = UINT32_MAX;  ///< In the order of the tree: for `hint`, corners() and indexOf().
    double squared = 0;              ///< Squared distance.
  };
  /// `hint`: the triangle of an answer for a point near by, which makes this one cheap, or UINT32_MAX.
  [[nodiscard]] Hit nearest(const Vec3d& p, uint32_t hint = UINT32_MAX) const;
  /// The same, or any that is at most `enough` away.
  [[nodiscard]] Hit nearEnough(const Vec3d& p, double enough, uint32_t hint = UINT32_MAX) const;
  /// The same among those that are nearer than `distance`: triangle UINT32_MAX when none is.
  [[nodiscard]] Hit nearerThan(const Vec3d& p, double distance, uint32_t hint = UINT32_MAX) const;
  /// Is some triangle at most this far? Ends at the first.
  [[nodiscard]] bool within(const Vec3d& p, double distance) const;
  /// The squared distance of one triangle, by the tree's order.
  [[nodiscard]] double squaredTo(uint32_t triangle, const Vec3d& p) const;
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  /// Of a Hit's triangle.
  [[nodiscard]] const std::array<uint32_t, 3>& corners(uint32_t triangle) const { return triangles_[triangle]; }

  /// In the mesh, of a Hit's triangle.
  [[nodiscard]] uint32_t indexOf(uint32_t triangle) const { return indices_[triangle]; }

 private:
  void addBoxes(const std::vector<Vec3d>& normals, size_t level);
  [[nodiscard]] Vec3d inTree(const Vec3d& p) const { return (p - middle_) * scale_; }
  /// What is nearer than `best`; the first that is within `enough` ends it.
  [[nodiscard]] Hit search(const Vec3d& p, Hit best, double enough) const;

  const TriangleMesh& mesh_;
  Vec3d middle_ = Vec3d::Zero();
  double scale_ = 1;  // Boxes are from −1 to 1 around the middle: no size of a mesh is beyond their floats.
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<uint32_t> indices_;  // of triangles_ in the mesh
  std::vector<BoxNode> nodes_;
  std::vector<size_t> levels_;  // The first node of each, from the leaves' to the root.
};

}  // namespace argil::clay
