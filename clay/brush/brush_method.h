#pragma once
// One way of changing distances: what a file of a new method implements. This module's own.

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "clay/base/steps.h"
#include "clay/brush/brush.h"
#include "clay/field/redistance.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// A step of a stamp computes about so many bricks: 1 to 20 ms by method.
inline constexpr size_t kBricksAStep = 256;

/// From the middle of a brick's voxels to its corner voxel, and a little that covers rounding: bricks farther out are
/// decided without looking at their voxels, with the same result.
inline const double kHalfDiagonal = 3.5 * std::sqrt(3.0) + 0.01;
/// The same for a region of 8×8×8 bricks, so that a brush of any size costs its surface; and for a cube of any edge.
inline const double kRegionHalfDiagonal = 31.5 * std::sqrt(3.0) + 0.01;
[[nodiscard]] inline double halfDiagonal(int bricks) {
  return (kBrickEdge * bricks - 1) * 0.5 * std::sqrt(3.0) + 0.01;
}

/// Of an application.
inline constexpr size_t kMostImages = 64;

/// Applications whose bricks are computed together at most (DistanceMethod::moves). What is shown lags by less.
inline constexpr size_t kTogether = 4;

/// Clay that moves by no more than so many voxels stays in the bricks around those that it was in.
inline constexpr double kMoveWithin = 6;

/// Throws Error for numbers that are not finite or out of range.
void checkStamp(const Stamp& stamp);

/// What a method knows for a whole stroke.
struct StrokeContext {
  std::shared_ptr<const Brush> brush;
  Operation operation;  ///< Of that brush, on distances.
  Version start;        ///< The clay as it was when the stroke began.
  float band = 3;
  Version base;     ///< The clay as the first application finds it.
  int threads = 1;  ///< That help where an application has much to do; the result does not depend on them.
};

/// With places that are multiples of a fixed step, so that sums and mirror images in planes between voxels are exact.
[[nodiscard]] Vec3d quantised(const Vec3d& place);
[[nodiscard]] std::vector<Stamp> quantised(std::span<const Stamp> images);
/// Part `part` of `parts` of an application's way; what goes by the way becomes less with it.
[[nodiscard]] std::vector<Stamp> partOf(std::span<const Stamp> images, int part, int parts);

/// Lives as long as the stroke, so it may keep what it accumulates. begin() is called once an application and brick()
/// for each of its bricks, those from several threads. Equal bits on every CPU and thread count: add, multiply, divide,
/// square root, min, max only, in an order that follows from the arguments. Where images overlap they combine so that
/// their order does not matter: the largest weight; sums are taken halves first, which mirroring does not change.
class DistanceMethod {
 public:
  virtual ~DistanceMethod() = default;

  /// How far from a stamp's segment it may change anything, voxels. The same every time.
  [[nodiscard]] virtual double reach(const Stamp& stamp) const { return stamp.largestRadius(); }

  /// Whether what it keeps of the stroke has grown so much that it should begin anew; asked before each application,
  /// and the answer follows from those alone. The stroke then redistances what trails and calls beginAnew() with the
  /// clay as it is: to be taken as that which the next application finds first.
  [[nodiscard]] virtual bool full() const { return false; }
  virtual void beginAnew(const Version& now) { (void)now; }

  /// How far outside of the surface applications that move clay by `moved` voxels altogether may put one, voxels; below
  /// zero: bricks that hold no surface stay as they are. Clay that moves a little stays in the bricks around those that
  /// it was in.
  [[nodiscard]] virtual double travel(double moved) const { return moved > kMoveWithin ? moved : 0; }

  /// Where the tool of an application, or of a part of it, counts as standing in the clay `before` it.
  [[nodiscard]] virtual std::vector<Stamp> placed(Sampler& before, std::span<const Stamp> images) const {
    (void)before;
    return {images.begin(), images.end()};
  }

  /// Where moves() is finite: an application comes. Its bricks are computed later, maybe with those of others; where it
  /// reaches none, begin() is not called for it.
  virtual void follow(Sampler& before, std::span<const Stamp> images) { (void)before, (void)images; }

  /// Before the bricks of an application, or of some together; `bricks` (sorted) are those that will be asked for: all
  /// within reach that hold or touch some surface. It pauses about every kBricksAStep bricks of work.
  [[nodiscard]] virtual Steps begin(Sampler& before, std::span<const Stamp> images, std::span<const Coord> bricks) {
    (void)before, (void)images, (void)bricks;
    co_return;
  }

  /// New distances of a brick, from the clay `before` the application: fills phi (clamping and signs are the caller's)
  /// and returns true; false where nothing changes. What a mask covers is put back by the caller.
  [[nodiscard]] virtual bool brick(Sampler& before, std::span<const Stamp> images, Coord coord,
                                   float (&phi)[kBrickVoxels]) const = 0;

