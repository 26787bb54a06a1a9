// Towards a plane fitted to the surface under the tip: what stands above it goes (scrape), what lies below is filled,
// or both.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/kernels/warp_kernels.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {
namespace {

// Voxels that phi moves at most in one application: less than the band, so that what is known goes along with the
// surface.
constexpr float kMost = 1.5f;
// Of the plane of the application before, what stays: a blade keeps its angle over bumps.
constexpr double kKeep = 0.5;
// Sums are of multiples of this: exact, so that their order does not matter.
constexpr double kGrain = 1.0 / (1 << 22);
// From this radius on, voxels, the surface within a brick counts as one piece of the plane.
constexpr double kLargeTip = 32;

class Levelling : public DistanceMethod {
 public:
  explicit Levelling(const StrokeContext& context)
      : operation_(context.operation),
        band_(context.band),
        rounds_(context.brush->quality.levelRounds),
        threads_(context.threads),
        perStamp_(static_cast<float>(context.brush->perStamp)) {}

  double reach(const Stamp& stamp) const override { return stamp.largestRadius(); }
  Renew leaves() const override { return Renew::all; }
  Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  struct Fitted {
    Vec3d point, normal;
  };
  // A piece of the surface under the tip, from the stamp's middle.
  struct Sample {
    float weight;
    Vec3f normal, place;
  };
  static void sample(Sampler& before, const Stamp& stamp, Coord coord, std::vector<Sample>& samples);
  [[nodiscard]] std::vector<Sample> sampleAll(const Sampler& before, const Stamp& stamp,
                                              std::span<const Coord> bricks) const;
  [[nodiscard]] std::optional<Fitted> fit(const Stamp& stamp, std::span<const Sample> samples) const;

