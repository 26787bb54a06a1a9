#include "bench/export/closed_model.h"

#include <fmt/format.h>

#include "clay/import/mesh_to_clay.h"
#include "clay/store/store.h"
#include "io/models/model_file.h"

namespace argil::bench {

using namespace clay;

constexpr double kSizeMm = 100, kVoxelMm = 0.25;

std::optional<Version> closedModel(BenchReport& report, const BenchOptions& options,
                                   const std::filesystem::path& file) {
  const auto leftOut = [&](const char* why) {
    report.heading(fmt::format("{}: left out: {}", file.filename().string(), why));
    return std::nullopt;
  };
  try {
    TriangleMesh mesh = io::merged(io::readModel(file, options.job).objects).mesh;
    Vec3d low = mesh.positions.front(), high = low;
    for (const Vec3d& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (Vec3d& p : mesh.positions) p = (p - 0.5 * (low + high)) * (kSizeMm / (high - low).maxCoeff());
    ImportOptions how;
    how.grid.voxelMm = kVoxelMm;
    Imported clay = meshToClay(Store::make(), mesh, how, options.job);
    if (!clay.report.sound()) return leftOut("not sound");
    if (clay.version.stats().bricks == 0) return leftOut("no clay");
    return std::move(clay.version);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    return leftOut(e.what());
  }
}

}  // namespace argil::bench