  /// Of a method that moves clay: where the clay of each voxel (its place in voxels) was before this application, for
  /// what it carries along. False: it stayed.
  [[nodiscard]] virtual bool origins(std::span<const Stamp> images, Coord coord, Vec3f (&from)[kBrickVoxels]) const {
    (void)images, (void)coord, (void)from;
    return false;
  }

  /// How far its applications may have changed distances when they are renewed at the latest, whatever Quality::drift
  /// says. Where this is finite the band is carried along by what is solved, which then takes all of its passes.
  [[nodiscard]] virtual double mostDrift() const { return HUGE_VAL; }

  /// What has to be renewed beside the surface: nothing where it leaves distances there, as a CSG of distances does.
  [[nodiscard]] virtual Renew leaves() const { return Renew::slopes; }

  /// Whether it may change anything in a cube of bricks, 2, 4 or 8 along its edge: asked before its bricks are looked
  /// at one by one, where clay comes far.
  [[nodiscard]] virtual bool mayChange(Sampler& before, Coord first, int edge) const {
    (void)before, (void)first, (void)edge;
    return true;
  }

  /// Whether it makes clay where no surface is near: all bricks within reach are asked for.
  [[nodiscard]] virtual bool everywhere() const { return false; }

  /// Whether every application computes its bricks from the stroke's base, so that nothing adds up that had to be
  /// redistanced on the way.
  [[nodiscard]] virtual bool lasting() const { return false; }

  /// Whether it heeds masks that cover a part itself; what they cover whole is put back in any case.
  [[nodiscard]] virtual bool masks() const { return false; }

  /// How far an application moves clay at most, voxels, where brick() computes what all applications have left that
  /// came since its bricks were last computed: bricks of some that move little are then computed together. Infinity:
  /// those of each at once.
  [[nodiscard]] virtual double moves(std::span<const Stamp> images) const {
    (void)images;
    return HUGE_VAL;
  }

  /// Of how many parts of its way, one after the other, an application is made: where it would carry the surface out of
  /// the bricks around it.
  [[nodiscard]] virtual int parts(std::span<const Stamp> images) const {
    (void)images;
    return 1;
  }
  [[nodiscard]] virtual std::vector<Stamp> part(std::span<const Stamp> images, int part, int parts) const {
    return partOf(images, part, parts);
  }
};

/// The method of the context's operation. One line a method.
[[nodiscard]] std::unique_ptr<DistanceMethod> makeMethod(const StrokeContext& context);

// Makers, each in the file of its method.
// carve, add, wax with any tip (sweep.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeSweep(const StrokeContext& context);
// smooth, smoothKeep (smoothing.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeSmoothing(const StrokeContext& context);
// scrape, fill, flatten, build (levelling.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeLevelling(const StrokeContext& context);
// raise: with a limit or an image (raising.cpp), and without (swelling.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeRaising(const StrokeContext& context);
[[nodiscard]] std::unique_ptr<DistanceMethod> makeSwelling(const StrokeContext& context);
// crease, tug, smudge, pinch, twist (warping.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeWarping(const StrokeContext& context);
[[nodiscard]] std::unique_ptr<DistanceMethod> makeMorphing(const StrokeContext& context);  // morph (morphing.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeFormula(
    const StrokeContext& context);  // formula (formula_method.cpp)
[[nodiscard]] std::unique_ptr<DistanceMethod> makeExternal(
    const StrokeContext& context);  // external (external_brush.cpp)

/// How far a stamp of strength 1 raises at most, voxels.
[[nodiscard]] float raisedByStamp(const Brush& brush, const Operation& operation);

/// Distance of a point from a stamp's segment, voxels; in double, for choosing.
[[nodiscard]] inline double segmentDistance(const Stamp& s, const Vec3d& p) {
  const Vec3d d = s.b - s.a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - s.a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - s.a - t * d).norm();
}

/// Middle of the voxels of a cube of bricks.
[[nodiscard]] inline Vec3d middleOf(Coord first, int bricks) {
  return (first * kBrickEdge).toVec3d() + Vec3d::Constant(kBrickEdge * bricks * 0.5 - 0.5);
}

