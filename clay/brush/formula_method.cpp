// Distances as a formula says.

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/brush/brush_method.h"
#include "clay/brush/formula.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {
namespace {

// Voxels that phi moves at most in one application: less than the band, so that what is known goes along with the
// surface.
constexpr float kMost = 1.5f;

class ByFormula : public DistanceMethod {
 public:
  explicit ByFormula(const StrokeContext& context)
      : brush_(context.brush),
        formula_(*brush_->formula),
        operation_(context.operation),
        band_(context.band),
        voxelMm_(static_cast<float>(context.base.grid().voxelMm)),
        originMm_(context.base.grid().originMm.cast<float>()) {}

  Renew leaves() const override { return Renew::all; }
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  // What a formula reads of the clay, whichever image.
  struct Clay {
    float phi[kBrickVoxels], mean[kBrickVoxels], normal[3][kBrickVoxels];
  };
  // And of an image.
  struct Held {
    float weight[kBrickVoxels], place[3][kBrickVoxels], fromTip[3][kBrickVoxels], fromPath[kBrickVoxels],
        normal[3][kBrickVoxels];
  };
  [[nodiscard]] bool readsAny(FormulaInput first, int count) const {
    for (int i = 0; i < count; ++i)
      if (formula_.reads(static_cast<FormulaInput>(static_cast<int>(first) + i))) return true;
    return false;
  }
  void look(Sampler& before, Coord coord, const BrickValues& values, Clay& clay) const;
  void hold(const Stamp& image, const Stamp& first, Coord coord, const Clay& clay, Held& held) const;

