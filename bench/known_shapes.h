#pragma once
// Shapes of which every distance is known, and how clay comes by them.

#include <array>
#include <string_view>
#include <vector>

#include "clay/store/version.h"
#include "engine/document/quality.h"

namespace argil::bench {

inline constexpr double kBallMm = 20;  ///< Radius of what is worked on; everything is 40 mm long.

/// Of a quality's voxels across `sideMm`; its origin off the middle of everything, so that no shape meets the grid at a
/// place that flatters it.
[[nodiscard]] clay::Grid gridOf(const engine::Quality& quality, double sideMm = 2 * kBallMm);
/// The ball.
[[nodiscard]] clay::Version ballOf(const engine::Quality& quality, const clay::Grid& grid);

/// A solid that turns about z, of two circles in the half plane (r, z): the first, with the second cut away or added.
struct Turned {
  Eigen::Vector2d a = {0, 0}, b = {0, 0};
  double radiusA = kBallMm, radiusB = 0;
  bool cut = true;

  /// Where both circles meet.
  [[nodiscard]] std::vector<Eigen::Vector2d> rims() const;
  [[nodiscard]] double distance(const Vec3d& at) const;
  /// Places on its sharp edges, and on all of its skin.
  [[nodiscard]] std::vector<Vec3d> edges() const;
  [[nodiscard]] std::vector<Vec3d> places() const;

 private:
  [[nodiscard]] bool onSkin(const Eigen::Vector2d& p, bool ofA) const;
};

/// The ball with something done to it by a stroke that goes once around z.
struct Ring {
  const char* name;
  const char* tool;     ///< Null: nothing is done.
  double radiusMm, at;  ///< Of the tip; of the circle that its middle goes along, mm.
};
inline constexpr std::array kRings{Ring{"ball", nullptr, 0, 0}, Ring{"groove", "carve", 2.5, 20},
                                   Ring{"rim", "carve", 4, 22}, Ring{"ridge", "add", 2, 20}};
[[nodiscard]] Turned turnedOf(const Ring& ring);
[[nodiscard]] clay::Version ringOn(const Ring& ring, clay::Version clay, const engine::StrokeQuality& quality);

}  // namespace argil::bench
