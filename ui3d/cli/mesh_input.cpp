#include "ui3d/cli/mesh_input.h"

#include <cstdio>

#include <fmt/format.h>

#include "clay/store.h"
#include "engine/model_files.h"
#include "ui3d/cli/progress.h"

namespace argil::cli {

io::MeshFile readMeshIn(const std::filesystem::path& file, const std::string& units, Job* job) {
  const double given = engine::unitMm(units);
  const ProgressLine line("reading " + file.filename().string(), job);
  io::MeshFile mesh = io::readMesh(file, job);
  const double mm = mesh.unitMm.value_or(given);
  if (mm != 1)
    for (Vec3d& p : mesh.mesh.positions) p *= mm;
  return mesh;
}

clay::Imported meshAsClay(const std::filesystem::path& file, const clay::TriangleMesh& mesh, std::optional<double> voxelMm, Job* job, bool tell) {
  const ProgressLine line("making clay", job);
  try {
    clay::ImportOptions options;
    options.grid.voxelMm = voxelMm ? *voxelMm : clay::suggestVoxelMm(mesh);
    clay::Imported imported = clay::meshToClay(clay::Store::make(), mesh, options, job);
    if (tell)
      for (const std::string& sentence : imported.report.sentences()) fmt::print("{}\n", sentence);
    return imported;
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file.string(), e.what()), e.kind());
  }
}

}  // namespace argil::cli
