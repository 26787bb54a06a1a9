#pragma once
// Free-form deformation by a lattice of control points (Sederberg & Parry): a box of clay follows the points around it.

#include <array>
#include <vector>

#include "clay/whole/warp.h"

namespace argil::clay {

/// Bernstein polynomials over a box, 2 to 8 control points an axis. The box must hold the whole piece, unless none of
/// the points on its sides was moved: then what lies outside of it stays. Control points are not on the clay but pull
/// it; drag() moves a point of the clay itself.
class Lattice : public Warp {
 public:
  /// Control points in place: nothing moves. Throws Error for a box that is not finite or thinner than 1e-6 mm, or
  /// counts out of range.
  explicit Lattice(const BoxMm& box, std::array<int, 3> counts = {4, 4, 4});
  /// Around a piece with a margin on every side of a twentieth of its longest side.
  [[nodiscard]] static Lattice around(const BoxMm& piece, std::array<int, 3> counts = {4, 4, 4});

  [[nodiscard]] const BoxMm& box() const { return box_; }
  [[nodiscard]] std::array<int, 3> counts() const { return counts_; }
  /// Control points, z fastest, then y, then x. mm.
  [[nodiscard]] const std::vector<Vec3d>& points() const { return points_; }
  [[nodiscard]] size_t index(int x, int y, int z) const;
  /// Where a control point is while nothing moves.
  [[nodiscard]] Vec3d restPoint(size_t index) const;
  /// Throws Error for a place that is not finite or an index out of range.
  void setPoint(size_t index, const Vec3d& mm);
  /// Moves the control points as little as possible (least squares) so that the clay at `p`, its place before any
  /// deformation, moves by `by`. A place outside of the box is brought to its side.
  void drag(const Vec3d& p, const Vec3d& by);
  [[nodiscard]] bool moved() const;

  [[nodiscard]] Vec3d map(const Vec3d& p, Eigen::Matrix3d& jacobian) const override;
  [[nodiscard]] BoxMm domain(const BoxMm& piece) const override;
  [[nodiscard]] bool fixes(const BoxMm& box) const override;

 private:
  void place();
  BoxMm box_;
  std::array<int, 3> counts_;
  std::vector<Vec3d> points_;
  // Four doubles a point, so that compilers take them two by two.
  std::vector<Eigen::Vector4d> packed_;
  bool sidesMoved_ = false, moved_ = false;
};

}  // namespace argil::clay
