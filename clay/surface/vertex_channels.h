#pragma once
// What vertices of a surface show of colour, material and mask.

#include <array>
#include <unordered_set>
#include <vector>

#include "clay/store/brick_set.h"
#include "clay/surface/surface.h"

namespace argil::clay {

/// Whether something was set in one of its channels.
[[nodiscard]] bool hasChannels(const Version& version);

/// Of one vertex: the mean of the voxels around it, by nearness.
struct VertexPaint {
  uint8_t red = 0, green = 0, blue = 0;  ///< sRGB.
  uint8_t cover = 0;                     ///< 0: the piece's own colour; 255: this one alone.
  uint8_t material = 0;                  ///< The one that most of it has.
  uint8_t mask = 0;
  friend bool operator==(const VertexPaint&, const VertexPaint&) = default;
};

/// Of a brick's mesh: one for each of its vertices, in their order; none where nothing is set.
struct BrickPaint {
  Coord brick;
  std::vector<VertexPaint> vertices;
};

/// What the vertices of a mesh show of their version's channels; empty where nothing is set.
[[nodiscard]] std::vector<VertexPaint> brickPaint(const Version& version, const BrickMesh& mesh);

/// Follows what the vertices of one surface show. Clay without channels costs one look a version; a stroke of paint
/// costs the bricks that it touched and extracts nothing.
class SurfacePaint {
 public:
  /// After `surface` came to `version` with `delta`: adds to delta.painted each brick with vertices that had or has
  /// something set and where that or the mesh changed.
  void follow(const Version& version, const Surface& surface, SurfaceDelta& delta);

 private:
  Version version_;
  std::unordered_set<Coord, CoordHash> painted_;  // bricks whose vertices have something set
};

/// One for each vertex of surface.toMesh(), in its order; empty when the surface's version has no channels.
[[nodiscard]] std::vector<VertexPaint> meshPaint(const Surface& surface);

}  // namespace argil::clay
