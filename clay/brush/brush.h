#pragma once
// What a tool does to clay: a brush is a list of operations, a stamp is one place where it works.

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "clay/brush/quality.h"
#include "clay/store/editor.h"

namespace argil::clay {

class StampShape;     // clay/brush/stamp_shape.h
class HeightImage;    // clay/import/height_image.h
class Formula;        // clay/brush/formula.h
class ExternalBrush;  // clay/brush/external_brush.h

/// What an operation changes.
enum class Property : uint8_t { distance, colour, material, mask };

/// How it changes it. Distances first: what is named there is what the piece looks like.
enum class Method : uint8_t {
  carve,
  add,         ///< The swept tip is cut away or laid on.
  wax,         ///< Laid on and blended with what is there over Brush::blend.
  smooth,      ///< Towards the mean of the neighbours.
  smoothKeep,  ///< The same, and what that takes or gives in volume is put back evenly.
  /// Towards a plane fitted to the surface under the tip: what stands above it goes, what lies below is filled, or
  /// both.
  scrape,
  fill,
  flatten,
  /// Clay is laid up to a plane that lies above the mean of the surface under the tip by Brush::height, a share a
  /// stamp: a pass of the smooth falloff raises level clay by about the height, fills what lies below, and leaves what
  /// stands above. Below zero the same downwards.
  build,
  /// Along the normals of the surface: as it is now, without end; or, where Brush::limited or with an image, as it was
  /// when the stroke began, by Brush::height at most. Below zero it lowers.
  raise,
  crease,    ///< Draws the clay together and lowers it along the stroke; above zero a sharp ridge.
  tug,       ///< Clay under the tip goes with it.
  smudge,    ///< The same with slip: what is behind stays.
  pinch,     ///< Towards the stroke; below zero away from it.
  twist,     ///< About the tip's axis, by Brush::angle over the radius.
  morph,     ///< Back to Brush::before.
  formula,   ///< As Brush::formula says; times the amount, by at most a voxel and a half a stamp.
  external,  ///< As Brush::external says; by at most a voxel and a half a stamp.
  set,       ///< Colour, material, mask: Brush::colour, Brush::material, 255 (below zero: 0).
  blur,      ///< Colour and mask: towards the mean of the neighbours.
};

/// Weight of an operation over the tip: 1 in its middle and 0 at its rim, t the distance in radii.
enum class Falloff : uint8_t {
  constant,  ///< 1.
  smooth,    ///< (1 − t²)².
  linear,    ///< 1 − t.
  sharp,     ///< (1 − t)².
  dome,      ///< √(1 − t²).
};
[[nodiscard]] float falloff(Falloff shape, float t) noexcept;

struct Operation {
  Property property = Property::distance;
  Method method = Method::carve;
  Falloff shape = Falloff::smooth;
  /// Times the stamp's strength: −1 to 1. Below zero the other way round where the method says so.
  float amount = 1;
  friend bool operator==(const Operation&, const Operation&) = default;
};

/// The solid that a tool works with, in the stamp's axes.
enum class Tip : uint8_t {
  ball,
  ellipsoid,  ///< Half axes: radius · proportions.
  box,        ///< Half edges: radius · proportions, its edges rounded by `round` of the least of them.
  shape,      ///< Brush::shape, scaled so that it fits into the radius.
};

/// The same for a whole stroke. Lengths are in voxels.
struct Brush {
  std::vector<Operation> operations;  ///< One to four, no property twice.
  Tip tip = Tip::ball;
  Vec3f proportions = Vec3f::Ones();  ///< 0.05 to 1.
  float round = 0.2f;                 ///< 0 to 1.
  float blend = 0;                    ///< Wax: 0 to 64; what is wider than the band counts as the band.
  float height = 1;                   ///< Raise: 0 to 4096; a smooth one reaches it in about ten stamps of strength 1.
  double spread = 1;                  ///< Smooth: times the variance of a stamp's mean, 1 to 64: coarser bumps go.
  bool limited = false;               ///< Raise: what a stroke lays never exceeds the height, however often it passes.
  bool bead = false;   ///< Limited: nor the height times the weight, so that it has the falloff's profile.
  float angle = 0.5f;  ///< Twist: radians over a whole turn of the tip's way, −3 to 3.
  std::array<uint8_t, 3> colour{};
  uint8_t material = 0;
  /// Carve: the thickness in voxels below which no wall is cut, 0 to 256; 0: no limit. clay/brush/wall_limit.h.
  float leastWall = 0;
  bool dye = false;  ///< New clay takes the brush's colour; else that of the nearest clay there was.
  std::shared_ptr<const StampShape> shape;
  std::shared_ptr<const HeightImage> image;  ///< Raise: its height over the tip's x and y instead of the falloff.
  Version before;                            ///< Morph: of the same store and grid.
  std::shared_ptr<const Formula> formula;
  std::shared_ptr<const ExternalBrush> external;
  std::vector<float> values;  ///< Of the formula's or the external brush's parameters.
  /// Formula and external: what stamps do adds up, so that `perStamp` multiplies their weight; else they go towards
  /// something, and a weight of 1 is all of it.
  bool adds = false;
  /// A stamp stands for so many of those that the tool was made for: stamps farther apart each do more. 0.01 to 1000.
  double perStamp = 1;
  Quality quality;

