#pragma once
// Walls and bars that repeat and hold a hollow print open.

#include <cstdint>

#include "clay/base/vec.h"

namespace argil::clay {

enum class Infill : uint8_t {
  gyroid,  ///< One smooth wall without end or crossing, with a way through on either side of it.
  struts,  ///< Round bars along the edges of cubes that stand on a corner. All of it is one way.
  cubic,   ///< Walls along the faces of cubes that stand on a corner: closed cells.
};

/// One kind of infill with its measures: a solid without end, given by its distance. Cubes stand on a corner, so that
/// none of it hangs over by more than 55° from the vertical along `turn`'s third row. Const members: any thread.
class InfillField {
 public:
  /// `cell`, `wall` and `near` in one unit, above 0; `turn` takes a place to where +z is up. A cell's middle lies at
  /// zero.
  InfillField(Infill kind, double cell, double wall, const Eigen::Matrix3d& turn, double near);

  /// Negative in the clay. Bars and walls: exact outside. Gyroid: to a few thousandths of a cell where that is less
  /// than `near`, beyond it less than the distance.
  [[nodiscard]] double distance(const Vec3d& p) const;

 private:
  Infill kind_;
  double cell_, wall_, near_;
  Eigen::Matrix3d axes_;
};

/// The part of space that is clay, 0 to 1. Closed form; of a gyroid that of a thin wall, within 0.02 to 0.5.
[[nodiscard]] double infillDensity(Infill kind, double wallPerCell);

}  // namespace argil::clay
