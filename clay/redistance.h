#pragma once
// Makes a field that an edit left as a bound into a distance again, where the edit was.

#include <span>
#include <vector>

#include "clay/brush_kernels.h"
#include "clay/editor.h"
#include "clay/sampler.h"

namespace argil::clay {

/// Writes brick `coord` and one voxel around it to `padded` (kPaddedSize values).
void gatherPadded(Sampler& field, Coord coord, float* padded) noexcept;

/// Redistances the bricks `coords` (sorted, each once) from the sign changes that they hold, with the field around them
/// as boundary. Voxels beside a sign change keep their bits, so the surface does not move; others keep theirs too where
/// the solution differs by less than kRedistanceTolerance. Missing bricks next to the surface are made. As many Jacobi
/// passes over all of them as the band needs, in a fixed order: the result depends on the field and `coords` alone.
/// Cost: about 4 µs a brick of a band of three voxels. Returns the bricks that changed. Method: NOTES.md,
/// "Redistancing".
///
/// `renew` (one for each of `coords`, or none): where an edit left no distances beside the surface either. There
/// another distance takes the place of what is kept elsewhere, and smaller differences count. What a mask covers whole
/// keeps its bits.
enum class Renew : uint8_t {
  none,
  impossible,  ///< Beside the surface only what exceeds a voxel, as no distance does; differences from kSlopeTolerance on count, as with slopes. For fields of second order.
  slopes,      ///< |phi| over its slope. First order, but repeated it does not wander at edges.
  all,         ///< The distance to the tricubic field's surface, and everything else of second order (renewal.h): for what is made smooth.
};
std::vector<Coord> redistance(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew = {});

/// Passes after which the whole band is solved. Information travels one voxel along an axis a pass; from a frozen voxel
/// to the band's edge a diagonal of `band` voxels takes √3 times as many steps: six at three voxels, where a narrower
/// band does not take fewer.
[[nodiscard]] int passesOf(float band);

/// Voxels. Below it an old value stands: it is often exact where the first-order solution is not, and the second call on
/// the same field changes nothing.
inline constexpr float kRedistanceTolerance = 0.1f;
inline constexpr float kSlopeTolerance = 0.02f;
inline constexpr float kRenewTolerance = 0.002f;

/// For redistance() and renewDistances(): what a mask covers whole is a source for the others and keeps its bits; what was solved takes a brick's place where it differs by the
/// tolerance or more, which is told. `padded`, `u` and `solved` by paddedOffset.
void holdMasked(ChannelSlot mask, const float* padded, uint64_t (&frozen)[kBrickEdge], float* u);
bool settleBrick(Editor& editor, Coord coord, Slot was, const float* solved, float tolerance);

}  // namespace argil::clay
