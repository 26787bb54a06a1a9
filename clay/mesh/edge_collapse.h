#pragma once
// Edges of a mesh, collapsed one after another, the one that costs the shape least first. Method: NOTES.md,
// "Reduction".

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/quadric.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// A mesh that loses two triangles at a time. What is a closed fan around a vertex stays one, no edge comes to be in
/// more than two triangles, and bodies and their genus stay; no triangle turns by more than a set angle at a time. A
/// vertex whose triangles are not one closed fan (at a hole, where sheets touch) stays, and with it its edges. Equal
/// meshes give equal results. One thread. Memory: about 75 bytes a triangle, and 30 more while it runs.
class EdgeCollapse {
 public:
  /// Called now and then with the triangles that are left; may throw to end the work.
  using Watch = std::function<void(uint64_t triangles)>;

  /// What bounds the way that the surface may go, at a price in time: vertices of the original stay within `mm` of the
  /// triangles that took their place, and new triangles (corner, middles of edges, middle) within `mm` of the original.
  /// What lies between may go a little farther.
  struct Bound {
    double mm = 0;
    std::vector<bool> fixed;  ///< Vertices that stay as they are; or empty.
  };

  /// Indices in range, coordinates finite; `mesh` must outlive it.
  EdgeCollapse(const TriangleMesh& mesh, std::optional<Bound> bound, const Watch& watch);

  /// Until at most `triangles` are left, or nothing can go any more.
  void run(uint64_t triangles, const Watch& watch);
  [[nodiscard]] uint64_t triangles() const { return alive_; }
  [[nodiscard]] uint64_t movable() const { return movable_; }  ///< Vertices that were not held at the beginning.
  /// Vertices and triangles in the order that they had.
  [[nodiscard]] TriangleMesh result() const;

 private:
  /// Half-edge 3t + k runs from corner k of triangle t to the next one.
  using HalfEdge = uint32_t;
  static constexpr uint32_t kNone = UINT32_MAX;
  struct Waiting {
    HalfEdge edge;
    uint32_t since;  // Collapses that had been done: stale once an end has changed later.
  };
  struct Goal {
    Vec3d at;
    float cost;
  };

  static HalfEdge next(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static HalfEdge before(HalfEdge h) { return h % 3 == 0 ? h + 2 : h - 1; }
  [[nodiscard]] bool held(uint32_t v) const { return start_[v] == kNone; }

  void pairEdges();
  void findFans();
  void addQuadrics();
  void push(HalfEdge h);
  void pushAll();
  [[nodiscard]] Goal goal(HalfEdge h) const;
  bool tryCollapse(HalfEdge h);
  /// The outgoing half-edges of a vertex; false when there are too many.
  bool ring(uint32_t v, std::vector<HalfEdge>& out) const;
  [[nodiscard]] bool staysUpright(const std::vector<HalfEdge>& out, HalfEdge gone1, HalfEdge gone2,
                                  const Vec3d& at) const;
  bool staysNear(HalfEdge h, HalfEdge g, const Vec3d& at);

  const TriangleMesh& mesh_;
  Vec3d middle_ = Vec3d::Zero();
  double costScale_ = 1;
  std::optional<Bound> bound_;
  std::optional<NearestTriangle> original_;  // When there is a bound.
  std::vector<Vec3d> positions_;             // From middle_.
  std::vector<Quadric> quadrics_;
  std::vector<uint32_t> vertex_;   // Where a half-edge begins; kNone when its triangle is gone.
  std::vector<HalfEdge> twin_;     // kNone at a rim.
  std::vector<HalfEdge> start_;    // An outgoing half-edge of a vertex; kNone when it is held, unused or gone.
  std::vector<uint32_t> changed_;  // Number of the last collapse that moved the vertex, from 1.
  std::vector<std::deque<Waiting>> queue_;
  size_t cheapest_ = 0;
  uint64_t alive_ = 0, movable_ = 0;
  uint32_t collapses_ = 0;

  // Original vertices by the triangle that took their place: lists, when there is a bound.
  std::vector<uint32_t> firstGuest_, nextGuest_;

  // Reused.
  std::vector<HalfEdge> ringU_, ringV_;
  struct Move {
    uint32_t guest, triangle;
  };
  std::vector<Move> moves_;
  std::vector<std::array<Vec3d, 3>> fan_;
  std::vector<uint32_t> fanTriangles_;
};

}  // namespace argil::clay
