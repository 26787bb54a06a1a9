#pragma once
// Triangles that cover a polygon.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// Divides polygons, convex or not, into triangles by ear clipping (G. H. Meisters, Polygons Have Ears, 1975). Reuses
/// its memory from polygon to polygon. Equal input gives equal triangles.
class Triangulator {
 public:
  /// Appends size − 2 triangles of places in `corners`, turned as the polygon is. Where a fan about the first corner
  /// covers the polygon, the triangles are that fan. A polygon is seen along its mean normal (Newell), so it need not
  /// lie in a plane; it may touch itself, as one with a hole does where an edge leads to the hole and back. Of a
  /// polygon that crosses itself a part may be covered twice or not at all: then the result is false. One without area
  /// is covered by any triangles. At least three
  /// corners, finite coordinates. O(n log n) for most polygons; work beyond a limit
  /// leaves the rest a fan and gives false.
  bool add(std::span<const Vec3d> corners, std::vector<std::array<uint32_t, 3>>& triangles);

 private:
  struct Point {
    double x, y;
  };
  /// How good an ear is; `none` is no ear.
  enum class Ear : uint8_t { good, flat, none };
  struct Candidate {
    Ear ear;
    double squared;  // of its diagonal
    uint32_t corner, stamp;
    bool operator<(const Candidate& o) const {
      if (ear != o.ear) return ear > o.ear;
      return squared != o.squared ? squared > o.squared : corner > o.corner;
    }
  };

  void project(std::span<const Vec3d> corners, const Vec3d& normal);
  void sortIntoCells();
  template <class Visit>
  void forEachNear(uint32_t a, uint32_t b, uint32_t c, const Visit& visit);
  [[nodiscard]] double turn(uint32_t a, uint32_t b, uint32_t c) const;
  [[nodiscard]] double squared(uint32_t a, uint32_t b) const;
  [[nodiscard]] bool same(uint32_t a, uint32_t b) const;
  [[nodiscard]] bool opensTo(uint32_t at, uint32_t first, uint32_t last, uint32_t to, double sign, bool& flat) const;
  [[nodiscard]] Ear earAt(uint32_t corner);
  void queue(uint32_t corner);
  void queueAll();
  bool clip(std::vector<std::array<uint32_t, 3>>& triangles);

  std::vector<Vec3d> scaled_;
  std::vector<Point> points_;
  std::vector<uint32_t> next_, before_, stamp_;
  std::vector<bool> gone_;
  std::vector<Candidate> queue_;
  // A grid of cells over the points: those of cell i are inCell_[cell_[i]] to inCell_[cell_[i + 1]].
  std::vector<uint32_t> cell_, inCell_;
  Point low_{}, cellSize_{};
  uint32_t columns_ = 0, rows_ = 0;
  uint32_t left_ = 0, anyLeft_ = 0;
  uint64_t work_ = 0, mostWork_ = 0;
};

}  // namespace argil::clay
