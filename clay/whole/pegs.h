#pragma once
// A cut whose halves find their place on each other: pegs in the one, holes in the other.

#include <vector>

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

struct PegOptions {
  Vec3d pointMm = Vec3d::Zero(), normal = Vec3d::UnitZ();  ///< The plane of the cut, mm of the piece.
  int pegs = 2;               ///< In each area of the cut, 1 to 8; fewer where there is no room.
  double diameterMm = 0;      ///< 0: as suits each area, 10 mm at most.
  double depthMm = 0;         ///< On either side of the cut; 0: as much as the diameter.
  double clearanceMm = 0.15;  ///< Between a peg and its hole, all around and at its end.
  bool loose = false;  ///< Holes on both sides, and pins as pieces of their own: both halves lie flat in printing.
};

struct Peg {
  Vec3d atMm;  ///< Its middle, in the plane of the cut.
  double diameterMm = 0, depthMm = 0;
};

struct PegPlan {
  std::vector<Peg> pegs;
  int areas = 0, without = 0;  ///< Of the cut, and those of them that have no room for a peg.
};
/// Where cutWithPegs() sets its pegs, without cutting. Throws as that does. Cost: the area of the cut in voxels.
[[nodiscard]] PegPlan planPegs(const Version& version, const PegOptions& options, const WorkPart& part);

struct PeggedHalves {
  Version front, back;  ///< What the normal points to, with holes; the rest, with pegs, or holes too.
  std::vector<Peg> pegs;
  std::vector<Version> pins;   ///< Loose ones in their places, one for each of `pegs`; stores of their own.
  int areas = 0, without = 0;  ///< Of the cut, and those of them that have no room for a peg.
};

/// Cuts by a plane, and sets pegs as far apart as there is room: each has clay around it, on both sides, of at least
/// three tenths of its diameter and two voxels. Ends have a chamfer, so that they find their hole. The front half is in
/// the version's store, the back in its own. Throws Error where the plane does not meet the clay, where no area has
/// room, and for what is out of range; Cancelled. Cost: that of the cut, and the area of the cut in voxels.
[[nodiscard]] PeggedHalves cutWithPegs(const Version& version, const PegOptions& options, const WorkPart& part);

}  // namespace argil::clay
