#include "haptics/touch_bench.h"

#include <cmath>

#include "clay/error.h"
#include "haptics/bare_loop.h"
#include "haptics/clock.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"

namespace argil::haptics {

TickFigures measureTicks(const Scene& scene, const HandPath& path, uint64_t ticks) {
  scene.check();
  if (scene.pieces.empty()) throw Error("bench touch: the scene holds no clay");
  Published<Scene> published;
  published.publish(std::make_unique<const Scene>(scene));
  TickFigures figures;
  figures.radiusVoxels = scene.tool.radiusMm / scene.pieces[0].version.grid().voxelMm;
  Servo::Options options;
  SimulatedDevice::Options device;
  device.prescribed = true;
  device.encoderSteps = false;
  device.fineStepS = 1e-3;  // One step a tick: the device must not be what is measured.
  for (int round = 0; round < 2; ++round) {
    SimulatedDevice stylus(deviceSheet("omega3"), path, device);
    Servo servo(stylus, published, options);
    servo.runVirtual(ticks);
    figures.compute = servo.statistics().compute;
    figures.ticks = servo.statistics().ticks;
    figures.touching = servo.statistics().touching;
    figures.peakForceN = servo.statistics().peakForceN;
  }
  return figures;
}

HandPath glideOnBall(const Vec3d& centreMm, double ballRadiusMm, double toolRadiusMm, double depthMm, double turns, double seconds) {
  const double r = ballRadiusMm + toolRadiusMm - depthMm;
  // Not along a plane of voxels: the axis is askew.
  const Vec3d axis = Vec3d(0.2, 0.3, 1).normalized();
  const Vec3d above = axis.unitOrthogonal();
  const Vec3d start = centreMm + above * r;
  // Comes down from free space first, or the start would be refused as out of range.
  return HandPath::line(centreMm + above * (r + depthMm + 2), start, 0.2)
      .then(HandPath::circle(centreMm, start, axis, turns, seconds, 0, 0.002));
}

PacedFigures measurePaced(Servo& servo, double seconds, const std::function<void(double)>& meanwhile) {
  constexpr int64_t kEveryNs = 2'000'000;
  PacedFigures figures;
  BareLoop bare(servo.rateHz());
  figures.grant = servo.start();
  bare.start();
  const int64_t begin = nowNs();
  for (int64_t next = begin; double(next - begin) < seconds * 1e9; next = std::max(next + kEveryNs, nowNs())) {
    sleepUntilNs(next);
    if (meanwhile) meanwhile(double(nowNs() - begin) * 1e-9);
  }
  servo.stop();
  bare.stop();
  figures.bareLateness = bare.lateness();
  return figures;
}

}  // namespace argil::haptics
