#pragma once
// Distances to a version's surface over a box of voxels, also where they exceed its band.

#include <array>
#include <vector>

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
  /// farther off is measured to the version's level set at ±kOwnDistance (to a triangle from which no way along it
  /// leads nearer, and by cubic splines from there to the level set itself). Where a reach is within the band nothing
  /// is measured. False when the box has no surface within reach: then all of it is `uniform()`. Cost: about 0.3 µs for
  /// each voxel that is measured.
  bool fill(const Version& version, Coord low, Coord size, Reach reach);
  [[nodiscard]] Tile uniform() const { return uniform_; }

  /// The signed distance at a voxel of the box, in voxels.
  [[nodiscard]] float at(Coord voxel) const { return phi_[index(voxel - outerLow_)]; }
  /// The voxel beside the place of the surface that is nearest to a voxel of the box whose distance is within reach.
  /// Where distances are measured that is a voxel of the version's band; else, farther than two voxels from the
  /// surface, it is found by what the band says of the direction.
  [[nodiscard]] Coord foot(Coord voxel) const;
  /// Between voxels, by Catmull-Rom splines, limited to what the eight voxels around allow of a distance. `p` at least
  /// one voxel within the box.
  [[nodiscard]] float sample(const Vec3d& p) const;

 private:
  struct Triangle {
    Vec3f a, ab, ac;
    int32_t corner[3];
    /// From its nearest point to p. `rim`: a corner of the edge that the nearest point is on, −1 where it is within the
    /// triangle.
    [[nodiscard]] Vec3f to(const Vec3f& p, int32_t& rim) const;
    [[nodiscard]] float squaredTo(const Vec3f& p, int32_t& rim) const { return to(p, rim).squaredNorm(); }
  };
  [[nodiscard]] size_t index(Coord v) const {
    return (static_cast<size_t>(v.x) * static_cast<size_t>(outer_.y) + static_cast<size_t>(v.y)) *
               static_cast<size_t>(outer_.z) +
           static_cast<size_t>(v.z);
  }
  bool gather(const Version& version);
  void makeTriangles(float side, float level);
  /// `p` from outerLow_ on; the gradient where it is asked for.
  [[nodiscard]] float spline(const Vec3f& p, Vec3f* gradient = nullptr) const;
  [[nodiscard]] Coord voxelNear(const Vec3f& p) const;  // of the outer box, and `p` from its corner on
  void makeFans();
  /// The triangle to which the way down along the surface leads from `triangle`, and its squared distance.
  float descend(const Vec3f& p, int32_t& triangle) const;
  void measure(float side, float level, float reach);

  Coord outerLow_, outer_;  // the box with what can be nearest around it
  Tile uniform_ = Tile::outside;
  bool feet_ = false;
  std::vector<float> phi_, squared_;
  std::vector<int32_t> foot_;     // index of the voxel beside the nearest place, −1: not measured
  std::vector<int32_t> nearest_;  // first the vertex of a cell, then the triangle of a voxel
  std::vector<uint8_t> queued_;
  std::vector<Vec3f> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<uint32_t> fanBegin_, fan_;  // triangles around each vertex
  std::vector<uint32_t> front_, next_;
};

}  // namespace argil::clay
