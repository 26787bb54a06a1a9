#pragma once
// Arithmetic of warps; compiled once per SIMD target. Same rules as brush_kernels.h: equal bits on every target,
// mirrored bits for mirrored arguments.

#include <cmath>
#include <cstdint>
#include <span>

namespace argil::clay {

/// How one image of a stamp moves clay while its tip goes from a to a + d, τ from 0 to 1. Lengths in voxels, relative
/// to the middle of the block of nodes. With e the place from the tip (or from the nearest place of the segment) and w
/// the falloff of |e| / radius, the clay flows with w · (move · d − pull · (e − n (n · e)) + lift · n + spin × e).
struct WarpImage {
  float ax, ay, az;
  float dx, dy, dz;
  float inverseLength2;  ///< 1 / |d|², 0 for a dab.
  float radius, growth;  ///< At a; what b's has more.
  float move, pull, lift;
  float nx, ny, nz;
  float spinX, spinY, spinZ;
  bool fromSegment;
  bool active;  ///< False: it does not reach the block.
};

inline constexpr int kBlockNodes = 512;  // 8×8×8, z fastest

struct NodePlaces {
  float x[kBlockNodes], y[kBlockNodes], z[kBlockNodes];
};

/// Where the clay at each node of a block (`spacing` apart around the middle, a power of two) was before the stamp: the
/// flow followed back in `steps` steps of fourth order. `shape`: as Falloff, with the rims of constant and dome eased
/// so that nothing tears. Places are multiples of 2⁻¹⁶ spacings.
void traceBack(std::span<const WarpImage> images, int shape, int steps, float spacing, NodePlaces& places) noexcept;

/// Displacements at nodes: x, y, z and one that is not used.
struct alignas(16) Displacement {
  float x = 0, y = 0, z = 0, unused = 0;
};

/// out = displacement (tricubic) at `places` + place − node. `window`: (8 + 2 margin)³ nodes, the block's own begin at
/// index `margin`; places may lie up to margin − 2 spacings from their nodes.
void composeDisplacements(const NodePlaces& places, float spacing, const Displacement* window, int margin,
                          Displacement* out) noexcept;

/// Weights of four nodes for a place t (0 to 1) past the second: Lagrange's, exact for cubics. Those of 1 − t are the
/// same ones turned round, to the bit.
void cubicWeights(float t, float (&weights)[4]) noexcept;

/// Separable tricubic refinement of a window of n³ nodes to 10³ places: place i along an axis takes nodes
/// first[axis][i] to first[axis][i] + 3 with weights[axis][i]. `scratch`: 10 n² + 100 n nodes.
void refineDisplacements(const Displacement* window, int n, const int (&first)[3][10], const float (&weights)[3][10][4],
                         Displacement* scratch, Displacement* out) noexcept;

/// A place along an axis, as the voxel below it and how far it is from there (0 to 1); in steps of 2⁻¹⁶, so that
/// mirrored places give mirrored parts to the bit.
struct AxisPlace {
  int base;
  float t;
};
/// `displacement` (−32 to 32 voxels) from `voxel`.
inline AxisPlace placeOf(int voxel, float displacement) noexcept {
  const float whole = std::nearbyint(displacement);
  // Adding 192 leaves multiples of 2⁻¹⁶.
  const float rest = (displacement - whole + 192.0f) - 192.0f;
  const int below = rest < 0 ? -1 : 0;
  return {voxel + static_cast<int>(whole) + below, rest - static_cast<float>(below)};
}

/// A field's values around a place and how it reads there.
struct FieldSample {
  const float* corner;  ///< Of the lowest of 4×4×4 values, z fastest.
  float tx, ty, tz;     ///< From the second value, 0 to 1.
};
struct FieldValue {
  float value, x, y, z;  ///< And the gradient.
};
/// Tricubic (Catmull-Rom) values and gradients; rows `strideY` and slices `strideX` apart.
void sampleField(std::span<const FieldSample> samples, ptrdiff_t strideX, ptrdiff_t strideY, FieldValue* out) noexcept;
/// The same values without gradients, at half of the cost.
void sampleValues(std::span<const FieldSample> samples, ptrdiff_t strideX, ptrdiff_t strideY, float* out) noexcept;

/// Displacements at the voxels of a brick and one around it, each axis for itself: [x][y][z] at (x·10 + y)·10 + z, and
/// room for vectors to end in.
struct MovedVoxels {
  float x[1000 + 16], y[1000 + 16], z[1000 + 16];
};
void splitDisplacements(const Displacement* from, MovedVoxels& out) noexcept;
/// The least and the largest displacement of the brick's own voxels along each axis.
void movedBounds(const MovedVoxels& moved, float (&low)[3], float (&high)[3]) noexcept;

/// A window of voxels: z fastest, its first relative to a brick's own first.
struct VoxelWindow {
  const float* values;
  int x, y, z;
  int sizeY, sizeZ;
};
/// For each voxel of a brick the value at the voxel nearest to the place that it came from, or its own from `now` where
/// it did not move. `doubtful` (a bit y·8 + z of word x): those that came from between two voxels, or from beside one
/// whose value is within `band`; that value says too little. `window`: holds all nearest voxels, less than 2²³.
void nearestValues(const MovedVoxels& moved, const VoxelWindow& window, const float* now, float band, float* phi,
                   uint64_t* doubtful) noexcept;

/// A field and its gradient at the places that the voxels of a brick came from.
struct CameFrom {
  float value[kBlockNodes] = {}, x[kBlockNodes] = {}, y[kBlockNodes] = {}, z[kBlockNodes] = {};
};
/// Distances to second order where a bit of `mask` (y·8 + z of word x) is set: what stands at x is f(x) = φ(x + D(x));
/// with m its slope, n its direction and c its second derivative along n the distance is f/m + c f²/(2 m³). Slopes that
/// are `stretch` times less than the field's, and corrections by more than `bend`, count as those.
void warpedDistances(const CameFrom& field, const MovedVoxels& moved, const uint64_t* mask, float stretch, float bend,
                     float* phi) noexcept;

}  // namespace argil::clay
