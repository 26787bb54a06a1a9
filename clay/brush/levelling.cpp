// Towards a plane fitted to the surface under the tip: what stands above it goes (scrape), what lies below is filled,
// or both. Build lays clay up to a plane above that surface, or takes it off down to one below.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/kernels/shaping_kernels.h"
#include "clay/kernels/warp_kernels.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {
namespace {

// Voxels that phi moves at most in one part of an application: less than the band, so that what is known goes along
// with the surface.
constexpr float kMost = 1.5f;
// Limits of how far one application moves clay: a part of the radius, so that a stroke does the same at any voxel size,
// at least this many voxels, and in no more parts than these.
constexpr double kMostOfRadius = 0.1, kLeastLimit = 0.5;
constexpr int kMostParts = 8;
// Clay that moves by this share of what a part may counts as kept back by that.
constexpr float kFar = 0.999f;
// Voxels around a brick that what comes from so far is read from, by a cubic.
constexpr int kMargin = 3;
// Of the plane of the application before, what stays: a blade keeps its angle over bumps.
constexpr double kKeep = 0.5;
// Build: the share of the way to its plane that a stamp goes. The less it is, the higher the plane lies for the same
// height of a pass: clay heaps up over several passes, and hollows fill more slowly.
constexpr float kBuildShare = 0.08f;
// Build: the plane is that of the surface within this part of the tip's radius, so that a bead as narrow as the tip
// grows with every pass.
constexpr double kBuildCore = 0.5;
// Build: the share of the way to the mean of its six neighbours that clay in a valley rises with a stamp, and how far
// from the surface, voxels. Flanks of what is laid grow steeper with every pass, and where they meet the clay beside
// them voxels know neither face; without this there are pits.
constexpr float kSettle = 0.25f, kSettledDepth = 1.5f;
// Voxels beside the tip up to which valleys are filled: the flank's foot lies on its rim.
constexpr double kBesideTip = 2;
// From this radius on, voxels, the surface within a brick counts as one piece of the plane.
constexpr double kLargeTip = 32;

class Levelling : public DistanceMethod {
 public:
  explicit Levelling(const StrokeContext& context)
      : operation_(context.operation),
        band_(context.band),
        rounds_(context.brush->quality.levelRounds),
        threads_(context.threads),
        build_(context.operation.method == Method::build),
        // Stamps that build add up: those farther apart lay more, so their plane lies higher.
        perStamp_(build_ ? 1.0f : static_cast<float>(context.brush->perStamp)),
        above_(build_ ? raisedByStamp(*context.brush, context.operation) / kBuildShare : 0.0f) {}

  double reach(const Stamp& stamp) const override { return stamp.largestRadius() + (build_ ? kBesideTip : 0); }
  Renew leaves() const override { return Renew::all; }
  double travel(double) const override { return -1; }
  int parts(std::span<const Stamp> images) const override {
    // The plane of a stamp that builds lies less than a part's way above the surface.
    if (build_) return 1;
    return std::min(static_cast<int>(std::ceil(limitOf(images) / static_cast<double>(kMost))), kMostParts);
  }
  // All of the way each time: a part moves what the parts before it left too far from the plane.
  std::vector<Stamp> part(std::span<const Stamp> images, int part, int) const override {
    part_ = part;
    return {images.begin(), images.end()};
  }
  Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  struct Fitted {
    Vec3d point, normal;
  };
  static double limitOf(std::span<const Stamp> images) {
    double radius = 0;
    for (const Stamp& each : images) radius = std::max(radius, each.largestRadius());
    return std::max(kMostOfRadius * radius, kLeastLimit);
  }
  static void sample(Sampler& before, const Stamp& stamp, Coord coord, std::vector<SurfacePart>& samples);
  void sampleAll(const Sampler& before, const Stamp& stamp, std::span<const Coord> bricks,
                 std::vector<SurfacePart>& samples) const;
  [[nodiscard]] std::optional<Fitted> fit(const Stamp& stamp, std::span<const SurfacePart> samples) const;

