#pragma once
// Walls that are too thin, gaps that are too narrow and faces that would stick in a mould, as colours of the surface
// while the clay is worked on.

#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include <Eigen/Geometry>

#include "clay/mould/pull_map.h"
#include "clay/store/brick_set.h"
#include "clay/surface/surface.h"
#include "clay/surface/vertex_channels.h"
#include "clay/surface/wall_map.h"

namespace argil::engine {

/// What has to come off a mould of two halves: nothing is undercut, and faces are so steep against the pull.
struct DraftLimit {
  Vec3d pull = Vec3d::UnitZ();  ///< Of the document's axes, of length 1. Both ways are the same.
  double degrees = 2;           ///< Above 0, to 45.
  friend bool operator==(const DraftLimit&, const DraftLimit&) = default;
};

/// What is coloured, mm; 0, or none: not looked for.
struct CheckLimits {
  double wallMm = 0, gapMm = 0;
  std::optional<DraftLimit> draft = {};
  friend bool operator==(const CheckLimits&, const CheckLimits&) = default;
};

/// Colours over those of the clay: walls red where there is nothing left to yellow at the limit, gaps violet to light
/// blue, and where neither is, undercuts magenta, and faces along the pull dark green to light green at the draft that
/// is asked for. Follows one surface; one thread. Limits of more than 256 voxels are looked for up to that.
class CheckPaint {
 public:
  explicit CheckPaint(const CheckLimits& limits);
  /// How the clay is turned in the document. Whether follow() has something to do for that.
  [[nodiscard]] bool turn(const Eigen::Quaterniond& rotation);
  /// After `surface` changed by `delta`, from all of it on: measures what that may have changed, and adds to
  /// delta.painted each brick that shows or showed something thin. Cost: WallMap::follow(), PullMap::follow().
  void follow(const clay::Surface& surface, clay::SurfaceDelta& delta, int threads);

 private:
  struct Found {
    std::span<const float> walls, gaps;
    std::span<const uint8_t> undercut;
  };
  void paint(const clay::BrickMesh& mesh, const Found& found, std::vector<clay::VertexPaint>& vertices) const;
  [[nodiscard]] bool anyIn(const clay::BrickMesh& mesh, const Found& found) const;

  CheckLimits limits_;
  std::optional<clay::WallMap> map_;
  std::optional<clay::PullMap> pulled_;
  float wall_ = 0, gap_ = 0;     // voxels
  Vec3f pull_ = Vec3f::UnitZ();  // in the clay's axes
  float draft_ = 0;              // cosine of a face with too little draft against its pull, at most; 0: none
  bool turned_ = false;          // all bricks are to be looked at
  std::unordered_set<Coord, clay::CoordHash> shown_;
};

}  // namespace argil::engine
