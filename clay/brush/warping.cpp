// Clay is moved: tug, smudge, pinch, crease, twist. Method and tolerances: warping_and_tips.md.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/brush/displacement.h"
#include "clay/brush/warp_tool.h"

namespace argil::clay {
namespace {

// Voxels that a part of a stamp moves clay by at most, so that the surface stays in bricks that are looked at.
constexpr double kMostMove = 6;
// A window of the start larger than this is not copied whole; voxels are read one by one.
constexpr int kMostWindow = 40 * 40 * 40;
// A stroke begins anew on the clay as it is once clay has come this many voxels and radii far, or so many blocks of
// nodes (8 KiB each) are held, which are some times those of one stamp.
constexpr double kMostWay = 16, kMostWayRadii = 0.25;
constexpr size_t kMostBlocks = 4096, kMostStamps = 4;
// Longer than this a displacement's slope says nothing about distances.
constexpr float kMostStretch = 16;
// The second order corrects by this much at most.
constexpr float kMostBend = 0.25f;

// Clay that is sheared or squeezed into less than a voxel would be torn into teeth: how much of it a voxel holds
// follows from the mean over a box around it. By how much the squared slopes of where clay comes from exceed those of
// clay at rest: no box up to the first, and one of so many voxels each way from the second on; and voxels from the
// surface to those that have none, to those a voxel nearer in part.
constexpr float kSqueezed = 0.2f, kFolded = 1, kMostBox = 0.5f, kBoxDepth = 2.5f;
// On clay that turns less than a ball of six voxels the mean differs by less, voxels: it stays as it is.
constexpr float kSmooth = 0.04f;
constexpr size_t kBoxCorners = 8;

// A brick's voxels and one around it.
constexpr int kMovedEdge = kBrickEdge + 2, kMovedVoxels = kMovedEdge * kMovedEdge * kMovedEdge;
// From a block's middle to its outermost nodes: along an axis, and to a corner.
constexpr double kToNode = (kBrickEdge - 1) / 2.0, kToCorner = kToNode * 1.7321;
// Tricubic values come from 4×4×4 voxels.
constexpr int kCubic = 4, kCubicVoxels = kCubic * kCubic * kCubic;

std::unique_ptr<WarpTool> toolOf(Method method, float angle) {
  switch (method) {
    case Method::tug:
      return makeTug();
    case Method::smudge:
      return makeSmudge();
    case Method::pinch:
      return makePinch();
    case Method::crease:
      return makeCrease();
    default:
      return makeTwist(angle);
  }
}

class Warping : public DistanceMethod {
 public:
  explicit Warping(const StrokeContext& context)
      : tool_(toolOf(context.operation.method, context.brush->angle)),
        operation_(context.operation),
        base_(context.base),
        masked_(context.base),
        band_(context.band),
        flowStep_(context.brush->quality.flowStep) {
    masks_ = base_.has(Channel::mask);
  }

  double reach(const Stamp& stamp) const override { return stamp.largestRadius() + 2 * spacingFor(stamp) + 1; }

  // Distances near the surface by the slope of what was there, far ones as flat; from the clay as the stroke found it,
  // so nothing adds up.
  Renew leaves() const override { return Renew::impossible; }
  bool lasting() const override { return true; }
  bool masks() const override { return true; }
  double moves(std::span<const Stamp> images) const override { return mostMove(images); }

  // The farther clay has come, the more of it a brick has to look at, and the nodes fill all of the space that the tip
  // went through.
  bool full() const override {
    return field_ && (farthest_ > kMostWay + kMostWayRadii * largest_ ||
                      field_->size() >= std::max(kMostBlocks, kMostStamps * moved_));
  }
  void beginAnew(const Version& now) override {
    base_ = now;
    field_.reset();
    farthest_ = 0;
  }

  int parts(std::span<const Stamp> images) const override {
    return std::max(1, static_cast<int>(std::ceil(mostMove(images) / kMostMove)));
  }

