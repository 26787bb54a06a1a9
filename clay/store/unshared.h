#pragma once
// What a version does not share with another one: the memory that undo costs.

#include "clay/store/version.h"

namespace argil::clay {

/// Bricks and nodes of `version` that `other` has not at the same place: what would be freed with it if `other` stayed.
/// All of them when they are of two stores. Cost follows the difference, not the model. Any thread but the servo's.
[[nodiscard]] VersionStats unshared(const Version& version, const Version& other);

/// Bricks and channel bricks of either version that the other has not at the same place, no further than `most` of them
/// are counted (then more than `most` comes back). Both of one store. Cost follows the difference, and `most`.
[[nodiscard]] uint64_t differingLeaves(const Version& a, const Version& b, uint64_t most);

}  // namespace argil::clay
