#pragma once
// Bodies of a clay that do not touch, and cavities in it.

#include <cstdint>
#include <functional>
#include <vector>

#include "clay/base/job.h"
#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

inline constexpr size_t kMostParts = 10'000;  ///< That splitParts() makes.

// Bodies and cavities are those that the surface bounds: two voxels on one side belong together when they are
// neighbours along an axis, or across a face of four voxels through which the surface lets them pass
// (clay/surface/NOTES.md, "Vertices and quads", 3). Results are made from `version`, in its store, beside whoever edits
// there, and share what they leave as it is. Where a body or a cavity goes, distances around it are made anew. Cost
// follows the bricks. All throw Cancelled.

/// Volumes in mm³ of the bodies (voxels inside, counted), largest first.
[[nodiscard]] std::vector<double> bodyVolumes(const Version& version, Job* job = nullptr);

/// A version for each body, largest first; the version itself when there is one. Throws Error when there are more than
/// kMostParts. Cost: O(bricks · log(bodies)), and that of the distances around each body.
[[nodiscard]] std::vector<Version> splitParts(const Version& version, Job* job = nullptr);

struct Cleaned {
  Version version;
  uint64_t count = 0;    ///< Bodies or cavities that went.
  double volumeMm3 = 0;  ///< Of them together.
};
/// Without the bodies below a volume; the largest always stays.
[[nodiscard]] Cleaned removeCrumbs(const Version& version, double belowMm3, Job* job = nullptr);
/// Cavities that no way leads to from outside become solid.
[[nodiscard]] Cleaned fillVoids(const Version& version, const WorkPart& part = WorkPart(nullptr));

/// Asked for a small body or cavity, with one of its voxels and how many it has: does it go?
using SpeckTest = std::function<bool(Coord voxel, double voxels)>;

struct Specks : Cleaned {
  uint64_t left = 0;  ///< Bodies, or cavities, that stayed.
};
/// Without the bodies (`side` inside) or cavities (outside) of less than so many voxels that the test wants to go; the
/// largest body always stays.
[[nodiscard]] Specks removeSpecks(const Version& version, Tile side, double belowVoxels, const SpeckTest& goes,
                                  const WorkPart& part);

}  // namespace argil::clay
