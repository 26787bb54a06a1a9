// Towards the mean of the neighbours.

#include "clay/brush_method.h"
#include "clay/redistance.h"

namespace argil::clay {
namespace {

class Smoothing : public DistanceMethod {
 public:
  explicit Smoothing(const StrokeContext& context) : operation_(context.operation), band_(context.band) {}

  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override {
    if (before.slot(coord).isTile()) return false;
    float padded[kPaddedSize] = {};
    gatherPadded(before, coord, padded);
    float weight[kBrickVoxels];
    imageWeights(images, operation_.shape, coord, weight);
    smoothBrick(padded, weight, operation_.amount, band_, phi);
    return true;
  }

 private:
  Operation operation_;
  float band_;
};

}  // namespace

std::unique_ptr<DistanceMethod> makeSmoothing(const StrokeContext& context) { return std::make_unique<Smoothing>(context); }

}  // namespace argil::clay