  /// One operation on distances.
  [[nodiscard]] static std::shared_ptr<const Brush> of(Method method, float amount = 1);
  /// Throws Error for what is out of range or does not go together.
  void check() const;
};

/// A tip swept from a to b, its radius changing evenly on the way. Equal stamps on equal versions give equal bits on
/// every CPU, whatever was published between.
struct Stamp {
  Vec3d a = Vec3d::Zero();  ///< Voxel coordinates.
  Vec3d b = Vec3d::Zero();  ///< Voxel coordinates; equal to a for a single dab.
  double radius = 1;        ///< Voxels, 0.5 to 4096.
  float strength = 1;       ///< 0 to 1.
  double endRadius = 0;     ///< At b; 0: the same.
  /// Columns: the tip's x, y, z; orthonormal, mirrored in a mirror image.
  Eigen::Matrix3f axes = Eigen::Matrix3f::Identity();

  [[nodiscard]] double radiusAtEnd() const { return endRadius > 0 ? endRadius : radius; }
  [[nodiscard]] double largestRadius() const { return std::max(radius, radiusAtEnd()); }
};

/// Where Brush::leastWall ends a tip's way: its centre may go as far as `place` and beside it, not on towards `wall`.
struct WallAhead {
  Vec3d place = Vec3d::Zero();  ///< Voxel coordinates.
  Vec3d wall = Vec3d::UnitZ();  ///< Unit length.
  size_t image = 0;             ///< Of the tip.
};

/// The stamps of one stroke, applied to a version one after the other, with redistancing that trails the tool by a
/// fixed count of stamps: the result depends on the sequence of stamps alone. One thread; `threads` help it with large
/// stamps.
class BrushStroke {
 public:
  /// `start`: the clay as it was when the stroke began, for methods that go by it; none: `base`. Throws Error for a bad
  /// brush.
  BrushStroke(Version base, std::shared_ptr<const Brush> brush, Version start = {}, int threads = 1);
  ~BrushStroke();

  /// Applies a stamp and its mirror images as one: all of them read the clay as it was before. Throws Error for a stamp
  /// that is not finite or out of range; then nothing changed. 1 to 64 images; each must be the mirror image of the one
  /// whose index differs in one bit, or a turned copy.
  void apply(std::span<const Stamp> images);
  void apply(const Stamp& stamp) { apply(std::span(&stamp, 1)); }
  /// The same in steps, since one stamp of a large tip takes longer than a picture may: true while there is more of it
  /// to do. Images count when a stamp begins. Whoever asks may publish between two steps: of methods that move the
  /// surface by little he gets the bricks that are done, of others the clay before the stamp; closed in any case. The
  /// stroke is the same.
  [[nodiscard]] bool step(std::span<const Stamp> images);
  /// A version of all that was applied so far. Cheap: path copies only.
  [[nodiscard]] Version publish();
  /// Ends a stamp that was begun and redistances what still trails; the version that the stroke leaves. The stroke is
  /// over.
  [[nodiscard]] Version finish();

  /// The walls of Brush::leastWall that hold the tip where the last stamp left it, or will within the next few voxels
  /// of its way: at most four an image, the nearest first. They hold near there: ask again after the next stamps.
  [[nodiscard]] std::vector<WallAhead> wallsAhead();

  /// Bricks and nodes made so far.
  [[nodiscard]] Editor::Counts counts() const;
  /// Bricks that stamps computed or turned into tiles so far, changed or not: what an edit's cost follows.
  [[nodiscard]] uint64_t touched() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::clay
