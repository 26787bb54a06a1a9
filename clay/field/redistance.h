#pragma once
// Makes a field that an edit left as a bound into a distance again, where the edit was.

#include <span>
#include <vector>

#include "clay/base/parallel.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// Voxels. Below it an old value stands: it is often exact where the first-order solution is not, and the second call
/// on the same field changes nothing.
inline constexpr float kRedistanceTolerance = 0.1f;
/// Voxels. What the first-order solution may exceed an exact distance by beside an edge: with it exact values stand,
/// and values that no surface near supports go.
inline constexpr float kExactTolerance = 1.25f;

/// Redistances the bricks `coords` (sorted, each once) from the sign changes that they hold, with the field around them
/// as boundary. Voxels beside a sign change keep their bits, so the surface does not move; others keep theirs too where
/// the solution differs by less than `how.tolerance`. Missing bricks next to the surface are made. As many Jacobi
/// passes over all of them as the band needs, in a fixed order: the result depends on the field and `coords` alone.
/// Cost: about 4 µs a brick of a band of three voxels. Returns the bricks that changed. Method: NOTES.md,
/// "Redistancing".
///
/// `renew` (one for each of `coords`, or none): where an edit left no distances beside the surface either. There
/// another distance takes the place of what is kept elsewhere, and smaller differences count. What a mask covers whole
/// keeps its bits.
enum class Renew : uint8_t {
  none,
  /// Beside the surface only what exceeds a voxel, as no distance does; differences from kSlopeTolerance on count, as
  /// with slopes. For fields of second order.
  impossible,
  slopes,  ///< |phi| over its slope. First order, but repeated it does not wander at edges.
  /// The distance to the tricubic field's surface, and everything else of second order (renewal.h): for what is made
  /// smooth.
  all,
};
/// Bricks that redistance() solves at once.
inline constexpr size_t kSolvedAtOnce = 1024;
struct Redistancing {
  /// Without `renew`, what an old value may differ from the solution by and stand; with it the same share of
  /// kSlopeTolerance and kRenewTolerance as this is of kRedistanceTolerance.
  float tolerance = kRedistanceTolerance;
  int passes = 0;  ///< At most so many; 0: as many as the band needs.
  /// More bricks are solved part by part, each with those around it from which something may come, so that memory (5 KB
  /// a brick) does not follow their count.
  size_t atOnce = kSolvedAtOnce;
  [[nodiscard]] int passesOf(float band) const;
  [[nodiscard]] float toleranceOf(Renew renew) const;
};
/// The result depends neither on `threads` nor on `how.atOnce`.
std::vector<Coord> redistance(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew = {},
                              int threads = 1, const Redistancing& how = {});

/// A brick that redistancing changed, not linked yet.
struct SettledBrick {
  FloatBrick* brick;
  bool inBand;
};
/// Links them; their coordinates.
std::vector<Coord> linkSettled(Editor& editor, std::span<const SettledBrick> settled);

/// redistance() for whoever does something else between its parts: each solved from the same field, and linked when he
/// likes.
struct RedistancePart {
  std::vector<Coord> bricks;  ///< Sorted.
  std::vector<Renew> renew;
  std::vector<uint8_t> wanted;  ///< 0: comes in as a boundary alone. None: all are wanted.
  bool all = false;             ///< Some brick, of whatever part, has Renew::all.
};
[[nodiscard]] std::vector<RedistancePart> redistanceParts(std::vector<Coord> coords, std::vector<Renew> renew,
                                                          float band, const Redistancing& how);
/// `field`: the clay before the first part.
[[nodiscard]] std::vector<SettledBrick> redistancePart(const Sampler& field, Editor& editor, const RedistancePart& part,
                                                       int threads, const Redistancing& how);

/// Passes after which the whole band is solved. Information travels one voxel along an axis a pass; from a frozen voxel
/// to the band's edge a diagonal of `band` voxels takes √3 times as many steps: six at three voxels, where a narrower
/// band does not take fewer.
[[nodiscard]] int passesOf(float band);

/// Voxels.
inline constexpr float kSlopeTolerance = 0.02f;
inline constexpr float kRenewTolerance = 0.002f;

/// As redistance() with no `renew`, but of bricks from `coords` those for which `wanted` is not 0 are given back
/// instead of linked, so that others can be solved from the same field.
std::vector<SettledBrick> solveDistances(Editor& editor, std::span<const Coord> coords, std::span<const uint8_t> wanted,
                                         int threads);

/// For redistance() and renewDistances(): what a mask covers whole is a source for the others and keeps its bits; what
/// was solved takes a brick's place where it differs by the tolerance or more. `padded`, `u` and `solved` by
/// paddedOffset.
void holdMasked(ChannelSlot mask, const float* padded, uint64_t (&frozen)[kBrickEdge], float* u);
/// `visit(begin, end)` for ranges of `count` bricks, from several threads where that is worth it; and `visit(i)` for
/// each.
template <class Visit>
void forBrickRanges(size_t count, int threads, const Visit& visit) {
  constexpr size_t kParallelFrom = 128, kAtOnce = 32;
  parallelBlocks(count, count >= kParallelFrom ? threads : 1, visit, kAtOnce);
}
template <class Visit>
void forEachBrickOf(size_t count, int threads, const Visit& visit) {
  forBrickRanges(count, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) visit(i);
  });
}
/// `settle(i, brick)` fills brick i from `coords` where it is wanted (all, if `wanted` is empty) and says what changed.
template <class Settle>
std::vector<SettledBrick> settleBricks(Editor& editor, std::span<const Coord> coords, std::span<const uint8_t> wanted,
                                       int threads, const Settle& settle) {
  std::vector<FloatBrick*> bricks(coords.size());
  std::vector<BrickChange> changes(coords.size());
  for (size_t i = 0; i < coords.size(); ++i)
    bricks[i] = wanted.empty() || wanted[i] ? editor.newBrick(coords[i]) : nullptr;
  forEachBrickOf(coords.size(), threads, [&](size_t i) {
    if (bricks[i]) changes[i] = settle(i, *bricks[i]);
  });
  std::vector<SettledBrick> settled;
  for (size_t i = 0; i < coords.size(); ++i) {
    if (!bricks[i]) continue;
    if (changes[i].changed)
      settled.push_back({bricks[i], changes[i].inBand});
    else
      editor.recycle(bricks[i]);
  }
  return settled;
}

}  // namespace argil::clay
