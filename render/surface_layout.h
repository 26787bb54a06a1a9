#pragma once
// Which part of the vertex and index buffers each brick of the surface has, and what must be written when bricks
// change.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "clay/surface.h"
#include "render/range_allocator.h"
#include "render/view.h"

namespace argil::render {

/// Vertices lie at this many units a voxel, counted from voxel (0, 0, 0): a brick's reach of ±131 072 voxels fills 32
/// bits.
inline constexpr int kUnitsPerVoxel = 1 << 14;

/// A vertex as the GPU reads it, 16 bytes. Integers, so that a shader subtracts the chunk's corner without rounding.
struct SurfaceVertex {
  int32_t x = 0, y = 0, z = 0;
  clay::PackedNormal normal;
};
static_assert(sizeof(SurfaceVertex) == 16);

/// Receives what a layout writes: the GPU's buffers, or a test's arrays.
class UploadSink {
 public:
  virtual ~UploadSink() = default;
  /// The buffers must hold at least this many vertices and indices from now on; what was written stays.
  virtual void reserve(uint32_t vertices, uint32_t indices) = 0;
  virtual void writeVertices(uint32_t first, std::span<const SurfaceVertex> vertices) = 0;
  virtual void writeIndices(uint32_t first, std::span<const uint32_t> indices) = 0;
};

/// 8×8×8 bricks that are drawn with one call.
inline constexpr int kChunkBits = 3;

struct ChunkDraw {
  Coord firstVoxel;                         ///< The chunk's lowest voxel.
  uint32_t firstIndex = 0, indexCount = 0;  ///< Triangles; some may be empty (three equal indices).
  Vec3d min, max;                           ///< Voxel coordinates that hold all its triangles.
};

/// Follows a clay surface delta by delta. One vertex range and one index range a brick; the index ranges of a chunk lie
/// in one block. Writes only bricks whose mesh changed, and the indices of those whose neighbour's vertices moved. One
/// thread.
class SurfaceLayout {
 public:
  /// Throws Error (work) when a quad names a vertex that no brick has, for a mesh without normals, or past 4 G indices;
  /// the layout is unusable then.
  void apply(const clay::SurfaceDelta& delta, UploadSink& sink);
  void clear();

  [[nodiscard]] const clay::Grid& grid() const { return grid_; }
  /// In order of chunk coordinate. Rebuilt by apply().
  [[nodiscard]] const std::vector<ChunkDraw>& draws() const { return draws_; }
  [[nodiscard]] uint64_t triangleCount() const { return 2 * quads_; }
  [[nodiscard]] uint64_t brickCount() const { return bricks_.size(); }
  /// Tight box of all vertices in world mm. O(bricks).
  [[nodiscard]] Box bounds() const;
  struct Hit {
    double distanceMm = 0;
    bool fromOutside = true;  ///< Met a triangle's front.
  };
  /// The first triangle met from `originMm` along the unit vector `direction`, or nothing. O(chunks + bricks near the
  /// ray).
  [[nodiscard]] std::optional<Hit> raycast(const Vec3d& originMm, const Vec3d& direction) const;

 private:
  struct BrickEntry {
    clay::BrickMeshPtr mesh;
    uint32_t firstVertex = 0, vertexCapacity = 0;
    uint32_t firstQuad = 0, quadCapacity = 0;  // within the chunk's block
    Vec3f min, max;                            // of the vertices, relative to the brick
  };
  struct Chunk {
    uint32_t firstQuad = 0;  // of its block
    RangeAllocator quads{0};
    std::vector<Coord> bricks;  // with quads; sorted
  };
  struct CoordHash {
    size_t operator()(Coord c) const noexcept;
  };

  bool writeVertices(Coord coord, BrickEntry& brick, UploadSink& sink);  // true when the range is another one
  void placeQuads(Coord coord, BrickEntry& brick, UploadSink& sink);
  void writeQuads(Coord coord, const BrickEntry& brick, const Chunk& chunk, UploadSink& sink);
  void eraseQuads(Coord coord, BrickEntry& brick, UploadSink& sink);
  void resizeChunk(Chunk& chunk, uint32_t capacity, UploadSink& sink);
  void reserve(RangeAllocator& ranges, uint64_t end, UploadSink& sink);
  uint32_t take(RangeAllocator& ranges, uint32_t count, UploadSink& sink);
  void rebuildDraws();

  clay::Grid grid_;
  std::unordered_map<Coord, BrickEntry, CoordHash> bricks_;
  std::map<Coord, Chunk> chunks_;
  RangeAllocator vertexRanges_{0}, quadRanges_{0};
  uint64_t quads_ = 0;
  std::vector<ChunkDraw> draws_;
  std::vector<SurfaceVertex> vertexScratch_;
  std::vector<uint32_t> indexScratch_;
};

}  // namespace argil::render
