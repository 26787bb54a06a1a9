#pragma once
// What a print meets layer by layer: islands of clay, hollows that hold a liquid, hollows that nothing leaves.

#include <cstdint>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

/// Clay that begins in the air: the lowest place of it, and how far up it hangs alone before it meets other clay.
struct Island {
  Vec3d at = Vec3d::Zero();  ///< mm, in the piece.
  double aloneMm = 0;
};

/// A hollow that would stay full when the piece stands in the air with +z up.
struct Trap {
  Vec3d at = Vec3d::Zero();  ///< Its lowest place, mm, in the piece.
  double volumeMm3 = 0;      ///< That stays in it.
  double spillsMm = 0;       ///< Height, z in the piece, at which it runs over; nothing where `closed`.
  bool closed = false;       ///< It has no way out at all.
};

struct SliceReport {
  std::vector<Island> islands;  ///< Without those on the lowest layer, that stand on the bed; from below upwards.
  std::vector<Trap> traps;      ///< From below upwards.
  uint64_t runs = 0;            ///< Rows of clay that were looked at: what it cost.
};

/// Voxels as layers along +z of the grid: each is clay or air by the sign of its distance, connected across faces. Two
/// merge trees in one pass upwards (union-find over rows of voxels): a part of the clay that begins without clay below
/// is an island; a part of the air that is not yet connected with the outside when it meets it is a trap, and its
/// volume is what it holds then. Of two traps that meet below their rim one remains, with the volume of both.
/// What has fewer voxels or is lower than these is left out: a flat face that lies in a plane of voxels is crumbs, by
/// the last bits of its distances. Cost: the rows, 12 bytes each and about
/// 50 ns; it follows the surface. Throws Cancelled. Method: Carr, Snoeyink, Axen 2003, of one direction each.
[[nodiscard]] SliceReport sweepSlices(const Version& version, const WorkPart& part, uint64_t leastVoxels = 8,
                                      int leastLayers = 2);

}  // namespace argil::clay