  Operation operation_;
  float band_;
  int rounds_, threads_;
  bool build_;
  float perStamp_;
  float above_;                                // voxels that the plane lies above the surface, or below where it digs
  std::vector<std::optional<Fitted>> planes_;  // one for each image
  mutable int part_ = 0;                       // of the application in work, where it has several
  bool atGoal_ = false;                        // no part of it has anything left to move
  mutable std::atomic<bool> wentFar_ = false;  // some clay went as far as a part may
};

Vec3d middleOf(const Stamp& stamp) {
  return (stamp.a + stamp.b) / 2;
}

void Levelling::sample(Sampler& before, const Stamp& stamp, Coord coord, std::vector<SurfacePart>& samples) {
  const Slot slot = before.slot(coord);
  if (slot.isTile() || segmentDistance(stamp, clay::middleOf(coord, 1)) > stamp.largestRadius() + 6.1) return;
  BrickValues scratch;
  const BrickValues& now = slot.values(scratch, before.band());
  // Two voxels from the surface and farther nothing has a weight.
  const uint64_t rows = rowsWithin(now, 2);
  if (rows == 0) return;
  SurfaceParts parts;
  float padded[kPaddedSize] = {}, weight[kBrickVoxels];
  gatherPadded(before, coord, padded);
  imageWeights(std::span(&stamp, 1), Falloff::smooth, coord, weight, rows);
  const Vec3f origin = BrickFrame(middleOf(stamp), coord).middle;
  surfaceParts(padded, weight, {origin.x(), origin.y(), origin.z()}, parts);
  const size_t first = samples.size();
  const auto &n = parts.normal, &p = parts.place;
  for (int i = 0; i < kBrickVoxels; ++i)
    if (parts.weight[i] > 0)
      samples.push_back({1, {n[0][i], n[1][i], n[2][i]}, {p[0][i], p[1][i], p[2][i]}, parts.weight[i]});
  if (stamp.largestRadius() < kLargeTip || samples.size() == first) return;
  double sums[8] = {};
  sumParts(std::span(samples).subspan(first), nullptr, sums);
  samples.resize(first);
  if (!(sums[0] > 0)) return;
  SurfacePart& whole = samples.emplace_back();
  whole.weight = static_cast<float>(sums[0]);
  for (size_t k = 0; k < 3; ++k) {
    whole.normal[k] = static_cast<float>(sums[1 + k] / sums[0]);
    whole.place[k] = static_cast<float>(sums[4 + k] / sums[0]);
  }
}

void Levelling::sampleAll(const Sampler& before, const Stamp& stamp, std::span<const Coord> bricks,
                          std::vector<SurfacePart>& samples) const {
  if (bricks.size() < kBricksAStep || threads_ == 1) {
    Sampler mine = before;
    for (const Coord coord : bricks) sample(mine, stamp, coord, samples);
    return;
  }
  constexpr size_t kRange = 32;
  std::vector<std::vector<SurfacePart>> ranges((bricks.size() + kRange - 1) / kRange);
  forEachBrickOf(ranges.size(), threads_, [&](size_t i) {
    Sampler mine = before;
    for (const Coord coord : bricks.subspan(i * kRange, std::min(kRange, bricks.size() - i * kRange)))
      sample(mine, stamp, coord, ranges[i]);
  });
  for (const auto& each : ranges) samples.insert(samples.end(), each.begin(), each.end());
}

// Mean place and normal of the surface under the tip; nothing where there is none.
std::optional<Levelling::Fitted> Levelling::fit(const Stamp& stamp, std::span<const SurfacePart> samples) const {
  const auto norm = [](const Vec3d& v) { return std::sqrt((v.x() * v.x() + v.y() * v.y()) + v.z() * v.z()); };
  // From the second time on the surface counts as far as it faces the way that it did on average the time before: a
  // wall at its edge does not tilt the plane.
  double sums[8] = {};
  Vec3d normals = Vec3d::Zero();
  float mean[3] = {};
  for (int round = 0; round < rounds_; ++round) {
    std::fill(std::begin(sums), std::end(sums), 0.0);
    sumParts(samples, round > 0 ? mean : nullptr, sums);
    normals = {sums[1], sums[2], sums[3]};
    // Faces that look against each other have no plane between them.
    const double length = norm(normals);
    if (!(length > 0.2 * sums[0]) || sums[0] == 0) return std::nullopt;
    for (int k = 0; k < 3; ++k) mean[k] = static_cast<float>(normals[k] / length);
  }
  // Places are multiples of a fixed step, so that mirrored ones are the mirror images.
  const Vec3d offset = (Vec3d(sums[4], sums[5], sums[6]) / sums[0] * 65536).array().round().matrix() / 65536;
  return Fitted{middleOf(stamp) + offset, normals / norm(normals)};
}

Steps Levelling::begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
  const bool wentFar = wentFar_.exchange(false);
  // The plane is that of the first part.
  if (parts(images) > 1 && part_ > 0) {
    atGoal_ = atGoal_ || !wentFar || planes_.size() != images.size();
    co_return;
  }
  atGoal_ = false;
  planes_.resize(images.size());
  for (size_t i = 0; i < images.size(); ++i) {
    const std::optional<Fitted> was = planes_[i];
    std::vector<SurfacePart> samples;
    std::optional<Fitted>& plane = planes_[i];
    plane.reset();
    // Uses the surface under the whole tip where none lies under the core of a tip that builds.
    for (const double part : {kBuildCore, 1.0}) {
      if (plane || (part < 1 && !build_)) continue;
      Stamp fitted = images[i];
      fitted.radius *= part;
      fitted.endRadius *= part;
      samples.clear();
      for (size_t from = 0; from < bricks.size(); from += kBricksAStep) {
        sampleAll(before, fitted, bricks.subspan(from, std::min(kBricksAStep, bricks.size() - from)), samples);
        co_yield Steps::kPause;
      }
      plane = fit(fitted, samples);
    }
    if (!plane || !was) continue;
    const Vec3d step = was->point - plane->point;
    // Another place, or another face: nothing to keep.
    if (step.squaredNorm() > images[i].radius * images[i].radius || was->normal.dot(plane->normal) < 0.5) continue;
    const Vec3d mixed = was->normal * kKeep + plane->normal * (1 - kKeep);
    plane->normal = mixed / std::sqrt((mixed.x() * mixed.x() + mixed.y() * mixed.y()) + mixed.z() * mixed.z());
  }
}