  void follow(Sampler& before, std::span<const Stamp> images) override {
    tool_->begin(before, images);
    int spacing = 1 << 12;
    for (const Stamp& s : images) spacing = std::min(spacing, spacingFor(s));
    if (!field_) field_.emplace(spacing);
    while (field_->spacing() > spacing) field_ = field_->refined();
    const int h = field_->spacing();
    BrickSet blocks;
    for (const Stamp& s : images) {
      const double radius = s.largestRadius();
      const Vec3d low = s.a.cwiseMin(s.b) - Vec3d::Constant(radius), high = s.a.cwiseMax(s.b) + Vec3d::Constant(radius);
      const auto block = [&](double v) { return static_cast<int>(std::floor((v + 0.5) / (kBrickEdge * h))); };
      for (int x = block(low.x()); x <= block(high.x()); ++x)
        for (int y = block(low.y()); y <= block(high.y()); ++y)
          for (int z = block(low.z()); z <= block(high.z()); ++z)
            if (reaches(s, field_->middle({x, y, z}), h)) blocks.add({x, y, z});
    }
    const std::vector<Coord> sorted = blocks.sorted();
    field_->compose(sorted, mostMove(images),
                    [&](Coord block, NodePlaces& places) { trace(images, field_->middle(block), h, places); });
    moved_ = sorted.size();
    for (const Stamp& s : images) largest_ = std::max(largest_, s.largestRadius());
    for (const Coord block : sorted) farthest_ = std::max(farthest_, field_->farthest(block));
  }

  bool brick(Sampler& before, std::span<const Stamp>, Coord coord, float (&phi)[kBrickVoxels]) const override;

  bool mayChange(Sampler& before, Coord first, int edge) const override;

  bool origins(std::span<const Stamp> images, Coord coord, Vec3f (&from)[kBrickVoxels]) const override {
    const Coord first = coord * kBrickEdge;
    const Vec3d middle = first.toVec3d() + Vec3d::Constant(kToNode);
    if (std::none_of(images.begin(), images.end(), [&](const Stamp& s) { return reaches(s, middle, 1); })) return false;
    NodePlaces places;
    trace(images, middle, 1, places);
    const ChannelSlot mask = masks_ ? masked_.find(Channel::mask, coord) : ChannelSlot();
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Vec3f own(static_cast<float>(i >> 6), static_cast<float>((i >> 3) & 7), static_cast<float>(i & 7));
      const Vec3f moved = Vec3f(places.x[i], places.y[i], places.z[i]) + Vec3f::Constant(kToNode) - own;
      from[i] = first.toVec3d().cast<float>() + own + moved * (static_cast<float>(255 - mask.value(i)) / 255.0f);
    }
    return true;
  }

 private:
  // Nodes: eight to sixteen a radius, at least one voxel apart.
  static int spacingFor(const Stamp& s) {
    int spacing = 1;
    while (16 * spacing <= std::min(s.radius, s.radiusAtEnd())) spacing *= 2;
    return spacing;
  }

  static bool reaches(const Stamp& s, const Vec3d& middle, int spacing) {
    return segmentDistance(s, middle) - kToCorner * spacing < s.largestRadius();
  }

  double mostMove(std::span<const Stamp> images) const {
    double most = 0;
    for (const Stamp& s : images)
      most = std::max(most, tool_->mostMove(s, std::abs(static_cast<double>(operation_.amount)) * s.strength));
    return most;
  }

  void trace(std::span<const Stamp> images, const Vec3d& middle, int spacing, NodePlaces& places) const {
    std::vector<WarpImage> relative;
    relative.reserve(images.size());
    double least = kMostMove * 1000;
    for (size_t i = 0; i < images.size(); ++i) {
      relative.push_back(image(images[i], i, middle));
      relative.back().active = reaches(images[i], middle, spacing);
      least = std::min({least, images[i].radius, images[i].radiusAtEnd()});
    }
    const int steps = std::max(1, static_cast<int>(std::ceil(mostMove(images) / (flowStep_ * least))));
    traceBack(relative, static_cast<int>(operation_.shape), steps, static_cast<float>(spacing), places);
  }

