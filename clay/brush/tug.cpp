// Clay under the tip goes with it.

#include "clay/brush/warp_tool.h"

namespace argil::clay {
namespace {

class Tug : public WarpTool {
 public:
  double mostMove(const Stamp& s, double share) const override { return share * (s.b - s.a).norm(); }
  void describe(const Stamp&, size_t, float share, float, WarpImage& w) const override { w.move = share; }
};

}  // namespace

std::unique_ptr<WarpTool> makeTug() {
  return std::make_unique<Tug>();
}

}  // namespace argil::clay
