#pragma once
// What a stroke does to colour, material and mask. This module's own.

#include <array>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/store/channel_reader.h"

namespace argil::clay {

/// Whether a brush that changes distances has channels to take along: the clay has some, or the brush dyes.
[[nodiscard]] bool carriesChannels(const Editor& editor, const Brush& brush);

/// How far clay that came into the band during a stroke has its colours from, in steps from voxel to voxel, where that
/// is known; 0 is what was there. With it a groove takes the colours beside it and not those that its beginning had.
using CarriedFrom = std::unordered_map<Coord, std::array<uint16_t, kBrickVoxels>, CoordHash>;

/// Takes channels along after distances were changed from `was` to the editor's base; the editor has no change of its
/// own yet. Voxels that are new in the band take what the nearest clay that was there before the stroke has, found
/// along the band (equally near: their mean; of materials the one met most often, then the lowest), and no mask; where
/// a `method` moved clay its colours and materials go with it, by how much a mask lets them; where there is no band any
/// more there is nothing. Where the brush dyes, clay that was laid on takes its colour, by how many voxels it is thick.
/// `method`, `images`: of the application, or null and none. `stroke`: empty when it begins. Cost: nothing follows the
/// model; where neither a changed brick nor its neighbours have channels, some lookups a brick.
void carryChannels(Editor& editor, const Version& was, const Brush& brush, const DistanceMethod* method,
                   std::span<const Stamp> images, CarriedFrom& stroke);

/// Shares of each voxel that the stamps of a stroke have laid so far, 0 to 1, of colours and of masks: the rim of a
/// stamp covers a voxel in part, and twenty stamps over the same rim must not cover all of it.
class LaidShares {
 public:
  /// Those of a brick's 512 voxels, to be read and changed.
  [[nodiscard]] float* of(Property property, Coord brick) {
    return shares_[property == Property::mask].try_emplace(brick).first->second.data();
  }

 private:
  std::array<std::unordered_map<Coord, std::array<float, kBrickVoxels>, CoordHash>, 2> shares_;
};

/// Applies an operation on colour, material or mask to the voxels of the band under the images, by their weight: set or
/// blur. A mask holds colours and materials. What the editor has counts as one state: images that overlap act once.
/// Sets channels up to the stamp's border on the surface, fading out over kPaintRim voxels. `laid`: of the stroke,
/// empty when it begins.
void applyToChannels(Editor& editor, const Brush& brush, const Operation& operation, std::span<const Stamp> images,
                     LaidShares& laid);

/// Bricks that hold some surface and come within `reach` voxels of the images' segments. Sorted, each once.
[[nodiscard]] std::vector<Coord> surfaceBricks(const Editor& editor, std::span<const Stamp> images,
                                               const std::function<double(const Stamp&)>& reach);

/// Bytes move towards bytes by a share (0 to 1) in one way everywhere: to the nearest, and by one at least, so that a
/// weak brush arrives too.
[[nodiscard]] uint8_t approach(uint8_t from, uint8_t to, float share) noexcept;
/// Colour laid over a voxel's own, which shows through by 1 − alpha.
void layColour(ChannelBytes& bytes, const std::array<uint8_t, 3>& colour, float alpha) noexcept;

}  // namespace argil::clay
