#pragma once
// Where a tool was.

#include <optional>

#include "clay/base/vec.h"

namespace argil::engine {

/// A place and its time, and how the tool was held there.
struct PathPoint {
  double timeS = 0;  ///< From the stroke's beginning or any other zero; never decreases in a path.
  Vec3d mm = Vec3d::Zero();
  double pressure = 1;  ///< 0 to 1: of a pen, or of the force that is felt.
  /// Of the stylus, where it has one; else the tip stands on the surface.
  std::optional<Eigen::Quaterniond> rotation = {};

  friend bool operator==(const PathPoint& a, const PathPoint& b) {
    return a.timeS == b.timeS && a.mm == b.mm && a.pressure == b.pressure &&
           a.rotation.has_value() == b.rotation.has_value() &&
           (!a.rotation || a.rotation->coeffs() == b.rotation->coeffs());
  }
};

}  // namespace argil::engine
