#pragma once
// Which part of the vertex and index buffers each brick of the surface has, and what must be written when bricks
// change.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "clay/surface/vertex_channels.h"
#include "render/surface/level_batch.h"
#include "render/surface/range_allocator.h"
#include "render/view/colour.h"
#include "render/view/lod.h"
#include "render/view/ray.h"
#include "render/view/view.h"

namespace argil::render {

/// Index ranges are handed out in steps of a quad's two triangles.
inline constexpr uint32_t kIndicesPerQuad = 6;

/// A vertex as the GPU reads it, 16 bytes. Integers, so that a shader subtracts an anchor near the eye without
/// rounding.
struct SurfaceVertex {
  int32_t x = 0, y = 0, z = 0;
  clay::PackedNormal normal;
};
static_assert(sizeof(SurfaceVertex) == 16);

/// What a vertex shows of its clay's channels, as the GPU reads it: square roots of the display-linear colour that it
/// adds (red lowest), and in the highest byte how much of the piece's own colour is left. A mask darkens both.
using PackedPaint = uint32_t;
inline constexpr PackedPaint kUnpainted = 0xff000000;
[[nodiscard]] PackedPaint packPaint(const clay::VertexPaint& paint, const MaterialColours& materials = {});

/// Row of a piece's materials (clay::Channel::material) that is not drawn.
inline constexpr uint8_t kUnseenMaterial = 255;

/// Receives what a layout writes: the GPU's buffers, or a test's arrays.
class UploadSink {
 public:
  virtual ~UploadSink() = default;
  /// The buffers must hold at least this many vertices and indices from now on; what was written stays.
  virtual void reserve(uint32_t vertices, uint32_t indices) = 0;
  virtual void writeVertices(uint32_t first, std::span<const SurfaceVertex> vertices) = 0;
  virtual void writeIndices(uint32_t first, std::span<const uint32_t> indices) = 0;
  /// Of vertices that were written; all others are unpainted from the first call on.
  virtual void writePaint(uint32_t first, std::span<const PackedPaint> paint) { (void)first, (void)paint; }
};

/// The two buffers, shared by all pieces: who has which range.
class BufferRanges {
 public:
  /// Room for that many more, in one growth; or nothing, where only what onFull() gave back may do. Throws Error (work)
  /// past 4 G indices; then nothing has changed.
  void reserve(uint64_t vertices, uint64_t quads, UploadSink& sink);
  [[nodiscard]] uint32_t takeVertices(uint32_t count, UploadSink& sink);
  [[nodiscard]] uint32_t takeQuads(uint32_t count, UploadSink& sink);
  void releaseVertices(uint32_t first, uint32_t count) { vertices_.release(first, count); }
  void releaseQuads(uint32_t first, uint32_t count) { quads_.release(first, count); }
  /// Whether some vertex has paint: then all have, else none costs anything.
  [[nodiscard]] bool painted() const { return painted_; }
  void setPainted() { painted_ = true; }
  /// All of both is free and of no length; nobody may have a range of it.
  void clear() {
    vertices_ = quads_ = RangeAllocator();
    painted_ = false;
  }
  /// From the first growth on the buffers are a quarter larger than asked for: levels of detail and strokes that follow
  /// then fit, where growing for them would take a GPU longer than a picture. Not where memory is short of that.
  void leaveRoom() { leavesRoom_ = true; }
  /// Called where the buffers cannot grow: gives back what can be spared, and says whether that was anything.
  void onFull(std::function<bool()> makeRoom) { makeRoom_ = std::move(makeRoom); }
  [[nodiscard]] uint32_t usedVertices() const { return vertices_.used(); }
  [[nodiscard]] uint32_t usedQuads() const { return quads_.used(); }

 private:
  RangeAllocator vertices_{0}, quads_{0};
  std::function<bool()> makeRoom_;
  bool painted_ = false, leavesRoom_ = false;
};

/// 8×8×8 bricks that are drawn with one command.
inline constexpr int kChunkBits = 3;

struct ChunkDraw {
  struct Range {
    uint32_t firstIndex = 0, indexCount = 0;  ///< Of triangles, some of which may be empty (three equal indices).
    uint32_t triangles = 0;                   ///< Without the empty ones.
    bool made = false;
  };
  Coord chunk;
  Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();  ///< Voxel coordinates that hold all its triangles.
  std::array<Range, kLevels> levels;               ///< Level 0 is always made.
  NormalCone cone;                                 ///< Of level 0.
  bool coned = false;                              ///< The cone was found.
  uint64_t changedIn = 0;                          ///< The picture before which it last changed.

