// Clay is moved: tug, smudge, pinch, crease, twist. Method and tolerances: NOTES.md, "Warping and tips".

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/brush/displacement.h"

namespace argil::clay {
namespace {

// A dab without a way counts as this much of one, in radii: what stamps of a stroke are apart.
constexpr double kDabWay = 0.1;
// Of what a step moves clay at most: in radii for the flow that is followed, in voxels for a stamp, so that the surface
// stays in bricks that are looked at.
constexpr double kFlowStep = 0.12, kMostMove = 6;
// What clay under a smudge loses on the tip.
constexpr float kSlip = 0.5f;
// Pinch: how much nearer to the stroke clay comes on a way of a radius; crease: the same and its depth, in radii.
constexpr double kPinch = 0.8, kCreasePinch = 0.6, kCreaseDepth = 0.25;
// The largest of t · falloff(t).
constexpr double kLeverage = 0.65;
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

double way(const Stamp& s) {
  const double length = (s.b - s.a).norm();
  return length > 0 ? length : kDabWay * s.largestRadius();
}

class Warping : public DistanceMethod {
 public:
  explicit Warping(const StrokeContext& context)
      : brush_(context.brush),
        operation_(context.operation),
        base_(context.base),
        masked_(context.base),
        band_(context.band) {
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

  void begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord>) override {
    findNormals(before, images);
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

  bool origins(std::span<const Stamp> images, Coord coord, Vec3f (&from)[kBrickVoxels]) const override {
    const Coord first = coord * kBrickEdge;
    const Vec3d middle = first.toVec3d() + Vec3d::Constant(3.5);
    if (std::none_of(images.begin(), images.end(), [&](const Stamp& s) { return reaches(s, middle, 1); })) return false;
    NodePlaces places;
    trace(images, middle, 1, places);
    const ChannelSlot mask = masks_ ? masked_.find(Channel::mask, coord) : ChannelSlot();
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Vec3f own(static_cast<float>(i >> 6), static_cast<float>((i >> 3) & 7), static_cast<float>(i & 7));
      const Vec3f moved = Vec3f(places.x[i], places.y[i], places.z[i]) + Vec3f::Constant(3.5f) - own;
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
    return segmentDistance(s, middle) - 3.5 * 1.7321 * spacing < s.largestRadius();
  }

  double mostMove(std::span<const Stamp> images) const {
    double most = 0;
    for (const Stamp& s : images) {
      const double share = std::abs(static_cast<double>(operation_.amount)) * s.strength, length = (s.b - s.a).norm(),
                   radius = s.largestRadius();
      switch (operation_.method) {
        case Method::tug:
          most = std::max(most, share * length);
          break;
        case Method::smudge:
          most = std::max(most, share * length * kSlip);
          break;
        case Method::pinch:
          most = std::max(most, share * way(s) * kPinch * kLeverage);
          break;
        case Method::crease:
          most = std::max(most, share * way(s) * (kCreasePinch * kLeverage + kCreaseDepth));
          break;
        default:
          most = std::max(most,
                          share * way(s) / radius * std::abs(static_cast<double>(brush_->angle)) * radius * kLeverage);
      }
    }
    return most;
  }

  void trace(std::span<const Stamp> images, const Vec3d& middle, int spacing, NodePlaces& places) const {
    std::vector<WarpImage> relative;
    relative.reserve(images.size());
    double least = kMostMove * 1000;
    for (size_t i = 0; i < images.size(); ++i) {
      relative.push_back(image(images[i], normals_[i], middle));
      relative.back().active = reaches(images[i], middle, spacing);
      least = std::min({least, images[i].radius, images[i].radiusAtEnd()});
    }
    const int steps = std::max(1, static_cast<int>(std::ceil(mostMove(images) / (kFlowStep * least))));
    traceBack(relative, static_cast<int>(operation_.shape), steps, static_cast<float>(spacing), places);
  }

  WarpImage image(const Stamp& s, const Vec3f& normal, const Vec3d& middle) const {
    WarpImage w{};
    const Vec3f a = (s.a - middle).cast<float>(), d = (s.b - s.a).cast<float>();
    w.ax = a.x(), w.ay = a.y(), w.az = a.z();
    w.dx = d.x(), w.dy = d.y(), w.dz = d.z();
    const float length2 = (d.x() * d.x() + d.y() * d.y()) + d.z() * d.z();
    w.inverseLength2 = length2 > 1e-12f ? 1 / length2 : 0;
    w.radius = static_cast<float>(s.radius);
    w.growth = static_cast<float>(s.radiusAtEnd()) - w.radius;
    const float share = operation_.amount * s.strength;
    const float length = std::sqrt(length2), ways = length > 0 ? length : static_cast<float>(kDabWay) * w.radius;
    switch (operation_.method) {
      case Method::tug:
        w.move = share;
        break;
      case Method::smudge:
        w.move = share * kSlip;
        break;
      case Method::pinch:
        w.fromSegment = true;
        w.pull = share * static_cast<float>(kPinch) * (ways / w.radius);
        break;
      case Method::crease:
        w.fromSegment = true;
        w.pull = std::abs(share) * static_cast<float>(kCreasePinch) * (ways / w.radius);
        w.lift = share * static_cast<float>(kCreaseDepth) * ways;
        w.nx = normal.x(), w.ny = normal.y(), w.nz = normal.z();
        break;
      default: {
        // An axis turns the other way in a mirror.
        const Vec3f x = s.axes.col(0), y = s.axes.col(1), z = s.axes.col(2);
        const float hand = (z.x() * (x.y() * y.z() - x.z() * y.y()) + z.y() * (x.z() * y.x() - x.x() * y.z())) +
                           z.z() * (x.x() * y.y() - x.y() * y.x());
        const float turn = (hand < 0 ? -1.0f : 1.0f) * share * brush_->angle * (ways / w.radius);
        w.spinX = turn * z.x(), w.spinY = turn * z.y(), w.spinZ = turn * z.z();
      }
    }
    return w;
  }

  // Crease: the way out of the surface under the middle of each image.
  void findNormals(Sampler& before, std::span<const Stamp> images);

  std::shared_ptr<const Brush> brush_;
  Operation operation_;
  Version base_;
  Version masked_;  // the clay that the stroke began with, whose masks count
  float band_;
  bool masks_;
  std::optional<DisplacementField> field_;
  float farthest_ = 0;  // of its displacements, about
  double largest_ = 0;  // radius so far
  size_t moved_ = 0;    // blocks of the last application
  std::vector<Vec3f> normals_;
};

Coord floorOf(const Vec3f& v) {
  return {static_cast<int32_t>(std::floor(v.x())), static_cast<int32_t>(std::floor(v.y())),
          static_cast<int32_t>(std::floor(v.z()))};
}

// Whether a brick is a tile and everything in a box of voxels is the same tile, the brick included.
bool tilesOnly(Sampler& field, Coord low, Coord high, Slot brick) {
  if (!brick.isTile()) return false;
  for (int x = low.x >> kBrickBits; x <= high.x >> kBrickBits; ++x)
    for (int y = low.y >> kBrickBits; y <= high.y >> kBrickBits; ++y)
      for (int z = low.z >> kBrickBits; z <= high.z >> kBrickBits; ++z)
        if (field.slot({x, y, z}) != brick) return false;
  return true;
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
        for (int x = x0; x < x1; ++x)
          for (int y = y0; y < y1; ++y) {
            float* row = out.data() + (static_cast<ptrdiff_t>(x) * size.y + y) * size.z;
            if (slot.isTile())
              std::fill(row + z0, row + z1, slot.phi(0, field.band()));
            else
              slot.brick()->read(Brick::offset(x - at.x, y - at.y, z0 - at.z), z1 - z0, row + z0);
          }
      }
  return true;
}

void Warping::findNormals(Sampler& before, std::span<const Stamp> images) {
  normals_.assign(images.size(), Vec3f::Zero());
  if (operation_.method != Method::crease) return;
  for (size_t i = 0; i < images.size(); ++i) {
    const Stamp& s = images[i];
    // Multiples of 2⁻¹⁶ throughout.
    const auto rounded = [](double v) { return std::nearbyint(v * 65536) / 65536; };
    const double apart = rounded(s.radius / 3);
    // Sums of three: both sides first, so that mirrored places give mirrored sums.
    Vec3f plane[3];
    for (int x = 0; x < 3; ++x) {
      Vec3f line[3];
      for (int y = 0; y < 3; ++y) {
        Vec3f point[3];
        for (int z = 0; z < 3; ++z) {
          AxisPlace place[3];
          for (int k = 0; k < 3; ++k) {
            const double p = rounded(0.5 * (s.a[k] + s.b[k])) + apart * ((k == 0   ? x
                                                                          : k == 1 ? y
                                                                                   : z) -
                                                                         1),
                         cell = std::floor(p);
            place[k] = {static_cast<int>(cell), static_cast<float>(p - cell)};
          }
          float values[64];
          for (int v = 0; v < 64; ++v)
            values[v] = before.voxel(
                {place[0].base + (v >> 4) - 1, place[1].base + ((v >> 2) & 3) - 1, place[2].base + (v & 3) - 1});
          const FieldSample sample{values, place[0].t, place[1].t, place[2].t};
          FieldValue value;
          sampleField(std::span(&sample, 1), 16, 4, &value);
          point[z] = {value.x, value.y, value.z};
        }
        line[y] = (point[0] + point[2]) + point[1];
      }
      plane[x] = (line[0] + line[2]) + line[1];
    }
    const Vec3f sum = (plane[0] + plane[2]) + plane[1];
    const float length2 = (sum.x() * sum.x() + sum.y() * sum.y()) + sum.z() * sum.z();
    normals_[i] = length2 > 1e-6f ? Vec3f(sum / std::sqrt(length2)) : Vec3f(s.axes.col(2));
  }
}

// Where in a window the voxel lies that is nearest to the place that each voxel of a brick came from, and whether two
// of them are about as near.
struct NearestVoxels {
  int index[kBrickVoxels];
  bool halfway[kBrickVoxels];
};

void findNearest(const MovedVoxels& moved, Coord from, Coord size, NearestVoxels& out) {
  constexpr float kHalf = 0.4999f;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) {
      const int at = ((x + 1) * 10 + y + 1) * 10 + 1, row = (x * 8 + y) * 8;
      const int first = ((x - from.x) * size.y + y - from.y) * size.z - from.z;
      for (int z = 0; z < 8; ++z) {
        const float dx = moved.x[at + z], dy = moved.y[at + z], dz = moved.z[at + z];
        const float wx = std::nearbyint(dx), wy = std::nearbyint(dy), wz = std::nearbyint(dz);
        out.index[row + z] =
            first + (static_cast<int>(wx) * size.y + static_cast<int>(wy)) * size.z + static_cast<int>(wz) + z;
        out.halfway[row + z] = std::max(std::max(std::abs(dx - wx), std::abs(dy - wy)), std::abs(dz - wz)) > kHalf;
      }
    }
}

bool Warping::brick(Sampler& before, std::span<const Stamp>, Coord coord, float (&phi)[kBrickVoxels]) const {
  Vec3f low, high;
  if (!field_->bounds(coord, low, high)) return false;
  Sampler start(base_);
  const Slot now = before.slot(coord);
  if (tilesOnly(start, coord * kBrickEdge + floorOf(low), coord * kBrickEdge + floorOf(high) + Coord{9, 9, 9}, now))
    return false;
  Displacement moved[1000];
  if (!field_->atVoxels(coord, moved)) return false;
  const auto cell = [](int x, int y, int z) { return (x * 10 + y) * 10 + z; };
  if (masks_) {
    // What is covered stays, and does not pull.
    for (int i = 0; i < 1000; ++i) {
      const Coord voxel = coord * kBrickEdge + Coord{i / 100 - 1, i / 10 % 10 - 1, i % 10 - 1};
      const uint8_t cover =
          masked_.find(Channel::mask, voxel >> kBrickBits).value(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7));
      const float free = static_cast<float>(255 - cover) / 255.0f;
      moved[i] = {moved[i].x * free, moved[i].y * free, moved[i].z * free, 0};
    }
  }
  MovedVoxels split;
  splitDisplacements(moved, split);
  float least[3], most[3];
  movedBounds(split, least, most);
  low = Vec3f(least[0], least[1], least[2]), high = Vec3f(most[0], most[1], most[2]);
  if (low == Vec3f::Zero() && high == Vec3f::Zero()) return false;
  const Coord from = floorOf(low) - Coord{2, 2, 2}, size = floorOf(high) - from + Coord{12, 12, 12};
  const bool dense = static_cast<double>(size.x) * size.y * size.z <= kMostWindow;
  const Coord firstVoxel = coord * kBrickEdge;
  thread_local std::vector<float> window;
  Slot flat;
  bool mixed = true;
  if (dense) mixed = copyBox(start, firstVoxel + from, size, window, flat);

