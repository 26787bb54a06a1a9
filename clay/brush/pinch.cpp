// Clay on both sides comes nearer to the stroke.

#include "clay/brush/warp_tool.h"

namespace argil::clay {
namespace {

constexpr double kNearer = 0.8;  // part of its distance, on a way of a radius

class Pinch : public WarpTool {
 public:
  double mostMove(const Stamp& s, double share) const override { return share * wayOf(s) * kNearer * kLeverage; }
  void describe(const Stamp&, size_t, float share, float way, WarpImage& w) const override {
    w.fromSegment = true;
    w.pull = share * static_cast<float>(kNearer) * (way / w.radius);
  }
};

}  // namespace

std::unique_ptr<WarpTool> makePinch() {
  return std::make_unique<Pinch>();
}

}  // namespace argil::clay
