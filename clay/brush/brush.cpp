#include "clay/brush/brush.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/brush/brush_method.h"
#include "clay/brush/formula.h"

namespace argil::clay {

namespace {

constexpr double kMinRadius = 0.5, kMaxRadius = 4096;  // voxels
constexpr double kReachVoxels = 8.0 * kBrickReach - 8 * kMaxRadius;

}  // namespace

void checkStamp(const Stamp& s) {
  if (!s.a.allFinite() || !s.b.allFinite() || !std::isfinite(s.radius) || !std::isfinite(s.strength) ||
      !s.axes.allFinite())
    throw Error("stamp with a number that is not finite");
  for (const double radius : {s.radius, s.radiusAtEnd()})
    if (!(radius >= kMinRadius && radius <= kMaxRadius))
      throw Error(
          fmt::format("brush radius of {} voxels: give one from {} to {} voxels", radius, kMinRadius, kMaxRadius));
  if (s.a.cwiseAbs().maxCoeff() > kReachVoxels || s.b.cwiseAbs().maxCoeff() > kReachVoxels)
    throw Error("stamp out of the clay's reach: move the tool nearer to the model");
  if (s.strength < 0 || s.strength > 1) throw Error(fmt::format("brush strength {}: give one from 0 to 1", s.strength));
  if (!(s.axes.transpose() * s.axes).isIdentity(1e-3f)) throw Error("stamp whose axes are not at right angles");
}

std::shared_ptr<const Brush> Brush::of(Method method, float amount) {
  auto brush = std::make_shared<Brush>();
  brush->operations.push_back({Property::distance, method, Falloff::smooth, amount});
  return brush;
}

void Brush::check() const {
  quality.check();
  if (!(perStamp >= 0.01 && perStamp <= 1000))
    throw Error(fmt::format("a brush's stamps that stand for {:g} each: give 0.01 to 1000", perStamp));
  if (operations.empty() || operations.size() > 4) throw Error("a brush has one to four operations");
  for (size_t i = 0; i < operations.size(); ++i) {
    const Operation& each = operations[i];
    if (!(each.amount >= -1 && each.amount <= 1))
      throw Error(fmt::format("a brush's amount of {}: give one from -1 to 1", each.amount));
    for (size_t j = 0; j < i; ++j)
      if (operations[j].property == each.property) throw Error("a brush names a property twice");
    const bool channel = each.method == Method::set || each.method == Method::blur;
    if (channel == (each.property == Property::distance))
      throw Error("a brush whose method does not go with what it changes");
  }
  const auto within = [](float value, float low, float high, const char* what) {
    if (!(value >= low && value <= high))
      throw Error(fmt::format("a brush's {} of {}: give one from {} to {}", what, value, low, high));
  };
  for (int i = 0; i < 3; ++i) within(proportions[i], 0.05f, 1, "proportion");
  within(round, 0, 1, "roundness");
  within(blend, 0, 64, "blend");
  within(height, 0, 4096, "height");
  within(static_cast<float>(spread), 1, 64, "spread");
  within(leastWall, 0, 256, "least wall");
  within(angle, -3.15f, 3.15f, "angle");
  const auto by = [&](Method method) {
    return std::any_of(operations.begin(), operations.end(),
                       [&](const Operation& each) { return each.method == method; });
  };
  if (leastWall > 0 && !by(Method::carve)) throw Error("a brush with a least wall that does not carve");
  if (by(Method::formula) && (!formula || formula->parameters() != values.size()))
    throw Error("a brush whose formula and values do not go together");
  if (by(Method::external) && (!external || values.size() > Formula::kMostParameters))
    throw Error("a brush that is computed elsewhere and does not say where, or has too many values");
  for (const float value : values)
    if (!std::isfinite(value)) throw Error("a brush's parameter that is not finite");
  if (tip == Tip::shape && !shape) throw Error("a brush that stamps a shape has none");
}

}  // namespace argil::clay
