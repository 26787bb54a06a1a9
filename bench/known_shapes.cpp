#include "bench/known_shapes.h"

#include <cmath>
#include <numbers>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"

namespace argil::bench {

namespace {

// One after the other around z, by the golden angle.
Vec3d turned(const Eigen::Vector2d& p, size_t number) {
  const double angle = 2.399963229728653 * static_cast<double>(number);
  return {p.x() * std::cos(angle), p.x() * std::sin(angle), p.y()};
}

}  // namespace

clay::Grid gridOf(const engine::Quality& quality, double sideMm) {
  clay::Grid grid;
  grid.voxelMm = sideMm / quality.clay.voxelsAcross;
  grid.band = static_cast<float>(quality.clay.band);
  grid.originMm = Vec3d(0.31, 0.17, 0.23) * grid.voxelMm;
  return grid;
}

clay::Version ballOf(const engine::Quality& quality, const clay::Grid& grid) {
  return clay::makeSphere(clay::Store::make(quality.clay.precision()), grid, Vec3d::Zero(), kBallMm);
}

std::vector<Eigen::Vector2d> Turned::rims() const {
  const Eigen::Vector2d way = b - a;
  const double d = way.norm();
  if (radiusB == 0 || d >= radiusA + radiusB || d <= std::abs(radiusA - radiusB)) return {};
  const double along = (d * d + radiusA * radiusA - radiusB * radiusB) / (2 * d);
  const double across = std::sqrt(std::max(0.0, radiusA * radiusA - along * along));
  const Eigen::Vector2d u = way / d, n(-u.y(), u.x()), foot = a + along * u;
  return {foot + across * n, foot - across * n};
}

// Whether a place on a circle is on the solid's skin.
bool Turned::onSkin(const Eigen::Vector2d& p, bool ofA) const {
  if (radiusB == 0) return ofA;
  if (ofA) return (p - b).norm() >= radiusB;
  return cut ? (p - a).norm() <= radiusA : (p - a).norm() >= radiusA;
}

double Turned::distance(const Vec3d& at) const {
  double least = INFINITY;
  for (const double side : {1.0, -1.0}) {  // the other half of the plane mirrors this one
    const Eigen::Vector2d p(side * std::hypot(at.x(), at.y()), at.z());
    const auto circle = [&](const Eigen::Vector2d& middle, double radius, bool ofA) {
      const double d = (p - middle).norm();
      if (radius == 0 || d == 0) return;
      const Eigen::Vector2d foot = middle + (p - middle) * (radius / d);
      if (onSkin(foot, ofA)) least = std::min(least, std::abs(d - radius));
    };
    circle(a, radiusA, true);
    circle(b, radiusB, false);
    for (const Eigen::Vector2d& rim : rims()) least = std::min(least, (p - rim).norm());
  }
  return least;
}

std::vector<Vec3d> Turned::edges() const {
  std::vector<Vec3d> all;
  for (const Eigen::Vector2d& rim : rims())
    for (int i = 0; i < 500 && rim.x() >= 0; ++i) all.push_back(turned(rim, all.size()));
  return all;
}

std::vector<Vec3d> Turned::places() const {
  std::vector<Vec3d> all = edges();
  constexpr int kAround = 4000;
  for (int i = 0; i < kAround; ++i) {
    const double t = 2 * std::numbers::pi * (i + 0.5) / kAround;
    const Eigen::Vector2d way(std::cos(t), std::sin(t));
    if (const Eigen::Vector2d p = a + radiusA * way; p.x() >= 0 && onSkin(p, true))
      all.push_back(turned(p, all.size()));
    if (const Eigen::Vector2d p = b + radiusB * way; radiusB > 0 && p.x() >= 0 && onSkin(p, false))
      all.push_back(turned(p, all.size()));
  }
  return all;
}

Turned turnedOf(const Ring& ring) {
  Turned turned;
  if (!ring.tool) return turned;
  turned.b = {ring.at, 0};
  turned.radiusB = ring.radiusMm;
  turned.cut = std::string_view(ring.tool) == "carve";
  return turned;
}

clay::Version ringOn(const Ring& ring, clay::Version clay, const engine::StrokeQuality& quality) {
  if (!ring.tool) return clay;
  engine::Session session(std::move(clay));
  engine::Tool tool = engine::standardTool(*engine::findTool(ring.tool));
  tool.radiusMm = ring.radiusMm;
  tool.radiusByPressure = tool.strengthByPressure = 0;
  tool.quality = quality;
  session.beginStroke(tool);
  constexpr int kPoints = 240;
  for (int i = 0; i <= kPoints; ++i) {
    const double t = 2 * std::numbers::pi * i / kPoints;
    session.addPoint(0.01 * i, ring.at * Vec3d(std::cos(t), std::sin(t), 0));
  }
  return session.endStroke();
}

}  // namespace argil::bench
