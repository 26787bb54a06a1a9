#pragma once
// A closed mesh of quads: the cage of a smooth surface.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/vec.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

struct QuadMesh {
  std::vector<Vec3d> positions;                ///< mm.
  std::vector<std::array<uint32_t, 4>> quads;  ///< Counter-clockwise seen from outside.
  /// Which sides are creases: bit s of each quad for its side s, the same from both quads. Empty: none.
  std::vector<uint8_t> creases = {};
  std::vector<uint32_t> corners = {};  ///< Vertices where a line of creases turns sharply.
};

/// The least scaled Jacobian of a quad's four corners, seen along the quad's own normal: 1 for a rectangle, 0 where a
/// corner is half a turn, below 0 where one bends inwards. 0 where a side has no length.
[[nodiscard]] double scaledJacobian(const QuadMesh& mesh, const std::array<uint32_t, 4>& quad);

struct QuadShapes {
  double mean = 1, least = 1;  ///< Scaled Jacobians.
};
[[nodiscard]] QuadShapes shapesOf(const QuadMesh& mesh);

/// The two triangles of a quad, as corners: along the shorter diagonal, unless one of them would lie the other way.
[[nodiscard]] std::array<std::array<uint8_t, 3>, 2> trianglesOf(const std::array<Vec3d, 4>& corners);

/// Those of all quads, two by two.
[[nodiscard]] TriangleMesh trianglesOf(const QuadMesh& mesh);

/// Each quad in four, at the middles of its sides; creases and corners as they were.
[[nodiscard]] QuadMesh halved(const QuadMesh& mesh);

/// What is beside what in a closed mesh of quads. Side s of a quad goes from its corner s to the next.
class QuadTopology {
 public:
  /// Throws Error where a side has no partner that goes the other way, or more than one, and where the quads around a
  /// vertex are not one fan.
  QuadTopology(size_t vertices, std::vector<std::array<uint32_t, 4>> quads, const std::vector<uint8_t>& creases = {});
  explicit QuadTopology(const QuadMesh& mesh) : QuadTopology(mesh.positions.size(), mesh.quads, mesh.creases) {}

  struct Edge {
    uint32_t from = 0, to = 0;
    std::array<uint32_t, 2> quad{};  ///< The first has it from `from` to `to`, the second the other way.
    std::array<uint8_t, 2> side{};
    bool crease = false;
  };
  /// A quad around a vertex, and the edge that leaves the vertex as side `corner` of it.
  struct Spoke {
    uint32_t quad = 0;
    uint8_t corner = 0;
    uint32_t edge = 0;
    bool outward = false;  ///< The edge begins at the vertex.
  };

  [[nodiscard]] size_t vertexCount() const { return first_.size() - 1; }
  [[nodiscard]] const std::vector<std::array<uint32_t, 4>>& quads() const { return quads_; }
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
  [[nodiscard]] uint32_t edgeOf(uint32_t quad, int side) const { return edgesOf_[quad][size_t(side)]; }
  /// Counter-clockwise seen from outside: quad k lies between edge k and edge k + 1.
  [[nodiscard]] size_t valence(uint32_t vertex) const { return first_[vertex + 1] - first_[vertex]; }
  [[nodiscard]] const Spoke* spokes(uint32_t vertex) const { return &spokes_[first_[vertex]]; }
  /// How many creases end at a vertex.
  [[nodiscard]] size_t creasesAt(uint32_t vertex) const;
  /// Vertices of another valence than 4, where no creases end.
  [[nodiscard]] size_t irregular() const;

 private:
  std::vector<std::array<uint32_t, 4>> quads_, edgesOf_;
  std::vector<Edge> edges_;
  std::vector<Spoke> spokes_;
  std::vector<size_t> first_;
};

/// Where place (p, q) of an n × n grid lies that is counted from corner `corner` of a quad, p along the side that
/// leaves it and q along the one before, in the grid that is counted from corner 0.
[[nodiscard]] constexpr std::array<int, 2> fromCorner(int corner, int p, int q, int n) {
  switch (corner & 3) {
    case 0:
      return {p, q};
    case 1:
      return {n - 1 - q, p};
    case 2:
      return {n - 1 - p, n - 1 - q};
    default:
      return {q, n - 1 - p};
  }
}

}  // namespace argil::clay
