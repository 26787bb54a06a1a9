// The swept tip is laid on and blended; or laid on or cut away where a mask makes the order of images matter. Else the
// stroke does that itself.

#include <algorithm>
#include <array>
#include <unordered_map>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/brush/swept_tip.h"
#include "clay/store/brick_set.h"

namespace argil::clay {
namespace {

class Sweep : public DistanceMethod {
 public:
  explicit Sweep(const StrokeContext& context)
      : brush_(context.brush),
        carves_(context.operation.method == Method::carve),
        // Beyond the band a distance is only a bound, so a blend is no wider than what is known.
        blend_(context.operation.method == Method::wax ? std::min(brush_->blend, context.band) : 0),
        band_(context.band),
        threads_(context.threads),
        base_(context.base) {}

  double reach(const Stamp& stamp) const override { return stamp.largestRadius() * aroundTip(*brush_) + band_; }
  bool everywhere() const override { return true; }
  Renew leaves() const override { return blend_ == 0 ? Renew::none : Renew::all; }

  // A blend is that of the clay before the stroke with all that the tip swept so far: it does not grow with the count
  // of stamps. Where that clay had no surface it is laid on.
  Steps begin(Sampler&, std::span<const Stamp> images, std::span<const Coord> bricks) override {
    if (blend_ == 0) co_return;
    std::vector<std::pair<Coord, Swept*>> work;
    for (const Coord coord : bricks) {
      if (base_.find(coord).isTile()) continue;
      auto& swept = swept_[coord];
      if (!swept) {
        swept = std::make_unique<Swept>();
        swept->fill(2 * kMostBlend);
      }
      work.emplace_back(coord, swept.get());
    }
    for (size_t from = 0; from < work.size(); from += kBricksAStep) {
      if (from > 0) co_yield Steps::kPause;
      forEachBrickOf(std::min(kBricksAStep, work.size() - from), threads_, [&](size_t i) {
        float one[kBrickVoxels];
        const auto& [coord, swept] = work[from + i];
        for (const Stamp& image : images) {
          tipDistances(*brush_, image, coord, one);
          for (size_t v = 0; v < kBrickVoxels; ++v) (*swept)[v] = std::min((*swept)[v], one[v]);
        }
      });
    }
  }

  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override {
    if (const auto it = swept_.find(coord); it != swept_.end()) return blended(coord, *it->second, phi);
    float distance[kBrickVoxels], one[kBrickVoxels];
    for (size_t i = 0; i < images.size(); ++i) {
      tipDistances(*brush_, images[i], coord, i == 0 ? distance : one);
      if (i > 0)
        for (int v = 0; v < kBrickVoxels; ++v) distance[v] = std::min(distance[v], one[v]);
    }
    const BrickValues& now = before.slot(coord).values(one, band_);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float old = now[v], d = distance[v];
      phi[v] = carves_ ? std::max(old, -d) : std::min(old, d);
    }
    return true;
  }

 private:
  using Swept = std::array<float, kBrickVoxels>;
  static constexpr float kMostBlend = 64;

  // Blends the clay before the stroke, not as it is by now: distances are renewed after each stamp, and what that moves
  // would add up.
  bool blended(Coord coord, const Swept& swept, float (&phi)[kBrickVoxels]) const {
    BrickValues scratch;
    const BrickValues& was = base_.find(coord).values(scratch, band_);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float old = was[v], d = swept[static_cast<size_t>(v)];
      const float near = std::max(blend_ - std::abs(old - d), 0.0f) / blend_;
      // Nothing is blended with what is not known: so it is laid on alone where the clay or the tip is a band away.
      const float known = std::min(std::max(band_ - old, 0.0f), 1.0f) * std::min(std::max(band_ - d, 0.0f), 1.0f);
      phi[v] = std::min(old, d) - near * near * known * (blend_ * 0.25f);
    }
    return true;
  }

  std::shared_ptr<const Brush> brush_;
  bool carves_;
  float blend_, band_;
  int threads_;
  Version base_;
  std::unordered_map<Coord, std::unique_ptr<Swept>, CoordHash> swept_;  // distances to all that was swept
};

}  // namespace

std::unique_ptr<DistanceMethod> makeSweep(const StrokeContext& context) {
  return std::make_unique<Sweep>(context);
}

}  // namespace argil::clay
