// Up to a limit, or as an image says, along the normals of the surface as it was when the stroke began: what is left is
// its distance then, less a height that belongs to each of its points.

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <vector>

#include "clay/base/parallel.h"
#include "clay/brush/brush_method.h"
#include "clay/field/wide_distance.h"
#include "clay/import/height_image.h"
#include "clay/store/near_surface.h"

namespace argil::clay {
namespace {

// Beyond the band around what a stamp may raise: for the slopes that are taken across voxels.
constexpr float kBeyond = 2;
// Reach grows by this, so that bricks are not solved again at each stamp.
constexpr float kReachStep = 2;
// A limit up to this many voxels is looked at from the first application on, however little has been laid.
constexpr float kMostAtOnce = 16;
// Bricks that are held from which on those go that no stamp asks for; also so many of those of one stamp.
constexpr size_t kMostBricks = 2048, kMostStamps = 3;
// Distances are solved this many voxels farther than an application needs them.
constexpr float kAhead = 4;
// Bricks that are worth a second thread.
constexpr size_t kParallelFrom = 128;
// An image fills the cube around the tip, whose corners are √3 radii away.
constexpr double kToCorner = 1.7321;
// Width over which an image fades towards the cube's faces: at least so many voxels, as a step within one voxel could
// fall to either side of it; and, so that finer voxels show the same wall, this share of the height, but no more than
// that share of the radius.
constexpr float kRimVoxels = 2, kRimOfHeight = 0.8f, kRimOfRadius = 0.1f;

// Rounded so that a place minus it is exact.
Vec3d quantised(const Vec3f& v) {
  return (v.cast<double>() * 65536.0).array().round().matrix() / 65536.0;
}

// Applications by where they may reach on the surface, so that a brick looks at those around it alone.
class Applications {
 public:
  /// Whether they are asked for with their axes.
  explicit Applications(bool turned) : turned_(turned) {}

  [[nodiscard]] size_t count() const { return ends_.size(); }

  /// Replaces `out` by the images of an application.
  void images(size_t application, std::vector<Stamp>& out) const {
    out.clear();
    for (size_t i = application > 0 ? ends_[application - 1] : 0; i < ends_[application]; ++i) {
      const Image& each = images_[i];
      out.push_back(
          {each.a, each.b, static_cast<double>(each.radius), each.strength, static_cast<double>(each.endRadius)});
      if (turned_) out.back().axes = axes_[i];
    }
  }

  /// `around`: radii of a tip that count as its reach.
  void add(std::span<const Stamp> stamps, double around) {
    const auto number = static_cast<uint32_t>(ends_.size());
    if (cell_ == 0)
      for (cell_ = 32; cell_ < 2 * around * stamps.front().largestRadius();) cell_ *= 2;
    BrickSet cells;
    for (const Stamp& s : stamps) {
      images_.push_back({s.a, s.b, static_cast<float>(s.radius), static_cast<float>(s.radiusAtEnd()), s.strength});
      if (turned_) axes_.push_back(s.axes);
      const Vec3d margin = Vec3d::Constant(s.largestRadius() * around + 1);
      forCells(s.a.cwiseMin(s.b) - margin, s.a.cwiseMax(s.b) + margin, [&](Coord cell) { cells.add(cell); });
    }
    ends_.push_back(images_.size());
    for (const Coord cell : cells.sorted()) cells_[cell].push_back(number);
  }

  /// Numbers of those that may reach into a box, in order.
  void near(const Vec3d& low, const Vec3d& high, std::vector<uint32_t>& out) const {
    out.clear();
    int lists = 0;
    forCells(low, high, [&](Coord cell) {
      const auto it = cells_.find(cell);
      if (it == cells_.end()) return;
      out.insert(out.end(), it->second.begin(), it->second.end());
      ++lists;
    });
    if (lists < 2) return;
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
  }

  void clear() {
    images_.clear();
    axes_.clear();
    ends_.clear();
    cells_.clear();
  }

