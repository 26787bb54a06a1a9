// The swept tip is laid on and blended; or laid on or cut away where a mask makes the order of images matter. Else the stroke does that itself.

#include <algorithm>

#include "clay/brush_method.h"
#include "clay/swept_tip.h"

namespace argil::clay {
namespace {

class Sweep : public DistanceMethod {
 public:
  explicit Sweep(const StrokeContext& context)
      : brush_(context.brush),
        carves_(context.operation.method == Method::carve),
        // Beyond the band a distance is only a bound, so a blend is no wider than what is known.
        blend_(context.operation.method == Method::wax ? std::min(brush_->blend, context.band) : 0),
        band_(context.band) {}

  double reach(const Stamp& stamp) const override { return stamp.largestRadius() * aroundTip(*brush_) + band_; }
  bool everywhere() const override { return true; }
  bool exact() const override { return blend_ == 0; }

  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override {
    float distance[kBrickVoxels], one[kBrickVoxels];
    for (size_t i = 0; i < images.size(); ++i) {
      tipDistances(*brush_, images[i], coord, i == 0 ? distance : one);
      if (i > 0)
        for (int v = 0; v < kBrickVoxels; ++v) distance[v] = std::min(distance[v], one[v]);
    }
    const Slot now = before.slot(coord);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float old = now.phi(v, band_), d = distance[v];
      if (carves_) {
        phi[v] = std::max(old, -d);
      } else {
        const float near = blend_ > 0 ? std::max(blend_ - std::abs(old - d), 0.0f) / blend_ : 0.0f;
        phi[v] = std::min(old, d) - near * near * (blend_ * 0.25f);
      }
    }
    return true;
  }

 private:
  std::shared_ptr<const Brush> brush_;
  bool carves_;
  float blend_, band_;
};

}  // namespace

std::unique_ptr<DistanceMethod> makeSweep(const StrokeContext& context) { return std::make_unique<Sweep>(context); }

}  // namespace argil::clay
