#pragma once
// Places that attract what is dragged: other guides, the clay, right angles, the grid.

#include <optional>
#include <string>
#include <vector>

#include "ui3d/studio/widgets/subject.h"

namespace argil::studio {

inline constexpr double kSnapUnits = 10;                         ///< Interface units within which a feature attracts.
inline constexpr double kSnapAngle = 4 * 0.0174532925199;        ///< rad, to a right angle.
inline constexpr double kStepAngle = 15 * 0.017453292519943295;  ///< rad, of constrained turns.

/// Where something snapped to, and what is to be lit there.
struct Snap {
  Vec3d at = Vec3d::Zero();
  std::string text;              ///< "Plane 1", "surface", "grid".
  std::vector<Vec3d> highlight;  ///< A line; the place itself is marked besides.
};

/// Where a dragged point may be.
struct Bound {
  enum class Kind : uint8_t { none, line, plane } kind = Kind::none;
  Vec3d origin = Vec3d::Zero(), axis = Vec3d::UnitZ();  ///< Of the line, or normal to the plane; unit.
  [[nodiscard]] Vec3d nearest(const Vec3d& p) const;
};

struct SnapQuery {
  Target self;  ///< Does not attract itself.
  Bound bound;
  Vec3d at = Vec3d::Zero();  ///< Where it would be without snapping: within the bound.
  std::optional<Ray> sight;  ///< Of a mouse, where the bound is none: depth is open.
  bool toSurface = false;
  bool aligns = false;        ///< Features beside the bound count too, by their foot on it.
  std::vector<Vec3d> beside;  ///< Right angles from these.
  double tipReachMm = 0;      ///< Of a stylus, to the surface.
};
/// Points go before lines, these before surfaces, right angles, planes and the grid; of equals the nearest.
[[nodiscard]] std::optional<Snap> snapPlace(const World& world, const engine::Document& shown, const SnapQuery& query);

/// Steps of 15° are not meant here: the angle near `angle` at which one of the directions is parallel or square to the
/// world's axes or to another guide, when all turn about `axis`.
[[nodiscard]] std::optional<double> snapTurn(const engine::Document& shown, const Target& self,
                                             const std::vector<Vec3d>& directions, const Vec3d& axis, double angle);

/// The nearest multiples of the grid's spacing, as far as the bound allows.
[[nodiscard]] Vec3d toGrid(const World& world, const Bound& bound, const Vec3d& start, const Vec3d& at);

}  // namespace argil::studio