  WarpImage image(const Stamp& s, size_t i, const Vec3d& middle) const {
    WarpImage w{};
    const Vec3f a = (s.a - middle).cast<float>(), d = (s.b - s.a).cast<float>();
    w.ax = a.x(), w.ay = a.y(), w.az = a.z();
    w.dx = d.x(), w.dy = d.y(), w.dz = d.z();
    const float length2 = (d.x() * d.x() + d.y() * d.y()) + d.z() * d.z();
    w.inverseLength2 = length2 > 1e-12f ? 1 / length2 : 0;
    w.radius = static_cast<float>(s.radius);
    w.growth = static_cast<float>(s.radiusAtEnd()) - w.radius;
    const float length = std::sqrt(length2);
    tool_->describe(s, i, operation_.amount * s.strength, length > 0 ? length : static_cast<float>(kDabWay) * w.radius,
                    w);
    return w;
  }

  void holdBack(Coord brick, Displacement (&moved)[kMovedVoxels]) const;

  std::unique_ptr<WarpTool> tool_;
  Operation operation_;
  Version base_;
  Version masked_;  // the clay that the stroke began with, whose masks count
  float band_;
  double flowStep_;
  bool masks_;
  std::optional<DisplacementField> field_;
  float farthest_ = 0;  // of its displacements, about
  double largest_ = 0;  // radius so far
  size_t moved_ = 0;    // blocks of the last application
};

Coord floorOf(const Vec3f& v) {
  return {static_cast<int32_t>(std::floor(v.x())), static_cast<int32_t>(std::floor(v.y())),
          static_cast<int32_t>(std::floor(v.z()))};
}

// Whether a brick is a tile and everything in a box of voxels is the same tile.
bool tilesOnly(Sampler& field, Coord low, Coord high, Slot brick) {
  if (!brick.isTile()) return false;
  for (int x = low.x >> kBrickBits; x <= high.x >> kBrickBits; ++x)
    for (int y = low.y >> kBrickBits; y <= high.y >> kBrickBits; ++y)
      for (int z = low.z >> kBrickBits; z <= high.z >> kBrickBits; ++z)
        if (field.slot({x, y, z}) != brick) return false;
  return true;
}

// One to eight values, without a call: two overlapping lengths that the compiler knows.
void copyShortRow(const float* from, int count, float* to) {
  if (count >= 4) {
    std::memcpy(to, from, 4 * sizeof(float));
    std::memcpy(to + count - 4, from + count - 4, 4 * sizeof(float));
    return;
  }
  to[0] = from[0];
  to[count - 1] = from[count - 1];
  if (count == 3) to[1] = from[1];
}

// Copies a box of voxels; false, and nothing is written, where it holds tiles of one kind alone (`flat`).
bool copyBox(Sampler& field, Coord first, Coord size, std::vector<float>& out, Slot& flat) {
  const Coord low = first >> kBrickBits, high = (first + size - Coord{1, 1, 1}) >> kBrickBits;
  flat = field.slot(low);
  bool same = flat.isTile();
  for (int bx = low.x; same && bx <= high.x; ++bx)
    for (int by = low.y; same && by <= high.y; ++by)
      for (int bz = low.z; same && bz <= high.z; ++bz) same = field.slot({bx, by, bz}) == flat;
  if (same) return false;
  out.resize(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * static_cast<size_t>(size.z));
  for (int bx = low.x; bx <= high.x; ++bx)
    for (int by = low.y; by <= high.y; ++by)
      for (int bz = low.z; bz <= high.z; ++bz) {
        const Slot slot = field.slot({bx, by, bz});
        const Coord at = Coord{bx, by, bz} * kBrickEdge - first;
        const int x0 = std::max(at.x, 0), x1 = std::min(at.x + kBrickEdge, size.x), y0 = std::max(at.y, 0),
                  y1 = std::min(at.y + kBrickEdge, size.y);
        const int z0 = std::max(at.z, 0), z1 = std::min(at.z + kBrickEdge, size.z);
        BrickValues room;
        const BrickValues& values = slot.values(room, field.band());
        for (int x = x0; x < x1; ++x)
          for (int y = y0; y < y1; ++y) {
            float* row = out.data() + (static_cast<ptrdiff_t>(x) * size.y + y) * size.z + z0;
            copyShortRow(values + Brick::offset(x - at.x, y - at.y, z0 - at.z), z1 - z0, row);
          }
      }
  return true;
}

// Of a voxel of a brick (−1 and kBrickEdge: those around it) among its displacements.
int movedIndex(int x, int y, int z) {
  return ((x + 1) * kMovedEdge + y + 1) * kMovedEdge + z + 1;
}

// Boxes of a brick's voxels, and how displacements change along each axis.
class Boxes {
 public:
  // `least`, `most`: bounds of the displacements.
  Boxes(const Displacement (&moved)[kMovedVoxels], const float (&least)[3], const float (&most)[3]) : moved_(moved) {
    // Clay that moves alike is not sheared.
    if (std::max({most[0] - least[0], most[1] - least[1], most[2] - least[2]}) < kAlike) return;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Slopes s = slopes(i);
      const float x = squared(s.x + Vec3f::UnitX()), y = squared(s.y + Vec3f::UnitY()),
                  z = squared(s.z + Vec3f::UnitZ());
      const float box = kMostBox * std::clamp((((x + y) + z) - 3 - kSqueezed) / (kFolded - kSqueezed), 0.0f, 1.0f);
      half_[static_cast<size_t>(i)] = box;
      const Vec3f far = s.x.cwiseAbs() + s.y.cwiseAbs() + s.z.cwiseAbs();
      reach_ = std::max(reach_, box * (1 + far.maxCoeff()));
    }
  }

