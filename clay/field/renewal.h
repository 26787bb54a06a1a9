#pragma once
// Distances of second order from a field that is none. This module's own.

#include <span>
#include <vector>

#include "clay/field/jacobi_solver.h"
#include "clay/field/redistance.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// Bricks that get distances together: beside the surface those to the surface of the tricubic field, found by
/// following it to its foot; from there |∇u| = 1 upwind and of second order, so that what a stroke leaves does not know
/// the grid's axes. As JacobiSolver: one at a time on a thread, begin() for each brick from any thread, run() once.
/// Method: NOTES.md, "Redistancing".
class Renewal {
 public:
  /// `coords`: sorted, each once.
  Renewal(std::span<const Coord> coords, float band, int threads) : band_(band), solver_(coords, threads) {}
  /// `broad`: the field of brick `i` and four voxels around it. What `mask` covers whole keeps its distance, and so
  /// does what is nearer to the surface than `known`.
  void begin(size_t i, const float* broad, Renew how, ChannelSlot mask = {}, float known = 0);
  /// The same where isAmongTiles().
  void beginUnknown(size_t i, Tile tile);
  void run(const Redistancing& options = {});
  /// The 512 distances of brick `i` without their signs, `band` at most; and those of two voxels around it too, by
  /// wideOffset, with signs and beyond the band too.
  void sizes(size_t i, float* out) const;
  void around(size_t i, float* out) const { solver_.around(i, out); }

 private:
  float band_;
  JacobiSolver<2> solver_;
};

/// Whether a brick, which is `slot`, and all that it shares a face with are tiles of one kind, so that nothing is known
/// there yet.
[[nodiscard]] bool isAmongTiles(Sampler& field, Coord brick, Slot slot);

/// What redistancePart() does where a `renew` is Renew::all.
std::vector<SettledBrick> renewDistances(const Sampler& before, Editor& editor, std::span<const Coord> coords,
                                         std::span<const Renew> renew, std::span<const uint8_t> wanted, int threads,
                                         const Redistancing& options);

}  // namespace argil::clay
