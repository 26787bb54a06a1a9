#pragma once
// A web of quads whose vertices lie on the surface of a clay and along its creases.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "clay/cage/crease_map.h"
#include "clay/cage/quad_web.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

/// What a web lies on. All of it must outlive the web.
struct WebGround {
  const TriangleMesh& surface;
  const NearestTriangle& tree;  ///< Searches it.
  const CreaseMap& creases;
  const std::vector<float>& sizes;  ///< Of edges, mm, at each vertex of the surface: above 0.
  const std::vector<float>& walls;  ///< How thick the clay is there, mm.
  double finest = 0;                ///< Nothing finer is looked at, mm, but in thinner walls.
};

/// Places vertices, evens edges out, and judges what quads look like and how far they lie off. One thread.
class WebOnSurface {
 public:
  /// Scaled Jacobians: evening out leaves none below the first that was not; below the second vertices are unfolded.
  static constexpr double kLeastJacobian = 0.2, kGoodJacobian = 0.4;
  static constexpr double kLeastMade = 0.02;  ///< Of the finest: no edge becomes shorter than that.

  /// Vertices go onto the surface; those of lines of creases onto the creases, one of them to each corner of the clay.
  /// Throws Error for a mesh that is not closed.
  WebOnSurface(QuadMesh mesh, const WebGround& ground);

  [[nodiscard]] QuadWeb& web() { return web_; }
  [[nodiscard]] const QuadWeb& web() const { return web_; }
  [[nodiscard]] double sizeBetween(uint32_t a, uint32_t b) const { return 0.5 * (size_[a] + size_[b]); }

  /// How far middles of edges and quads may lie off the surface, in stages: a fifth of their length, and more, and
  /// less than half of a wall.
  [[nodiscard]] size_t stage() const { return stage_; }
  void setStage(size_t stage) { stage_ = stage; }
  static constexpr size_t kStages = 4;  ///< In the last of them, as far as they like.

  /// A vertex goes to what is nearest to p: on the surface, or on the creases if it lies on a line; an end stays.
  void place(uint32_t v, const Vec3d& p);
  /// To p itself, on the surface or not; its size and normal are those of the surface beside it.
  void placeAt(uint32_t v, const Vec3d& p);
  /// To the nearest place of the surface, on a line or not.
  void placeOnSurface(uint32_t v, const Vec3d& p);
  /// What is nearest to p. `near`: a vertex that is near by.
  [[nodiscard]] Vec3d onSurface(const Vec3d& p, uint32_t near) const;

  /// The least scaled Jacobian of what v moves: of its own corners of the quads around it and those beside them. 1: a
  /// right angle that faces outwards, at a crease as its quad does; below 0: folded.
  [[nodiscard]] double shapeAt(uint32_t v) const;
  /// How far the middles of an edge, or of edges and quads around a vertex if it were at `to`, lie off the surface, in
  /// parts of what the stage allows; 0 where that is little. Quad `without` does not count.
  [[nodiscard]] double edgeOff(uint32_t from, uint32_t to) const;
  [[nodiscard]] double offAround(uint32_t v, const Vec3d& to, uint32_t without = UINT32_MAX) const;

  /// Edges of one length in proportion to the sizes pull by as much. What folds a quad, draws one through the clay, or
  /// lets a body of few quads shrink to a point, does not stay.
  void relax(uint32_t v);
  /// v goes where the worst corner around it is best, if there is such a place: over a quad with a corner that bends
  /// inwards every smooth face folds. No edge becomes shorter than `leastEdge` sizes that was not.
  void unfold(uint32_t v, double leastEdge = 0);

  /// As in QuadWeb; what is added comes onto the surface.
  std::vector<uint32_t> replace(const std::vector<uint32_t>& going, const std::vector<std::array<uint32_t, 4>>& quads,
                                const std::vector<uint32_t>& free,
                                const std::vector<std::vector<uint32_t>>& lines = {});
  uint32_t add(const Vec3d& at, uint32_t near);
  void takeBack(uint32_t first);
  QuadWeb::Kept forgetGone();  ///< As in QuadWeb.
  /// A vertex as it is, to be put back.
  struct Place {
    uint32_t vertex;
    Vec3d at, normal;
    double size;
  };
  [[nodiscard]] Place placeOf(uint32_t v) const { return {v, web_.at(v), normals_[v], size_[v]}; }
  void putBack(const Place& place);

 private:
  using Near = std::array<uint32_t, 5>;
  static constexpr Near kNoneNear{UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};

  void keepFor(size_t vertices, uint32_t hint = UINT32_MAX);
  bool isOnLine(uint32_t v);
  void placeCorners(const std::vector<Vec3d>& before);
  [[nodiscard]] double sizeOf(const NearestTriangle::Hit& hit) const;
  // `hint`: a triangle near by; the nearest one afterwards, or one that is near enough.
  [[nodiscard]] double off(const Vec3d& p, double length, uint32_t& hint) const;
  [[nodiscard]] double middleOff(const Vec3d& p, const Vec3d& q, uint32_t& hint) const;
  // Of the edges to what was put into `beside_`.
  [[nodiscard]] double shortestAt(uint32_t v) const;
  [[nodiscard]] Vec3d alongLines(uint32_t v) const;

  QuadWeb web_;
  WebGround ground_;
  size_t stage_ = 0;
  std::vector<uint32_t> hints_, creaseHints_;
  std::vector<double> size_;
  std::vector<Vec3d> normals_;
  // Of each quad: triangles near the middles of its edges, by the corner that they begin at, and near its own.
  mutable std::vector<Near> near_;
  struct Around;
  std::shared_ptr<const Around> around_;  // least sizes and walls near each vertex of the surface
  double least_, thinnest_;               // and of all
  std::vector<uint32_t> beside_, pulling_;
};

}  // namespace argil::clay