// Whether any weighed voxel of the band may go the plane's way, whichever way the surface faces: tells before what lies
// around the brick is gathered.
bool mayMove(const LevelPlane& plane, const BrickValues& now, float band, const float (&weight)[kBrickVoxels]) {
  float alongZ[kBrickEdge];
  for (int z = 0; z < kBrickEdge; ++z) alongZ[z] = plane.nz * (static_cast<float>(z) - 3.5f);
  for (int row = 0; row < kBrickVoxels; row += kBrickEdge) {
    const int x = row >> 6, y = (row >> 3) & 7;
    const float across = plane.nx * (static_cast<float>(x) - 3.5f) + plane.ny * (static_cast<float>(y) - 3.5f);
    int any = 0;
    for (int z = 0; z < kBrickEdge; ++z) {
      const float phi = now[row + z], height = (across + alongZ[z]) - plane.offset;
      const int falls = plane.down & (std::min(phi, 0.0f) < height), rises = plane.up & (std::max(phi, 0.0f) > height);
      any |= (falls | rises) & (weight[row + z] > 0) & (std::abs(phi) < band);
    }
    if (any) return true;
  }
  return false;
}

// Fills valleys, or takes ridges off where it digs, towards the mean of the neighbours: `change` is that of each voxel.
void settle(const float* broad, const float (&weight)[kBrickVoxels], bool fills, float (&change)[kBrickVoxels]) {
  constexpr int kX = 16 * kBroadRow, kY = kBroadRow;
  for (int i = 0; i < kBrickVoxels; ++i) {
    const float* at = broad + broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4);
    if (!(weight[i] > 0) || !(std::abs(*at) < kSettledDepth)) continue;
    const float mean = ((at[-kX] + at[kX]) + (at[-kY] + at[kY]) + (at[-1] + at[1])) * (1 / 6.0f),
                step = kSettle * weight[i] * (mean - *at);
    change[i] = fills ? std::min(change[i], step) : std::max(change[i], step);
  }
}

