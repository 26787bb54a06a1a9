#include "engine/print/print_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "clay/base/error.h"
#include "clay/surface/surface.h"
#include "clay/whole/resample.h"

namespace argil::engine {

namespace {

// Limits as print services and makers of machines give them for a part of a hand's size.
const std::array<PrintProcess, 5> kProcesses{{
    {"sla", "resin (SLA)", 1, 0.5, 20, true, true, {145, 145, 185}},
    {"fdm", "filament (FDM)", 0.8, 0.4, 45, true, false, {250, 210, 210}},
    {"sls", "powder (SLS)", 0.8, 0.6, 0, false, true, {300, 300, 300}},
    {"metal", "metal powder (SLM)", 0.5, 0.4, 45, true, true, {250, 250, 300}},
    {"casting", "wax for casting", 0.6, 0.4, 20, true, true, {120, 68, 150}},
}};

constexpr double kBedVoxels = 3;  // from the lowest place: what stands on the bed

}  // namespace

std::span<const PrintProcess> printProcesses() {
  return kProcesses;
}

const PrintProcess& printProcess(std::string_view id) {
  std::string known;
  for (const PrintProcess& each : kProcesses) {
    if (each.id == id) return each;
    known += (known.empty() ? "" : ", ") + std::string(each.id);
  }
  throw Error(fmt::format("there is no way to print called '{}': known are {}", id, known));
}

int PrintReport::troubles(const PrintProcess& process) const {
  const bool thin = walls.shareThinner(process.wallMm) > 0, narrow = gaps.shareThinner(process.gapMm) > 0;
  const auto closed =
      std::any_of(slices.traps.begin(), slices.traps.end(), [](const clay::Trap& trap) { return trap.closed; });
  return thin + narrow + !fits + (process.needsSupport && overhangMm2 > 0) +
         (process.needsSupport && !slices.islands.empty()) + (closed || (process.holdsLiquid && !slices.traps.empty()));
}

PrintReport checkPrint(const clay::Version& given, const haptics::Pose& pose, const PrintProcess& process, Job* job) {
  const clay::WorkPart part(job);
  clay::Version version = given;
  Vec3d shift = pose.translation;
  if (pose.rotation.angularDistance(Eigen::Quaterniond::Identity()) > 1e-9) {
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() = pose.rotation.toRotationMatrix();
    version = clay::resample(given, given.grid(), turn, 0, part.part(0, 0.3));
  }
  clay::Surface surface(false);
  surface.update(version, 2);
  clay::TriangleMesh mesh = surface.toMesh();
  if (mesh.triangles.empty()) throw Error("it has no clay");
  PrintReport report;
  Vec3d low = mesh.positions[0], high = low;
  for (const Vec3d& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);

  const double flat = std::cos(process.overhangDegrees * std::numbers::pi / 180);
  const double onBed = low.z() + kBedVoxels * version.grid().voxelMm;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    const Vec3d normal = (b - a).cross(c - a);
    const double twice = normal.norm();
    if (twice > 0 && -normal.z() > flat * twice && std::max({a.z(), b.z(), c.z()}) > onBed)
      report.overhangMm2 += twice / 2;
  }
  report.walls = clay::wallThickness(mesh, part.part(0.3, 0.6));
  // The same from the other side, within a box that is no wall of a gap.
  clay::TriangleMesh air = mesh;
  for (auto& [i, j, k] : air.triangles) std::swap(j, k);
  const auto first = uint32_t(air.positions.size());
  const Vec3d room = Vec3d::Constant(4 * process.gapMm);
  for (int corner = 0; corner < 8; ++corner)
    air.positions.push_back({corner & 1 ? high.x() + room.x() : low.x() - room.x(),
                             corner & 2 ? high.y() + room.y() : low.y() - room.y(),
                             corner & 4 ? high.z() + room.z() : low.z() - room.z()});
  constexpr std::array<std::array<uint32_t, 3>, 12> kBox{{{0, 2, 3},
                                                          {0, 3, 1},
                                                          {4, 5, 7},
                                                          {4, 7, 6},
                                                          {0, 1, 5},
                                                          {0, 5, 4},
                                                          {2, 6, 7},
                                                          {2, 7, 3},
                                                          {0, 4, 6},
                                                          {0, 6, 2},
                                                          {1, 3, 7},
                                                          {1, 7, 5}}};
  for (const auto& [i, j, k] : kBox) air.triangles.push_back({first + i, first + j, first + k});
  report.gaps = clay::wallThickness(air, part.part(0.6, 0.9));
  report.slices = clay::sweepSlices(version, part.part(0.9, 1));

  report.lowMm = low + shift;
  report.highMm = high + shift;
  const Vec3d size = high - low, &bed = process.bedMm;
  report.fits = size.z() <= bed.z() && std::max(size.x(), size.y()) <= std::max(bed.x(), bed.y()) &&
                std::min(size.x(), size.y()) <= std::min(bed.x(), bed.y());
  for (std::vector<Vec3d>* places : {&report.walls.places, &report.gaps.places})
    for (Vec3d& p : *places) p += shift;
  for (clay::Island& island : report.slices.islands) island.at += shift;
  for (clay::Trap& trap : report.slices.traps) trap.at += shift, trap.spillsMm += shift.z();
  return report;
}

}  // namespace argil::engine
