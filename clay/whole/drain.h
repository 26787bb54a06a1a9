#pragma once
// Holes through which what is in a hollow print runs out, and plugs for them.

#include <vector>

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

struct DrainOptions {
  double diameterMm = 3;     ///< Of the holes: at least four voxels.
  bool vents = true;         ///< The hollows are drained upside down too: air comes in where they are highest.
  bool plugs = false;        ///< What was bored out is given too,
  double clearanceMm = 0.1;  ///< thinner all around by this.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< From the piece to where +z is up.
};

/// mm of the piece.
struct DrainHole {
  Vec3d fromMm, toMm;  ///< From the lowest place of a hollow, or of a part of it, to the outside.
  bool vent = false;
};

struct Drained {
  Version version;
  std::vector<DrainHole> holes;
  std::vector<Version> plugs;  ///< One for each hole where asked for, in its place; stores of their own.
  double leftMm3 = 0;  ///< That stays in the hollows as they stand: less than half a ball of a hole's width each.
  int cups = 0;        ///< Hollows that were open enough before and hold a liquid: they get no hole.
};

/// Every hollow that no way leads into from outside, or ways alone that are narrower than the holes (narrowWaysOut();
/// up to eight of those), gets a hole from its lowest place along the shortest way out that does not lead upwards. Then
/// the layers are looked at again, and where something would stay another hole is bored: so hollows of many legs are
/// emptied one after the other. Made from `version`, in its store. Throws Error where nothing is hollow, for what is
/// out of range and when something stays after sixteen rounds; Cancelled. Cost: narrowWaysOut(), three to four sweeps
/// over the layers, and the bricks that the holes meet; turned, as many resamplings; with narrow ways three offsets
/// more.
[[nodiscard]] Drained drain(const Version& version, const DrainOptions& options, const WorkPart& part);

}  // namespace argil::clay
