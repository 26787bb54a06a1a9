#pragma once
// Distances to a version's surface over a box of voxels, also where they exceed its band.

#include <vector>

#include "clay/field/foot_points.h"
#include "clay/store/version.h"

namespace argil::clay {

/// Voxels. At an outward edge the level set at this distance is round where the surface itself is sharp, so that voxels
/// can tell it; and splines read distances up to two voxels beyond it, which a band of 3 still has.
inline constexpr float kOwnDistance = 1.5f;

/// Work space of whole-piece operations: dense, used again for box after box. One thread each.
class DistanceBox {
 public:
  struct Reach {
    float inside, outside;  ///< Voxels; farther off the answer is −inside or +outside.
    bool feet = false;      ///< Whether foot() will be asked for.
  };

  /// Reads `version` over `size` voxels from `low` on. Values up to kOwnDistance are the version's own; what lies
  /// farther off is measured to the version's level set at ±kOwnDistance (FootPoints). Where a reach is within the band
  /// nothing is measured. False when the box has no surface within reach: then all of it is `uniform()`. Cost: of the
  /// voxels of the box and of `reach` around it, and more for those that are measured.
  bool fill(const Version& version, Coord low, Coord size, Reach reach);
  [[nodiscard]] Tile uniform() const { return uniform_; }

  /// The signed distance at a voxel of the box, in voxels.
  [[nodiscard]] float at(Coord voxel) const { return phi_[index(voxel - outerLow_)]; }
  /// The distances from a voxel on along z, to the end of the box.
  [[nodiscard]] const float* row(Coord voxel) const { return &phi_[index(voxel - outerLow_)]; }
  /// The voxel beside the place of the surface that is nearest to a voxel of the box whose distance is within reach.
  /// Where distances are measured that is a voxel of the version's band; else, farther than two voxels from the
  /// surface, it is found by what the band says of the direction.
  [[nodiscard]] Coord foot(Coord voxel) const;

 private:
  [[nodiscard]] size_t index(Coord v) const { return voxelIndex(outer_, v); }
  bool gather(const Version& version);
  [[nodiscard]] Coord voxelNear(const Vec3f& p) const;  // of the outer box, and `p` from its corner on
  void measure(FootPoints& points, float side, float reach);
  void measureBlock(FootPoints& points, Coord low, float side, float reach);

  Coord outerLow_, outer_;  // the box with what can be nearest around it
  Coord low_, size_;        // the box itself, from outerLow_ on
  Tile uniform_ = Tile::outside;
  bool feet_ = false;
  std::vector<float> phi_;
  std::vector<uint8_t> filled_;  // bricks that have values of their own
  std::vector<int32_t> foot_;    // index of the voxel beside the nearest place, −1: not measured
  std::vector<Coord> blocks_;    // blocks of 8³ cells that may hold surface, from outerLow_ on
  FootPoints points_[2];         // outside, inside
};

}  // namespace argil::clay
