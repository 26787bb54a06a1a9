#pragma once
// A region that the tool's ball may not enter, or not leave, as something to touch.

#include "haptics/scene/guide.h"
#include "haptics/scene/touchable.h"

namespace argil::haptics {

/// Box, ball, plane or piece of clay. Its inside, where distances are negative, is where the ball may not be. A region
/// that holds the tool in is never smaller than the ball. Servo thread only.
class KeepOut final : public Touchable {
 public:
  /// What it is from now on. `guide` is a keep-out; `scene`, which holds its piece, outlives the use, as does `clay`,
  /// which searches a piece for it (null for other kinds). True when it is not what it was before.
  bool reset(const Guide& guide, const Scene& scene, TouchableClay* clay) ARGIL_REALTIME;

  Nearest nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME override;
  Vec3d normal(const Vec3d& point) ARGIL_REALTIME override;
  /// Of a piece its voxel; the others are exact, and tolerances are counted in quarters of the tool's radius.
  [[nodiscard]] double resolutionMm() const ARGIL_REALTIME override;

 private:
  enum class Kind : uint8_t { none, box, ball, plane, piece };
  struct Region {
    Kind kind = Kind::none;
    bool inside = false;
    Vec3d place = Vec3d::Zero();  // Of the box, the ball's centre, a point of the plane.
    Vec3d size = Vec3d::Zero();   // Half edges; radius in x; unit normal.
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    bool operator==(const Region& o) const noexcept {
      return kind == o.kind && inside == o.inside && place == o.place && size == o.size &&
             rotation.coeffs() == o.rotation.coeffs();
    }
  };
  [[nodiscard]] Nearest toBox(const Vec3d& p) const noexcept;
  [[nodiscard]] Nearest toBall(const Vec3d& p, const Vec3d* hint) const noexcept;

  Region region_;
  double radius_ = 1;
  TouchableClay* clay_ = nullptr;
};

}  // namespace argil::haptics
