// Towards the mean of the neighbours; farther ones for larger tips.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/field/unbent_plane.h"
#include "clay/kernels/smoothing_kernels.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {
namespace {

// Up to this radius the mean of the next neighbours serves; a stamp's variance then grows with the square of the
// radius.
constexpr double kFineRadius = 10;
// Sums are of multiples of this: exact, so that their order does not matter.
constexpr double kGrain = 1.0 / (1 << 30);
// From this radius on, voxels, applications are computed together: a brick lies under twenty of them. All three means
// serve from there on.
constexpr double kLargeTip = 32;
// A stamp whose mean is to be wider than the widest is done again, at most so often: each costs as much as the first.
constexpr int kMostRounds = 4;
// Of means of means, 1, 2 and 4 voxels apart: of 3, 7 and 15 voxels, their variance along an axis half the sum of
// squares.
constexpr double kVariance[3] = {0.5, 2.5, 10.5};
// What the mean eight voxels apart adds to the variance along an axis.
constexpr float kFarVariance = 0.5f * kBrickEdge * kBrickEdge;
// Voxels beside an edge that the surface may come to in one application.
constexpr float kNear = 2;

// How much of an edge between two voxels is inside.
float insideOf(float a, float b) {
  if ((a < 0) == (b < 0)) return a < 0 ? 1.0f : 0.0f;
  return a < 0 ? a / (a - b) : b / (b - a);
}

// Of the means of means 1, 2 and so on to `spacing` voxels apart: their weights along an axis are a triangle.
UnbentPlane unbentPlane(int spacing, float band) {
  const auto mean = [spacing, band = static_cast<double>(band)](double d) {
    const int half = 2 * spacing;
    double sum = 0;
    for (int k = 1 - half; k < half; ++k) sum += (half - std::abs(k)) * std::clamp(d + k, -band, band);
    return sum / (half * half);
  };
  return {mean, band};
}

// Variance along an axis that is asked of an application.
double wantedVariance(double radius, double spread) {
  return 0.5 * spread * std::max(1.0, (radius / kFineRadius) * (radius / kFineRadius));
}

using Row = Eigen::Array<float, kBrickVoxels, 1>;

class Smoothing : public DistanceMethod {
 public:
  explicit Smoothing(const StrokeContext& context)
      : operation_(context.operation),
        band_(context.band),
        perStamp_(static_cast<float>(context.brush->perStamp)),
        spread_(context.brush->spread),
        threads_(context.threads) {}

  Renew leaves() const override { return Renew::all; }
  double travel(double) const override { return -1; }
  // What is beyond the band stays.
  double moves(std::span<const Stamp> images) const override {
    const bool together = operation_.method == Method::smooth && spread_ == 1 && largestOf(images) >= kLargeTip;
    return together ? band_ : HUGE_VAL;
  }
  void follow(Sampler&, std::span<const Stamp> images) override {
    if (came_.size() == kTogether) came_.erase(came_.begin());  // it was in the air
    came_.emplace_back(images.begin(), images.end());
  }
  // Splits a smoothing that the widest mean cannot do at once into rounds, each of the full strength.
  int parts(std::span<const Stamp> images) const override {
    if (spread_ == 1) return 1;
    const double rounds = wantedVariance(largestOf(images), spread_) / kVariance[2];
    return std::clamp(static_cast<int>(std::ceil(rounds)), 1, kMostRounds);
  }
  std::vector<Stamp> part(std::span<const Stamp> images, int, int) const override {
    return {images.begin(), images.end()};
  }
  Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  struct Values {
    float of[kBrickVoxels];
  };
  using Around = std::array<const float*, kBricksAround>;
  static double largestOf(std::span<const Stamp> images) {
    double radius = 0;
    for (const Stamp& each : images) radius = std::max(radius, each.largestRadius());
    return radius;
  }
  // For gatherBroad: the means around brick i, where there are any.
  [[nodiscard]] Around meansAround(size_t i) const {
    Around means{};
    for (size_t k = 0; k < kBricksAround; ++k)
      if (const ptrdiff_t at = around_[i][k]; at >= 0) means[k] = means_[static_cast<size_t>(at)].of;
    return means;
  }
  void gatherWeights(size_t i, float* broad) const;
  // A power of two up to 8.
  void prepareUnbent(int spacing) {
    auto& plane = unbent_[static_cast<size_t>(std::countr_zero(static_cast<unsigned>(spacing)))];
    if (!plane) plane = unbentPlane(spacing, band_);
  }
  [[nodiscard]] const UnbentPlane& unbent(int spacing) const {
    return *unbent_[static_cast<size_t>(std::countr_zero(static_cast<unsigned>(spacing)))];
  }
  // The mean of brick i, up to `spacing` voxels apart: of four by those up to two, which are there; `broad` is room.
  void meanOf(size_t i, int spacing, Sampler& before, float (&broad)[kBroadSize], float (&mean)[kBrickVoxels]) const;
  // Towards its mean: what becomes of brick i, and its weights.
  void blend(size_t i, std::span<const Stamp> images, Sampler& before, float (&mean)[kBrickVoxels],
             float (&weight)[kBrickVoxels]) const;
  // The same of several applications.
  void blendTogether(size_t i, Sampler& before, float (&phi)[kBrickVoxels]) const;
  [[nodiscard]] float shareOf(double wanted) const {
    return operation_.amount * static_cast<float>(std::min(wanted / variance_, 1.0));
  }

