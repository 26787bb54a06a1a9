#pragma once
// What stands in the way of printing a piece, before a slicer says it.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clay/base/job.h"
#include "clay/field/necks.h"
#include "clay/field/slice_sweep.h"
#include "clay/store/version.h"
#include "clay/surface/wall_map.h"
#include "haptics/base/pose.h"

namespace argil::engine {

/// A way to print, with the limits that its users go by: where to begin, not what a machine promises.
struct PrintProcess {
  std::string_view id, name;
  double wallMm = 1;            ///< Thinner walls break or are not made.
  double gapMm = 0.5;           ///< Narrower gaps are filled.
  double overhangDegrees = 45;  ///< From the horizontal: faces that look down and are flatter need supports.
  bool needsSupport = true;     ///< Overhangs and islands count.
  bool holdsLiquid = true;      ///< Traps count, closed ones in any process: what is in there stays in there.
  double outletMm = 0;          ///< What is in a hollow does not leave it by narrower ways; 0: not looked for.
  Vec3d bedMm = {250, 210, 210};
};
inline constexpr size_t kPrintProcesses = 5;
[[nodiscard]] std::span<const PrintProcess, kPrintProcesses> printProcesses();
/// Throws Error that lists them.
[[nodiscard]] const PrintProcess& printProcess(std::string_view id);

inline constexpr double kLeastPrintLimitMm = 0.001, kMostPrintLimitMm = 1000;
/// A process by its id, with limits of one's own.
struct PrintWish {
  std::string process;
  std::optional<double> wallMm, gapMm, outletMm;  ///< kLeastPrintLimitMm to kMostPrintLimitMm.
  friend bool operator==(const PrintWish&, const PrintWish&) = default;
};
/// Throws Error for a process that there is none of.
[[nodiscard]] PrintProcess printProcess(const PrintWish& wish);

struct PrintReport {
  Vec3d lowMm = Vec3d::Zero(), highMm = Vec3d::Zero();  ///< Of the piece as it stands.
  bool fits = false;                                    ///< On the bed, turned by a quarter or not.
  clay::ThinParts walls, gaps;                          ///< Beyond the limits of the process.
  double overhangMm2 = 0;  ///< Area that looks down and is flatter than the limit, without what stands on the bed.
  bool overhangs = false;  ///< A patch of that area needs support: more than 0.25 mm² and 4 voxels².
  clay::SliceReport slices;
  std::vector<clay::Neck> necks;  ///< Of hollows whose ways out are narrower than the limit, the narrowest first.
  /// How many kinds of trouble there are.
  [[nodiscard]] int troubles(const PrintProcess& process) const;
};

/// Looks at a piece as it stands, +z up. Layers of a piece that is turned are those of a resampled one. Places are in
/// the world. `job` may be null. Throws Cancelled; Error for a piece without clay, and for limits of more than 256
/// voxels. Cost follows the surface: about 0.2 s for a million triangles on two threads,
/// and as much for ways out.
[[nodiscard]] PrintReport checkPrint(const clay::Version& version, const haptics::Pose& pose,
                                     const PrintProcess& process, Job* job);

}  // namespace argil::engine
