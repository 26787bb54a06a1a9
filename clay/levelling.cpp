// Towards a plane fitted to the surface under the tip: what stands above it goes (scrape), what lies below is filled, or both.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "clay/brush_method.h"
#include "clay/redistance.h"
#include "clay/shaping_kernels.h"

namespace argil::clay {
namespace {

// Voxels that phi moves at most in one application: less than the band, so that what is known goes along with the surface.
constexpr float kMost = 1.5f;
// Of the plane of the application before, what stays: a blade keeps its angle over bumps.
constexpr double kKeep = 0.5;
// Sums are of multiples of this: exact, so that their order does not matter.
constexpr double kGrain = 1.0 / (1 << 22);

class Levelling : public DistanceMethod {
 public:
  explicit Levelling(const StrokeContext& context) : operation_(context.operation), band_(context.band) {}

  double reach(const Stamp& stamp) const override { return stamp.largestRadius(); }
  Renew leaves() const override { return Renew::all; }
  void begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  struct Fitted {
    Vec3d point, normal;
  };
  [[nodiscard]] std::optional<Fitted> fit(Sampler& before, const Stamp& stamp, std::span<const Coord> bricks) const;

  Operation operation_;
  float band_;
  std::vector<std::optional<Fitted>> planes_;  // one for each image
};

int64_t grains(float value) { return static_cast<int64_t>(static_cast<double>(value) / kGrain); }

// Mean place and normal of the surface under the tip; nothing where there is none.
std::optional<Levelling::Fitted> Levelling::fit(Sampler& before, const Stamp& stamp, std::span<const Coord> bricks) const {
  const Vec3d middle = (stamp.a + stamp.b) / 2;
  struct Sample {
    float weight;
    Vec3f normal, place;
  };
  std::vector<Sample> samples;
  for (const Coord coord : bricks) {
    const Slot slot = before.slot(coord);
    if (slot.isTile() || segmentDistance(stamp, (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5)) > stamp.largestRadius() + 6.1) continue;
    float padded[kPaddedSize] = {}, weight[kBrickVoxels];
    gatherPadded(before, coord, padded);
    BrickValues scratch;
    const BrickValues& values = slot.brick()->values(scratch);
    imageWeights(std::span(&stamp, 1), Falloff::smooth, coord, weight);
    const BrickFrame frame(middle, coord);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float phi = values[i];
      // As much of each voxel as lies near the surface: together they weigh its area.
      const float w = weight[i] * (1 - std::abs(phi));
      if (!(w > 0)) continue;
      const int x = i >> 6, y = (i >> 3) & 7, z = i & 7, at = paddedOffset(x + 1, y + 1, z + 1);
      const Vec3f g(padded[at + 10 * kPaddedRow] - padded[at - 10 * kPaddedRow], padded[at + kPaddedRow] - padded[at - kPaddedRow], padded[at + 1] - padded[at - 1]);
      const float length = std::sqrt((g.x() * g.x() + g.y() * g.y()) + g.z() * g.z());
      if (!(length > 0.2f)) continue;
      const Vec3f n = g / length, p = frame.at(x, y, z) - n * phi;
      samples.push_back({w, n, p});
    }
  }
  const auto vec = [](const std::array<int64_t, 3>& sum) { return Vec3d(static_cast<double>(sum[0]), static_cast<double>(sum[1]), static_cast<double>(sum[2])); };
  const auto norm = [](const Vec3d& v) { return std::sqrt((v.x() * v.x() + v.y() * v.y()) + v.z() * v.z()); };
  // The second time the surface counts as far as it faces the way that all of it did on average: a wall at its edge does not tilt the plane.
  int64_t weights = 0;
  std::array<int64_t, 3> places{}, normals{};
  Vec3f mean = Vec3f::Zero();
  for (const bool again : {false, true}) {
    weights = 0;
    places = normals = {};
    for (const Sample& each : samples) {
      float w = each.weight;
      if (again) {
        const float facing = std::max((each.normal.x() * mean.x() + each.normal.y() * mean.y()) + each.normal.z() * mean.z(), 0.0f), square = facing * facing;
        w *= square * square;
      }
      weights += grains(w);
      for (size_t k = 0; k < 3; ++k) {
        normals[k] += grains(w * each.normal[static_cast<int>(k)]);
        places[k] += grains(w * each.place[static_cast<int>(k)]);
      }
    }
    // Faces that look against each other have no plane between them.
    const double length = norm(vec(normals));
    if (!(length > 0.2 * static_cast<double>(weights)) || weights == 0) return std::nullopt;
    mean = (vec(normals) / length).cast<float>();
  }
  const Vec3d normal = vec(normals);
  // Places are multiples of a fixed step, so that mirrored ones are the mirror images.
  const Vec3d offset = (vec(places) / static_cast<double>(weights) * 65536).array().round().matrix() / 65536;
  return Fitted{middle + offset, normal / norm(normal)};
}

void Levelling::begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
  planes_.resize(images.size());
  for (size_t i = 0; i < images.size(); ++i) {
    const std::optional<Fitted> was = planes_[i];
    std::optional<Fitted>& plane = planes_[i] = fit(before, images[i], bricks);
    if (!plane || !was) continue;
    const Vec3d step = was->point - plane->point;
    // Another place, or another face: nothing to keep.
    if (step.squaredNorm() > images[i].radius * images[i].radius || was->normal.dot(plane->normal) < 0.5) continue;
    const Vec3d mixed = was->normal * kKeep + plane->normal * (1 - kKeep);
    plane->normal = mixed / std::sqrt((mixed.x() * mixed.x() + mixed.y() * mixed.y()) + mixed.z() * mixed.z());
  }
}

bool Levelling::brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const {
  if (before.slot(coord).isTile()) return false;
  float padded[kPaddedSize] = {}, cut[kBrickVoxels] = {}, heap[kBrickVoxels] = {};
  gatherPadded(before, coord, padded);
  const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
  for (size_t i = 0; i < images.size(); ++i) {
    if (!planes_[i]) continue;
    const Vec3d n = planes_[i]->normal, from = planes_[i]->point - middle;
    float weight[kBrickVoxels];
    imageWeights(images.subspan(i, 1), operation_.shape, coord, weight);
    for (float& w : weight) w *= std::abs(operation_.amount);
    levelBrick(padded, weight, {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z()), static_cast<float>((n.x() * from.x() + n.y() * from.y()) + n.z() * from.z())},
               band_, kMost, cut, heap);
  }
  BrickValues scratch;
  const BrickValues& old = before.slot(coord).values(scratch, band_);
  // Below zero scraping fills and filling scrapes.
  const bool down = operation_.method == Method::flatten || (operation_.method == Method::scrape) == (operation_.amount >= 0);
  const bool up = operation_.method == Method::flatten || !down;
  for (int i = 0; i < kBrickVoxels; ++i) phi[i] = old[i] + ((down ? cut[i] : 0.0f) + (up ? heap[i] : 0.0f));
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeLevelling(const StrokeContext& context) { return std::make_unique<Levelling>(context); }

}  // namespace argil::clay