/// The bricks of which a voxel may lie within a margin of a stamp's segment along each axis: first and last.
struct BrickBox {
  BrickBox(const Stamp& s, double margin) {
    const Vec3d low = s.a.cwiseMin(s.b) - Vec3d::Constant(margin), high = s.a.cwiseMax(s.b) + Vec3d::Constant(margin);
    // From the last voxel of a brick: mirrored stamps choose mirrored bricks.
    first = {static_cast<int32_t>(std::ceil((low.x() - 7) / 8)), static_cast<int32_t>(std::ceil((low.y() - 7) / 8)),
             static_cast<int32_t>(std::ceil((low.z() - 7) / 8))};
    last = {static_cast<int32_t>(std::floor(high.x() / 8)), static_cast<int32_t>(std::floor(high.y() / 8)),
            static_cast<int32_t>(std::floor(high.z() / 8))};
  }
  template <class Visit>
  void forRegions(const Visit& visit) const {
    for (int x = first.x >> 3; x <= last.x >> 3; ++x)
      for (int y = first.y >> 3; y <= last.y >> 3; ++y)
        for (int z = first.z >> 3; z <= last.z >> 3; ++z) visit(Coord{x, y, z} * 8);
  }
  Coord first, last;
};

/// Visits the bricks around a stamp, region by region, so that consecutive ones share a node. `enter` is asked first,
/// with the region's first brick and the distance of its middle to the segment.
template <class Enter, class Visit>
void forBricks(const Stamp& s, double margin, const Enter& enter, const Visit& visit) {
  const BrickBox box(s, margin);
  box.forRegions([&](Coord region) {
    if (!enter(region, segmentDistance(s, middleOf(region, 8)))) return;
    for (int x = std::max(box.first.x, region.x); x <= std::min(box.last.x, region.x + 7); ++x)
      for (int y = std::max(box.first.y, region.y); y <= std::min(box.last.y, region.y + 7); ++y)
        for (int z = std::max(box.first.z, region.z); z <= std::min(box.last.z, region.z + 7); ++z)
          visit(Coord{x, y, z});
  });
}

/// Halves regions down to bricks for as long as `enter` says so; it gets a cube's first brick, its edge in bricks (8,
/// 4, 2, 1), and the distance of its middle to the segment. So the skin of a large tip is found at the cost of its
/// skin.
template <class Enter>
void forCubes(const Stamp& s, double margin, const Enter& enter) {
  const BrickBox box(s, margin);
  const auto halve = [&](const auto& again, Coord first, int edge) -> void {
    if (first.x > box.last.x || first.y > box.last.y || first.z > box.last.z || first.x + edge <= box.first.x ||
        first.y + edge <= box.first.y || first.z + edge <= box.first.z)
      return;
    if (!enter(first, edge, segmentDistance(s, middleOf(first, edge))) || edge == 1) return;
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i) again(again, first + Coord{i >> 2, i >> 1 & 1, i & 1} * half, half);
  };
  box.forRegions([&](Coord region) { halve(halve, region, 8); });
}

/// Bricks within reach of the images that hold some surface, and those beside them that some may come to by
/// applications that move clay by `moved` voxels altogether (DistanceMethod::travel). Of a method that makes clay
/// everywhere all within reach but `goal` tiles. Sorted.
[[nodiscard]] std::vector<Coord> reachedBricks(const Editor& editor, const DistanceMethod& method,
                                               std::span<const Stamp> images, double moved, Tile goal);

/// A stamp's ball as kernels take it.
[[nodiscard]] SweptBall sweptBall(const Stamp& stamp, Coord brick);

/// Weight of the images at the voxels of a brick: the largest over all images of falloff(distance to the segment /
/// radius) · strength. Centre-relative arithmetic, so that mirrored bricks have mirrored bits.
void imageWeights(std::span<const Stamp> images, Falloff shape, Coord coord, float (&weight)[kBrickVoxels],
                  uint64_t rows = ~uint64_t{});
/// Makes of each weight towards something that of `perStamp` stamps (Brush::perStamp) at once: w → n·w / (1 + (n −
/// 1)·w), so that 0 and 1 stay.
void moreByStamp(float perStamp, float (&weight)[kBrickVoxels]);
/// The same as imageWeights() above, with moreByStamp().
void imageWeights(std::span<const Stamp> images, Falloff shape, Coord coord, float perStamp,
                  float (&weight)[kBrickVoxels], uint64_t rows = ~uint64_t{});

/// The same as Brush::adds says.
void brushWeights(const Brush& brush, Falloff shape, std::span<const Stamp> images, Coord coord,
                  float (&weight)[kBrickVoxels]);

/// Where voxel (x, y, z) of a brick lies relative to a point, computed through the brick's middle: mirrored places give
/// mirrored bits.
struct BrickFrame {
  BrickFrame(const Vec3d& point, Coord coord)
      : middle((point - ((coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5))).cast<float>()) {}
  [[nodiscard]] Vec3f at(int x, int y, int z) const {
    return {(static_cast<float>(x) - 3.5f) - middle.x(), (static_cast<float>(y) - 3.5f) - middle.y(),
            (static_cast<float>(z) - 3.5f) - middle.z()};
  }
  Vec3f middle;  ///< The point, from the brick's middle.
};

}  // namespace argil::clay