  FieldSample samples[kBrickVoxels];
  int voxels[kBrickVoxels];
  size_t count = 0;
  if (!dense) window.clear(), window.reserve(size_t{kBrickVoxels} * 64);
  NearestVoxels nearest;
  if (dense && mixed) findNearest(split, from, size, nearest);
  for (int i = 0; i < kBrickVoxels; ++i) {
    const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
    const Displacement& d = moved[cell(x + 1, y + 1, z + 1)];
    if (d.x == 0 && d.y == 0 && d.z == 0) {
      phi[i] = now.phi(i, band_);
      continue;
    }
    // Most voxels of a brick come from beyond the band.
    if (dense && mixed && !nearest.halfway[i]) {
      phi[i] = window[static_cast<size_t>(nearest.index[i])];
      if (std::abs(phi[i]) >= band_) continue;
    }
    if (!mixed) {
      phi[i] = flat.phi(0, band_);
      continue;
    }
    const AxisPlace px = placeOf(x, d.x), py = placeOf(y, d.y), pz = placeOf(z, d.z);
    const Coord at{px.base + (px.t >= 0.5f), py.base + (py.t >= 0.5f), pz.base + (pz.t >= 0.5f)};
    const float near =
        dense ? window[static_cast<size_t>(((at.x - from.x) * size.y + at.y - from.y) * size.z + at.z - from.z)]
              : start.voxel(firstVoxel + at);
    phi[i] = near;
    // No voxel of the cell is in the band unless the nearest is within it. Halfway there are two: which, a mirror would
    // turn round.
    const bool halfway = px.t == 0.5f || py.t == 0.5f || pz.t == 0.5f;
    if (std::abs(near) >= band_ && !halfway) continue;
    const float* corner;
    if (dense) {
      corner = window.data() + ((px.base - 1 - from.x) * size.y + py.base - 1 - from.y) * size.z + pz.base - 1 - from.z;
    } else {
      corner = window.data() + window.size();
      for (int k = 0; k < 64; ++k)
        window.push_back(start.voxel(
            firstVoxel + Coord{px.base + (k >> 4) - 1, py.base + ((k >> 2) & 3) - 1, pz.base + (k & 3) - 1}));
    }
    samples[count] = {corner, px.t, py.t, pz.t};
    voxels[count++] = i;
  }
  FieldValue values[kBrickVoxels];
  if (dense)
    sampleField(std::span(samples, count), static_cast<ptrdiff_t>(size.y) * size.z, size.z, values);
  else
    sampleField(std::span(samples, count), 16, 4, values);
  // A sample this near to the surface has a voxel of the band beside it whichever way it was rounded.
  const float known = band_ - 0.9f;
  CameFrom came;
  uint64_t mask[kBrickEdge] = {};
  for (size_t k = 0; k < count; ++k) {
    const FieldValue& v = values[k];
    const int i = voxels[k];
    float value = v.value;
    if (std::abs(value) > known) {
      const float* c = samples[k].corner;
      const ptrdiff_t sx = dense ? static_cast<ptrdiff_t>(size.y) * size.z : 16, sy = dense ? size.z : 4;
      const float tx = samples[k].tx, ty = samples[k].ty, tz = samples[k].tz;
      float farthest = 0;
      const auto corner = [&](int x, int y, int z) {
        const float f = c[(x + 1) * sx + (y + 1) * sy + z + 1];
        // On a voxel, or between two, the cell beyond is another one in a mirror: what weighs nothing says nothing.
        if ((x == 0 || tx > 0) && (y == 0 || ty > 0) && (z == 0 || tz > 0)) farthest = std::max(farthest, std::abs(f));
        return f;
      };
      const auto line = [&](int x, int y) { return corner(x, y, 0) * (1 - tz) + corner(x, y, 1) * tz; };
      const auto plane = [&](int x) { return line(x, 0) * (1 - ty) + line(x, 1) * ty; };
      const float linear = plane(0) * (1 - tx) + plane(1) * tx;
      if (farthest >= band_) {
        phi[i] = value < 0 ? -band_ : band_;
        continue;
      }
      value = linear;
    }
    came.value[i] = value;
    came.x[i] = v.x;
    came.y[i] = v.y;
    came.z[i] = v.z;
    mask[i >> 6] |= uint64_t{1} << (i & 63);
  }
  warpedDistances(came, split, mask, kMostStretch, kMostBend, phi);
  return true;
}

}  // namespace

std::unique_ptr<DistanceMethod> makeWarping(const StrokeContext& context) {
  return std::make_unique<Warping>(context);
}

}  // namespace argil::clay
