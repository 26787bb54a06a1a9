// The swept tip is cut away, laid on, or laid on and blended.

#include <algorithm>

#include "clay/brush_method.h"
#include "clay/error.h"

namespace argil::clay {
namespace {

class Sweep : public DistanceMethod {
 public:
  explicit Sweep(const StrokeContext& context) : brush_(context.brush), method_(context.operation.method), band_(context.band) {
    if (brush_->tip != Tip::ball) throw Error("no such tip yet");
  }

  double reach(const Stamp& stamp) const override { return stamp.largestRadius() + band_; }
  bool exact() const override { return method_ != Method::wax; }

  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override {
    float distance[kBrickVoxels], one[kBrickVoxels];
    for (size_t i = 0; i < images.size(); ++i) {
      ballDistances(sweptBall(images[i], coord), i == 0 ? distance : one);
      if (i > 0)
        for (int v = 0; v < kBrickVoxels; ++v) distance[v] = std::min(distance[v], one[v]);
    }
    const Slot now = before.slot(coord);
    // Beyond the band a distance is only a bound, so a blend is no wider than what is known.
    const float blend = std::min(brush_->blend, band_);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float old = now.phi(v, band_), d = distance[v];
      if (method_ == Method::carve) {
        phi[v] = std::max(old, -d);
      } else {
        const float near = method_ == Method::wax && blend > 0 ? std::max(blend - std::abs(old - d), 0.0f) / blend : 0.0f;
        phi[v] = std::min(old, d) - near * near * (blend * 0.25f);
      }
    }
    return true;
  }

 private:
  std::shared_ptr<const Brush> brush_;
  Method method_;
  float band_;
};

}  // namespace

std::unique_ptr<DistanceMethod> makeSweep(const StrokeContext& context) { return std::make_unique<Sweep>(context); }

}  // namespace argil::clay
