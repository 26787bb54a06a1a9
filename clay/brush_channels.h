#pragma once
// What a stroke does to colour, material and mask. This room's own.

#include <span>

#include "clay/brush_method.h"

namespace argil::clay {

/// Whether the clay has colours or materials, which go along with it.
[[nodiscard]] bool hasPaint(const Editor& editor);

/// After distances were changed in (some of) `bricks`: voxels that are new in the band take what the nearest clay that was there has (`was`, the clay before),
/// or the brush's own where it dyes; where a method moved clay its channels went along; where there is no band any more there is nothing.
void carryChannels(Editor& editor, const Version& was, const Brush& brush, const DistanceMethod* method, std::span<const Stamp> images, std::span<const Coord> bricks);

/// An operation on colour, material or mask.
void applyToChannels(Editor& editor, const Brush& brush, const Operation& operation, std::span<const Stamp> images);

}  // namespace argil::clay
