// Along the normals of the surface as it was when the stroke began: what is left is its distance then, less a height that belongs to each of its points.

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "clay/brush_method.h"
#include "clay/height_image.h"
#include "clay/wide_distance.h"

namespace argil::clay {
namespace {

// A stamp of strength 1 adds this part of the height: swept stamps a tenth of the radius apart, of the smooth falloff, add up to 35/3 of one where the tool's
// middle passes, so that a pass is the height.
constexpr float kStep = 3.0f / 35;
// Beyond the band around what a stamp may raise: for the slopes that are taken across voxels.
constexpr float kBeyond = 2;
// Reach grows by this, so that bricks are not solved again at each stamp.
constexpr float kReachStep = 2;

// Rounded so that a place minus it is exact.
Vec3d quantised(const Vec3f& v) { return (v.cast<double>() * 65536.0).array().round().matrix() / 65536.0; }

class Raising : public DistanceMethod {
 public:
  explicit Raising(const StrokeContext& context)
      : brush_(context.brush), operation_(context.operation), band_(context.band), side_(context.operation.amount < 0 ? -1.0f : 1.0f),
        rise_(std::abs(context.operation.amount) * context.brush->height), base_(context.start, context.operation.amount < 0 ? -1 : 1) {}

  double travel() const override { return step(); }
  double reach(const Stamp& stamp) const override { return stamp.largestRadius() * (brush_->image ? 1.4143 : 1.0) + band_ + highest_ + step(); }
  void begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

 private:
  struct Layer {
    float height[kBrickVoxels] = {};
    uint64_t known[kBrickEdge] = {};  // voxels that have all applications so far
    uint64_t changedBy = 0;           // application
  };
  struct Application {
    std::vector<Stamp> images;
    Vec3d low, high;  // around all that they reach on the surface
  };

  // How far one application raises at most.
  [[nodiscard]] float step() const { return brush_->image ? rise_ : rise_ * kStep; }
  [[nodiscard]] float limit() const { return brush_->limited || brush_->image ? rise_ : HUGE_VALF; }
  [[nodiscard]] Vec3d lowered(const Vec3d& place) const;
  [[nodiscard]] bool raise(const Application& application, Coord coord, const WideDistance::Block& block, const uint64_t* mask, Layer& layer) const;
  void emboss(const Stamp& stamp, Coord coord, const WideDistance::Block& block, float (&weight)[kBrickVoxels]) const;
  [[nodiscard]] const Layer* layer(Coord coord) const {
    const auto it = layers_.find(coord);
    return it == layers_.end() ? nullptr : it->second.get();
  }