  Operation operation_;
  float band_, perStamp_;
  double spread_;
  int threads_;
  std::array<std::optional<UnbentPlane>, 4> unbent_;  // by the spacing's logarithm
  std::vector<std::vector<Stamp>> came_, together_;   // applications: not computed yet, and those that are
  // Of the application: whether the means of the next neighbours serve; else its bricks that hold some surface.
  bool near_ = true;
  std::vector<Coord> bricks_;
  std::vector<std::array<ptrdiff_t, kBricksAround>> around_;  // indices among bricks_
  std::vector<Values> means_;                                 // of the neighbours, near and far
  // Of the last means, which bricks compute themselves unless the volume is kept or there are several applications.
  int spacing_ = 1;
  double variance_ = 0;  // of these, along an axis
  float share_ = 1;      // of the way to them
  // Where the volume is kept, what bricks become stands in means_, and is put back by these weights: 0 where nothing is
  // known. Before, room for the next means.
  std::vector<Values> weights_;
  float putBack_ = 0;
};

void Smoothing::meanOf(size_t i, int spacing, Sampler& before, float (&broad)[kBroadSize],
                       float (&mean)[kBrickVoxels]) const {
  if (spacing == 2) {
    gatherBroad(before, bricks_[i], 3, broad);
    broadMeanOfMeans(broad, mean);
    return;
  }
  gatherBroad(before, bricks_[i], spacing, broad, spacing > 1 ? meansAround(i).data() : nullptr);
  broadMean(broad, spacing, mean);
}

void Smoothing::blend(size_t i, std::span<const Stamp> images, Sampler& before, float (&mean)[kBrickVoxels],
                      float (&weight)[kBrickVoxels]) const {
  imageWeights(images, operation_.shape, bricks_[i], perStamp_, weight);
  unbent(spacing_).distances(mean);
  BrickValues scratch;
  const BrickValues& values = before.slot(bricks_[i]).values(scratch, band_);
  for (int v = 0; v < kBrickVoxels; ++v) {
    const float phi = values[v];
    if (!(std::abs(phi) < band_)) weight[v] = 0;
    mean[v] = phi + weight[v] * share_ * (mean[v] - phi);
  }
}

// Towards the means that one application has, so that of what is fine as much stays as after one application after the
// other, ∏(1 − w); and as far towards those of these eight voxels apart that what is coarse loses as much as well: the
// variance of all together is ∑ w times that of one.
void Smoothing::blendTogether(size_t i, Sampler& before, float (&phi)[kBrickVoxels]) const {
  Row left = Row::Ones(), sum = Row::Zero();
  for (const std::vector<Stamp>& images : together_) {
    float weight[kBrickVoxels];
    imageWeights(images, operation_.shape, bricks_[i], perStamp_, weight);
    const Row share = shareOf(wantedVariance(largestOf(images), 1)) * Eigen::Map<const Row>(weight);
    left *= 1 - share;
    sum += share;
  }
  BrickValues scratch[kBricksAround];
  const float* around[kBricksAround];
  for (size_t k = 0; k < kBricksAround; ++k) {
    const ptrdiff_t at = around_[i][k];
    around[k] = at >= 0 ? means_[static_cast<size_t>(at)].of
                        : before.slot(bricks_[i] + kAroundSteps[k]).values(scratch[k], band_);
  }
  Row far, mean = Eigen::Map<const Row>(means_[i].of);
  farMean(around, far.data());
  unbent(2 * spacing_).distances(far.data());
  unbent(spacing_).distances(mean.data());
  const BrickValues& values = before.slot(bricks_[i]).values(scratch[0], band_);
  const Eigen::Map<const Row> now(values);
  const Row all = 1 - left, farther = static_cast<float>(variance_) / kFarVariance * (sum - all);
  const Row moved = now + (all * (mean - now) + farther * (far - mean));
  Eigen::Map<Row>{phi} = (now.abs() < band_).select(moved, now);
}

Steps Smoothing::begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
  const bool keep = operation_.method == Method::smoothKeep;
  const double radius = largestOf(images);
  // The last that came: others before them reached no clay.
  together_.clear();
  for (size_t count = 0; !came_.empty() && count < images.size(); came_.pop_back()) {
    count += came_.back().size();
    together_.insert(together_.begin(), std::move(came_.back()));
  }
  came_.clear();
  const bool store = keep || together_.size() > 1;
  bricks_.clear();
  putBack_ = 0;
  const double wanted = wantedVariance(radius, spread_) / parts(images);
  near_ = !keep && wanted <= kVariance[0];
  if (near_) co_return;
  // A brick without a surface is the same all over, and its mean with it but for what its neighbours say beside the
  // band's edge.
  std::copy_if(bricks.begin(), bricks.end(), std::back_inserter(bricks_),
               [&](Coord coord) { return !before.slot(coord).isTile(); });
  around_ = besideEach(bricks_, kAroundSteps);
  means_.resize(bricks_.size());
  weights_.resize(bricks_.size());
  spacing_ = wanted <= kVariance[0] ? 1 : wanted <= kVariance[1] ? 2 : 4;
  variance_ = kVariance[spacing_ / 2];
  std::vector<int> stored;
  if (spacing_ == 4) stored.push_back(2);
  if (store) stored.push_back(spacing_);
  for (const int spacing : stored) {
    for (size_t from = 0; from < bricks_.size(); from += kBricksAStep) {
      forBrickRanges(std::min(kBricksAStep, bricks_.size() - from), threads_, [&](size_t begin, size_t end) {
        Sampler mine = before;
        float broad[kBroadSize] = {};
        for (size_t i = from + begin; i < from + end; ++i) meanOf(i, spacing, mine, broad, weights_[i].of);
      });
      co_yield Steps::kPause;
    }
    std::swap(means_, weights_);
  }
  share_ = shareOf(wanted);
  prepareUnbent(spacing_);
  if (together_.size() > 1) prepareUnbent(2 * spacing_);
  if (!keep) co_return;
  forBrickRanges(bricks_.size(), threads_, [&](size_t begin, size_t end) {
    Sampler mine = before;
    for (size_t i = begin; i < end; ++i) blend(i, images, mine, means_[i].of, weights_[i].of);
  });
  // What was taken is put back along the normals, by the same weights: Newton on the one number that says how much.
  // Volume is the length that lies inside of the lines of voxels along each axis.
  struct Edge {
    float a, b, weightA, weightB, share;
  };
  std::vector<Edge> edges;
  int64_t goal = 0;
  const auto grains = [](float value) { return static_cast<int64_t>(static_cast<double>(value) / kGrain); };
  float broadNow[kBroadSize], broadWas[kBroadSize], broadWeight[kBroadSize] = {};
  for (size_t i = 0; i < bricks_.size(); ++i) {
    if (std::none_of(weights_[i].of, weights_[i].of + kBrickVoxels, [](float w) { return w > 0; })) continue;
    gatherBroad(before, bricks_[i], 1, broadWas);
    gatherBroad(before, bricks_[i], 1, broadNow, meansAround(i).data());
    gatherWeights(i, broadWeight);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const int at = broadOffset((v >> 6) + 4, ((v >> 3) & 7) + 4, (v & 7) + 4);
      if (!(std::abs(broadWas[at]) < kNear)) continue;
      constexpr int kSteps[3] = {16 * kBroadRow, kBroadRow, 1};
      float slopes[3], squares = 1e-6f;
      for (int k = 0; k < 3; ++k) {
        slopes[k] = broadWas[at + kSteps[k]] - broadWas[at - kSteps[k]];
        squares += slopes[k] * slopes[k];
      }
      for (int k = 0; k < 3; ++k) {
        const int next = at + kSteps[k];
        if (!(broadWeight[at] > 0) && !(broadWeight[next] > 0)) continue;
        // Lines along the surface say nothing of its height.
        const float lineShare = slopes[k] * slopes[k] / squares;
        goal += grains(lineShare * insideOf(broadWas[at], broadWas[next]));
        edges.push_back({broadNow[at], broadNow[next], broadWeight[at], broadWeight[next], lineShare});
      }
    }
  }
  for (int step = 0; step < 4; ++step) {
    int64_t now = 0, slope = 0;
    for (const Edge& each : edges) {
      const float a = each.a + each.weightA * putBack_, b = each.b + each.weightB * putBack_;
      now += grains(each.share * insideOf(a, b));
      if ((a < 0) != (b < 0))
        slope += grains(each.share * 0.5f * (each.weightA + each.weightB) / std::max(std::abs(a - b), 0.05f));
    }
    if (slope <= 0) break;
    putBack_ = static_cast<float>(std::clamp(
        static_cast<double>(putBack_) + static_cast<double>(now - goal) / static_cast<double>(slope), -1.0, 1.0));
  }
}