  /// The coarsest level that is made, up to `wanted`.
  [[nodiscard]] const Range& at(int wanted) const {
    while (wanted > 0 && !levels[size_t(wanted)].made) --wanted;
    return levels[size_t(wanted)];
  }
};

/// Follows a clay surface delta by delta. One vertex range and one index range a brick; the index ranges of a chunk lie
/// in one block. Writes only bricks whose mesh changed, and the indices of those whose neighbour's vertices moved. Of a
/// delta whose surface keeps what it replaced, chunks that are replaced as a whole stay in the buffers, as long as they
/// take no more than what is drawn, and not too much of themselves: bringing them back writes nothing of them. One
/// thread.
class SurfaceLayout {
 public:
  /// So many quads of what was replaced are kept at most: 0.7 GB of buffers.
  static constexpr uint64_t kMostKept = uint64_t{1} << 24;
  /// `ranges` and the sinks given later belong together and outlive this.
  explicit SurfaceLayout(BufferRanges& ranges, uint64_t mostKept = kMostKept) : ranges_(&ranges), mostKept_(mostKept) {}
  ~SurfaceLayout() { clear(); }
  SurfaceLayout(const SurfaceLayout&) = delete;
  SurfaceLayout& operator=(const SurfaceLayout&) = delete;

  /// Throws Error (work) when a quad names a vertex that no brick has, for a mesh without normals, or past 4 G indices;
  /// unless whole() still holds, the layout is unusable then.
  void apply(const clay::SurfaceDelta& delta, UploadSink& sink);
  /// Whether masked clay (above half) is left out too, beside what is of the unseen material. Writes the triangles of
  /// painted bricks anew when it changes.
  void hideMasked(bool hide, UploadSink& sink);
  /// Colours of materials. Writes the paint of painted bricks anew when they change.
  void colourMaterials(const MaterialColours& colours, UploadSink& sink);
  void clear();
  [[nodiscard]] bool whole() const { return whole_; }

  [[nodiscard]] const clay::Grid& grid() const { return grid_; }
  /// In order of chunk coordinate. Valid until the next apply().
  [[nodiscard]] const std::vector<ChunkDraw>& draws() const { return draws_; }
  [[nodiscard]] uint64_t triangleCount() const { return 2 * quads_; }
  [[nodiscard]] uint64_t brickCount() const { return bricks_; }
  /// Of what lies in the buffers but is not drawn, since it may come back.
  [[nodiscard]] uint64_t keptQuads() const { return keptQuads_; }
  /// False where there is nothing of that.
  bool dropKept() { return dropKept(0); }
  /// Tight box of all vertices, turned and then moved by `translation`. O(chunks + bricks of changed chunks + vertices
  /// at its sides, where turned).
  [[nodiscard]] Box bounds(const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity(),
                           const Vec3d& translation = Vec3d::Zero()) const;
  /// A box that holds all chunks, in the piece's mm. O(1).
  [[nodiscard]] const Box& looseBounds() const { return loose_; }
  /// The first triangle met along a ray in the piece's mm. O(chunks + bricks near the ray).
  [[nodiscard]] std::optional<RayHit> raycast(const Ray& ray) const;

  // Levels of detail (surface_levels.cpp)

  /// Starts the next picture. Levels are not made for chunks that changed within the last kRestPictures of them: a
  /// stroke pays nothing for them.
  void nextPicture() { ++picture_; }
  [[nodiscard]] bool atRest(size_t at) const { return picture_ >= draws_[at].changedIn + kRestPictures; }
  /// Makes `level` (0 to 4) and the cone of the chunk draws()[at], unless they are made or the chunk is not at rest.
  /// Returns the quads that were read: the cost, about 60 ns each.
  size_t prepareChunk(size_t at, int level, UploadSink& sink);

  // The same, made by a device (render/gpu/level_kernel.h).

  /// Adds what a device has to know to make `level` and the cone of draws()[at], which is at rest; level 0: the cone
  /// alone. Returns the quads that it will read. About 100 ns a brick.
  size_t describeLevel(size_t at, int level, LevelBatch& batch) const;
  /// Takes ranges for what describeLevel() had measured, says in `chunk` where they are, and draws them from now on:
  /// they are to be written before the next picture. Throws Error (work) where there is no memory; nothing has changed.
  void takeLevel(size_t at, int level, const LevelSize& size, LevelChunk& chunk, UploadSink& sink);
  /// Gives all levels of draws()[at] back: they were not written.
  void dropLevels(size_t at) { dropLevels(chunks_.at(draws_[at].chunk)); }

  static constexpr uint64_t kRestPictures = 8;