  std::shared_ptr<const Brush> brush_;
  const Formula& formula_;
  Operation operation_;
  float band_, voxelMm_;
  Vec3f originMm_;
};

void ByFormula::look(Sampler& before, Coord coord, const BrickValues& values, Clay& clay) const {
  for (int i = 0; i < kBrickVoxels; ++i) clay.phi[i] = values[i] * voxelMm_;
  const bool mean = formula_.reads(FormulaInput::mean), normal = readsAny(FormulaInput::nx, 3);
  if (!mean && !normal) return;
  float padded[kPaddedSize] = {};
  gatherPadded(before, coord, padded);
  if (mean) {
    float whole[kBrickVoxels];
    std::fill(std::begin(whole), std::end(whole), 1.0f);
    smoothBrick(padded, whole, 1, HUGE_VALF, clay.mean);
    for (float& each : clay.mean) each *= voxelMm_;
  }
  if (!normal) return;
  for (int i = 0; i < kBrickVoxels; ++i) {
    const int at = paddedOffset((i >> 6) + 1, ((i >> 3) & 7) + 1, (i & 7) + 1);
    const float gx = padded[at + 10 * kPaddedRow] - padded[at - 10 * kPaddedRow],
                gy = padded[at + kPaddedRow] - padded[at - kPaddedRow], gz = padded[at + 1] - padded[at - 1];
    const float length = std::sqrt((gx * gx + gy * gy) + gz * gz), inverse = length > 0.2f ? 1 / length : 0.0f;
    clay.normal[0][i] = gx * inverse;
    clay.normal[1][i] = gy * inverse;
    clay.normal[2][i] = gz * inverse;
  }
}

// Places and directions of a mirror image or a turned copy are those that they are copies of: what the formula says
// there is said here too, to the bit in a mirror.
void ByFormula::hold(const Stamp& image, const Stamp& first, Coord coord, const Clay& clay, Held& held) const {
  brushWeights(*brush_, operation_.shape, std::span(&image, 1), coord, held.weight);
  const bool place = readsAny(FormulaInput::x, 3), tip = readsAny(FormulaInput::u, 4),
             normal = readsAny(FormulaInput::nx, 3);
  if (!place && !tip && !normal) return;
  const BrickFrame frame(image.a, coord);
  const Vec3f way = (image.b - image.a).cast<float>();
  const float length2 = (way.x() * way.x() + way.y() * way.y()) + way.z() * way.z();
  const float inverse = length2 > 0 && std::isfinite(1 / length2) ? 1 / length2 : 0.0f;
  const auto radius = static_cast<float>(image.radius), growth = static_cast<float>(image.radiusAtEnd()) - radius;
  const Eigen::Matrix3f& own = image.axes;
  const Vec3f start = (first.a * static_cast<double>(voxelMm_)).cast<float>() + originMm_;
  const auto along = [](const Eigen::Matrix3f& axes, int axis, const Vec3f& v) {
    return (axes(0, axis) * v.x() + axes(1, axis) * v.y()) + axes(2, axis) * v.z();
  };
  for (int i = 0; i < kBrickVoxels; ++i) {
    const Vec3f p = frame.at(i >> 6, (i >> 3) & 7, i & 7);
    if (place) {
      // In the tip's axes, then from there as the first image is held.
      const Vec3f in(along(own, 0, p), along(own, 1, p), along(own, 2, p));
      for (int k = 0; k < 3; ++k)
        held.place[k][i] =
            start[k] + ((first.axes(k, 0) * in.x() + first.axes(k, 1) * in.y()) + first.axes(k, 2) * in.z()) * voxelMm_;
    }
    if (tip) {
      const float t = std::min(std::max(((p.x() * way.x() + p.y() * way.y()) + p.z() * way.z()) * inverse, 0.0f), 1.0f);
      const Vec3f e = p - way * t;
      const float over = 1 / (radius + t * growth);
      for (int k = 0; k < 3; ++k) held.fromTip[k][i] = along(own, k, e) * over;
      held.fromPath[i] = std::sqrt((e.x() * e.x() + e.y() * e.y()) + e.z() * e.z()) * over;
    }
    if (normal) {
      const Vec3f n(clay.normal[0][i], clay.normal[1][i], clay.normal[2][i]);
      const Vec3f in(along(own, 0, n), along(own, 1, n), along(own, 2, n));
      for (int k = 0; k < 3; ++k)
        held.normal[k][i] = (first.axes(k, 0) * in.x() + first.axes(k, 1) * in.y()) + first.axes(k, 2) * in.z();
    }
  }
}

bool ByFormula::brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const {
  const Slot slot = before.slot(coord);
  if (slot.isTile()) return false;
  BrickValues scratch;
  const BrickValues& values = slot.values(scratch, band_);
  Clay clay;
  look(before, coord, values, clay);
  Held held;
  float change[kBrickVoxels] = {}, made[kBrickVoxels];
  const float toVoxels = 1 / voxelMm_;
  for (const Stamp& image : images) {
    hold(image, images.front(), coord, clay, held);
    if (std::none_of(std::begin(held.weight), std::end(held.weight), [](float w) { return w > 0; })) continue;
    const float radiusMm = static_cast<float>(image.radius) * voxelMm_, strength = image.strength;
    const FormulaOperand inputs[kFormulaInputs] = {
        {clay.phi},        {clay.mean},       {held.weight},     {held.place[0]},  {held.place[1]},  {held.place[2]},
        {held.fromTip[0]}, {held.fromTip[1]}, {held.fromTip[2]}, {held.fromPath},  {held.normal[0]}, {held.normal[1]},
        {held.normal[2]},  {&radiusMm, true}, {&strength, true}, {&voxelMm_, true}};
    formula_.run(inputs, brush_->values, made);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float by = (made[i] - clay.phi[i]) * toVoxels * operation_.amount;
      // What is no number says nothing.
      if (!(held.weight[i] > 0) || !(std::abs(values[i]) < band_) || !(std::abs(by) <= 1e30f)) continue;
      // Of several images the one that does most; of two that do as much the one that cuts.
      if (std::abs(by) > std::abs(change[i]) || (std::abs(by) == std::abs(change[i]) && by > change[i])) change[i] = by;
    }
  }
  for (int i = 0; i < kBrickVoxels; ++i) phi[i] = values[i] + std::clamp(change[i], -kMost, kMost);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeFormula(const StrokeContext& context) {
  if (!context.brush->formula) throw Error("a formula brush that has no formula");
  return std::make_unique<ByFormula>(context);
}

}  // namespace argil::clay
