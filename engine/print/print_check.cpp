#include "engine/print/print_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <unordered_map>
#include <vector>

#include "clay/base/error.h"
#include "clay/surface/quads.h"
#include "clay/surface/surface.h"
#include "clay/whole/resample.h"
#include "clay/whole/ways_out.h"

namespace argil::engine {

namespace {

// Limits as print services and makers of machines give them for a part of a hand's size.
const std::array<PrintProcess, kPrintProcesses> kProcesses{{
    {"sla", "resin (SLA)", 1, 0.5, 20, true, true, 2, {145, 145, 185}},
    {"fdm", "filament (FDM)", 0.8, 0.4, 45, true, false, 0, {250, 210, 210}},
    {"sls", "powder (SLS)", 0.8, 0.6, 0, false, true, 2, {300, 300, 300}},
    {"metal", "metal powder (SLM)", 0.5, 0.4, 45, true, true, 3, {250, 250, 300}},
    {"casting", "wax for casting", 0.6, 0.4, 20, true, true, 2, {120, 68, 150}},
}};

constexpr double kBedVoxels = 3;  // from the lowest place: what stands on the bed
constexpr double kMostVoxels = 256;
// An overhang that is no larger, in one patch, needs no support: a thread of filament and a cured layer carry
// themselves so far, and below some voxels it is but how a rim was rounded.
constexpr double kCarriedMm2 = 0.25, kCarriedVoxels = 4;
constexpr int kThreads = 2;

// Areas of triangles that hang together through vertices of a surface.
class Patches {
 public:
  explicit Patches(const clay::Surface& surface) {
    uint32_t count = 0;
    surface.forEach([&](const clay::BrickMesh& mesh) {
      first_[&mesh] = count;
      count += static_cast<uint32_t>(mesh.positions.size());
    });
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0u);
    area_.resize(count);
  }
  void add(const clay::Corner& a, const clay::Corner& b, const clay::Corner& c, double area) {
    const uint32_t root = find(indexOf(a));
    area_[root] += area;
    for (const clay::Corner* other : {&b, &c}) {
      const uint32_t from = find(indexOf(*other)), to = find(indexOf(a));
      if (from == to) continue;
      area_[to] += area_[from];
      parent_[from] = to;
    }
  }
  // Area of the largest patch.
  [[nodiscard]] double largest() {
    double most = 0;
    for (uint32_t i = 0; i < parent_.size(); ++i)
      if (parent_[i] == i) most = std::max(most, area_[i]);
    return most;
  }

 private:
  [[nodiscard]] uint32_t indexOf(const clay::Corner& corner) const { return first_.at(corner.mesh) + corner.index; }
  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  std::unordered_map<const clay::BrickMesh*, uint32_t> first_;
  std::vector<uint32_t> parent_;
  std::vector<double> area_;
};

}  // namespace