  std::shared_ptr<const Brush> brush_;
  Operation operation_;
  float band_, side_, rise_;
  WideDistance base_;
  std::unordered_map<Coord, std::unique_ptr<Layer>, CoordHash> layers_;
  std::vector<Application> applications_;
  float highest_ = 0;  // bound of all heights so far
};

// A tool that rides on what the stroke has laid belongs to the place below it.
Vec3d Raising::lowered(const Vec3d& place) const {
  const Vec3d floor = place.array().floor();
  const Coord first{static_cast<int32_t>(floor.x()), static_cast<int32_t>(floor.y()), static_cast<int32_t>(floor.z())};
  const Vec3f t = (place - floor).cast<float>();
  // u, height, foot of the corners; halves are summed pair by pair, so that mirroring changes no bit.
  float value[8][5];
  for (int i = 0; i < 8; ++i) {
    const Coord v = first + Coord{i >> 2, (i >> 1) & 1, i & 1};
    const Coord coord = v >> kBrickBits;
    const int at = Brick::offset(v.x & 7, v.y & 7, v.z & 7);
    const WideDistance::Block* block = base_.find(coord);
    const Layer* heights = layer(coord);
    if (!block || !heights || !((block->known[at >> 6] >> (at & 63)) & 1)) return place;
    value[i][0] = block->u[at];
    value[i][1] = heights->height[at];
    for (int axis = 0; axis < 3; ++axis) value[i][2 + axis] = block->foot[axis * kBrickVoxels + at];
  }
  float mean[5];
  for (int k = 0; k < 5; ++k) {
    float x[2];
    for (int i = 0; i < 2; ++i) {
      const float low = value[4 * i][k] * (1 - t.z()) + value[4 * i + 1][k] * t.z(), high = value[4 * i + 2][k] * (1 - t.z()) + value[4 * i + 3][k] * t.z();
      x[i] = low * (1 - t.y()) + high * t.y();
    }
    mean[k] = x[0] * (1 - t.x()) + x[1] * t.x();
  }
  if (!(mean[0] > 0)) return place;
  return place + quantised(Vec3f(mean[2], mean[3], mean[4]) * std::min(mean[1] / mean[0], 1.0f));
}

void Raising::begin(Sampler&, std::span<const Stamp> images, std::span<const Coord> bricks) {
  highest_ = std::max(highest_, std::min(highest_ + step(), limit()));
  base_.extend(bricks, std::ceil((band_ + highest_ + kBeyond) / kReachStep) * kReachStep);

  Application now;
  now.low = Vec3d::Constant(HUGE_VAL);
  now.high = -now.low;
  for (const Stamp& each : images) {
    Stamp stamp = each;
    stamp.a = lowered(each.a);
    stamp.b = each.b == each.a ? stamp.a : lowered(each.b);
    const Vec3d radius = Vec3d::Constant(stamp.largestRadius() * (brush_->image ? 1.4143 : 1.0) + 1);
    now.low = now.low.cwiseMin(stamp.a.cwiseMin(stamp.b) - radius);
    now.high = now.high.cwiseMax(stamp.a.cwiseMax(stamp.b) + radius);
    now.images.push_back(stamp);
  }
  applications_.push_back(std::move(now));
  const Application& current = applications_.back();

  for (const Coord coord : bricks) {
    const WideDistance::Block* block = base_.find(coord);
    if (!block) continue;
    std::unique_ptr<Layer>& layer = layers_[coord];
    if (!layer) layer = std::make_unique<Layer>();
    const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
    const Vec3f low(block->feet[0][0], block->feet[0][1], block->feet[0][2]), high(block->feet[1][0], block->feet[1][1], block->feet[1][2]);
    if (!(low.x() <= high.x())) continue;
    const Vec3d from = middle + low.cast<double>(), to = middle + high.cast<double>(), centre = (from + to) / 2;
    const double around = (to - from).norm() / 2 + 0.01;
    const auto near = [&](const Application& a) {
      if (!((a.low - to).array() < 0).all() || !((from - a.high).array() < 0).all()) return false;
      return std::any_of(a.images.begin(), a.images.end(), [&](const Stamp& s) {
        return segmentDistance(s, centre) < around + s.largestRadius() * (brush_->image ? 1.4143 : 1.0);
      });
    };
    // Voxels that have come within reach only now get what was applied before.
    uint64_t fresh[kBrickEdge], any = 0;
    for (int x = 0; x < kBrickEdge; ++x) {
      any |= fresh[x] = block->known[x] & ~layer->known[x];
      layer->known[x] = block->known[x];
    }
    if (any)
      for (size_t i = 0; i + 1 < applications_.size(); ++i)
        if (near(applications_[i])) static_cast<void>(raise(applications_[i], coord, *block, fresh, *layer));
    if (near(current) && raise(current, coord, *block, block->known, *layer)) layer->changedBy = applications_.size();
  }
}

bool Raising::raise(const Application& application, Coord coord, const WideDistance::Block& block, const uint64_t* mask, Layer& layer) const {
  float weight[kBrickVoxels] = {};
  if (!brush_->image) {
    for (const Stamp& each : application.images) footWeights(sweptBall(each, coord), static_cast<int>(operation_.shape), each.strength, block.foot, weight);
    return raiseHeights(weight, step(), limit(), mask, layer.height);
  }
  for (const Stamp& each : application.images) emboss(each, coord, block, weight);
  bool any = false;
  for (int i = 0; i < kBrickVoxels; ++i) {
    const float height = weight[i] * rise_;
    if (!((mask[i >> 6] >> (i & 63)) & 1) || !(height > layer.height[i])) continue;
    layer.height[i] = height;
    any = true;
  }
  return any;
}

// The largest of what `weight` holds and the image over the stamp's x and y at its end, fading towards the rim by the falloff.
void Raising::emboss(const Stamp& stamp, Coord coord, const WideDistance::Block& block, float (&weight)[kBrickVoxels]) const {
  const HeightImage& image = *brush_->image;
  const auto radius = static_cast<float>(stamp.radiusAtEnd());
  // An image's pixels to a voxel.
  const int level = image.levelFor(0.5f * static_cast<float>(std::max(image.width(), image.height())) / radius);
  const BrickFrame frame(stamp.b, coord);
  const Vec3f ex = stamp.axes.col(0), ey = stamp.axes.col(1), ez = stamp.axes.col(2);
  for (int i = 0; i < kBrickVoxels; ++i) {
    const Vec3f at = frame.at(i >> 6, (i >> 3) & 7, i & 7) + Vec3f(block.foot[i], block.foot[kBrickVoxels + i], block.foot[2 * kBrickVoxels + i]);
    const auto along = [&](const Vec3f& axis) { return ((at.x() * axis.x() + at.y() * axis.y()) + at.z() * axis.z()) / radius; };
    const float x = along(ex), y = along(ey), z = along(ez);
    if (!(std::abs(z) < 1) || !(std::abs(x) < 1) || !(std::abs(y) < 1)) continue;
    // The constant falloff leaves the whole square, as an image is one, but for its rim: a step would fall to either side of a voxel.
    const float rim = std::min(0.5f * radius * (1 - std::max(std::max(std::abs(x), std::abs(y)), std::abs(z))), 1.0f);
    const float shade = operation_.shape == Falloff::constant ? rim : falloff(operation_.shape, std::sqrt(x * x + y * y)) * rim;
    if (shade > 0) weight[i] = std::max(weight[i], image.at(x, y, level) * shade * stamp.strength);
  }
}

bool Raising::brick(Sampler& before, std::span<const Stamp>, Coord coord, float (&phi)[kBrickVoxels]) const {
  const WideDistance::Block* block = base_.find(coord);
  const Layer* mine = layer(coord);
  if (!block || !mine) return false;
  // Heights with one voxel around them; what lies behind the surface has none of its own and goes on as it is here.
  constexpr Coord kFaces[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  const Layer* beside[6];
  bool changed = mine->changedBy == applications_.size();
  for (int face = 0; face < 6; ++face) {
    beside[face] = layer(coord + kFaces[face]);
    changed |= beside[face] && beside[face]->changedBy == applications_.size();
  }
  if (!changed) return false;
  float padded[kPaddedSize] = {};
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) std::copy_n(mine->height + Brick::offset(x, y, 0), 8, padded + paddedOffset(x + 1, y + 1, 1));
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, target = face % 2 ? 9 : 0;
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j) {
        // Of the neighbour its layer next to this brick, else this brick's own.
        const int from = beside[face] ? (face % 2 ? 0 : 7) : (face % 2 ? 7 : 0);
        const float* heights = beside[face] ? beside[face]->height : mine->height;
        if (axis == 0)
          padded[paddedOffset(target, i + 1, j + 1)] = heights[Brick::offset(from, i, j)];
        else if (axis == 1)
          padded[paddedOffset(i + 1, target, j + 1)] = heights[Brick::offset(i, from, j)];
        else
          padded[paddedOffset(i + 1, j + 1, target)] = heights[Brick::offset(i, j, from)];
      }
  }
  before.slot(coord).read(phi, band_);
  raisedDistances(block->u, padded, side_, phi);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeRaising(const StrokeContext& context) { return std::make_unique<Raising>(context); }

}  // namespace argil::clay
