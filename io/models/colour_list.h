#pragma once
// Colours as text formats write them, numbers from 0 to 1 or from 0 to 255, and those of pictures on a surface.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
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

/// The pictures of an object with coarser copies of each, so that a place may be asked for as wide as a voxel sees it.
/// Any number of threads.
class PictureColours {
 public:
  /// `mesh`: the object's, wherever it is kept; both must outlive this and stay as they are. Cost and memory: those of
  /// the pictures, and a third more.
  PictureColours(const ModelObject& object, const clay::TriangleMesh& mesh);

  [[nodiscard]] bool empty() const { return object_.places.empty(); }
  /// The colour at a point of a triangle, whose shares of the corners sum to 1, as the mean over about `width` in the
  /// mesh's unit; alpha says how much it covers. A triangle without a picture has the object's other colours.
  [[nodiscard]] Colour at(size_t triangle, const Vec3d& shares, double width) const;

 private:
  using Rgba = std::array<uint8_t, 4>;
  struct Level {
    int width, height;
    std::vector<Rgba> pixels;
  };
  using Levels = std::vector<Level>;
  static Levels levelsOf(const ColourImage& picture, bool opaque);

  const ModelObject& object_;
  const clay::TriangleMesh& mesh_;
  std::vector<std::shared_ptr<const Levels>> levels_;  // by ModelObject::pictures
};

/// Gives the vertices of an object the colours of its pictures, of which it has none afterwards; a vertex whose
/// triangles differ there becomes several in one place. Detail between vertices is lost.
void picturesToVertices(ModelObject& object);

}  // namespace argil::io
