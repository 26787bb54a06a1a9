#pragma once
// The level set of a box of distances as points with tangent planes and curvatures, and distances to it by the nearest.

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

  /// Goes to the block of 8³ voxels from `low` on; false where no point is within `reach` of any of them, and then
  /// what follows must not be called. Cost: a look at every block of points.
  bool approach(Coord low, float reach);
  /// How far the voxels of that block are from the level set, z fastest, in those rows of eight whose bit (x · 8 + y)
  /// is set; the others are undefined. Exact for points; between them the surface is that of second order at the
  /// nearest one.
  void measure(uint64_t rows, float (&distance)[kBrickVoxels]);
  /// After measure(): the place of the level set that is nearest to a voxel of these rows.
  [[nodiscard]] Vec3f nearestPlace(int voxel) const;

 private:
  // As FootShape, z towards the side that is measured; none is known where a slope points nowhere.
  struct Shape {
    Vec3f point, normal, first;
    float curvature[2];
    float beside2;
    bool known;
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
  void addGroup(const LevelSet& set, Coord cell, PointRange range);
  void addPoints(const LevelSet& set, const Group& group);
  [[nodiscard]] static Shape shapeAt(const LevelSet& set, const Vec3f& place);
  void add(const Shape& shape);

  std::vector<float> x_, y_, z_;
  std::vector<Vec3f> places_;  // of crossed cells
  std::vector<Group> groups_;
  std::vector<uint8_t> bent_;  // of each group of the box, whether it has no surface of second order
  Coord across_;
  std::vector<FootShape> shapes_;
  // Points of a block of cells lie one after the other; the boxes around them.
  std::vector<PointRange> blocks_;
  std::vector<float> low_[3], high_[3];
  Vec3f corner_ = Vec3f::Zero();  // of the block that was gone to
  uint32_t middles_ = kNoPoint;   // the point nearest to its middle, and how far
  float middlesFar_ = 0;
  std::vector<float> squares_;  // of the boxes from its middle
  uint32_t nearest_[kBrickVoxels];
  std::vector<PointRange> ranges_;
  PointRoom wide_, narrow_;
};

}  // namespace argil::clay
