#pragma once
// Distances to the surface of a version beyond its band, on one side of it, where they are asked for.

#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "clay/base/steps.h"
#include "clay/kernels/shaping_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/store/version.h"

namespace argil::clay {

/// In the band the version's own distances; beyond, |∇u| = 1 solved from them upwind and of second order. One thread
/// calls; equal bits for the same sequence of calls whatever the count of threads, and mirrored ones for mirrored clay.
/// Method: NOTES.md, "Distances beyond the band, while a stroke goes on".
class WideDistance {
 public:
  /// From each voxel of a brick to its nearest point of the surface: x of all, y of all, z of all.
  struct Feet {
    float foot[3 * kBrickVoxels];
    float box[2][3];  ///< Around the points of known voxels, from the brick's middle; upside down where there are none.
  };
  struct Block {
    /// Signed distance, above zero on the side asked for; kUnknownDistance beyond what was asked for.
    float u[kBrickVoxels];
    uint64_t known[kBrickEdge] = {};   ///< Bit y·8 + z of word x: u is known, and what its slope is taken from.
    uint64_t frozen[kBrickEdge] = {};  ///< The same for the version's own, within the band or behind the surface.
    float solvedTo = 0;
    bool open = true;            ///< Some voxels lie farther than it was solved to.
    std::unique_ptr<Feet> feet;  ///< Of bricks that are asked often; `feetKnown`: as its distances are now.
    bool feetKnown = false;
  };

  /// `side` +1: distances outside of the clay, −1: inside. `threads` help where there is much to solve.
  WideDistance(Version version, int side, int threads = 1)
      : version_(std::move(version)), side_(static_cast<float>(side)), threads_(threads) {}

  /// Makes distances up to `reach` (voxels, above the band) known in `bricks` (sorted), whose shortest ways to the
  /// surface must lie in bricks of this or earlier calls. Cost: about 10 µs a new brick, more the farther. Pauses where
  /// there are many; until its end nothing else is asked.
  [[nodiscard]] Steps extend(std::span<const Coord> bricks, float reach);
  /// Forgets all but `bricks` (sorted), and says which: what is asked for again is solved again.
  std::vector<Coord> keepOnly(std::span<const Coord> bricks);
  [[nodiscard]] size_t size() const { return blocks_.size(); }  ///< Bricks that it holds, 2.2 KiB each.
  /// Null where nothing was asked for, or all of a brick is on the other side beyond the band.
  [[nodiscard]] const Block* find(Coord brick) const;
  /// Of a brick that it holds, there or in `room`. About 1 µs where they are not kept. Any threads, one a brick, while
  /// nothing is extended.
  [[nodiscard]] const Feet& feet(Coord brick, Feet& room) const;
  /// Keeps the feet of `bricks` (sorted) where they are few; they are the same whether they are kept or not.
  void keepFeetOf(std::span<const Coord> bricks);

 private:
  // What stands across a face of a brick, 512 values.
  [[nodiscard]] const float* beside(Coord brick, size_t face, float (&room)[kBrickVoxels]) const;

  Version version_;
  float side_;
  int threads_;
  std::unordered_map<Coord, std::unique_ptr<Block>, CoordHash> blocks_;
  size_t keptFeet_ = 0;  // bricks
};

}  // namespace argil::clay
