#include "clay/brush/external_brush.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <iterator>
#include <vector>

#include "clay/base/error.h"
#include "clay/brush/brush_method.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {

BrickLayout brickLayout(int margin) {
  switch (margin) {
    case 0:
      return {0, kBrickEdge, kBrickEdge * kBrickEdge, kBrickVoxels};
    case 1:
      return {paddedOffset(1, 1, 1), paddedOffset(0, 1, 0) - paddedOffset(0, 0, 0),
              paddedOffset(1, 0, 0) - paddedOffset(0, 0, 0), kPaddedSize};
    default:
      return {broadOffset(4, 4, 4), broadOffset(0, 1, 0) - broadOffset(0, 0, 0),
              broadOffset(1, 0, 0) - broadOffset(0, 0, 0), kBroadSize};
  }
}

namespace {

// Voxels that phi moves at most in one application: less than the band, so that what is known goes along with the
// surface.
constexpr float kMost = 1.5f;

class ByWorker : public DistanceMethod {
 public:
  explicit ByWorker(const StrokeContext& context)
      : brush_(context.brush),
        operation_(context.operation),
        band_(context.band),
        threads_(context.threads),
        worker_(brush_->external->begin({context.base.grid(), operation_.amount, static_cast<float>(brush_->perStamp),
                                         brush_->values, threads_})) {}

  Renew leaves() const override { return brush_->external->leaves(); }
  Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  struct Values {
    float of[kBrickVoxels];
  };
  void give(Sampler& before, std::span<const Stamp> images, std::span<const Coord> some);
  void take(Sampler& before, std::span<const Coord> some, Values* to) const;

  std::shared_ptr<const Brush> brush_;
  Operation operation_;
  float band_;
  int threads_;
  std::unique_ptr<BrickWorker> worker_;  // null: it failed, and no stamp does anything any more
  // Of the application: bricks that hold some surface, and what they become.
  std::vector<Coord> bricks_;
  std::vector<Values> made_;
  std::vector<Values> weights_;  // of a batch
};

Steps ByWorker::begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
  bricks_.clear();
  if (!worker_) co_return;
  std::vector<Coord> here;
  std::copy_if(bricks.begin(), bricks.end(), std::back_inserter(here),
               [&](Coord coord) { return !before.slot(coord).isTile(); });
  made_.resize(here.size());
  const size_t most = worker_->most();
  try {
    for (size_t from = 0; from < here.size(); from += most) {
      const auto some = std::span(here).subspan(from, std::min(most, here.size() - from));
      worker_->begin(images, some.size());
      give(before, images, some);
      worker_->finish();
      take(before, some, made_.data() + from);
    }
  } catch (...) {
    worker_.reset();
    throw;
  }
  bricks_ = std::move(here);  // now that all of the application is there
}

void ByWorker::give(Sampler& before, std::span<const Stamp> images, std::span<const Coord> some) {
  const int margin = brush_->external->margin();
  weights_.resize(some.size());
  const bool alone = threads_ == 1;  // one after the other, in order
  forBrickRanges(some.size(), threads_, [&](size_t begin, size_t end) {
    Sampler mine = before;
    // Memory that another process reads costs as much as is written to it, however often a line of it is touched.
    alignas(64) float phi[kBroadSize] = {};
    for (size_t i = begin; i < end; ++i) {
      const BrickWorker::Place place = worker_->place(i);
      const std::array<int32_t, 3> coord{some[i].x, some[i].y, some[i].z};
      std::memcpy(place.coord, coord.data(), sizeof coord);
      const float* given = phi;
      BrickValues scratch;
      if (margin == 0)
        given = mine.slot(some[i]).values(scratch, band_);
      else if (margin == 1)
        gatherPadded(mine, some[i], phi);
      else
        gatherBroad(mine, some[i], margin, phi);
      std::memcpy(place.phi, given, static_cast<size_t>(brickLayout(margin).floats) * sizeof(float));
      float(&weight)[kBrickVoxels] = weights_[i].of;
      brushWeights(*brush_, operation_.shape, images, some[i], weight);
      std::memcpy(place.weight, weight, sizeof weight);
      if (alone) worker_->written(i + 1);
    }
  });
  worker_->written(some.size());
}

void ByWorker::take(Sampler& before, std::span<const Coord> some, Values* to) const {
  bool finite = true;
  for (size_t i = 0; i < some.size(); ++i) {
    float(&made)[kBrickVoxels] = to[i].of;
    std::memcpy(made, worker_->result(i), sizeof made);
    std::atomic_signal_fence(std::memory_order_seq_cst);  // read once: whoever computed it may go on writing
    BrickValues scratch;
    finite = boundChange(before.slot(some[i]).values(scratch, band_), weights_[i].of, band_, kMost, made) && finite;
  }
  if (!finite) worker_->failResult();
}

bool ByWorker::brick(Sampler&, std::span<const Stamp>, Coord coord, float (&phi)[kBrickVoxels]) const {
  const auto it = std::lower_bound(bricks_.begin(), bricks_.end(), coord);
  if (it == bricks_.end() || *it != coord) return false;
  std::copy_n(made_[static_cast<size_t>(it - bricks_.begin())].of, kBrickVoxels, phi);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeExternal(const StrokeContext& context) {
  if (!context.brush->external) throw Error("a brush that is computed elsewhere and does not say where");
  return std::make_unique<ByWorker>(context);
}

}  // namespace argil::clay
