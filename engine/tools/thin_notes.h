#pragma once
// Sentences on clay and gaps that an operation took away because they were thinner than voxels can tell.

#include <string>
#include <vector>

#include "clay/field/thin_parts.h"
#include "engine/document/document.h"

namespace argil::engine {

/// Voxels³ of clay between voxels that are told of: less lies in sharp edges.
inline constexpr double kLeastBetween = 0.5;

/// Adds a sentence for each kind of what went from `piece`, whose voxels the result has; none where nothing did.
void addThinNotes(std::vector<std::string>& notes, const Piece& piece, const clay::ThinParts& gone);

}  // namespace argil::engine
