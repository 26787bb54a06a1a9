#pragma once
// Reads a version between its voxels.

#include "clay/store/version.h"

namespace argil::clay {

class Editor;

/// Point reads of one version at voxel coordinates. Remembers the region (64³ voxels) read last, so reads near each
/// other skip the tree. One thread per sampler; noexcept, allocation-free, servo-safe. The version must be held by
/// somebody while it is used. Where the field is not known (outside of the band) values are ±band and gradients fall to
/// zero.
class Sampler {
 public:
  explicit Sampler(const Version& version) noexcept { reset(version); }
  Sampler() noexcept = default;
  /// The clay as the editor has it now; until its next change.
  explicit Sampler(const Editor& editor) noexcept { reset(editor); }
  void reset(const Editor& editor) noexcept;
  /// Reads another version from now on.
  void reset(const Version& version) noexcept;

  [[nodiscard]] float band() const noexcept { return band_; }  ///< Of the version, in voxels.
  [[nodiscard]] float step() const noexcept { return step_; }  ///< Of its bricks (Brick::step).
  /// Distance in voxels at a voxel.
  [[nodiscard]] float voxel(Coord voxel) noexcept;
  /// Brick or tile at a brick coordinate, through the cache.
  [[nodiscard]] Slot slot(Coord brick) noexcept;

  /// Whether all of the region (8×8×8 bricks) around a brick coordinate is one tile.
  [[nodiscard]] bool isTileRegion(Coord brick) noexcept;

  /// What stands at a brick coordinate and one step higher along each axis, as [x][y][z].
  void corner(Coord brick, Slot (&out)[2][2][2]) noexcept;

  /// Trilinear value in voxels; exact for linear fields.
  [[nodiscard]] float trilinear(const Vec3d& p) noexcept;
  /// Trilinear value and its gradient (voxels per voxel, pointing outwards).
  float trilinear(const Vec3d& p, Vec3f& gradient) noexcept;
  /// Tricubic (Catmull-Rom) value and gradient: once continuously differentiable, exact for quadratic fields.
  float tricubic(const Vec3d& p, Vec3f& gradient) noexcept;
  /// Tricubic value, limited to what the eight voxels around allow of a distance: beside creases splines swing over.
  /// Voxels at the band's end, which only say "farther", are taken to go on as the three before them do.
  [[nodiscard]] float distance(const Vec3d& p) noexcept;

 private:
  template <int n>
  void gather(Coord first, float (&out)[n][n][n]) noexcept;

  uintptr_t root_ = 0;    // tree of the version (clay/store/tree.h)
  uintptr_t region_ = 0;  // its region node or tile met last
  Coord regionCoord_{INT32_MIN, 0, 0};
  float band_ = 3, step_ = 0;
};

}  // namespace argil::clay