  // Tells how far beside a voxel's own place clay is looked at, voxels.
  [[nodiscard]] float reach() const { return reach_; }
  [[nodiscard]] bool has(int voxel) const { return reach_ > 0 && half_[static_cast<size_t>(voxel)] > 0; }
  // Displacement of a box's corner, 0 to 7, from the voxel.
  [[nodiscard]] Vec3f corner(int voxel, int c) const {
    const float h = half_[static_cast<size_t>(voxel)];
    const Vec3f to((c & 4) != 0 ? h : -h, (c & 2) != 0 ? h : -h, (c & 1) != 0 ? h : -h);
    const Displacement& d = moved_[indexOf(voxel)];
    const Slopes s = slopes(voxel);
    return to + (Vec3f(d.x, d.y, d.z) + ((to.x() * s.x + to.y() * s.y) + to.z() * s.z));
  }

 private:
  static constexpr float kAlike = 0.06f;
  struct Slopes {
    Vec3f x, y, z;
  };
  static int indexOf(int voxel) { return movedIndex(voxel >> 6, (voxel >> 3) & 7, voxel & 7); }
  static float squared(const Vec3f& v) { return (v.x() * v.x() + v.y() * v.y()) + v.z() * v.z(); }
  [[nodiscard]] Slopes slopes(int voxel) const {
    const int at = indexOf(voxel);
    const auto along = [&](int step) {
      const Displacement &a = moved_[at - step], &b = moved_[at + step];
      return Vec3f(0.5f * (b.x - a.x), 0.5f * (b.y - a.y), 0.5f * (b.z - a.z));
    };
    return {along(kMovedEdge * kMovedEdge), along(kMovedEdge), along(1)};
  }

  const Displacement (&moved_)[kMovedVoxels];
  float reach_ = 0;
  std::array<float, kBrickVoxels> half_;
};

