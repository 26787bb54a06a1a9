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
// Sums are of multiples of 2⁻¹⁸, and so exact up to 2³⁵: their order does not matter. What is added to this number is
// rounded to such a multiple.
constexpr double kRounds = 1.5 * double(uint64_t{1} << (52 - 18));
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
  // A piece of the surface under the tip, its place from the stamp's middle.
  struct Sample {
    float weight;
    std::array<float, 8> part;  // 1, normal, place, 0
    [[nodiscard]] Vec3f normal() const { return {part[1], part[2], part[3]}; }
  };
  static void sample(Sampler& before, const Stamp& stamp, Coord coord, std::vector<Sample>& samples);
  void sampleAll(const Sampler& before, const Stamp& stamp, std::span<const Coord> bricks,
                 std::vector<Sample>& samples) const;
  [[nodiscard]] std::optional<Fitted> fit(const Stamp& stamp, std::span<const Sample> samples) const;

  Operation operation_;
  float band_;
  int rounds_, threads_;
  float perStamp_;
  std::vector<std::optional<Fitted>> planes_;  // one for each image
};

Vec3d middleOf(const Stamp& stamp) {
  return (stamp.a + stamp.b) / 2;
}

// Sums over pieces of the surface, and their mean: the same in any order.
struct PartsSum {
  std::array<double, 8> sums{};
  void add(float weight, const std::array<float, 8>& part) {
    for (size_t k = 0; k < 8; ++k) sums[k] += (static_cast<double>(weight * part[k]) + kRounds) - kRounds;
  }
  [[nodiscard]] double weight() const { return sums[0]; }
  [[nodiscard]] Vec3d normals() const { return {sums[1], sums[2], sums[3]}; }
  [[nodiscard]] Vec3d places() const { return {sums[4], sums[5], sums[6]}; }
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
  const auto of = [&](int i) {
    const auto &n = parts.normal, &p = parts.place;
    return std::array{1.0f, n[0][i], n[1][i], n[2][i], p[0][i], p[1][i], p[2][i], 0.0f};
  };
  if (stamp.largestRadius() < kLargeTip) {
    for (int i = 0; i < kBrickVoxels; ++i)
      if (parts.weight[i] > 0) samples.push_back({parts.weight[i], of(i)});
    return;
  }
  PartsSum sum;
  for (int i = 0; i < kBrickVoxels; ++i)
    if (parts.weight[i] > 0) sum.add(parts.weight[i], of(i));
  if (!(sum.weight() > 0)) return;
  Sample& whole = samples.emplace_back();
  whole.weight = static_cast<float>(sum.weight());
  for (size_t k = 0; k < 8; ++k) whole.part[k] = static_cast<float>(sum.sums[k] / sum.weight());
}

void Levelling::sampleAll(const Sampler& before, const Stamp& stamp, std::span<const Coord> bricks,
                          std::vector<Sample>& samples) const {
  if (bricks.size() < kBricksAStep || threads_ == 1) {
    Sampler mine = before;
    for (const Coord coord : bricks) sample(mine, stamp, coord, samples);
    return;
  }
  constexpr size_t kRange = 32;
  std::vector<std::vector<Sample>> ranges((bricks.size() + kRange - 1) / kRange);
  forEachBrickOf(ranges.size(), threads_, [&](size_t i) {
    Sampler mine = before;
    for (const Coord coord : bricks.subspan(i * kRange, std::min(kRange, bricks.size() - i * kRange)))
      sample(mine, stamp, coord, ranges[i]);
  });
  for (const auto& each : ranges) samples.insert(samples.end(), each.begin(), each.end());
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
        const Vec3f normal = each.normal();
        const float facing = std::max((normal.x() * mean.x() + normal.y() * mean.y()) + normal.z() * mean.z(), 0.0f),
                    square = facing * facing;
        w *= square * square;
      }
      sum.add(w, each.part);
    }
    // Faces that look against each other have no plane between them.
    const double length = norm(sum.normals());
    if (!(length > 0.2 * sum.weight()) || sum.weight() == 0) return std::nullopt;
    mean = (sum.normals() / length).cast<float>();
  }
  const Vec3d normal = sum.normals();
  // Places are multiples of a fixed step, so that mirrored ones are the mirror images.
  const Vec3d offset = (sum.places() / sum.weight() * 65536).array().round().matrix() / 65536;
  return Fitted{middleOf(stamp) + offset, normal / norm(normal)};
}

Steps Levelling::begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
  planes_.resize(images.size());
  for (size_t i = 0; i < images.size(); ++i) {
    const std::optional<Fitted> was = planes_[i];
    std::vector<Sample> samples;
    for (size_t from = 0; from < bricks.size(); from += kBricksAStep) {
      sampleAll(before, images[i], bricks.subspan(from, std::min(kBricksAStep, bricks.size() - from)), samples);
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
  float broad[kBroadSize], cut[kBrickVoxels], heap[kBrickVoxels];
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
    std::array<float, kBrickEdge> alongZ;
    for (size_t z = 0; z < kBrickEdge; ++z) alongZ[z] = n.z() * (static_cast<float>(z) - 3.5f);
    for (int row = 0; row < kBrickVoxels; row += kBrickEdge) {
      if (!(Eigen::Map<const Eigen::Array<float, kBrickEdge, 1>>(weight + row) > 0).any()) continue;
      const int x = row >> 6, y = (row >> 3) & 7;
      const float across = n.x() * (static_cast<float>(x) - 3.5f) + n.y() * (static_cast<float>(y) - 3.5f);
      for (int z = 0; z < kBrickEdge; ++z) {
        const int i = row + z;
        if (!(weight[i] > 0) || !(std::abs(now[i]) < band_)) continue;
        const float goal = (across + alongZ[static_cast<size_t>(z)]) - offset;
        if (!(down && std::min(now[i], 0.0f) < goal) && !(up && std::max(now[i], 0.0f) > goal)) continue;
        goals[candidates] = goal;
        voxels[candidates++] = i;
      }
    }
    if (candidates == 0) continue;
    if (!std::exchange(gathered, true)) {
      std::fill(broad + 16 * kX, std::end(broad), 0.0f);
      gatherBroad(before, coord, 4, broad);
      std::fill(std::begin(cut), std::end(cut), 0.0f);
      std::fill(std::begin(heap), std::end(heap), 0.0f);
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
  using Row = Eigen::Array<float, kBrickEdge, 1>;
  using Values = Eigen::Map<const Row>;
  for (int row = 0; row < kBrickVoxels; row += kBrickEdge)
    Eigen::Map<Row>(phi + row) =
        Values(broad + broadOffset((row >> 6) + 4, ((row >> 3) & 7) + 4, 4)) + (Values(cut + row) + Values(heap + row));
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeLevelling(const StrokeContext& context) {
  return std::make_unique<Levelling>(context);
}

}  // namespace argil::clay
