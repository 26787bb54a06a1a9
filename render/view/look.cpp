// Names and limits of what a picture may be asked for.

#include "render/view/look.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/base/error.h"
#include "render/view/overlays.h"

namespace argil::render {
namespace {

constexpr std::array<std::string_view, 3> kShadings{"matcap", "lit", "material"};
constexpr std::array<std::string_view, 6> kMatcaps{"clay", "wax", "porcelain", "steel", "rubber", "normals"};

template <class Enum>
std::optional<Enum> named(std::span<const std::string_view> names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

bool direction(const Vec3d& v) {
  return v.allFinite() && v.squaredNorm() > 0;
}
bool within(double value, double least, double most) {
  return value >= least && value <= most;  // false for NaN
}
bool finite(const Colour& c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b) && std::isfinite(c.a);
}

void check(const Cursor& c) {
  if (!c.positionMm.allFinite() || !direction(c.shaft) || !direction(c.drop) || !(c.radiusMm > 0) ||
      !std::isfinite(c.radiusMm) || !finite(c.tint)) {
    throw Error(
        "the cursor's position, shaft, drop, radius or tint is not finite, or its radius not above zero; leave the "
        "cursor out instead");
  }
  if (!c.forceN.allFinite() || !(c.fullForceN > 0) || !std::isfinite(c.fullForceN))
    throw Error("the cursor's force is not finite or its full force not above zero; give a force of zero instead");
  if (c.footprint && (!c.footprint->pointMm.allFinite() || !direction(c.footprint->normal)))
    throw Error("the cursor's footprint is not a finite point and direction; leave the footprint out instead");
}

}  // namespace

std::span<const std::string_view> shadingNames() {
  return kShadings;
}
std::span<const std::string_view> matcapNames() {
  return kMatcaps;
}
std::optional<Shading> shadingNamed(std::string_view name) {
  return named<Shading>(kShadings, name);
}
std::optional<Matcap> matcapNamed(std::string_view name) {
  return named<Matcap>(kMatcaps, name);
}

void check(const Look& look) {
  if (!within(look.cavityStrength, 0, 2)) throw Error("the cavity strength must lie between 0 and 2");
  if (!within(look.depthFadeStrength, 0, 1)) throw Error("the depth fade must lie between 0 and 1");
  if (look.section && (!look.section->pointMm.allFinite() || !direction(look.section->normal)))
    throw Error("the section plane needs a finite point in mm and a normal that is not zero");
}

void check(const Overlays& overlays) {
  if (overlays.cursor) check(*overlays.cursor);
  const auto points = [](const std::vector<Vec3d>& all) {
    return std::all_of(all.begin(), all.end(), [](const Vec3d& p) { return p.allFinite(); });
  };
  for (const Polyline& path : overlays.polylines) {
    if (!points(path.pointsMm))
      throw Error("a path to be drawn holds a point that is not finite; leave that point out");
    if (!within(path.widthPixels, 0, 1000) || !finite(path.colour))
      throw Error("a path to be drawn has a width outside of 0 to 1000 pixels or a colour that is not finite");
  }
  for (const Fill& fill : overlays.fills) {
    if (fill.trianglesMm.size() % 3 != 0) throw Error("the faces of a fill are triangles: give three corners each");
    if (!points(fill.trianglesMm) || !finite(fill.colour))
      throw Error("a fill to be drawn holds a corner or a colour that is not finite; leave that triangle out");
  }
  if (overlays.planes.size() > kMostPlaneMarks) throw Error("clay shows four planes at most; leave the others out");
  for (const PlaneMark& plane : overlays.planes) {
    if (!plane.pointMm.allFinite() || !plane.normal.allFinite() || !(plane.normal.norm() > 0))
      throw Error("a plane to be drawn needs a point and a normal that are finite, and a normal that is not zero");
    if (!within(plane.widthPixels, 0, 1000) || !finite(plane.line) || !finite(plane.beyond))
      throw Error("a plane to be drawn has a width outside of 0 to 1000 pixels or a colour that is not finite");
  }
}

}  // namespace argil::render