// The clay that the voxels of a brick came from, as the stroke found it: the box around all of their places, copied;
// where it is too large for that, the 4×4×4 voxels around each place, one lot after the other.
class StartWindow {
 public:
  // `low` and `high`: bounds of the displacements in the brick. One at a time in each thread.
  StartWindow(Sampler& start, Coord brick, const Vec3f& low, const Vec3f& high)
      : start_(start),
        values_(scratch()),
        brick_(brick * kBrickEdge),
        from_(floorOf(low) - Coord{2, 2, 2}),  // a voxel below the cell for the cubic, and one for rounding
        size_(floorOf(high) - from_ + Coord{kBrickEdge + 4, kBrickEdge + 4, kBrickEdge + 4}),
        whole_(static_cast<double>(size_.x) * size_.y * size_.z <= kMostWindow) {
    if (whole_)
      mixed_ = copyBox(start_, brick_ + from_, size_, values_, tile_);
    else
      values_.clear(), values_.reserve(size_t{kBrickVoxels} * kCubicVoxels * (1 + kBoxCorners));
  }

  [[nodiscard]] bool whole() const { return whole_; }
  [[nodiscard]] VoxelWindow window() const { return {values_.data(), from_.x, from_.y, from_.z, size_.y, size_.z}; }
  // Nothing but tiles of one kind, which this is.
  [[nodiscard]] bool flat() const { return !mixed_; }
  [[nodiscard]] Slot tile() const { return tile_; }

  // The voxel `at`, counted from the brick's first.
  [[nodiscard]] float voxel(Coord at) {
    if (!whole_) return start_.voxel(brick_ + at);
    return values_[static_cast<size_t>(((at.x - from_.x) * size_.y + at.y - from_.y) * size_.z + at.z - from_.z)];
  }
  // The lowest of the 4×4×4 voxels around a cell. Stays where it is.
  [[nodiscard]] const float* cubic(Coord cell) {
    const Coord low = cell - Coord{1, 1, 1};
    if (whole_) return values_.data() + ((low.x - from_.x) * size_.y + low.y - from_.y) * size_.z + low.z - from_.z;
    const size_t begin = values_.size();
    for (int k = 0; k < kCubicVoxels; ++k)
      values_.push_back(start_.voxel(brick_ + low + Coord{k >> 4, (k >> 2) & 3, k & 3}));
    return values_.data() + begin;
  }
  [[nodiscard]] ptrdiff_t strideX() const {
    return whole_ ? static_cast<ptrdiff_t>(size_.y) * size_.z : kCubic * kCubic;
  }
  [[nodiscard]] ptrdiff_t strideY() const { return whole_ ? size_.z : kCubic; }

 private:
  static std::vector<float>& scratch() {  // Bricks follow each other, and it is large.
    thread_local std::vector<float> values;
    return values;
  }

  Sampler& start_;
  std::vector<float>& values_;
  Coord brick_, from_, size_;  // from_: counted from the brick's first voxel
  bool whole_, mixed_ = true;
  Slot tile_;
};

// Trilinear in the cell of a sample; nothing where a corner that counts is not in the band: what is known there is its
// sign alone.
std::optional<float> linearWithin(const FieldSample& sample, const StartWindow& window, float band) {
  const ptrdiff_t sx = window.strideX(), sy = window.strideY();
  const float tx = sample.tx, ty = sample.ty, tz = sample.tz;
  float farthest = 0;
  const auto corner = [&](int x, int y, int z) {
    const float f = sample.corner[(x + 1) * sx + (y + 1) * sy + z + 1];
    // On a voxel, or between two, the cell beyond is another one in a mirror: what weighs nothing says nothing.
    if ((x == 0 || tx > 0) && (y == 0 || ty > 0) && (z == 0 || tz > 0)) farthest = std::max(farthest, std::abs(f));
    return f;
  };
  const auto line = [&](int x, int y) { return corner(x, y, 0) * (1 - tz) + corner(x, y, 1) * tz; };
  const auto plane = [&](int x) { return line(x, 0) * (1 - ty) + line(x, 1) * ty; };
  const float linear = plane(0) * (1 - tx) + plane(1) * tx;
  if (farthest >= band) return std::nullopt;
  return linear;
}

