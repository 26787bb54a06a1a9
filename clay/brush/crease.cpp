// Clay comes nearer to the stroke and the stroke goes down into it, or up out of it.

#include <vector>

#include "clay/brush/warp_tool.h"

namespace argil::clay {
namespace {

constexpr double kNearer = 0.6;  // part of its distance, on a way of a radius
constexpr double kDepth = 0.25;  // of the way
// The surface's normal is that of 3³ places around the middle of the stamp, so many of them a radius: what is rough
// below the size of the tip does not turn it.
constexpr double kPlacesARadius = 3;

// Sums of three numbers that lie around a middle: both sides first, so that mirrored places give mirrored sums.
template <class At>
Vec3f sumOfThree(const At& at) {
  const Vec3f before = at(-1), middle = at(0), behind = at(1);
  return (before + behind) + middle;
}

// The gradient of the distances there, tricubic.
Vec3f gradientAt(Sampler& field, const Vec3d& p) {
  AxisPlace place[3];
  for (int k = 0; k < 3; ++k) {
    const double cell = std::floor(p[k]);
    place[k] = {static_cast<int>(cell), static_cast<float>(p[k] - cell)};
  }
  float values[64];  // of 4×4×4 voxels around it, z fastest
  for (int v = 0; v < 64; ++v)
    values[v] =
        field.voxel({place[0].base + (v >> 4) - 1, place[1].base + ((v >> 2) & 3) - 1, place[2].base + (v & 3) - 1});
  const FieldSample sample{values, place[0].t, place[1].t, place[2].t};
  FieldValue value;
  sampleField(std::span(&sample, 1), 16, 4, &value);
  return {value.x, value.y, value.z};
}

// The way out of the surface under the middle of a stamp; that of the tip where the clay says nothing.
Vec3f normalUnder(Sampler& before, const Stamp& s) {
  // Multiples of 2⁻¹⁶ throughout, as mirror images need them.
  const auto rounded = [](double v) { return std::nearbyint(v * 65536) / 65536; };
  const double apart = rounded(s.radius / kPlacesARadius);
  Vec3d middle;
  for (int k = 0; k < 3; ++k) middle[k] = rounded(0.5 * (s.a[k] + s.b[k]));
  const Vec3f sum = sumOfThree([&](int x) {
    return sumOfThree(
        [&](int y) { return sumOfThree([&](int z) { return gradientAt(before, middle + apart * Vec3d(x, y, z)); }); });
  });
  const float length2 = (sum.x() * sum.x() + sum.y() * sum.y()) + sum.z() * sum.z();
  return length2 > 1e-6f ? Vec3f(sum / std::sqrt(length2)) : Vec3f(s.axes.col(2));
}

class Crease : public WarpTool {
 public:
  double mostMove(const Stamp& s, double share) const override {
    return share * wayOf(s) * (kNearer * kLeverage + kDepth);
  }
  void begin(Sampler& before, std::span<const Stamp> images) override {
    normals_.clear();
    for (const Stamp& s : images) normals_.push_back(normalUnder(before, s));
  }
  void describe(const Stamp&, size_t i, float share, float way, WarpImage& w) const override {
    w.fromSegment = true;
    w.pull = std::abs(share) * static_cast<float>(kNearer) * (way / w.radius);
    w.lift = share * static_cast<float>(kDepth) * way;
    w.nx = normals_[i].x(), w.ny = normals_[i].y(), w.nz = normals_[i].z();
  }

 private:
  std::vector<Vec3f> normals_;  // of each image
};

}  // namespace

std::unique_ptr<WarpTool> makeCrease() {
  return std::make_unique<Crease>();
}

}  // namespace argil::clay
