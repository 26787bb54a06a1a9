#pragma once
// Where a disk that is filled anew lies on the quads that were there.

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "clay/base/vec.h"
#include "clay/cage/quad_fill.h"

namespace argil::clay {

/// Quads within a border, both counter-clockwise.
struct QuadDisk {
  std::vector<std::array<uint32_t, 4>> quads;
  std::vector<BorderSide> sides;
};

/// For each vertex of `is` that is not on its border, a place on the quads of `was`. Both have the same corners, and
/// `sides` are the whole border; a side of which the number of edges differs is divided evenly along the old one. Both
/// are laid out in a circle by Tutte's embedding, which folds nothing, and a new vertex goes to where it lies among the
/// old ones there. `at`: where a vertex of `was` lies. Cost: grows as quads of `was` times vertices of `is`.
/// Method: Tutte 1963 (every vertex in the mean of those beside it).
[[nodiscard]] std::vector<std::pair<uint32_t, Vec3d>> placesOn(const QuadDisk& was, const QuadDisk& is,
                                                               const std::function<Vec3d(uint32_t)>& at);

}  // namespace argil::clay
