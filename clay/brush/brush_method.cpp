#include "clay/brush/brush_method.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

constexpr double kPlaceStep = 1.0 / 65536;

}  // namespace

// Rounded to even, as mirror images in planes between voxels must be rounded to mirror images.
Vec3d quantised(const Vec3d& p) {
  return p.unaryExpr([](double v) { return std::nearbyint(v / kPlaceStep) * kPlaceStep; });
}

std::vector<Stamp> quantised(std::span<const Stamp> given) {
  std::vector<Stamp> images(given.begin(), given.end());
  for (Stamp& each : images) {
    each.a = quantised(each.a);
    each.b = quantised(each.b);
  }
  return images;
}

std::vector<Stamp> partOf(std::span<const Stamp> images, int part, int parts) {
  std::vector<Stamp> made(images.begin(), images.end());
  for (Stamp& each : made) {
    const Stamp whole = each;
    const auto at = [&](int step) {
      return quantised(Vec3d(whole.a + (whole.b - whole.a) * (static_cast<double>(step) / parts)));
    };
    each.a = at(part);
    each.b = at(part + 1);
    each.radius = whole.radius + (whole.radiusAtEnd() - whole.radius) * part / parts;
    each.endRadius = whole.radius + (whole.radiusAtEnd() - whole.radius) * (part + 1) / parts;
    // A dab has no way.
    if (whole.a == whole.b) each.strength = whole.strength / static_cast<float>(parts);
  }
  return made;
}

SweptBall sweptBall(const Stamp& s, Coord brick) {
  const Vec3d a = s.a - ((brick * kBrickEdge).toVec3d() + Vec3d::Constant(3.5)), d = s.b - s.a;
  SweptBall ball{};
  ball.ax = static_cast<float>(a.x());
  ball.ay = static_cast<float>(a.y());
  ball.az = static_cast<float>(a.z());
  ball.dx = static_cast<float>(d.x());
  ball.dy = static_cast<float>(d.y());
  ball.dz = static_cast<float>(d.z());
  const float length2 = (ball.dx * ball.dx + ball.dy * ball.dy) + ball.dz * ball.dz;
  // A segment too short for its inverse to be finite is a dab.
  const float inverse = length2 > 0 ? 1.0f / length2 : 0.0f;
  ball.inverseLength2 = std::isfinite(inverse) ? inverse : 0.0f;
  ball.radius = static_cast<float>(s.radius);
  ball.growth = static_cast<float>(s.radiusAtEnd()) - ball.radius;
  return ball;
}

void imageWeights(std::span<const Stamp> images, Falloff shape, Coord coord, float (&weight)[kBrickVoxels],
                  uint64_t rows) {
  std::fill(std::begin(weight), std::end(weight), 0.0f);
  for (const Stamp& each : images)
    ballWeights(sweptBall(each, coord), static_cast<int>(shape), each.strength, weight, rows);
}

void imageWeights(std::span<const Stamp> images, Falloff shape, Coord coord, float perStamp,
                  float (&weight)[kBrickVoxels], uint64_t rows) {
  imageWeights(images, shape, coord, weight, rows);
  moreByStamp(perStamp, weight);
}

void moreByStamp(float perStamp, float (&weight)[kBrickVoxels]) {
  if (perStamp == 1) return;
  for (float& w : weight) w = perStamp * w / (1 + (perStamp - 1) * w);
}

float falloff(Falloff shape, float t) noexcept {
  if (!(t < 1)) return 0;
  switch (shape) {
    case Falloff::constant:
      return 1;
    case Falloff::smooth:
      return (1 - t * t) * (1 - t * t);
    case Falloff::linear:
      return 1 - t;
    case Falloff::sharp:
      return (1 - t) * (1 - t);
    case Falloff::dome:
      return std::sqrt(1 - t * t);
  }
  return 0;
}

float raisedByStamp(const Brush& brush, const Operation& operation) {
  // Swept stamps a tenth of the radius apart, of the smooth falloff, add up to 35/3 of one where the tool's middle
  // passes, so that a pass is the height.
  constexpr float kShare = 3.0f / 35;
  return std::abs(operation.amount) * brush.height * kShare * static_cast<float>(brush.perStamp);
}

std::unique_ptr<DistanceMethod> makeMethod(const StrokeContext& context) {
  switch (context.operation.method) {
    case Method::carve:
    case Method::add:
    case Method::wax:
      return makeSweep(context);
    case Method::smooth:
    case Method::smoothKeep:
      return makeSmoothing(context);
    case Method::scrape:
    case Method::fill:
    case Method::flatten:
    case Method::build:
      return makeLevelling(context);
    case Method::raise:
      return context.brush->limited || context.brush->image ? makeRaising(context) : makeSwelling(context);
    case Method::crease:
    case Method::tug:
    case Method::smudge:
    case Method::pinch:
    case Method::twist:
      return makeWarping(context);
    case Method::morph:
      return makeMorphing(context);
    case Method::formula:
      return makeFormula(context);
    case Method::external:
      return makeExternal(context);
    case Method::set:
    case Method::blur:
      break;
  }
  throw Error("a brush cannot do that to distances");
}

void brushWeights(const Brush& brush, Falloff shape, std::span<const Stamp> images, Coord coord,
                  float (&weight)[kBrickVoxels]) {
  const auto perStamp = static_cast<float>(brush.perStamp);
  if (!brush.adds) return imageWeights(images, shape, coord, perStamp, weight);
  imageWeights(images, shape, coord, weight);
  for (float& each : weight) each *= perStamp;
}

}  // namespace argil::clay