  Operation operation_;
  float band_;
  int rounds_, threads_;
  float perStamp_;
  std::vector<std::optional<Fitted>> planes_;  // one for each image
};

int64_t grains(float value) {
  return static_cast<int64_t>(static_cast<double>(value) / kGrain);
}

Vec3d middleOf(const Stamp& stamp) {
  return (stamp.a + stamp.b) / 2;
}

// Sums over pieces of the surface, and their mean: the same in any order.
struct PartsSum {
  int64_t weights = 0;
  std::array<int64_t, 3> places{}, normals{};
  void add(float weight, const Vec3f& normal, const Vec3f& place) {
    weights += grains(weight);
    for (size_t k = 0; k < 3; ++k) {
      normals[k] += grains(weight * normal[static_cast<int>(k)]);
      places[k] += grains(weight * place[static_cast<int>(k)]);
    }
  }
  static Vec3d vec(const std::array<int64_t, 3>& sum) {
    return {static_cast<double>(sum[0]), static_cast<double>(sum[1]), static_cast<double>(sum[2])};
  }
};

void Levelling::sample(Sampler& before, const Stamp& stamp, Coord coord, std::vector<Sample>& samples) {
  const Slot slot = before.slot(coord);
  if (slot.isTile() || segmentDistance(stamp, clay::middleOf(coord, 1)) > stamp.largestRadius() + 6.1) return;
  BrickValues scratch;
  const BrickValues& now = slot.values(scratch, before.band());
  // Two voxels from the surface and farther nothing has a weight.
  float nearest = HUGE_VALF;
  for (const float phi : now) nearest = std::min(nearest, std::abs(phi));
  if (nearest >= 2) return;
  SurfaceParts parts;
  float padded[kPaddedSize] = {}, weight[kBrickVoxels];
  gatherPadded(before, coord, padded);
  imageWeights(std::span(&stamp, 1), Falloff::smooth, coord, weight);
  const Vec3f origin = BrickFrame(middleOf(stamp), coord).middle;
  surfaceParts(padded, weight, {origin.x(), origin.y(), origin.z()}, parts);
  const auto of = [](const float(&axes)[3][kBrickVoxels], int i) { return Vec3f(axes[0][i], axes[1][i], axes[2][i]); };
  if (stamp.largestRadius() < kLargeTip) {
    for (int i = 0; i < kBrickVoxels; ++i)
      if (parts.weight[i] > 0) samples.push_back({parts.weight[i], of(parts.normal, i), of(parts.place, i)});
    return;
  }
  PartsSum sum;
  for (int i = 0; i < kBrickVoxels; ++i)
    if (parts.weight[i] > 0) sum.add(parts.weight[i], of(parts.normal, i), of(parts.place, i));
  const auto whole = static_cast<double>(sum.weights);
  if (sum.weights > 0)
    samples.push_back({static_cast<float>(whole * kGrain), (PartsSum::vec(sum.normals) / whole).cast<float>(),
                       (PartsSum::vec(sum.places) / whole).cast<float>()});
}

std::vector<Levelling::Sample> Levelling::sampleAll(const Sampler& before, const Stamp& stamp,
                                                    std::span<const Coord> bricks) const {
  constexpr size_t kRange = 32;
  std::vector<std::vector<Sample>> ranges((bricks.size() + kRange - 1) / kRange);
  forEachBrickOf(ranges.size(), bricks.size() >= kBricksAStep ? threads_ : 1, [&](size_t i) {
    Sampler mine = before;
    for (const Coord coord : bricks.subspan(i * kRange, std::min(kRange, bricks.size() - i * kRange)))
      sample(mine, stamp, coord, ranges[i]);
  });
  std::vector<Sample> all;
  for (const auto& each : ranges) all.insert(all.end(), each.begin(), each.end());
  return all;
}

// Mean place and normal of the surface under the tip; nothing where there is none.
std::optional<Levelling::Fitted> Levelling::fit(const Stamp& stamp, std::span<const Sample> samples) const {
  const auto norm = [](const Vec3d& v) { return std::sqrt((v.x() * v.x() + v.y() * v.y()) + v.z() * v.z()); };
  // From the second time on the surface counts as far as it faces the way that it did on average the time before: a
  // wall at its edge does not tilt the plane.
  PartsSum sum;
  Vec3f mean = Vec3f::Zero();
  for (int round = 0; round < rounds_; ++round) {
    sum = {};
    for (const Sample& each : samples) {
      float w = each.weight;
      if (round > 0) {
        const float facing = std::max(
                        (each.normal.x() * mean.x() + each.normal.y() * mean.y()) + each.normal.z() * mean.z(), 0.0f),
                    square = facing * facing;
        w *= square * square;
      }
      sum.add(w, each.normal, each.place);
    }
    // Faces that look against each other have no plane between them.
    const double length = norm(PartsSum::vec(sum.normals));
    if (!(length > 0.2 * static_cast<double>(sum.weights)) || sum.weights == 0) return std::nullopt;
    mean = (PartsSum::vec(sum.normals) / length).cast<float>();
  }
  const Vec3d normal = PartsSum::vec(sum.normals);
  // Places are multiples of a fixed step, so that mirrored ones are the mirror images.
  const Vec3d offset =
      (PartsSum::vec(sum.places) / static_cast<double>(sum.weights) * 65536).array().round().matrix() / 65536;
  return Fitted{middleOf(stamp) + offset, normal / norm(normal)};
}

Steps Levelling::begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
  planes_.resize(images.size());
  for (size_t i = 0; i < images.size(); ++i) {
    const std::optional<Fitted> was = planes_[i];
    std::vector<Sample> samples;
    for (size_t from = 0; from < bricks.size(); from += kBricksAStep) {
      const std::vector<Sample> some =
          sampleAll(before, images[i], bricks.subspan(from, std::min(kBricksAStep, bricks.size() - from)));
      samples.insert(samples.end(), some.begin(), some.end());
      co_yield Steps::kPause;
    }
    std::optional<Fitted>& plane = planes_[i] = fit(images[i], samples);
    if (!plane || !was) continue;
    const Vec3d step = was->point - plane->point;
    // Another place, or another face: nothing to keep.
    if (step.squaredNorm() > images[i].radius * images[i].radius || was->normal.dot(plane->normal) < 0.5) continue;
    const Vec3d mixed = was->normal * kKeep + plane->normal * (1 - kKeep);
    plane->normal = mixed / std::sqrt((mixed.x() * mixed.x() + mixed.y() * mixed.y()) + mixed.z() * mixed.z());
  }
}

