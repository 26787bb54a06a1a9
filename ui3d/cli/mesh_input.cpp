#include "ui3d/cli/mesh_input.h"

#include <cstdio>

#include <fmt/format.h>

#include "clay/store/store.h"
#include "engine/models/load_document.h"
#include "engine/models/model_files.h"
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

io::MeshFile readMeshIn(const std::filesystem::path& file, const engine::ImportPlace& wish, Job* job) {
  if (wish.up.empty() && !wish.heightMm && !wish.stands && wish.units != "auto")
    return readMeshIn(file, wish.units, job);
  const ProgressLine line("reading " + file.filename().string(), job);
  io::MeshFile mesh = io::readMesh(file, job);
  auto model = std::make_shared<io::ModelFile>();
  model->unitMm = mesh.unitMm;
  model->objects.emplace_back().mesh = std::move(mesh.mesh);
  const engine::ModelLook look = engine::lookAtModel(model, file);
  try {
    const engine::Placement placement = engine::placementOf(look, wish);
    mesh.notes.push_back(engine::placeWords(look, placement, wish));
    mesh.mesh = std::move(model->objects[0].mesh);
    for (Vec3d& position : mesh.mesh.positions) position = placement.apply(position);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file.string(), e.what()), e.kind());
  }
  return mesh;
}

void requireModel(const std::filesystem::path& file, const engine::ImportPlace& wish) {
  if (engine::holdsClay(file) && (!wish.up.empty() || wish.heightMm || wish.stands))
    throw Error(fmt::format("{}: clay has its size and place; leave --up, --height and --ground out", file.string()));
}

clay::Imported meshAsClay(const std::filesystem::path& file, const clay::TriangleMesh& mesh,
                          std::optional<double> voxelMm, Job* job, bool tell) {
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