 private:
  template <class Visit>
  void forCells(const Vec3d& low, const Vec3d& high, const Visit& visit) const {
    const auto at = [&](double v) { return static_cast<int32_t>(std::floor(v / cell_)); };
    for (int32_t x = at(low.x()); x <= at(high.x()); ++x)
      for (int32_t y = at(low.y()); y <= at(high.y()); ++y)
        for (int32_t z = at(low.z()); z <= at(high.z()); ++z) visit(Coord{x, y, z});
  }

  // A stamp in half the memory: strokes with a limit keep all of theirs.
  struct Image {
    Vec3d a, b;
    float radius, endRadius, strength;
  };

  bool turned_;
  std::vector<Image> images_;
  std::vector<Eigen::Matrix3f> axes_;
  std::vector<size_t> ends_;  // of each application's images
  double cell_ = 0;           // voxels, a power of two
  std::unordered_map<Coord, std::vector<uint32_t>, CoordHash> cells_;
};

class Raising : public DistanceMethod {
 public:
  explicit Raising(const StrokeContext& context)
      : brush_(context.brush),
        operation_(context.operation),
        band_(context.band),
        threads_(context.threads),
        side_(context.operation.amount < 0 ? -1.0f : 1.0f),
        rise_(std::abs(context.operation.amount) * context.brush->height),
        step_(brush_->image || brush_->bead ? rise_ : raisedByStamp(*brush_, operation_)),
        start_(context.start),
        base_(context.start, context.operation.amount < 0 ? -1 : 1, context.threads),
        applications_(context.brush->image != nullptr) {
    // Where a tool was lifted on the way the limit counts from where the stroke began.
    if (context.start != context.base) laid_ = context.base;
    everywhere_ = rise_ <= kMostAtOnce;
    if (everywhere_) highest_ = rise_;
  }

  double travel(double) const override { return everywhere_ ? rise_ : step_; }
  double reach(const Stamp& stamp) const override { return stamp.largestRadius() * radii() + band_ + highest_ + step_; }
  Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) override;
  bool brick(Sampler& before, std::span<const Stamp> images, Coord coord, float (&phi)[kBrickVoxels]) const override;

  bool lasting() const override { return true; }

 private:
  struct Layer {
    float height[kBrickVoxels] = {};
    uint64_t known[kBrickEdge] = {};  // voxels that have all applications so far
    size_t changedBy = 0;             // application, counted from 1
    float most = 0;                   // of the heights
  };

  // Radii of the tip that count as its reach.
  [[nodiscard]] double radii() const { return brush_->image ? kToCorner : 1.0; }
  // Bricks that are held, at most about as many.
  [[nodiscard]] size_t mostBricks() const { return std::max(kMostBricks, kMostStamps * asked_); }
  [[nodiscard]] Vec3d lowered(const Vec3d& place, double radius) const;
  [[nodiscard]] Vec3d loweredFromAfar(const Vec3d& place, double radius) const;
  void apply(Coord coord, const WideDistance::Block& block, std::span<const Stamp> current, Layer& layer) const;
  [[nodiscard]] bool raise(std::span<const Stamp> images, Coord coord, const float* foot, const uint64_t* mask,
                           Layer& layer) const;
  void emboss(const Stamp& stamp, Coord coord, const float* foot, float (&weight)[kBrickVoxels]) const;
  [[nodiscard]] const Layer* layer(Coord coord) const {
    const auto it = layers_.find(coord);
    return it == layers_.end() ? nullptr : it->second.get();
  }

