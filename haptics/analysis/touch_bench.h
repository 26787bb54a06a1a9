#pragma once
// What touch costs, for `argil bench touch`, the demo's table and tests: measured by the code that is used.

#include <functional>

#include "haptics/base/histogram.h"
#include "haptics/devices/hand_path.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/servo/servo.h"

namespace argil::haptics {

/// Ticks back to back in virtual time, warm.
struct TickFigures {
  Histogram compute;  ///< Of a whole tick: device, contact, safety, hand-offs.
  uint64_t ticks = 0, touching = 0;
  double radiusVoxels = 0;  ///< Of the tool on the scene's first piece, else in resolutions of its first part.
  double peakForceN = 0;
};

/// Runs `ticks` ticks at 1 kHz with the stylus on `path` (world frame, whatever the force), twice, and measures the
/// second time. Throws Error for a bad scene or an empty path.
[[nodiscard]] TickFigures measureTicks(const Scene& scene, const HandPath& path, uint64_t ticks);

/// A path that circles on a ball of clay, `depthMm` deep, as seen from the tool's centre: `turns` great circles in
/// `seconds`.
[[nodiscard]] HandPath glideOnBall(const Vec3d& centreMm, double ballRadiusMm, double toolRadiusMm, double depthMm,
                                   double turns, double seconds);

/// A ball of 20 · 4^level triangles (level 8: 1.3 million) around zero, corners on the sphere. `level` 0 to 10.
[[nodiscard]] clay::TriangleMesh icosphere(double radiusMm, int level);

/// A scene of that ball as a part, at an odd pose, without clay.
[[nodiscard]] Scene partScene(double radiusMm, int level, double toolRadiusMm);

/// PartMesh::nearest() alone, as contact calls it: for a place `heightMm` over an icosphere's surface, gliding by
/// `stepMm` from call to call around it, each with the triangle of the last answer as hint. Twice; the second time is
/// measured.
[[nodiscard]] Histogram measureNearest(const PartMesh& ball, double radiusMm, double heightMm, double stepMm,
                                       uint64_t calls);

/// A paced run with a bare sleep loop beside it in the same seconds.
struct PacedFigures {
  RealtimeGrant grant;
  Histogram bareLateness;  ///< Of the bare loop; the servo's own figures are in its statistics().
};

/// Starts `servo` and a BareLoop, calls `meanwhile` every 2 ms in the calling thread (the edit thread's place) for
/// `seconds`, stops both.
PacedFigures measurePaced(Servo& servo, double seconds, const std::function<void(double elapsedS)>& meanwhile = {});

}  // namespace argil::haptics