 private:
  struct BrickEntry {
    clay::BrickMeshPtr mesh;
    std::shared_ptr<const clay::BrickPaint> paint;  // null: none
    uint32_t firstVertex = 0, vertexCapacity = 0;
    uint32_t firstQuad = 0, quadCapacity = 0;  // within the chunk's block
    bool unseen = false;                       // some vertex is
    Vec3f min, max;                            // of the vertices, relative to the brick
  };
  struct ChunkLevel {
    uint32_t firstVertex = 0, vertexCount = 0, firstQuad = 0, quadCount = 0;
  };
  static constexpr size_t kChunkBricks = size_t{1} << (3 * kChunkBits);
  // Bit y·8 + z of word x: a brick of a chunk.
  using BrickBits = std::array<uint64_t, kChunkBricks / 64>;
  struct Chunk {
    Coord coord;
    uint32_t firstQuad = 0;  // of its block
    RangeAllocator quads{0};
    std::array<std::unique_ptr<BrickEntry>, kChunkBricks> bricks;
    size_t held = 0;                                   // of these
    BrickBits drawn{};                                 // bricks with quads
    std::array<ChunkLevel, size_t(kLevels)> levels{};  // above 0
    size_t draw = SIZE_MAX;                            // in draws_
    // Another number whenever its vertices are others: who names them asks whether they are what they were.
    uint64_t stamp = 0;
    mutable std::optional<Box> tight;  // of the vertices that its quads name, in voxels; found when asked for
  };
  struct Base {
    const BrickEntry* brick = nullptr;
    uint32_t first = 0, count = 0;
  };
  using Bases = std::array<Base, 8>;
  using Lower = std::array<const Chunk*, 8>;
  struct ChunkWork;
  class Works;
  class NamedBricks;
  // A chunk that was replaced, with what its indices relied on.
  struct KeptChunk {
    std::map<Coord, Chunk>::node_type node;  // empty: there was none
    ChunkDraw draw;
    uint64_t quads = 0, age = 0;
    std::array<uint64_t, 8> lower{};  // stamps of the chunks lower by n
  };
  // What comes back, and what is left to be written.
  struct Exchange {
    std::vector<clay::BrickMeshPtr> rest;
    std::map<Coord, KeptChunk> back;  // without their nodes, which are in chunks_ again
    bool otherChunks = false;
  };

  [[nodiscard]] Exchange exchangeKept(const clay::SurfaceDelta& delta);
  [[nodiscard]] KeptChunk takeOut(Coord coord);
  void putBack(KeptChunk& kept);  // its node is empty then
  [[nodiscard]] uint64_t stampOf(Coord chunk) const;
  void rewriteAround(const Exchange& exchange, Works& works);
  void releaseChunk(Chunk& chunk);
  bool dropKept(uint64_t most);  // down to so many quads, the oldest first
  void reserveFor(std::span<const clay::BrickMeshPtr> changed, UploadSink& sink);
  void takeMesh(const clay::BrickMeshPtr& mesh, Works& works, UploadSink& sink);
  void takePaint(const clay::SurfaceDelta& delta, Works& works);
  static SurfaceVertex vertexOf(const clay::BrickMesh& mesh, size_t index);
  [[nodiscard]] PackedPaint paintOf(const BrickEntry& brick, size_t index) const;
  void writePaint(const BrickEntry& brick, UploadSink& sink);
  [[nodiscard]] bool unseen(const clay::VertexPaint& paint) const {
    return paint.material == kUnseenMaterial || (hideMasked_ && paint.mask > 127);
  }
  // all of its corners
  [[nodiscard]] bool unseen(const Bases& bases, const std::array<clay::VertexRef, 4>& quad) const;
  void noteUnseen(Works& works);
  bool writeVertices(BrickEntry& brick, UploadSink& sink);  // true when the range is another one
  void placeQuads(Works& works, UploadSink& sink);
  [[nodiscard]] bool rangesFor(ChunkWork& work);
  void repack(ChunkWork& work, UploadSink& sink);
  void writeQuads(const BrickEntry& brick, const Bases& bases, const Chunk& chunk, UploadSink& sink);
  static size_t placeOf(Coord brick);  // in its chunk
  static Coord brickAt(size_t place);  // in its chunk
  static Coord brickAt(const Chunk& chunk, size_t place) { return chunk.coord * (1 << kChunkBits) + brickAt(place); }
  [[nodiscard]] const Chunk* chunkAt(Coord chunk) const;
  [[nodiscard]] const BrickEntry* find(Coord brick) const;
  [[nodiscard]] Lower lowerOf(const Chunk& chunk) const;   // the chunk, and those dx·1 + dy·2 + dz·4 lower, or null
  static Bases basesOf(const Lower& lower, size_t place);  // the bricks that a brick's quads may name
  void dropLevels(Chunk& chunk);
  void updateDraws(const Works& works, const Exchange& exchange);
  const Box& tightBox(const Chunk& chunk) const;
  NormalCone coneOf(const Chunk& chunk) const;
  void makeLevel(Chunk& chunk, int level, UploadSink& sink);
  const ChunkLevel& placeLevel(Chunk& chunk, int level, uint32_t vertices, uint32_t triangles, UploadSink& sink);

  BufferRanges* ranges_;
  uint64_t mostKept_;
  clay::Grid grid_;
  bool hideMasked_ = false;
  MaterialColours materials_;
  std::map<Coord, Chunk> chunks_;
  std::map<Coord, KeptChunk> kept_;
  uint64_t keptQuads_ = 0, stamps_ = 0, age_ = 0;
  uint64_t bricks_ = 0, quads_ = 0, picture_ = kRestPictures;
  bool whole_ = true;
  std::vector<ChunkDraw> draws_;
  Box loose_;
  std::vector<SurfaceVertex> vertexScratch_;
  std::vector<uint32_t> indexScratch_;
  std::vector<PackedPaint> paintScratch_;
};

}  // namespace argil::render
