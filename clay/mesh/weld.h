#pragma once
// Vertices of equal coordinates become one: for formats that repeat a vertex in its triangles.

#include <cstdint>
#include <span>
#include <vector>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// Numbers distinct positions in order of first appearance. Positions are equal when their coordinates are (-0 equals
/// 0); there is no tolerance. Flat open addressing: 8 to 32 bytes a distinct position beside the position itself.
class VertexWelder {
 public:
  VertexWelder();

  /// Index of `position` in positions(), appended when it is new. Finite coordinates only. Amortized O(1). Throws Error
  /// past 2^32 - 1 distinct positions.
  uint32_t add(const Vec3d& position);
  /// The same for many in their order, which is faster: indices[i] becomes that of positions[i]. Equal lengths.
  void add(std::span<const Vec3d> positions, std::span<uint32_t> indices);

  [[nodiscard]] const std::vector<Vec3d>& positions() const { return positions_; }
  /// Hands the positions over; the welder is empty afterwards.
  [[nodiscard]] std::vector<Vec3d> take();

 private:
  uint32_t place(const Vec3d& position, uint64_t hash);
  void grow();

  std::vector<Vec3d> positions_;
  std::vector<uint64_t> slots_;  // Upper half: upper half of the hash. Lower half: index + 1, 0 when free.
};

/// The same triangles, in the same order, over positions without duplicates. Positions that no triangle uses go.
/// Triangles that lose a corner by it stay, so that the count is the file's; checkTopology counts them as degenerate.
[[nodiscard]] TriangleMesh weldExact(const TriangleMesh& mesh);

/// The same, but of vertices of open edges alone, those in one triangle. Bodies that their indices close stay what they
/// are where they touch themselves or each other, as the halves of a cut do. Memory while it works, beside what
/// those vertices take in a VertexWelder: 12 bytes a triangle and 13 a vertex. O(triangles). Throws Error beyond
/// 1 431 655 765 triangles.
[[nodiscard]] TriangleMesh weldOpenEdges(const TriangleMesh& mesh);

}  // namespace argil::clay