  std::shared_ptr<const Brush> brush_;
  Operation operation_;
  float band_;
  int threads_;
  float side_, rise_;
  float step_;       // how far one application raises at most
  bool everywhere_;  // bricks get all applications from the first on, as high as the limit: none is made up for
  Version start_;    // the clay that heights stand on
  Version laid_;     // what the stroke left before the tool was lifted; none: nothing
  WideDistance base_;
  std::unordered_map<Coord, std::unique_ptr<Layer>, CoordHash> layers_;
  Applications applications_;
  float highest_ = 0;  // of all heights so far
  size_t asked_ = 0;   // bricks of the last application
};

bool anyKnown(const WideDistance::Block& block) {
  uint64_t any = 0;
  for (const uint64_t row : block.known) any |= row;
  return any != 0;
}

// What is known around a place of a field and of the heights above it, if all is.
struct Around {
  float u, height;
  Vec3f foot;
};
template <class HeightAt>
std::optional<Around> around(const WideDistance& field, const Vec3d& place, const HeightAt& heightAt) {
  const Vec3d floor = place.array().floor();
  const Coord first{static_cast<int32_t>(floor.x()), static_cast<int32_t>(floor.y()), static_cast<int32_t>(floor.z())};
  const Vec3f t = (place - floor).cast<float>();
  // u, height, foot of the corners; halves are summed pair by pair, so that mirroring changes no bit.
  float value[8][5];
  WideDistance::Feet room;
  const WideDistance::Feet* feet = nullptr;
  Coord feetOf;
  for (int i = 0; i < 8; ++i) {
    const Coord v = first + Coord{i >> 2, (i >> 1) & 1, i & 1};
    const Coord coord = v >> kBrickBits;
    const int at = Brick::offset(v.x & 7, v.y & 7, v.z & 7);
    const WideDistance::Block* block = field.find(coord);
    if (!block || !((block->known[at >> 6] >> (at & 63)) & 1) || !heightAt(coord, at, value[i][1])) return std::nullopt;
    if (!feet || feetOf != coord) feet = &field.feet(feetOf = coord, room);
    value[i][0] = block->u[at];
    for (int axis = 0; axis < 3; ++axis) value[i][2 + axis] = feet->foot[axis * kBrickVoxels + at];
  }
  float mean[5];
  for (int k = 0; k < 5; ++k) {
    float x[2];
    for (int i = 0; i < 2; ++i) {
      const float low = value[4 * i][k] * (1 - t.z()) + value[4 * i + 1][k] * t.z(),
                  high = value[4 * i + 2][k] * (1 - t.z()) + value[4 * i + 3][k] * t.z();
      x[i] = low * (1 - t.y()) + high * t.y();
    }
    mean[k] = x[0] * (1 - t.x()) + x[1] * t.x();
  }
  return Around{mean[0], mean[1], Vec3f(mean[2], mean[3], mean[4])};
}

// A tool that rides on what the stroke has laid belongs to the place below it.
Vec3d Raising::lowered(const Vec3d& place, double radius) const {
  const auto there = around(base_, place, [&](Coord coord, int at, float& height) {
    const Layer* heights = layer(coord);
    if (heights) height = heights->height[at];
    return heights != nullptr;
  });
  if (there && !(there->u > 0)) return place;
  if (there) return place + quantised(there->foot * std::min(there->height / there->u, 1.0f));
  return loweredFromAfar(place, radius);
}

// Lowers a place that lies farther off than distances are known, by the nearest part of the surface.
Vec3d Raising::loweredFromAfar(const Vec3d& place, double radius) const {
  Sampler start(start_);
  const Vec3d nearest = place.array().round();
  const Coord voxel{static_cast<int32_t>(nearest.x()), static_cast<int32_t>(nearest.y()),
                    static_cast<int32_t>(nearest.z())};
  if (!(highest_ > 0) || !(side_ * start.voxel(voxel) > 0)) return place;
  // Sums of whole numbers, so that their order does not matter.
  const auto whole = [](double v) { return static_cast<int64_t>(std::nearbyint(v * 65536)); };
  int64_t out[3] = {}, heights = 0, weights = 0;
  for (const NearVoxel& each : surfaceNear(start, place, radius + static_cast<double>(highest_))) {
    const Layer* mine = layer(each.brick);
    const auto weight = static_cast<double>(each.weight);
    for (int k = 0; k < 3; ++k) out[k] += whole(weight * static_cast<double>(each.normal[k]));
    if (mine) heights += whole(weight * static_cast<double>(mine->height[each.voxel]));
    weights += whole(weight);
  }
  if (heights == 0) return place;
  const auto x = static_cast<double>(out[0]), y = static_cast<double>(out[1]), z = static_cast<double>(out[2]);
  const double length = std::sqrt((x * x + y * y) + z * z);
  if (!(length > 0)) return place;
  const double by = -static_cast<double>(side_) * static_cast<double>(heights) / static_cast<double>(weights) / length;
  return place + quantised(Vec3f(static_cast<float>(by * x), static_cast<float>(by * y), static_cast<float>(by * z)));
}

Steps Raising::begin(Sampler&, std::span<const Stamp> images, std::span<const Coord> bricks) {
  asked_ = bricks.size();
  // Farther than it is needed, where that is near: what is solved again and again costs more.
  const float needed = std::min(highest_ + step_, rise_), ahead = std::min({needed + kAhead, rise_, kMostAtOnce});
  const float reach = std::ceil((band_ + std::max(needed, ahead) + kBeyond) / kReachStep) * kReachStep;
  for (Steps each = base_.extend(bricks, reach); each.next();) co_yield Steps::kPause;
  std::vector<Stamp> stamps(images.begin(), images.end());
  for (size_t i = 0; i < stamps.size(); ++i) {
    stamps[i].a = lowered(images[i].a, images[i].radius);
    stamps[i].b = images[i].b == images[i].a ? stamps[i].a : lowered(images[i].b, images[i].radiusAtEnd());
    // As applications are kept.
    stamps[i].endRadius = static_cast<double>(static_cast<float>(stamps[i].radiusAtEnd()));
    stamps[i].radius = static_cast<double>(static_cast<float>(stamps[i].radius));
  }
  applications_.add(stamps, radii());
  base_.keepFeetOf(bricks);
  // Whatever it looks at, each brick has a layer of its own.
  std::vector<std::pair<const WideDistance::Block*, Layer*>> work(bricks.size());
  for (size_t i = 0; i < bricks.size(); ++i) {
    work[i].first = base_.find(bricks[i]);
    if (!work[i].first || !anyKnown(*work[i].first)) continue;
    std::unique_ptr<Layer>& layer = layers_[bricks[i]];
    if (!layer) layer = std::make_unique<Layer>();
    work[i].second = layer.get();
  }
  for (size_t from = 0; from < bricks.size(); from += kBricksAStep) {
    co_yield Steps::kPause;
    const size_t some = std::min(kBricksAStep, bricks.size() - from);
    parallelBlocks(
        some, some >= kParallelFrom ? threads_ : 1,
        [&](size_t begin, size_t end) {
          for (size_t i = from + begin; i < from + end; ++i)
            if (work[i].second) apply(bricks[i], *work[i].first, stamps, *work[i].second);
        },
        16);
  }
  for (const auto& each : work)
    if (each.second) highest_ = std::max(highest_, each.second->most);
  // Where a brick is asked for together with all below it the stroke need not keep more than the heights that it laid.
  if (!everywhere_ || base_.size() < mostBricks()) co_return;
  for (const Coord coord : base_.keepOnly(bricks)) {
    const auto it = layers_.find(coord);
    if (it != layers_.end() && it->second->most == 0) layers_.erase(it);
  }
}

// Raises a brick by the application that was added last, and by those before it where they have not been heeded yet.
void Raising::apply(Coord coord, const WideDistance::Block& block, std::span<const Stamp> current, Layer& layer) const {
  WideDistance::Feet room;
  const WideDistance::Feet& feet = base_.feet(coord, room);
  const Vec3f low(feet.box[0][0], feet.box[0][1], feet.box[0][2]), high(feet.box[1][0], feet.box[1][1], feet.box[1][2]);
  if (!(low.x() <= high.x())) return;
  const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
  const Vec3d from = middle + low.cast<double>(), to = middle + high.cast<double>(), centre = (from + to) / 2;
  const double half = (to - from).norm() / 2 + 0.01;
  const auto near = [&](std::span<const Stamp> images) {
    return std::any_of(images.begin(), images.end(),
                       [&](const Stamp& s) { return segmentDistance(s, centre) < half + s.largestRadius() * radii(); });
  };
  // Voxels that have come within reach only now get what was applied before.
  uint64_t fresh[kBrickEdge], any = 0;
  for (int x = 0; x < kBrickEdge; ++x) {
    any |= fresh[x] = block.known[x] & ~layer.known[x];
    layer.known[x] = block.known[x];
  }
  bool changed = false;
  if (any) {
    std::vector<uint32_t> before;
    std::vector<Stamp> images;
    applications_.near(from, to, before);
    for (const uint32_t i : before) {
      if (i + 1 >= applications_.count()) break;
      applications_.images(i, images);
      if (near(images)) changed |= raise(images, coord, feet.foot, fresh, layer);
    }
  }
  if (near(current) && raise(current, coord, feet.foot, block.known, layer)) {
    layer.changedBy = applications_.count();
    changed = true;
  }
  if (changed) layer.most = *std::max_element(std::begin(layer.height), std::end(layer.height));
}

bool Raising::raise(std::span<const Stamp> images, Coord coord, const float* foot, const uint64_t* mask,
                    Layer& layer) const {
  float weight[kBrickVoxels] = {};
  if (!brush_->image) {
    for (const Stamp& each : images)
      footWeights(sweptBall(each, coord), static_cast<int>(operation_.shape), each.strength, foot, weight);
    if (!brush_->bead) return raiseHeights(weight, step_, rise_, mask, layer.height);
  } else {
    for (const Stamp& each : images) emboss(each, coord, foot, weight);
  }
  bool any = false;
  for (int i = 0; i < kBrickVoxels; ++i) {
    const float height = weight[i] * rise_;
    if (!((mask[i >> 6] >> (i & 63)) & 1) || !(height > layer.height[i])) continue;
    layer.height[i] = height;
    any = true;
  }
  return any;
}

// The largest of what `weight` holds and the image over the stamp's x and y at its end, fading towards the rim by the
// falloff.
void Raising::emboss(const Stamp& stamp, Coord coord, const float* foot, float (&weight)[kBrickVoxels]) const {
  const HeightImage& image = *brush_->image;
  const auto radius = static_cast<float>(stamp.radiusAtEnd());
  // An image's pixels to a voxel.
  const int level = image.levelFor(0.5f * static_cast<float>(std::max(image.width(), image.height())) / radius);
  const float toRim = radius / std::max(kRimVoxels, std::min(kRimOfHeight * rise_, kRimOfRadius * radius));
  const BrickFrame frame(stamp.b, coord);
  const Vec3f ex = stamp.axes.col(0), ey = stamp.axes.col(1), ez = stamp.axes.col(2);
  for (int i = 0; i < kBrickVoxels; ++i) {
    const Vec3f at =
        frame.at(i >> 6, (i >> 3) & 7, i & 7) + Vec3f(foot[i], foot[kBrickVoxels + i], foot[2 * kBrickVoxels + i]);
    const auto along = [&](const Vec3f& axis) {
      return ((at.x() * axis.x() + at.y() * axis.y()) + at.z() * axis.z()) / radius;
    };
    const float x = along(ex), y = along(ey), z = along(ez);
    if (!(std::abs(z) < 1) || !(std::abs(x) < 1) || !(std::abs(y) < 1)) continue;
    // The constant falloff leaves the whole square, as an image is one, but for its rim.
    const float rim = std::min((1 - std::max(std::max(std::abs(x), std::abs(y)), std::abs(z))) * toRim, 1.0f);
    const float shade =
        operation_.shape == Falloff::constant ? rim : falloff(operation_.shape, std::sqrt(x * x + y * y)) * rim;
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
  bool changed = mine->changedBy == applications_.count();
  for (int face = 0; face < 6; ++face) {
    beside[face] = layer(coord + kFaces[face]);
    changed |= beside[face] && beside[face]->changedBy == applications_.count();
  }
  if (!changed) return false;
  float padded[kPaddedSize] = {};
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      std::copy_n(mine->height + Brick::offset(x, y, 0), 8, padded + paddedOffset(x + 1, y + 1, 1));
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
  if (laid_) {
    BrickValues room;
    const BrickValues& was = laid_.find(coord).values(room, band_);
    for (int i = 0; i < kBrickVoxels; ++i) phi[i] = side_ > 0 ? std::min(phi[i], was[i]) : std::max(phi[i], was[i]);
  }
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeRaising(const StrokeContext& context) {
  return std::make_unique<Raising>(context);
}

}  // namespace argil::clay