// Weights of a brick and of one voxel beyond its upper faces.
void Smoothing::gatherWeights(size_t i, float* broad) const {
  for (int k = 0; k < 4; ++k) {
    const Coord side{k == 1, k == 2, k == 3};
    const ptrdiff_t at = around_[i][aroundNumber(side)];
    const Values* weight = at < 0 ? nullptr : &weights_[static_cast<size_t>(at)];
    for (int x = side.x * 8; x < (side.x ? 9 : 8); ++x)
      for (int y = side.y * 8; y < (side.y ? 9 : 8); ++y)
        for (int z = side.z * 8; z < (side.z ? 9 : 8); ++z)
          broad[broadOffset(x + 4, y + 4, z + 4)] = weight ? weight->of[Brick::offset(x & 7, y & 7, z & 7)] : 0.0f;
  }
}

bool Smoothing::brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const {
  if (before.slot(coord).isTile()) return false;
  if (near_) {
    float padded[kPaddedSize] = {}, weight[kBrickVoxels];
    gatherPadded(before, coord, padded);
    imageWeights(images, operation_.shape, coord, perStamp_, weight);
    smoothBrick(padded, weight, operation_.amount, band_, phi);
    return true;
  }
  const auto it = std::lower_bound(bricks_.begin(), bricks_.end(), coord);
  if (it == bricks_.end() || *it != coord) return false;
  const auto at = static_cast<size_t>(it - bricks_.begin());
  if (together_.size() > 1) {
    blendTogether(at, before, phi);
    return true;
  }
  if (operation_.method != Method::smoothKeep) {
    float broad[kBroadSize], weight[kBrickVoxels];
    meanOf(at, spacing_, before, broad, phi);
    blend(at, images, before, phi, weight);
    return true;
  }
  for (int v = 0; v < kBrickVoxels; ++v) phi[v] = means_[at].of[v] + weights_[at].of[v] * putBack_;
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeSmoothing(const StrokeContext& context) {
  return std::make_unique<Smoothing>(context);
}

}  // namespace argil::clay
