#pragma once
// Two or three flat faces that meet in edges of one turn, rounded by a ball: its exact distance.

#include <array>
#include <optional>

#include "clay/base/vec.h"
#include "clay/surface/crease_model.h"
#include "clay/surface/crease_path.h"

namespace argil::clay {

/// Coordinates are those of the model it is made of. A few dozen floating-point operations a call, in a fixed order.
class RoundedWedge {
 public:
  /// Nothing where the faces meet by convex and by concave edges.
  static std::optional<RoundedWedge> of(const CreaseModel& model);

  struct Value {
    float distance = 0;              ///< Signed.
    Vec3f gradient = Vec3f::Zero();  ///< Of unit length.
    float byRadius = 0;              ///< Derivative by the radius.
  };
  [[nodiscard]] Value at(const Vec3f& p) const;

  /// Chooses the radius, 0 to kMostRadius, that fits the values around a cell best.
  void fit(const CellView& cell);
  [[nodiscard]] float radius() const { return radius_; }
  /// The most that the values at the cell's corners are off, voxels.
  [[nodiscard]] float misfit(const CellView& cell) const;

 private:
  static constexpr float kMostRadius = 4;

  // Of distances from the faces moved in by the radius: the largest, and whether its face alone counts.
  [[nodiscard]] size_t farthest(const std::array<float, 3>& d) const;
  [[nodiscard]] bool alone(const std::array<float, 3>& d, size_t most) const;

  // Where no face alone counts.
  [[nodiscard]] Value between(const std::array<float, 3>& d, size_t most) const;
  [[nodiscard]] Value given(float distance, const Vec3f& gradient, float byRadius) const;

  std::array<Vec3f, 3> normal_;
  std::array<float, 3> offset_{};
  float cosine_[3][3] = {};
  int count_ = 0;
  float turn_ = 1;  // −1: concave, taken as the hollow that it is of the other side.
  float radius_ = 0;
};

}  // namespace argil::clay