// Clay moves along the plane's normal, so what comes to a voxel is read where it came from: a wall across the plane
// stays as it is, and no lip grows from an edge.
bool Levelling::brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const {
  if (before.slot(coord).isTile()) return false;
  // Below zero scraping fills and filling scrapes.
  const bool down =
      operation_.method == Method::flatten || (operation_.method == Method::scrape) == (operation_.amount >= 0);
  const bool up = operation_.method == Method::flatten || !down;
  const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
  // Whether a plane lies so that some voxel of the band may go its way.
  const bool moves = std::any_of(planes_.begin(), planes_.end(), [&](const std::optional<Fitted>& plane) {
    if (!plane) return false;
    const double above = plane->normal.dot(middle - plane->point), far = static_cast<double>(band_) + kHalfDiagonal;
    return (down && above > -far) || (up && above < far);
  });
  if (!moves) return false;
  constexpr int kX = 16 * kBroadRow, kY = kBroadRow;
  BrickValues scratch;
  const BrickValues& now = before.slot(coord).values(scratch, band_);
  float broad[kBroadSize], cut[kBrickVoxels] = {}, heap[kBrickVoxels] = {};
  bool gathered = false;
  FieldSample samples[kBrickVoxels];
  FieldValue values[kBrickVoxels];
  int voxels[kBrickVoxels];
  float goals[kBrickVoxels], rises[kBrickVoxels];
  for (size_t image = 0; image < images.size(); ++image) {
    if (!planes_[image]) continue;
    const Vec3d from = planes_[image]->point - middle;
    const Vec3d& normal = planes_[image]->normal;
    const Vec3f n = normal.cast<float>();
    const auto offset = static_cast<float>((normal.x() * from.x() + normal.y() * from.y()) + normal.z() * from.z());
    float weight[kBrickVoxels];
    imageWeights(images.subspan(image, 1), operation_.shape, coord, perStamp_, weight);
    // Whichever way the surface faces, these stay where they are.
    size_t candidates = 0;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
      if (!(weight[i] > 0) || !(std::abs(now[i]) < band_)) continue;
      const float goal = ((n.x() * (static_cast<float>(x) - 3.5f) + n.y() * (static_cast<float>(y) - 3.5f)) +
                          n.z() * (static_cast<float>(z) - 3.5f)) -
                         offset;
      if (!(down && std::min(now[i], 0.0f) < goal) && !(up && std::max(now[i], 0.0f) > goal)) continue;
      goals[candidates] = goal;
      voxels[candidates++] = i;
    }
    if (candidates == 0) continue;
    if (!std::exchange(gathered, true)) {
      std::fill(std::begin(broad), std::end(broad), 0.0f);
      gatherBroad(before, coord, 4, broad);
    }
    size_t count = 0;
    for (size_t k = 0; k < candidates; ++k) {
      const int i = voxels[k], x = i >> 6, y = (i >> 3) & 7, z = i & 7;
      const float* at = broad + broadOffset(x + 4, y + 4, z + 4);
      const float goal = goals[k];
      const Vec3f g(at[kX] - at[-kX], at[kY] - at[-kY], at[1] - at[-1]);
      const float length2 = (g.x() * g.x() + g.y() * g.y()) + g.z() * g.z(),
                  along = (g.x() * n.x() + g.y() * n.y()) + g.z() * n.z();
      // From the plane to the surface along its normal: of what faces away there is nothing to move.
      const float facing = std::min(std::max(along / std::sqrt(std::max(length2, 0.04f)), 0.0f), 1.0f);
      const float way = std::min(std::max(*at * facing - goal, -kMost), kMost),
                  rise = way * (weight[i] * std::abs(operation_.amount));
      if (rise == 0 || !(rise > 0 ? up : down)) continue;
      const AxisPlace px = placeOf(x, -rise * n.x()), py = placeOf(y, -rise * n.y()), pz = placeOf(z, -rise * n.z());
      samples[count] = {broad + broadOffset(px.base + 3, py.base + 3, pz.base + 3), px.t, py.t, pz.t};
      goals[count] = goal;
      rises[count] = rise;
      voxels[count++] = i;
    }
    sampleField(std::span(samples, count), kX, kY, values);
    for (size_t k = 0; k < count; ++k) {
      const int i = voxels[k];
      const float old = broad[broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4)];
      // Filling only adds, scraping only takes away, neither beyond the plane.
      if (rises[k] > 0)
        heap[i] = std::min(heap[i], std::max(values[k].value, std::min(goals[k], old)) - old);
      else
        cut[i] = std::max(cut[i], std::min(values[k].value, std::max(goals[k], old)) - old);
    }
  }
  if (!gathered) return false;
  for (int i = 0; i < kBrickVoxels; ++i)
    phi[i] = broad[broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4)] + (cut[i] + heap[i]);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeLevelling(const StrokeContext& context) {
  return std::make_unique<Levelling>(context);
}

}  // namespace argil::clay
