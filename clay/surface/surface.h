#pragma once
// The clay's surface as quads, brick by brick, re-extracted only where the clay changed.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "clay/mesh/triangle_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

/// A vertex as a quad names it: bits 0–12 its index in a brick's vertices, bits 13, 14, 15 whether that brick is one
/// lower in x, y, z than the quad's own.
using VertexRef = uint16_t;
inline constexpr int kVertexRefBits = 13;
inline constexpr VertexRef kVertexRefIndex = (1u << kVertexRefBits) - 1;

/// Where the vertices stand; topology is the same.
enum class Grade : uint8_t {
  draft,  ///< At the mean of a cell's edge crossings: creases are cut off by up to half a voxel.
  crisp,  ///< On creases of 25° and more, found by a quick look: for what is seen at once. Method: crisp_edges.md.
  fine,   ///< On creases and corners where the field has some; as the draft elsewhere. Method: sharp_features.md.
};

/// A unit vector in 32 bits: octahedral, within 0.006°. The lowest bit of `v`: on a crease, between its faces' normals.
struct PackedNormal {
  int16_t u = 0, v = 0;
  /// Of any vector but zero: its length does not matter.
  static PackedNormal pack(const Vec3f& direction) noexcept;
  [[nodiscard]] Vec3f unpack() const noexcept;
  friend bool operator==(PackedNormal, PackedNormal) = default;
};

/// The part of the surface that one brick coordinate owns: the vertices of its 8×8×8 cells (cell v has the corners v to
/// v + 1) and a quad for each voxel edge with a sign change whose lower voxel is in the brick. Immutable once handed
/// out.
struct BrickMesh {
  Coord brick;                ///< Brick coordinate; positions are relative to voxel brick · 8.
  uint64_t serial = 0;        ///< Names this content for good within its Surface.
  uint64_t vertexSerial = 0;  ///< The same for positions and normals: meshes that share it differ in quads alone.
  std::span<const Vec3f> positions;       ///< In voxels, 0 to 8 along each axis; by kVertexReach beyond on creases.
  std::span<const PackedNormal> normals;  ///< One a vertex, from the field, outwards; empty when not asked for.
  std::span<const std::array<VertexRef, 4>> quads;  ///< Counter-clockwise from outside; split along corners 0 and 2.
};

using BrickMeshPtr = std::shared_ptr<const BrickMesh>;

struct BrickPaint;  // clay/surface/vertex_channels.h

/// What update() changed: for the renderer. A brick whose surface is gone comes as a mesh without quads and vertices.
struct SurfaceDelta {
  Grid grid;
  std::vector<BrickMeshPtr> changed;  ///< Each brick coordinate at most once, in the order of the tree.
  /// What vertices show of colour, material and mask, where that or the mesh changed; a mesh with other vertices that
  /// has none here has nothing set. Each brick coordinate at most once.
  std::vector<std::shared_ptr<const BrickPaint>> painted;
  /// The surface keeps the meshes that this replaced: a later delta may bring the same ones back.
  bool keepsBefore = false;
};

/// A part of a surface as triangles: 64 voxels along x.
struct SurfaceSlab {
  uint32_t firstVertex = 0;                        ///< Index of the first of `positions` in the whole.
  std::vector<Vec3d> positions;                    ///< World mm.
  std::vector<std::array<uint32_t, 3>> triangles;  ///< By vertices of this slab and of the one before.
};
enum class SlabOf : uint8_t { vertices, triangles, both };  ///< What of a slab is filled in.

/// The surface of one clay model, always closed and 2-manifold, following its versions. One thread calls update(); the
/// meshes handed out may be read anywhere. Method, tables and the rule for ambiguous faces: NOTES.md.
class Surface {
 public:
  /// `normals` false leaves them out.
  explicit Surface(bool normals = true, Grade grade = Grade::draft);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  /// Brings the surface to `version` and tells what changed. Cost follows the difference from the version before (all
  /// of the model the first time, or after another store or grid); the result does not depend on it, nor on `threads`
  /// (1 to 64).
  ///
  /// `keepBefore`: the meshes that this replaces are kept; what is kept in all takes no more memory than the larger of
  /// the two surfaces, and what is oldest goes first. An update to the very version before, and from there to this one
  /// again, then costs a look at each of these bricks. Its meshes are the same, with their serials.
  SurfaceDelta update(const Version& version, int threads = 1, bool keepBefore = false);
  /// Whether update(version) takes meshes that are kept, and no paint has to be found for them.
  [[nodiscard]] bool keeps(const Version& version) const;

  [[nodiscard]] const Version& version() const;
  [[nodiscard]] uint64_t vertexCount() const;
  [[nodiscard]] uint64_t quadCount() const;
  /// Memory of its meshes and tables, those that are kept for going back among them; so much of it from the heap.
  struct Usage {
    uint64_t bytes = 0, heapBytes = 0;
  };
  [[nodiscard]] Usage usage() const;
  /// The mesh that a brick coordinate owns, or null.
  [[nodiscard]] const BrickMesh* find(Coord brick) const;
  /// Every brick mesh that has quads or vertices, in order of the tree.
  void forEach(const std::function<void(const BrickMesh&)>& visit) const;
  /// Hash of all that forEach visits, serials apart.
  [[nodiscard]] uint64_t hash() const;
  /// One welded mesh in world mm. O(model).
  [[nodiscard]] TriangleMesh toMesh() const;
  /// The same mesh piece by piece, in its order: for surfaces that have no room beside themselves. The slab is used
  /// again after each call.
  void forEachSlab(SlabOf what, const std::function<void(const SurfaceSlab&)>& visit) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::clay
