#include "ui3d/cli/inspect_cost.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <set>
#include <string>

#include "clay/base/memory_guard.h"
#include "clay/store/store.h"
#include "engine/document/cost.h"
#include "engine/document/quality.h"

namespace argil::cli {

namespace {

using nlohmann::ordered_json;

// Of the process, bytes; 0 where the system does not say.
uint64_t status(const std::string& which) {
  std::ifstream lines("/proc/self/status");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(which + ":")) return 1024 * std::stoull(line.substr(which.size() + 1));
  return 0;
}

std::string mb(double bytes) {
  return fmt::format("{:.1f} MB", bytes * 1e-6);
}

}  // namespace

ordered_json planCosts(const clay::TriangleMesh& mesh, const std::optional<double>& voxelMm, bool say) {
  double area = 0, slanted = 0;
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  for (const auto& t : mesh.triangles) {
    const Vec3d normal =
        0.5 * (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
    area += normal.norm();
    slanted += normal.cwiseAbs().sum();
  }
  for (const Vec3d& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const engine::MachineSpeed machine = engine::machineSpeed();
  const double side = (high - low).maxCoeff();
  ordered_json rows = ordered_json::array();
  if (!(area > 0) || !(side > 0) || !std::isfinite(area)) return rows;
  const auto add = [&](const std::string& name, double voxel, const engine::ClayQuality& quality) {
    const engine::ClayPlan plan{area, voxel, quality.band, slanted / area, quality.precision(), side / 20};
    const engine::ClayCost cost = engine::costOf(plan, machine);
    rows.push_back({{"name", name},
                    {"voxel_mm", plan.voxelMm},
                    {"active_voxels", std::round(cost.activeVoxels)},
                    {"bytes", std::round(cost.bytes)},
                    {"triangles", std::round(cost.triangles)},
                    {"tip_mm", plan.tipMm},
                    {"dab_ms", cost.dabMs},
                    {"rim_mm", cost.edgeMm}});
    if (say) fmt::print("  {:<11} {}\n", name, engine::sentence(plan, cost));
  };
  if (say) fmt::print("as clay it would be, about\n");
  for (const engine::QualityPreset& preset : engine::qualityPresets())
    add(std::string(preset.id), side / preset.quality.clay.voxelsAcross, preset.quality.clay);
  const engine::ClayQuality here = engine::machineQuality(machine, memoryRoom().total).clay;
  add("machine", side / here.voxelsAcross, here);
  if (voxelMm) add("--voxel", *voxelMm, {});
  return rows;
}

ordered_json memoryCosts(const engine::Document& document, const std::vector<clay::Surface>& surfaces, bool say) {
  std::set<std::shared_ptr<clay::Store>> stores;
  for (const engine::Piece& piece : document.pieces)
    if (piece.version) stores.insert(piece.version.store());
  uint64_t clay = 0, live = 0, seen = 0, parts = 0, small = 0;
  for (const auto& store : stores) {
    clay += store->usage().slabBytes;
    live += store->usage().bytes();
    small += store->usage().heapBytes;
  }
  for (const clay::Surface& surface : surfaces) {
    seen += surface.usage().bytes;
    small += surface.usage().heapBytes;
  }
  // Lists so large are no part of the heap that is counted below.
  constexpr uint64_t kLarge = 128 << 10;
  const auto large = [&](uint64_t bytes) { parts += bytes >= kLarge ? bytes : 0; };
  for (const engine::Part& part : document.parts) {
    large(part.mesh->positions.size() * sizeof(part.mesh->positions[0]));
    large(part.mesh->triangles.size() * sizeof(part.mesh->triangles[0]));
  }
  const uint64_t heap = mallinfo2().arena, resident = status("VmRSS");
  const std::vector<std::pair<const char*, uint64_t>> items{{"program", status("RssFile") + status("RssShmem")},
                                                            {"clay", clay},
                                                            {"surfaces", seen},
                                                            {"parts", parts},
                                                            {"rest", heap - std::min(heap, small)}};
  ordered_json json;
  uint64_t sum = 0;
  if (say) fmt::print("memory\n");
  for (const auto& [name, bytes] : items) {
    json[name] = bytes;
    sum += bytes;
    if (say)
      fmt::print("  {:<11} {:>10}{}\n", name, mb(static_cast<double>(bytes)),
                 std::string_view(name) == "clay" ? fmt::format(", {} of it in use", mb(static_cast<double>(live)))
                                                  : std::string());
  }
  json["sum"] = sum;
  json["resident"] = resident;
  if (say)
    fmt::print("  {:<11} {:>10}, and the system counts {}\n", "together", mb(static_cast<double>(sum)),
               mb(static_cast<double>(resident)));
  return json;
}

}  // namespace argil::cli