// Puts the mean over a voxel's box in place of its value where clay was squeezed, but for what both differ by on smooth
// clay.
void readBoxes(const Boxes& boxes, StartWindow& window, std::span<const int> voxels,
               FieldValue (&values)[kBrickVoxels]) {
  FieldSample corners[kBrickVoxels * kBoxCorners];
  size_t of[kBrickVoxels], count = 0;
  for (size_t k = 0; k < voxels.size(); ++k) {
    const int i = voxels[k];
    if (!boxes.has(i) || std::abs(values[k].value) > kBoxDepth) continue;
    for (size_t c = 0; c < kBoxCorners; ++c) {
      const Vec3f d = boxes.corner(i, static_cast<int>(c));
      const AxisPlace x = placeOf(i >> 6, d.x()), y = placeOf((i >> 3) & 7, d.y()), z = placeOf(i & 7, d.z());
      corners[kBoxCorners * count + c] = {window.cubic({x.base, y.base, z.base}), x.t, y.t, z.t};
    }
    of[count++] = k;
  }
  float read[kBrickVoxels * kBoxCorners];
  sampleValues(std::span(corners, kBoxCorners * count), window.strideX(), window.strideY(), read);
  for (size_t j = 0; j < count; ++j) {
    const float* r = read + kBoxCorners * j;
    // Opposite corners first, which mirrors turn into each other.
    const float mean = (((r[0] + r[7]) + (r[3] + r[4])) + ((r[1] + r[6]) + (r[2] + r[5]))) / kBoxCorners;
    float& value = values[of[j]].value;
    const float off = mean - value, share = std::min(1.0f, kBoxDepth - std::abs(value));
    value += share * (std::max(off - kSmooth, 0.0f) + std::min(off + kSmooth, 0.0f));
  }
}

// What is covered stays, and does not pull.
void Warping::holdBack(Coord brick, Displacement (&moved)[kMovedVoxels]) const {
  int i = 0;
  for (int x = -1; x <= kBrickEdge; ++x)
    for (int y = -1; y <= kBrickEdge; ++y)
      for (int z = -1; z <= kBrickEdge; ++z, ++i) {
        const Coord voxel = brick * kBrickEdge + Coord{x, y, z};
        const uint8_t cover = masked_.find(Channel::mask, voxel >> kBrickBits)
                                  .value(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7));
        const float free = static_cast<float>(255 - cover) / 255.0f;
        moved[i] = {moved[i].x * free, moved[i].y * free, moved[i].z * free, 0};
      }
}

// Nothing where all is air, or all is clay, as all is that came.
bool Warping::mayChange(Sampler& before, Coord cube, int edge) const {
  const Coord first = cube * kBrickEdge, end = Coord{1, 1, 1} * (kBrickEdge * edge);
  const Slot now = before.slot(cube);
  if (!tilesOnly(before, first, first + end - Coord{1, 1, 1}, now)) return true;
  Vec3f low, high;
  if (!field_->bounds(cube, edge, low, high)) return false;
  Sampler start(base_);
  return !tilesOnly(start, first + floorOf(low), first + floorOf(high) + end + Coord{1, 1, 1}, now);
}

