#pragma once
// A smooth curve through given points.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/vec.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// A curve through points, with a continuous tangent everywhere: cubic pieces whose end tangents are weighted by the
/// chords beside (Catmull-Rom for uneven points). Immutable; read by any number of threads. What is marked real-time
/// safe costs about the same for ten points and for a million.
class Polyline {
 public:
  /// A place on the curve. Belongs to the curve that gave it.
  struct Place {
    uint32_t piece = 0;
    double t = 0;  ///< 0 to 1 within the piece.
    Vec3d point = Vec3d::Zero();
    Vec3d tangent = Vec3d::UnitX();  ///< Unit length.
    double distance = 0;             ///< From the place asked for.
  };

  /// `closed`: the last point is joined to the first. Points that repeat are dropped. Throws Error when fewer than two
  /// (closed: three) are left, when one is not finite or beyond 1e6 mm, or when there are more than kMaxPoints.
  explicit Polyline(std::vector<Vec3d> points, bool closed = false);

  [[nodiscard]] double lengthMm() const noexcept { return starts_.back(); }
  [[nodiscard]] bool closed() const noexcept { return closed_; }
  /// Differs between any two curves of a process, copies aside: addresses are reused.
  [[nodiscard]] uint64_t id() const noexcept { return id_; }

  /// The place at an arc length from the beginning, cut to 0 .. lengthMm(); exact to 1e-6 of a piece.
  [[nodiscard]] Place at(double arcLengthMm) const ARGIL_REALTIME;
  /// Arc length of a place, mm.
  [[nodiscard]] double arcLengthMm(const Place& place) const ARGIL_REALTIME;

  /// The nearest place of all. `hint`: a place near the answer makes it cheaper. Looks at no more than kMostLeaves
  /// groups of pieces: where the whole curve is about equally far (the centre of a ring) the answer is the best of
  /// these, never farther than the hint.
  [[nodiscard]] Place nearest(const Vec3d& p, const Place* hint = nullptr) const ARGIL_REALTIME;
  /// The nearest place that is reached from `from` along the curve without ever going away from p: a bead on a wire. It
  /// stays on its strand where strands cross. Walks at most kMostPieces pieces.
  [[nodiscard]] Place slide(const Vec3d& p, const Place& from) const ARGIL_REALTIME;

  static constexpr size_t kMaxPoints = 1'000'000;
  static constexpr int kMostLeaves = 48;
  static constexpr int kMostPieces = 256;

 private:
  struct Piece {
    std::array<Vec3d, 4> c;  // c0 + t c1 + t² c2 + t³ c3
    double bulge = 0;        // No place of it is farther from its chord, mm.
    [[nodiscard]] Vec3d point(double t) const noexcept { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
    [[nodiscard]] Vec3d first(double t) const noexcept { return c[1] + t * (2 * c[2] + 3 * t * c[3]); }
    [[nodiscard]] Vec3d second(double t) const noexcept { return 2 * c[2] + 6 * t * c[3]; }
    [[nodiscard]] double arc(double t) const noexcept;
  };
  struct Box {
    Vec3d low, high;
    [[nodiscard]] double distance2(const Vec3d& p) const noexcept {
      return (low - p).cwiseMax(p - high).cwiseMax(0).squaredNorm();
    }
  };

  void addPieces(const std::array<Vec3d, 4>& bezier, int depth);
  void buildBoxes();
  [[nodiscard]] Place finish(uint32_t piece, double t, const Vec3d& p) const noexcept;
  static double descend(const Piece& piece, const Vec3d& p, double t) noexcept;

  bool closed_;
  uint64_t id_;
  std::vector<Piece> pieces_;
  std::vector<double> starts_;  // Arc length where each piece begins, and the whole length.
  std::vector<Box> boxes_;      // A complete binary tree over groups of kGroup neighbouring pieces; the root is box 1.
  size_t leaves_ = 1;
};

}  // namespace argil::haptics
