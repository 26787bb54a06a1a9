// Back to an earlier version.

#include <algorithm>

#include "clay/base/error.h"
#include "clay/brush/brush_method.h"

namespace argil::clay {
namespace {

class Morphing : public DistanceMethod {
 public:
  explicit Morphing(const StrokeContext& context)
      : brush_(context.brush), operation_(context.operation), band_(context.band) {
    const Version& goal = brush_->before;
    if (!goal) throw Error("there is no earlier clay to go back to");
    if (goal.store() != context.start.store() || !(goal.grid() == context.start.grid()))
      throw Error("the earlier clay is of another voxel size: resampling cannot be morphed back");
  }

  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override {
    const Slot now = before.slot(coord), goal = brush_->before.find(coord);
    if (now == goal) return false;
    float weight[kBrickVoxels];
    imageWeights(images, operation_.shape, coord, static_cast<float>(brush_->perStamp), weight);
    BrickValues nowScratch, goalScratch;
    const BrickValues &nowValues = now.values(nowScratch, band_), &goalValues = goal.values(goalScratch, band_);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float from = nowValues[i], to = goalValues[i];
      const float w = weight[i] * operation_.amount;
      // The whole way where it is nearly there: it arrives, to the bit.
      const float step = (to - from) * w;
      phi[i] = w > 0 && std::abs(to - from) < 0.01f ? to : from + step;
    }
    return true;
  }

 private:
  std::shared_ptr<const Brush> brush_;
  Operation operation_;
  float band_;
};

}  // namespace

std::unique_ptr<DistanceMethod> makeMorphing(const StrokeContext& context) {
  return std::make_unique<Morphing>(context);
}

}  // namespace argil::clay
