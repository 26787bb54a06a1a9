#pragma once
// Curves on a triangle mesh, as closed ways along its sides.

#include <cstdint>
#include <optional>
#include <vector>

#include "clay/base/vec.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/surface_faces.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// A closed curve on a surface that edges are to follow, mm.
using GuideLoop = std::vector<Vec3d>;

/// A way along sides from vertex to vertex, closed, and where the curve passes each.
struct GuideWay {
  std::vector<uint32_t> vertices;
  std::vector<Vec3d> places;
};

/// Finds ways. A way crosses creases, and the ways that were added before, at one vertex each. One thread.
class GuideWays {
 public:
  /// Of a closed mesh, which must stay. `creases`: sides that are bent, in the order of `cells`. `meanSide`, mm. Cost:
  /// a tree of the triangles.
  GuideWays(const TriangleMesh& mesh, const SurfaceCells& cells, const std::vector<bool>& creases, double meanSide);

  /// None where some place of the curve is farther than `off` mm from the mesh, or where it goes around nothing. Cost:
  /// a search of the mesh for each half of a side.
  [[nodiscard]] std::optional<GuideWay> along(const GuideLoop& loop, double off) const;
  /// Ways that are asked for later cross this one as they cross creases. Cost: its length.
  void add(const GuideWay& way);
  /// The side from a vertex to one of its neighbours.
  [[nodiscard]] uint32_t side(uint32_t from, uint32_t to) const;

 private:
  [[nodiscard]] Vec3d onCrease(uint32_t v, const Vec3d& place) const;
  [[nodiscard]] std::vector<uint32_t> shortest(uint32_t from, uint32_t to) const;

  const TriangleMesh& mesh_;
  NearestTriangle tree_;
  std::vector<bool> creases_, lines_;  // sides; lines are creases and ways
  double meanSide_;
  std::vector<bool> onLine_;                  // vertices
  std::vector<uint32_t> first_, sides_, to_;  // of each vertex the sides that begin there
};

}  // namespace argil::clay