std::span<const PrintProcess, kPrintProcesses> printProcesses() {
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

PrintProcess printProcess(const PrintWish& wish) {
  PrintProcess process = printProcess(wish.process);
  process.wallMm = wish.wallMm.value_or(process.wallMm);
  process.gapMm = wish.gapMm.value_or(process.gapMm);
  process.outletMm = wish.outletMm.value_or(process.outletMm);
  return process;
}

int PrintReport::troubles(const PrintProcess& process) const {
  const auto closed =
      std::any_of(slices.traps.begin(), slices.traps.end(), [](const clay::Trap& trap) { return trap.closed; });
  return !walls.parts.empty() + !gaps.parts.empty() + !fits + (process.needsSupport && overhangs) +
         (process.needsSupport && !slices.islands.empty()) +
         (closed || (process.holdsLiquid && !slices.traps.empty())) + !necks.empty();
}

PrintReport checkPrint(const clay::Version& version, const haptics::Pose& pose, const PrintProcess& process, Job* job) {
  const clay::WorkPart part(job);
  const clay::Grid& grid = version.grid();
  const double most = std::max(process.wallMm, process.gapMm) / grid.voxelMm;
  if (most > kMostVoxels)
    throw Error(
        fmt::format("walls and gaps are looked for up to {} voxels, {:.3g} mm here: ask for less, or resample it",
                    kMostVoxels, kMostVoxels * grid.voxelMm));
  clay::Surface surface;
  clay::WallMap map(process.wallMm / grid.voxelMm, process.gapMm / grid.voxelMm);
  {
    const clay::SurfaceDelta delta = surface.update(version, kThreads);
    if (surface.quadCount() == 0) throw Error("it has no clay");
    map.follow(delta, kThreads, part.part(0.1, 0.3));
  }
  part.step(0.3);
  PrintReport report;
  report.walls = thinParts(surface, map, clay::SideOf::wall, process.wallMm);
  report.gaps = thinParts(surface, map, clay::SideOf::gap, process.gapMm);
  part.step(0.35);
  const auto toWorld = [&](const Vec3d& p) { return Vec3d(pose.rotation * p + pose.translation); };

  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  const auto inWorld = [&](const clay::BrickMesh& mesh, const Vec3d& p) {
    return toWorld(grid.toWorld(mesh.brick.toVec3d() * clay::kBrickEdge + p));
  };
  surface.forEach([&](const clay::BrickMesh& mesh) {
    for (const Vec3f& each : mesh.positions) {
      const Vec3d p = inWorld(mesh, each.cast<double>());
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  });
  const double flat = std::cos(process.overhangDegrees * std::numbers::pi / 180);
  const double onBed = low.z() + kBedVoxels * grid.voxelMm;
  Patches patches(surface);
  surface.forEach([&](const clay::BrickMesh& mesh) {
    forEachQuad(surface, mesh, [&](const std::array<clay::Corner, 4>& corners) {
      std::array<Vec3d, 4> p;
      for (size_t k = 0; k < 4; ++k) p[k] = inWorld(mesh, corners[k].from(mesh.brick));
      for (size_t k = 1; k < 3; ++k) {
        const Vec3d normal = (p[k] - p[0]).cross(p[k + 1] - p[0]);
        const double twice = normal.norm();
        if (!(twice > 0 && -normal.z() > flat * twice && std::max({p[0].z(), p[k].z(), p[k + 1].z()}) > onBed))
          continue;
        report.overhangMm2 += twice / 2;
        patches.add(corners[0], corners[k], corners[k + 1], twice / 2);
      }
    });
  });
  report.overhangs = patches.largest() > std::max(kCarriedMm2, kCarriedVoxels * grid.voxelMm * grid.voxelMm);
  part.step(0.4);

  clay::Version layers = version;
  if (pose.rotation.angularDistance(Eigen::Quaterniond::Identity()) > 1e-9) {
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() = pose.rotation.toRotationMatrix();
    layers = clay::resample(version, grid, turn, 0, part.part(0.4, 0.6));
  }
  report.slices = clay::sweepSlices(layers, part.part(0.6, 0.7));
  for (clay::Island& island : report.slices.islands) island.at += pose.translation;
  for (clay::Trap& trap : report.slices.traps) trap.at += pose.translation, trap.spillsMm += pose.translation.z();

  if (process.outletMm > 0)
    report.necks = clay::narrowWaysOut(version, process.outletMm / 2, kThreads, part.part(0.7, 1));
  for (clay::Neck& neck : report.necks) neck.atMm = toWorld(neck.atMm), neck.hollowMm = toWorld(neck.hollowMm);

  report.lowMm = low;
  report.highMm = high;
  const Vec3d size = high - low, &bed = process.bedMm;
  report.fits = size.z() <= bed.z() && std::max(size.x(), size.y()) <= std::max(bed.x(), bed.y()) &&
                std::min(size.x(), size.y()) <= std::min(bed.x(), bed.y());
  for (clay::ThinParts* parts : {&report.walls, &report.gaps})
    for (clay::ThinPart& each : parts->parts) each.atMm = toWorld(each.atMm);
  return report;
}

}  // namespace argil::engine
