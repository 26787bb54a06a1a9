#pragma once
// A smooth surface over a cage: one bicubic B-spline a quad, all of them with one tangent plane where they meet.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "clay/cage/quad_mesh.h"

namespace argil::clay {

/// Spans of a patch along each side, and its control points: double knots between spans.
inline constexpr int kPatchSpans = 6, kPatchPoints = 2 * kPatchSpans + 2;

/// Control points of the patches of a closed surface, those of sides and corners once. Patch f has control point (a,
/// b), a along side 0, by index `patches[f][a][b]` of `points`; knots 0 0 0 0 1 1 2 2 … 6 6 6 6 along both.
struct PatchSurface {
  QuadMesh cage;
  std::vector<Vec3d> points;  ///< mm.
  using Patch = std::array<std::array<uint32_t, kPatchPoints>, kPatchPoints>;
  std::vector<Patch> patches;
  /// From 0 to kPatchSpans along both.
  [[nodiscard]] Vec3d at(uint32_t patch, double u, double v) const;
  struct Tangents {
    Vec3d u, v;
  };
  [[nodiscard]] Tangents tangentsAt(uint32_t patch, double u, double v) const;
};

/// Weights of some net vertices that add up to 1.
using Weights = std::vector<std::pair<uint32_t, double>>;

/// How control points follow from a net: the cage's quads in 6 × 6, whose vertices may stand anywhere. All is linear.
/// Where four quads meet everywhere around, a patch is the uniform bicubic B-spline of the net, as the limit of
/// Catmull–Clark is; around a vertex of another valence it is that limit's approximation by Loop and Schaefer (2008)
/// with the two spans beside it corrected, so that tangent planes are one along every side: side curves are quadratic
/// in the first span, across them λ(t) = 2 cos(2π/n) (1 − t)² (after Peters 2000). A crease is the cubic B-spline of
/// its own net vertices; patches meet along it at any angle, and those on one side of it with one tangent plane as
/// everywhere. At the ends of creases, and where a line of them turns, it goes through the net's vertex. Method:
/// NOTES.md.
class PatchNet {
 public:
  /// `cage`: that of the topology; its positions say what angles there are between creases.
  PatchNet(const QuadTopology& topology, const QuadMesh& cage);

  [[nodiscard]] size_t vertexCount() const { return vertices_; }
  /// Index of a net vertex: 0 to kPatchSpans along both sides of a quad.
  [[nodiscard]] uint32_t vertex(uint32_t quad, int i, int j) const { return grid_[quad][size_t(i)][size_t(j)]; }
  [[nodiscard]] const std::vector<PatchSurface::Patch>& patches() const { return patches_; }
  [[nodiscard]] const std::vector<Weights>& points() const { return points_; }
  /// Of the place (u, v) of a patch.
  [[nodiscard]] Weights at(uint32_t patch, double u, double v) const;

 private:
  // Quads that lie between two edges of a vertex, both of them creases, or all around it.
  struct Fan {
    uint32_t vertex = 0;
    size_t first = 0, quads = 0;  // by spokes
    bool closed = false;
    double angle = 0;
  };
  static double angleOf(const QuadTopology& topology, const QuadMesh& cage, const Fan& fan);
  void placeCreases(const QuadTopology& topology, const QuadMesh& cage);
  void correctBeside(const QuadTopology& topology, const QuadMesh& cage, uint32_t vertex);
  void correctFan(const QuadTopology& topology, const Fan& fan);
  uint32_t& inner(uint32_t quad, int i, int j) { return patches_[quad][size_t(i) + 1][size_t(j) + 1]; }
  uint32_t edgePoint(uint32_t edge, int k) const { return firstEdge_ + edge * uint32_t(2 * kPatchSpans) + uint32_t(k); }

  size_t vertices_ = 0;
  uint32_t firstEdge_ = 0;
  std::vector<std::array<std::array<uint32_t, kPatchSpans + 1>, kPatchSpans + 1>> grid_;
  std::vector<PatchSurface::Patch> patches_;
  std::vector<Weights> points_;  // corners, then two a span of each edge, then four a span of each quad
};

}  // namespace argil::clay
