#pragma once
// A triangle mesh as it is, in the buffers of the surface.

#include <vector>

#include "clay/mesh/triangle_mesh.h"
#include "render/surface/surface_layout.h"

namespace argil::render {

/// Vertices with normals from the faces around them, apart where faces meet at more than 40°; the same format as
/// clay's, in units that hold the mesh 2³⁰ wide. One thread.
class PartLayout {
 public:
  /// Throws Error for positions that are not finite, triangles that name a missing one, and what BufferRanges throws.
  PartLayout(const clay::TriangleMesh& mesh, BufferRanges& ranges, UploadSink& sink);
  ~PartLayout();
  PartLayout(const PartLayout&) = delete;
  PartLayout& operator=(const PartLayout&) = delete;

  [[nodiscard]] double unitMm() const { return unitMm_; }
  [[nodiscard]] const Vec3d& originMm() const { return origin_; }
  [[nodiscard]] const Box& bounds() const { return bounds_; }
  /// As SurfaceLayout's. O(vertices) where turned.
  [[nodiscard]] Box bounds(const Eigen::Quaterniond& rotation, const Vec3d& translation) const;
  [[nodiscard]] ChunkDraw::Range draw() const;
  /// As SurfaceLayout's. O(log triangles) for most meshes.
  [[nodiscard]] std::optional<RayHit> raycast(const Ray& ray) const;

 private:
  /// Of a tree of boxes; a leaf holds triangles order_[first … first + count).
  struct Node {
    Vec3f min, max;
    uint32_t first = 0, count = 0;
    uint32_t right = 0;  // child; the left one follows its parent
  };
  uint32_t build(uint32_t first, uint32_t count);

  BufferRanges& ranges_;
  double unitMm_ = 1;
  Vec3d origin_ = Vec3d::Zero();
  Box bounds_;
  std::vector<Vec3f> positions_;  // relative to origin_
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<uint32_t> order_;
  std::vector<Node> nodes_;
  uint32_t firstVertex_ = 0, vertexCount_ = 0, firstQuad_ = 0, quadCount_ = 0;
};

}  // namespace argil::render
