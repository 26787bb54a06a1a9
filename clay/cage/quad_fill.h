#pragma once
// Quads between given borders, with as few vertices of other than four quads as their lengths allow.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// From one corner to the next, both included, counter-clockwise: the next side begins where this one ends.
using BorderSide = std::vector<uint32_t>;

struct QuadFill {
  std::vector<std::array<uint32_t, 4>> quads;  ///< Counter-clockwise.
  std::vector<Vec3d> added;                    ///< Vertices within, those numbered from kAdded on.
  int irregular = 0;                           ///< How many of them have three or five quads.
  static constexpr uint32_t kAdded = 1U << 31;
};

/// How many of the vertices that filled() adds have other than four quads, if it finds a way. Of 2 to 6 sides, how many
/// edges each has.
[[nodiscard]] int leastIrregular(const std::vector<int>& lengths);

/// Fills a polygon of 2 to 6 straight sides: at each corner lies one quad, along each side two at a vertex. Four sides
/// of which the opposite ones are equally long get a grid; three or five, where lengths allow, one vertex of as many
/// quads; others are cut in two of those, where that can be. Of the ways to cut the one is taken whose count of quads
/// is nearest to `about`. Without quads: no way was found. `at`: where a vertex of the border lies. Method: Takayama,
/// Panozzo and Sorkine-Hornung 2014 (patterns), reduced to at most two irregular vertices.
[[nodiscard]] QuadFill filled(const std::vector<BorderSide>& sides, size_t about,
                              const std::function<Vec3d(uint32_t)>& at);

}  // namespace argil::clay