bool Warping::brick(Sampler& before, std::span<const Stamp>, Coord coord, float (&phi)[kBrickVoxels]) const {
  // 1. Where its voxels came from. Nothing to do where that is all air, or all clay, as the brick itself.
  Vec3f low, high;
  if (!field_->bounds(coord, 1, low, high)) return false;
  const Slot now = before.slot(coord);
  Sampler start(base_);
  const Coord first = coord * kBrickEdge, around{kBrickEdge + 1, kBrickEdge + 1, kBrickEdge + 1};
  if (tilesOnly(start, first + floorOf(low), first + floorOf(high) + around, now)) return false;
  Displacement moved[kMovedVoxels];
  if (!field_->atVoxels(coord, moved)) return false;
  if (masks_) holdBack(coord, moved);
  MovedVoxels split;
  splitDisplacements(moved, split);
  float least[3], most[3];
  movedBounds(split, least, most);
  low = Vec3f(least[0], least[1], least[2]), high = Vec3f(most[0], most[1], most[2]);
  if (low == Vec3f::Zero() && high == Vec3f::Zero()) return false;
  const Boxes boxes(moved, least, most);
  low -= Vec3f::Constant(boxes.reach()), high += Vec3f::Constant(boxes.reach());

  // 2. What lay there. Most voxels of a brick come from beyond the band, which the nearest voxel tells; the others are
  // samples.
  StartWindow window(start, coord, low, high);
  BrickValues room;
  const BrickValues& own = now.values(room, band_);
  uint64_t doubtful[kBrickEdge];
  if (window.whole() && !window.flat()) {
    nearestValues(split, window.window(), own, band_, phi, doubtful);
  } else {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Displacement& d = moved[movedIndex(i >> 6, (i >> 3) & 7, i & 7)];
      const bool stays = d.x == 0 && d.y == 0 && d.z == 0;
      phi[i] = stays || !window.flat() ? own[i] : window.tile().phi(0, band_);
      if ((i & 63) == 0) doubtful[i >> 6] = 0;
      doubtful[i >> 6] |= uint64_t{!stays && !window.flat()} << (i & 63);
    }
  }
  FieldSample samples[kBrickVoxels];
  int voxels[kBrickVoxels];
  size_t count = 0;
  for (int x = 0; x < kBrickEdge; ++x)
    for (uint64_t left = doubtful[x]; left != 0; left &= left - 1) {
      const int i = x << 6 | std::countr_zero(left), y = (i >> 3) & 7, z = i & 7;
      const Displacement& d = moved[movedIndex(x, y, z)];
      const AxisPlace px = placeOf(x, d.x), py = placeOf(y, d.y), pz = placeOf(z, d.z);
      const float near = window.voxel({px.base + (px.t >= 0.5f), py.base + (py.t >= 0.5f), pz.base + (pz.t >= 0.5f)});
      phi[i] = near;
      // No voxel of the cell is in the band unless the nearest is within it. Halfway there are two: which, a mirror
      // would turn round.
      const bool halfway = px.t == 0.5f || py.t == 0.5f || pz.t == 0.5f;
      if (std::abs(near) >= band_ && !halfway) continue;
      samples[count] = {window.cubic({px.base, py.base, pz.base}), px.t, py.t, pz.t};
      voxels[count++] = i;
    }

  // 3. Tricubic values; trilinear ones where the cubic reaches beyond the band.
  FieldValue values[kBrickVoxels];
  sampleField(std::span(samples, count), window.strideX(), window.strideY(), values);
  if (boxes.reach() > 0) readBoxes(boxes, window, std::span(voxels, count), values);
  // A sample this near to the surface has a voxel of the band beside it whichever way it was rounded.
  const float near = band_ - 0.9f;
  CameFrom came;
  uint64_t mask[kBrickEdge] = {};
  for (size_t k = 0; k < count; ++k) {
    const FieldValue& v = values[k];
    const int i = voxels[k];
    float value = v.value;
    if (std::abs(value) > near) {
      const std::optional<float> linear = linearWithin(samples[k], window, band_);
      if (!linear) {
        phi[i] = value < 0 ? -band_ : band_;
        continue;
      }
      value = *linear;
    }
    came.value[i] = value;
    came.x[i] = v.x;
    came.y[i] = v.y;
    came.z[i] = v.z;
    mask[i >> 6] |= uint64_t{1} << (i & 63);
  }

  // 4. From values that were moved to distances of what was moved.
  warpedDistances(came, split, mask, kMostStretch, kMostBend, phi);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeWarping(const StrokeContext& context) {
  return std::make_unique<Warping>(context);
}

}  // namespace argil::clay
