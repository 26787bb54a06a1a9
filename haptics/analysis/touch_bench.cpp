#include "haptics/analysis/touch_bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/threads/bare_loop.h"

namespace argil::haptics {

TickFigures measureTicks(const Scene& scene, const HandPath& path, uint64_t ticks) {
  scene.check();
  if (scene.pieces.empty() && scene.parts.empty()) throw Error("bench touch: the scene holds neither clay nor a part");
  Published<Scene> published;
  published.publish(std::make_unique<const Scene>(scene));
  TickFigures figures;
  figures.radiusVoxels = scene.tool.radiusMm / (scene.pieces.empty() ? scene.parts[0].mesh->resolutionMm()
                                                                     : scene.pieces[0].version.grid().voxelMm);
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

HandPath glideOnBall(const Vec3d& centreMm, double ballRadiusMm, double toolRadiusMm, double depthMm, double turns,
                     double seconds) {
  const double r = ballRadiusMm + toolRadiusMm - depthMm;
  // Not along a plane of voxels: the axis is askew.
  const Vec3d axis = Vec3d(0.2, 0.3, 1).normalized();
  const Vec3d above = axis.unitOrthogonal();
  const Vec3d start = centreMm + above * r;
  // Comes down from free space first, or the start would be refused as out of range.
  return HandPath::line(centreMm + above * (r + depthMm + 2), start, 0.2)
      .then(HandPath::circle(centreMm, start, axis, turns, seconds, 0, 0.002));
}

clay::TriangleMesh icosphere(double radiusMm, int level) {
  clay::TriangleMesh mesh;
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  for (const double one : {1.0, -1.0})
    for (const double g : {golden, -golden})
      for (int axis = 0; axis < 3; ++axis) {
        Vec3d p = Vec3d::Zero();
        p[axis] = one;
        p[(axis + 1) % 3] = g;
        mesh.positions.push_back(radiusMm * p.normalized());
      }
  // Its faces: three corners, each two as near as corners get.
  const double edge = 1.1 * radiusMm * 2 / std::sqrt(golden * golden + 1);
  for (uint32_t a = 0; a < 12; ++a)
    for (uint32_t b = a + 1; b < 12; ++b)
      for (uint32_t c = b + 1; c < 12; ++c) {
        const Vec3d &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        if ((p - q).norm() > edge || (q - r).norm() > edge || (r - p).norm() > edge) continue;
        if ((q - p).cross(r - p).dot(p) > 0)
          mesh.triangles.push_back({a, b, c});
        else
          mesh.triangles.push_back({a, c, b});
      }
  for (int l = 0; l < level; ++l) {
    std::unordered_map<uint64_t, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [it, fresh] = middles.try_emplace(uint64_t{std::min(a, b)} << 32 | std::max(a, b),
                                                   static_cast<uint32_t>(mesh.positions.size()));
      if (fresh) mesh.positions.push_back(radiusMm * (mesh.positions[a] + mesh.positions[b]).normalized());
      return it->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    finer.reserve(4 * mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

Scene partScene(double radiusMm, int level, double toolRadiusMm) {
  Scene scene;
  Part part;
  part.mesh = std::make_shared<const PartMesh>(icosphere(radiusMm, level));
  part.pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  scene.parts.push_back(std::move(part));
  scene.tool.radiusMm = toolRadiusMm;
  scene.check();
  return scene;
}

Histogram measureNearest(const PartMesh& ball, double radiusMm, double heightMm, double stepMm, uint64_t calls) {
  const Vec3d axis = Vec3d(0.2, 0.3, 1).normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const double radius = radiusMm + heightMm, reach = heightMm + 4 * ball.resolutionMm();
  Histogram times;
  for (int round = 0; round < 2; ++round) {
    times.clear();
    uint32_t hint = PartMesh::kNone;
    for (uint64_t i = 0; i < calls; ++i) {
      // Great circles that wander, so that no place is met twice.
      const double turn = double(i) * stepMm / radius, tilt = 0.3 * std::sin(0.37 * turn);
      const Vec3d p = radius * (std::cos(tilt) * (std::cos(turn) * u + std::sin(turn) * v) + std::sin(tilt) * axis);
      const int64_t begin = nowNs();
      hint = ball.nearest(p, reach, hint).triangle;
      times.add(nowNs() - begin);
    }
  }
  return times;
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
