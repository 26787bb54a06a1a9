#pragma once
// Haptic rendering of a recorded hand path: what `argil feel` does.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/store/version.h"
#include "engine/session/run.h"
#include "haptics/devices/hand_path.h"
#include "haptics/scene/scene.h"

namespace argil::engine {

struct FeelOptions {
  std::string contact = "proxy";  ///< One of haptics::contactNames().
  std::string device = "touch";   ///< Whose limits hold (haptics/devices/sheets.h).
  double rateHz = 1000;           ///< 100 to 8000.
  /// False: the hand follows the path whatever the force, positions are exact, and forces are those of the contact
  /// alone. True: a simulated hand that wants to follow it holds the simulated device, in closed loop through the whole
  /// servo tick.
  bool freeHand = false;
  Job* job = nullptr;
};

struct FeelTick {
  double timeS = 0;
  Vec3d hand = Vec3d::Zero(), proxy = Vec3d::Zero();  ///< World mm.
  Vec3d force = Vec3d::Zero();                        ///< On the hand, N.
  double depthMm = 0;
  int planes = 0;        ///< Active.
  uint32_t flags = 0;    ///< haptics::TickFlag.
  double computeUs = 0;  ///< Of the contact, or with a free hand of the whole tick.
};

/// Of all ticks.
struct FeelSummary {
  uint64_t ticks = 0, touching = 0, incomplete = 0, clamped = 0;
  double peakN = 0, deepestMm = 0;
  double jumpP50 = 0, jumpP99 = 0, jumpMax = 0;  ///< Change of force between two touching ticks, % of peakN.
  double jumpRms = 0;
  Timing compute;
  std::string fault;  ///< Why forces were stopped; empty when they were not.
};

struct FeelRun {
  std::vector<FeelTick> ticks;
  FeelSummary summary;
};

/// Feels `scene` along `path`, which is in the world's frame, in virtual time: the same every time but for computeUs.
/// Throws Error for a bad scene, option or path (longer than kLongestFeelS), Cancelled.
[[nodiscard]] FeelRun feel(const haptics::Scene& scene, const haptics::HandPath& path, const FeelOptions& options = {});
inline constexpr double kLongestFeelS = 1800;

/// A row a tick: `t_s,x_mm,y_mm,z_mm,fx_n,fy_n,fz_n,proxy_x_mm,proxy_y_mm,proxy_z_mm,planes,depth_mm,flags,compute_us`.
[[nodiscard]] std::string feelCsv(const FeelRun& run);

/// How a path of another place and size is brought to the clay, in this order.
struct PathPlacement {
  bool fit = false;  ///< Centred on the clay, and scaled down until it is no larger.
  Vec3d moveMm = Vec3d::Zero();
  std::optional<Vec3d> onto = {};  ///< Laid onto the surface along this direction (engine/text/lay.h),
  double pressMm = 1;              ///< the ball's front this deep below it.
};
/// Throws Error when nothing of the path meets the clay.
[[nodiscard]] haptics::HandPath placePath(const haptics::HandPath& path, const clay::Version& version, double radiusMm,
                                          const PathPlacement& placement);

}  // namespace argil::engine