// Clay moves along the plane's normal, so what comes to a voxel is read where it came from: a wall across the plane
// stays as it is, and no lip grows from an edge.
bool Levelling::brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const {
  if (atGoal_ || before.slot(coord).isTile()) return false;
  // Below zero scraping fills, and filling and building scrape.
  const bool down =
      operation_.method == Method::flatten || (operation_.method == Method::scrape) == (operation_.amount >= 0);
  const float raised = down ? -above_ : above_;
  const bool up = operation_.method == Method::flatten || !down;
  const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
  // Whether a plane lies so that some voxel of the band may go its way.
  const bool moves = std::any_of(planes_.begin(), planes_.end(), [&](const std::optional<Fitted>& plane) {
    if (!plane) return false;
    const double above = plane->normal.dot(middle - plane->point) - static_cast<double>(raised),
                 far = static_cast<double>(band_) + kHalfDiagonal;
    return (down && above > -far) || (up && above < far);
  });
  if (!moves) return false;
  constexpr int kX = 16 * kBroadRow, kY = kBroadRow;
  BrickValues scratch;
  const BrickValues& now = before.slot(coord).values(scratch, band_);
  const uint64_t rows = rowsWithin(now, band_);
  if (rows == 0) return false;
  float broad[kBroadSize], cut[kBrickVoxels], heap[kBrickVoxels];
  const int count = parts(images);
  const auto most = static_cast<float>(std::min(limitOf(images) / count, static_cast<double>(kMost)));
  const float done = count > 1 ? most * static_cast<float>(part_) : 0;
  bool gathered = false, far = false;
  FieldSample samples[kBrickVoxels];
  float values[kBrickVoxels], heights[kBrickVoxels], rises[kBrickVoxels];
  int voxels[kBrickVoxels];
  for (size_t image = 0; image < images.size(); ++image) {
    if (!planes_[image]) continue;
    const Vec3d from = planes_[image]->point - middle;
    const Vec3d& normal = planes_[image]->normal;
    const LevelPlane plane{
        .nx = static_cast<float>(normal.x()),
        .ny = static_cast<float>(normal.y()),
        .nz = static_cast<float>(normal.z()),
        .offset = static_cast<float>((normal.x() * from.x() + normal.y() * from.y()) + normal.z() * from.z()) + raised,
        .down = down,
        .up = up,
        .share = build_ ? kBuildShare : std::abs(operation_.amount),
        .most = build_ ? kMost / kBuildShare : most,
        .done = done};
    float weight[kBrickVoxels];
    imageWeights(images.subspan(image, 1), operation_.shape, coord, perStamp_, weight, rows);
    if (!gathered && !mayMove(plane, now, band_, weight)) continue;
    if (!std::exchange(gathered, true)) {
      std::fill(broad + 16 * kX, std::end(broad), 0.0f);
      gatherBroad(before, coord, kMargin, broad);
      std::fill(std::begin(cut), std::end(cut), 0.0f);
      std::fill(std::begin(heap), std::end(heap), 0.0f);
    }
    uint64_t moving[kBrickEdge];
    levelRises(broad, band_, weight, plane, heights, rises, moving);
    size_t moved = 0;
    for (int x = 0; x < kBrickEdge; ++x)
      for (uint64_t left = moving[x]; left != 0; left &= left - 1) {
        const int i = x << 6 | std::countr_zero(left), y = (i >> 3) & 7, z = i & 7;
        const AxisPlace px = placeOf(x, -rises[i] * plane.nx), py = placeOf(y, -rises[i] * plane.ny),
                        pz = placeOf(z, -rises[i] * plane.nz);
        samples[moved] = {broad + broadOffset(px.base + 3, py.base + 3, pz.base + 3), px.t, py.t, pz.t};
        voxels[moved++] = i;
        far = far || (count > 1 && std::abs(rises[i]) >= kFar * most * weight[i] * plane.share);
      }
    sampleValues(std::span(samples, moved), kX, kY, values);
    if (build_) {
      Stamp wide = images[image];
      wide.radius += kBesideTip;
      if (wide.endRadius > 0) wide.endRadius += kBesideTip;
      imageWeights(std::span(&wide, 1), Falloff::dome, coord, perStamp_, weight, rows);
      settle(broad, weight, up, up ? heap : cut);
    }
    for (size_t k = 0; k < moved; ++k) {
      const int i = voxels[k];
      const float old = broad[broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4)];
      // Filling only adds, scraping only takes away, neither beyond the plane.
      if (rises[i] > 0)
        heap[i] = std::min(heap[i], std::max(values[k], std::min(heights[i], old)) - old);
      else
        cut[i] = std::max(cut[i], std::min(values[k], std::max(heights[i], old)) - old);
    }
  }
  if (!gathered) return false;
  if (far) wentFar_.store(true, std::memory_order_relaxed);
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
