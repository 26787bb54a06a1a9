#pragma once
// What holds a triangle mesh together: the independent check of every mesh that Argil makes or is given.
//
// Goal: say whether triangles, by their indices alone, bound a solid, and count what is in the way. It shares nothing
// with the surface extractor, so that the one can testify about the other. Steps: (1) triangles that repeat an index
// are counted and left out; (2) the others are listed per corner vertex by a counting sort into one flat array; (3)
// around each vertex v the triangles (v, a, b) form a graph, the link, with an arc a -> b each: the arcs at w count the
// uses and directions of the edge v-w, and the shape of the link (one cycle, one path, anything else) says whether the
// fan is closed, open or non-manifold; (4) bodies by union-find over vertices; (5) volume and area summed in fixed
// blocks, about the middle of the bounding box, so that distance from the origin costs no digits. Rejected: hash maps
// and sorting all half-edges (slower and larger than one pass over links that fit in cache). Cost: O(n log k) for k
// triangles at a vertex; about 12 bytes a triangle and 12 a vertex besides the mesh. A mesh may also come piece by
// piece (TopologyCheck): then only the vertices count that may still get triangles, and 4 bytes for each other.

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

struct TopologyReport {
  uint64_t triangles = 0;            ///< All, degenerate ones included.
  uint64_t vertices = 0;             ///< Used by a triangle that is not degenerate.
  uint64_t degenerateTriangles = 0;  ///< Repeat an index. Left out of everything below.
  uint64_t boundaryEdges = 0;        ///< In one triangle.
  uint64_t nonManifoldEdges = 0;     ///< In more than two triangles.
  uint64_t flippedEdges = 0;         ///< In two triangles that run along it the same way.
  uint64_t boundaryVertices = 0;     ///< Triangles around it form one open fan.
  uint64_t nonManifoldVertices = 0;  ///< Triangles around it form neither one closed nor one open fan.
  uint64_t bodies = 0;               ///< Sets of triangles connected through vertices.
  double volume = 0;          ///< mm³, signed: positive when the triangles face outwards. Means little unless closed.
  double area = 0;            ///< mm².
  Vec3d low = Vec3d::Zero();  ///< Bounding box of the used vertices, mm; zero when there are none.
  Vec3d high = Vec3d::Zero();

  /// Every edge in exactly two triangles, oppositely wound, every vertex one closed fan, no degenerate triangle, and at
  /// least one triangle.
  [[nodiscard]] bool closed() const;
  /// The same where degenerate triangles, which vertices at one place leave when they are welded, take nothing away.
  [[nodiscard]] bool solid() const;
};

/// Takes indices as they are: weldExact (clay/mesh/weld.h) first where a file repeats its vertices. Throws Error when
/// an index is out of range. Any thread.
[[nodiscard]] TopologyReport checkTopology(const TriangleMesh& mesh);

/// The same for a mesh that is nowhere as a whole. The report is that of the whole mesh, to the bit.
class TopologyCheck {
 public:
  /// `middle` of the box of all vertices that triangles use.
  explicit TopologyCheck(const Vec3d& middle);
  ~TopologyCheck();
  TopologyCheck(const TopologyCheck&) = delete;
  TopologyCheck& operator=(const TopologyCheck&) = delete;

  /// The next vertices, and triangles by the index of vertices that came and may still get triangles; else Error.
  void add(std::span<const Vec3d> positions, std::span<const std::array<uint32_t, 3>> triangles);
  /// Vertices below this index get no more triangles.
  void settle(uint64_t vertices);
  /// Settles all and gives the report. Once.
  [[nodiscard]] TopologyReport finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::clay
