#pragma once
// The level set of a box of distances as points with tangent planes and curvatures, and distances to it by the nearest.

#include <array>
#include <span>
#include <vector>

#include "clay/base/vec.h"
#include "clay/kernels/foot_kernels.h"

namespace argil::clay {

/// The place of a voxel in an array of `size`: z fastest, rows of y, slices of x.
[[nodiscard]] inline size_t voxelIndex(Coord size, Coord v) {
  return (static_cast<size_t>(v.x) * static_cast<size_t>(size.y) + static_cast<size_t>(v.y)) *
             static_cast<size_t>(size.z) +
         static_cast<size_t>(v.z);
}

/// Where side·phi is `level`, in a field of `size` voxels (voxelIndex()). Values from ±band on only say "farther".
struct LevelSet {
  const float* phi;
  Coord size;
  float band;
  float side, level;  ///< 1: outside, −1: inside; voxels.
};

/// Work space, used again for box after box. One thread each.
class FootPoints {
 public:
  /// Takes a level set apart: a point for each cell that it crosses, moved onto it, with the plane and the curvatures
  /// that cubic splines have there; where it is smooth, for each two by two by two cells. Cells nearer than a voxel to
  /// the rim of the field have none. `blocks`: corners of blocks of 8³ cells that hold all of it; they may lie partly
  /// outside of the field. The field is not looked at afterwards. Cost: of the blocks' voxels, and of a spline with its
  /// derivatives for each point.
  void make(const LevelSet& set, const std::vector<Coord>& blocks);

  /// The nearest place of the level set, as its points tell it.
  struct Foot {
    float distance;  ///< From the level set; not less than 0.
    Vec3f place;     ///< Only where it was asked for.
  };
  /// Goes to the block of 8³ voxels from `low` on; false where no point is within `reach` of any of them, and then
  /// measure() must not be called. Cost: a look at every block of points.
  bool approach(Coord low, float reach);
  /// The feet of the voxels of that block, z fastest; where `wanted` is false a foot is undefined. Exact for points;
  /// between them the surface is that of second order at the nearest one.
  void measure(const std::array<bool, kBrickVoxels>& wanted, bool places, std::array<Foot, kBrickVoxels>& feet);

 private:
  // Points of a block of cells, one after the other, and the box around them.
  struct Block {
    Vec3f low, high;
    PointRange points;
  };
  struct Near {
    float distance;  // from the middle of what is measured to the box
    uint32_t block;
  };
  // Of the surface beside a point: z = −(κ1 u² + κ2 v²)/2 over its plane, z towards the side that is measured.
  struct Shape {
    Vec3f point, normal, first;  // `first`: direction of κ1, unit length
    float curvature[2];
    float beside2;  // voxels²: how far the nearest place may be from it
    bool known;     // false: a slope that points nowhere; the point alone counts
  };
  // Two by two by two cells.
  struct Group {
    PointRange places;  // of those that are crossed
    uint32_t one;       // of these places,
    Shape shape;        // and the surface there
    size_t at;          // in bent_
    float off;          // how far the others are off its surface
  };
  void addBlock(const LevelSet& set, Coord block);
  [[nodiscard]] static Vec3f crossingOf(const LevelSet& set, Coord cell);
  void addGroup(const LevelSet& set, Coord cell, PointRange range);
  void addPoints(const LevelSet& set, const Group& group);
  [[nodiscard]] static Shape shapeAt(const LevelSet& set, const Vec3f& place);
  void add(const Shape& shape);
  [[nodiscard]] Foot footOn(const Shape& shape, const Vec3f& p, bool place) const;

  std::vector<float> x_, y_, z_;
  std::vector<Vec3f> places_;  // of crossed cells
  std::vector<Group> groups_;
  std::vector<uint8_t> bent_;  // of each group of the box, whether it has no surface of second order
  Coord across_;
  std::vector<Shape> shapes_;
  std::vector<Block> blocks_;
  Vec3f corner_ = Vec3f::Zero();  // of the block that was gone to
  uint32_t middles_ = kNoPoint;   // the point nearest to its middle, and how far
  float middlesFar_ = 0;
  std::vector<Near> near_;
  std::vector<PointRange> ranges_;
  PointRoom wide_, narrow_;
};

}  // namespace argil::clay
