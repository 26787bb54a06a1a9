#pragma once
// Levels of detail that a device is to make: which chunks, and where their vertices and triangles lie. Layouts of
// shaders/level.glsl.

#include <array>
#include <cstdint>
#include <vector>

namespace argil::render {

/// A brick whose vertices the triangles of a chunk name.
struct LevelBrick {
  static constexpr uint32_t kOwn = 8;
  uint32_t first = 0, count = 0;  ///< Of its vertices, in the vertex buffer.
  uint32_t scratch = 0;           ///< Where its first vertex is in the scratch of the batch.
  uint32_t flags = 0;             ///< Bits 0 to 2: its chunk's last along x, y, z; kOwn; from bit 4: cells of a group.
  std::array<int32_t, 4> zero{};  ///< Its place, in units.
};
static_assert(sizeof(LevelBrick) == 32);

struct LevelChunk {
  uint32_t firstBrick = 0, bricks = 0;     ///< Of the batch, in the order of their first vertices.
  uint32_t firstIndex = 0, indices = 0;    ///< Its triangles, empty ones among them.
  uint32_t firstScratch = 0, scratch = 0;  ///< All vertices of its bricks.
  uint32_t outVertex = 0, outIndex = 0;    ///< Where the level is to lie.
};
static_assert(sizeof(LevelChunk) == 32);

/// What a level comes to, and the cone of the surface's own triangles there.
struct LevelSize {
  uint32_t vertices = 0, triangles = 0;
  std::array<uint32_t, 2> unused{};
  std::array<float, 3> axis{};
  float cosine = -1;
};
static_assert(sizeof(LevelSize) == 32);

struct LevelBatch {
  std::vector<LevelBrick> bricks;
  std::vector<LevelChunk> chunks;
  uint32_t scratch = 0;  ///< Vertices of all bricks.
};

}  // namespace argil::render
