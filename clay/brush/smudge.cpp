// Clay under the tip goes along with it and is left behind bit by bit, as paint under a finger.

#include "clay/brush/warp_tool.h"

namespace argil::clay {
namespace {

constexpr float kSlip = 0.5f;  // What clay loses on the tip.

class Smudge : public WarpTool {
 public:
  double mostMove(const Stamp& s, double share) const override { return share * (s.b - s.a).norm() * kSlip; }
  void describe(const Stamp&, size_t, float share, float, WarpImage& w) const override { w.move = share * kSlip; }
};

}  // namespace

std::unique_ptr<WarpTool> makeSmudge() {
  return std::make_unique<Smudge>();
}

}  // namespace argil::clay
