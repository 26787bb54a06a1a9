#pragma once
// What to put where a damaged file has lost clay. For this module's files alone.

#include <cstdint>
#include <span>

#include "clay/store/version.h"

namespace argil::io {

/// A block of 8^level bricks along each axis whose records are lost.
struct LostBlock {
  Coord first;
  int level = 0;
};

/// `damaged` has bricks in the lost blocks where some were found, and tiles of no meaning elsewhere in them. Returns it
/// with the tiles decided by the clay around them, lost bricks (level 0) filled smoothly between their neighbours, and
/// walls of bricks where inside would touch outside otherwise: its surface is closed. The same version when nothing is
/// lost. Throws Error (kind work) when the walls would need more than 2^16 bricks.
[[nodiscard]] clay::Version repairClay(const clay::Version& damaged, std::span<const LostBlock> lost);

}  // namespace argil::io
