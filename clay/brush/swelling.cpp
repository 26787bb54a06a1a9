// Along the normals of the surface as it is now, stamp by stamp: what a stroke lays has no end.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/store/brick_margins.h"
#include "clay/store/near_surface.h"

namespace argil::clay {
namespace {

// What a part of a stamp leaves of the band, voxels: what is known has to go along with the surface.
constexpr float kLeft = 1.4f;
// What several of them may leave.
constexpr float kLeastLeft = 1.1f;
// A tool that the stroke has buried by no more than this many radii counts as standing on the clay above it.
constexpr double kMostBuried = 2;
// Radii: how far a tool is lifted beyond what the stroke has laid, as it lays a little beside its middle.
constexpr double kBeyondLaid = 0.25;
// Voxels: beyond the depth of a place in the band, the surface is no farther than that.
constexpr double kBesideSurface = 1;
constexpr double kGrains = 65536;
// Of the way to the surface: steps of the distance, until it is so near.
constexpr int kMostSteps = 64;
constexpr float kArrived = 0.001f;

class Swelling : public DistanceMethod {
 public:
  explicit Swelling(const StrokeContext& context)
      : operation_(context.operation),
        band_(context.band),
        side_(context.operation.amount < 0 ? -1.0f : 1.0f),
        step_(raisedByStamp(*context.brush, context.operation)),
        most_(band_ - kLeft) {}

  double reach(const Stamp& stamp) const override { return stamp.largestRadius() + static_cast<double>(band_); }
  Renew leaves() const override { return Renew::all; }
  // And one more application may come before.
  double mostDrift() const override {
    return std::max(static_cast<double>(band_ - kLeastLeft - std::min(step_, most_)), 0.0);
  }

  // All of the way, each time by less: what is beside the way rises as what is on it.
  int parts(std::span<const Stamp> images) const override {
    return std::max(1, static_cast<int>(std::ceil(step_ * strongest(images) / most_)));
  }
  std::vector<Stamp> part(std::span<const Stamp> images, int, int parts) const override {
    std::vector<Stamp> made(images.begin(), images.end());
    for (Stamp& each : made) each.strength /= static_cast<float>(parts);
    return made;
  }

  std::vector<Stamp> placed(Sampler& before, std::span<const Stamp> images) const override;
  Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  static float strongest(std::span<const Stamp> images) {
    float most = 0;
    for (const Stamp& each : images) most = std::max(most, each.strength);
    return most;
  }
  [[nodiscard]] Vec3d lifted(Sampler& field, const Vec3d& place, double radius) const;

  Operation operation_;
  float band_, side_;
  float step_;       // voxels that a stamp of strength 1 moves the surface
  float most_;       // of a part
  double laid_ = 0;  // at most, by the stamps so far
};

// Trilinear; halves are summed pair by pair, so that mirroring changes no bit.
float valueAt(Sampler& field, const Vec3d& place) {
  const Vec3d floor = place.array().floor();
  const Coord first{static_cast<int32_t>(floor.x()), static_cast<int32_t>(floor.y()), static_cast<int32_t>(floor.z())};
  const Vec3f t = (place - floor).cast<float>();
  float x[2], y[2];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j)
      y[j] = field.voxel(first + Coord{i, j, 0}) * (1 - t.z()) + field.voxel(first + Coord{i, j, 1}) * t.z();
    x[i] = y[0] * (1 - t.y()) + y[1] * t.y();
  }
  return x[0] * (1 - t.x()) + x[1] * t.x();
}

// Where the surface around the nearest point of it faces, if it is no farther than `reach`.
std::optional<Vec3f> outwards(Sampler& field, const Vec3d& place, double reach) {
  // Sums of whole numbers, so that their order does not matter.
  Eigen::Matrix<int64_t, 3, 1> sum(0, 0, 0);
  for (const NearVoxel& each : surfaceNear(field, place, reach))
    sum += ((each.normal * each.weight).cast<double>() * kGrains).array().round().matrix().cast<int64_t>();
  const Vec3f normal = sum.cast<float>();
  const float length = std::sqrt((normal.x() * normal.x() + normal.y() * normal.y()) + normal.z() * normal.z());
  return length > 0 ? std::optional<Vec3f>(normal / length) : std::nullopt;
}

// A tool that stands where the surface was belongs to the place above it.
Vec3d Swelling::lifted(Sampler& field, const Vec3d& place, double radius) const {
  float depth = -side_ * valueAt(field, place);
  if (!(depth > 0)) return place;
  const double most = std::min(laid_, kMostBuried * radius) + kBeyondLaid * radius;
  const std::optional<Vec3f> out =
      outwards(field, place, depth < band_ ? std::min<double>(depth + kBesideSurface, most) : most);
  if (!out) return place;
  const Vec3d way = side_ * out->cast<double>();
  Vec3d at = place;
  double walked = 0;
  for (int step = 0; step < kMostSteps && depth > kArrived; ++step) {
    walked += static_cast<double>(depth);
    if (walked > most) return place;
    at = quantised(Vec3d(place + walked * way));
    depth = -side_ * valueAt(field, at);
  }
  return at;
}

std::vector<Stamp> Swelling::placed(Sampler& before, std::span<const Stamp> images) const {
  std::vector<Stamp> stamps(images.begin(), images.end());
  if (laid_ == 0) return stamps;
  for (Stamp& each : stamps) {
    const bool dab = each.a == each.b;
    each.a = lifted(before, each.a, each.radius);
    each.b = dab ? each.a : lifted(before, each.b, each.radiusAtEnd());
  }
  return stamps;
}

Steps Swelling::begin(Sampler&, std::span<const Stamp> images, std::span<const Coord>) {
  laid_ += static_cast<double>(step_ * strongest(images));
  co_return;
}

bool Swelling::brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const {
  // A tile beside the surface gets some of the band where that is carried towards it.
  const auto isBrick = [&](Coord step) { return !before.slot(coord + step).isTile(); };
  const Slot own = before.slot(coord);
  if (own.isTile() && (side_ * own.phi(0, band_) < 0 || std::none_of(kFaceSteps.begin(), kFaceSteps.end(), isBrick)))
    return false;
  float broad[kBroadSize] = {};
  gatherBroad(before, coord, 2, broad);
  WeighedBall balls[kMostImages];
  const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
  size_t count = 0;
  for (const Stamp& each : images)
    if (segmentDistance(each, middle) < reach(each) + kHalfDiagonal)
      balls[count++] = {sweptBall(each, coord), each.strength};
  raiseAtFeet(broad, band_, std::span(balls, count), static_cast<int>(operation_.shape), side_ * step_, phi);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeSwelling(const StrokeContext& context) {
  return std::make_unique<Swelling>(context);
}

}  // namespace argil::clay
