#pragma once
// Hollows that get an infill.

#include "clay/base/work_part.h"
#include "clay/field/infill.h"
#include "clay/store/version.h"

namespace argil::clay {

struct HollowFilling {
  Infill kind = Infill::gyroid;
  double density = 0.15;                               ///< Of what is filled, 0.02 to 0.8.
  double wallMm = 1;                                   ///< Of walls, or across bars; at least two voxels.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< From the piece to where +z is up.
};

struct FilledHollows {
  Version version;
  double cellMm = 0;     ///< Of the pattern.
  double hollowMm3 = 0;  ///< Of the hollows before.
  double density = 0;    ///< That was reached: of the clay that came in.
};

/// Every hollow that no way leads into from outside gets an infill that joins its walls; the outer surface stays
/// where it is. The cell follows from wall and density, by the very hollows. Made from `version`, in its store. Throws
/// Error where nothing is hollow and for what is out of range, Cancelled. Cost: the surface of the infill, about as a
/// join.
[[nodiscard]] FilledHollows fillHollows(const Version& version, const HollowFilling& filling, int threads,
                                        const WorkPart& part);

}  // namespace argil::clay
