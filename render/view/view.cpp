#include "render/view/view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "clay/base/error.h"

namespace argil::render {
namespace {

constexpr double kMargin = 0.05;         ///< Of the picture, free on the tightest side after fit().
constexpr double kEmptyHalfEdge = 50.0;  ///< mm; what is framed when there is nothing to see.

struct Name {
  const char* name;
  Vec3d from;  ///< Direction from the target to the camera.
  Vec3d up;
};
const std::array<Name, 7>& table() {
  static const std::array<Name, 7> rows{{{"front", {0, -1, 0}, {0, 0, 1}},
                                         {"back", {0, 1, 0}, {0, 0, 1}},
                                         {"left", {-1, 0, 0}, {0, 0, 1}},
                                         {"right", {1, 0, 0}, {0, 0, 1}},
                                         {"top", {0, 0, 1}, {0, 1, 0}},
                                         {"bottom", {0, 0, -1}, {0, -1, 0}},
                                         {"iso", {0.62, -1, 0.62}, {0, 0, 1}}}};
  return rows;
}

double halfTangent(const View& view) {
  return std::tan(0.5 * view.openingDegrees * std::numbers::pi / 180);
}

}  // namespace

void Box::add(const Vec3d& point) {
  if (empty()) {
    min = max = point;
  } else {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
}

void Box::add(const Box& other) {
  if (other.empty()) return;
  add(other.min);
  add(other.max);
}

const std::vector<std::string>& View::names() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> result;
    for (const Name& row : table()) result.emplace_back(row.name);
    return result;
  }();
  return all;
}

View View::named(const std::string& name, const Box& bounds, double aspect, Projection projection) {
  for (const Name& row : table()) {
    if (name != row.name) continue;
    View view;
    view.projection = projection;
    view.target = Vec3d::Zero();
    view.position = row.from;
    view.up = row.up;
    view.fit(bounds, aspect);
    return view;
  }
  std::string known;
  for (const std::string& each : names()) known += (known.empty() ? "" : ", ") + each;
  throw Error("there is no view named '" + name + "'; choose one of " + known);
}

View::Axes View::axes() const {
  Axes axes;
  axes.forward = (target - position).normalized();
  Vec3d right = axes.forward.cross(up.normalized());
  if (right.squaredNorm() < 1e-12) {
    right = axes.forward.cross(std::abs(axes.forward.z()) > 0.5 ? Vec3d::UnitY() : Vec3d::UnitZ());
  }
  axes.right = right.normalized();
  axes.up = axes.right.cross(axes.forward);
  return axes;
}

double View::heightAtTarget() const {
  return 2 * distance() * halfTangent(*this);
}

void View::fit(const Box& bounds, double aspect) {
  Box box = bounds;
  if (box.empty()) {
    box.min = Vec3d::Constant(-kEmptyHalfEdge);
    box.max = Vec3d::Constant(kEmptyHalfEdge);
  }
  const Axes a = axes();
  const Vec3d centre = box.centre();
  const double usable = 1 - 2 * kMargin;
  const double tanY = halfTangent(*this) * usable, tanX = tanY * aspect;
  double needed = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = Vec3d((corner & 1) ? box.max.x() : box.min.x(), (corner & 2) ? box.max.y() : box.min.y(),
                          (corner & 4) ? box.max.z() : box.min.z()) -
                    centre;
    const double sideways = std::max(std::abs(p.dot(a.right)) / tanX, std::abs(p.dot(a.up)) / tanY);
    const double nearer = projection == Projection::perspective ? -p.dot(a.forward) : 0;
    needed = std::max(needed, sideways + nearer);
  }
  // A point or a line still needs a camera that stands off.
  needed = std::max({needed, 0.75 * box.size().norm(), 1e-3, 1e-9 * centre.norm()});
  target = centre;
  position = centre - needed * a.forward;
}

View View::revolved(double degrees) const {
  const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180, Vec3d::UnitZ());
  View view = *this;
  view.position = target + turn * (position - target);
  view.up = turn * up;
  return view;
}

Vec3d View::project(const Vec3d& point, int width, int height) const {
  const Axes a = axes();
  const Vec3d p = point - position;
  const double z = p.dot(a.forward);
  const double halfHeight = projection == Projection::perspective ? z * halfTangent(*this) : 0.5 * heightAtTarget();
  const double pixelsPerMm = 0.5 * height / halfHeight;
  return {0.5 * width + p.dot(a.right) * pixelsPerMm, 0.5 * height - p.dot(a.up) * pixelsPerMm, z};
}

void View::check() const {
  if (!position.allFinite() || !target.allFinite() || !up.allFinite() || up.squaredNorm() == 0) {
    throw Error(
        "the view holds a position, target or up direction that is not a finite vector; give three numbers each");
  }
  if (!(openingDegrees >= 1 && openingDegrees <= 150)) {
    throw Error("the view's opening angle must lie between 1 and 150 degrees");
  }
  if (!(distance() > 1e-9 * (1 + position.norm()))) {
    throw Error("the view's position and target coincide; move the camera away from what it looks at");
  }
}

}  // namespace argil::render
