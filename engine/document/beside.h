#pragma once
// Where a new thing stands: beside what is there, on the same ground.

#include "clay/whole/deform.h"
#include "engine/document/document.h"

namespace argil::engine {

/// World mm; low above high where there is nothing.
[[nodiscard]] clay::BoxMm boundsOf(const Piece& piece);
[[nodiscard]] clay::BoxMm boundsOf(const Part& part);
/// Of all pieces and parts, hidden ones too.
[[nodiscard]] clay::BoxMm boundsOf(const Document& document);

/// The move that puts a new thing with this box (world mm) to the right of all pieces and parts, in the middle of their
/// depth, on the ground on which the lowest of them stands. Zero for an empty document. O(bricks of the document).
[[nodiscard]] Vec3d moveBeside(const Document& document, const clay::BoxMm& box);

}  // namespace argil::engine
