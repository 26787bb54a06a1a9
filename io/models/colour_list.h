#pragma once
// Colours as text formats write them: numbers from 0 to 1 or from 0 to 255, and nobody says which.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/models/model_file.h"

namespace argil::io {

/// Takes the numbers of a colour for vertex after vertex (or face after face) and decides at the end: where none
/// exceeds 1, 1 is full, else 255 is.
class ColourList {
 public:
  /// Three or four numbers, red green blue alpha, for the item `index`; items may be left out, indices only rise. What
  /// is not finite is 0.
  void add(size_t index, std::span<const double> numbers);
  [[nodiscard]] bool empty() const { return colours_.empty(); }
  /// One an item for `count` items, white where none was added; empty when none was added at all. The list is empty
  /// afterwards.
  [[nodiscard]] std::vector<Colour> take(size_t count);

 private:
  std::vector<std::array<float, 4>> colours_;
  double largest_ = 0;
};

/// Gives the corners of each triangle their colours: of triangles where each has one, else of vertices; a vertex whose
/// corners differ becomes several in one place. As many as triangles. O(n log n) in what differs.
void setCornerColours(ModelObject& object, std::span<const std::array<Colour, 3>> corners);

}  // namespace argil::io
