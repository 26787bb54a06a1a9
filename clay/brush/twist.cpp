// Clay turns around the axis of the tip.

#include "clay/brush/warp_tool.h"

namespace argil::clay {
namespace {

class TwistTool : public WarpTool {
 public:
  explicit TwistTool(float angle) : angle_(angle) {}

  double mostMove(const Stamp& s, double share) const override {
    const double radius = s.largestRadius();
    return share * wayOf(s) / radius * std::abs(static_cast<double>(angle_)) * radius * kLeverage;
  }
  void describe(const Stamp& s, size_t, float share, float way, WarpImage& w) const override {
    // An axis turns the other way in a mirror.
    const Vec3f x = s.axes.col(0), y = s.axes.col(1), z = s.axes.col(2);
    const float hand = (z.x() * (x.y() * y.z() - x.z() * y.y()) + z.y() * (x.z() * y.x() - x.x() * y.z())) +
                       z.z() * (x.x() * y.y() - x.y() * y.x());
    const float turn = (hand < 0 ? -1.0f : 1.0f) * share * angle_ * (way / w.radius);
    w.spinX = turn * z.x(), w.spinY = turn * z.y(), w.spinZ = turn * z.z();
  }

 private:
  float angle_;
};

}  // namespace

std::unique_ptr<WarpTool> makeTwist(float angle) {
  return std::make_unique<TwistTool>(angle);
}

}  // namespace argil::clay
