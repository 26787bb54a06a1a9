#pragma once
// A mesh that is touched as it is: nearest points on its triangles, and normals for force shading.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"
#include "haptics/base/realtime.h"
#include "haptics/scene/part_shading.h"
#include "haptics/scene/part_tree.h"

namespace argil::haptics {

/// Triangles and their hierarchy, never changed. No topology is asked for: soup, duplicates, holes, T-junctions,
/// flipped and degenerate triangles (they count as the segments or points that they are) are all touched where they
/// are; both faces count. Built off the servo thread, read by any number of threads.
///
/// Coordinates are kept as 32-bit floats from the middle of the part: they move by at most 6e-8 of its half size,
/// however far it lies from zero. Recipe, tolerances and figures: parts.md.
class PartMesh {
 public:
  static constexpr uint32_t kNone = UINT32_MAX;

  /// Throws Error for a mesh without triangles, of more than 2^28 triangles, with an index that points nowhere, or with
  /// a coordinate that is not finite or beyond 10^9 mm; Cancelled when `job` was. Cost: about 2 s for 10^6 triangles.
  explicit PartMesh(const clay::TriangleMesh& mesh, Job* job = nullptr);
  PartMesh(const PartMesh&) = delete;
  PartMesh& operator=(const PartMesh&) = delete;

  /// Nearest point of the triangles, in the mesh's own millimetres.
  struct Hit {
    /// In an order of its own, stable for this PartMesh; kNone: nothing within the reach.
    uint32_t triangle = kNone;
    Vec3d point = Vec3d::Zero();
    double distance = 0;             ///< Never negative; the reach when nothing was found.
    uint32_t nodes = 0, looked = 0;  ///< Nodes and triangles that were looked at.
  };
  /// Exact to rounding of the coordinates as long as fewer than 128 triangles had to be looked at; in a socket of the
  /// ball's own size, where all are equally near, to resolutionMm() / 100 for each 128 of them, at most to a tenth.
  /// `hint`: the triangle of the last answer, which makes the next one cheap, or kNone. Cost: 1.4 to 3 µs warm on 10^6
  /// triangles, by how far it moved; grows with the logarithm of their number.
  [[nodiscard]] Hit nearest(const Vec3d& p, double reachMm, uint32_t hint) const ARGIL_REALTIME;

  /// Smooth unit normal at a point of a triangle; zero at creases (see PartShading) and where the triangle has no area.
  [[nodiscard]] Vec3d normal(uint32_t triangle, const Vec3d& point) const ARGIL_REALTIME;

  /// Mean length of an edge, but between 1/10 000 and 1/400 of the diagonal: detail finer than its triangles a mesh has
  /// not, and a large plain triangle says nothing about how exactly it should be felt.
  [[nodiscard]] double resolutionMm() const ARGIL_REALTIME { return resolution_; }

  /// No other PartMesh of this process has it, unlike an address.
  [[nodiscard]] uint64_t number() const ARGIL_REALTIME { return number_; }
  [[nodiscard]] size_t triangleCount() const noexcept { return triangles_.size(); }
  [[nodiscard]] const Vec3d& middleMm() const noexcept { return middle_; }  ///< Of the bounding box.
  [[nodiscard]] double diagonalMm() const noexcept { return diagonal_; }    ///< Of the bounding box.
  [[nodiscard]] size_t bytes() const noexcept;

 private:
  uint64_t number_ = 0;
  Vec3d middle_ = Vec3d::Zero();
  double diagonal_ = 0, resolution_ = 0;
  std::vector<PartTriangle> triangles_;  // In the order of the leaves.
  std::vector<PartShading> shading_;
  std::vector<PartNode> nodes_;
};

}  // namespace argil::haptics
