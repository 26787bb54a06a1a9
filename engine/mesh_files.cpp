#include "engine/mesh_files.h"

#include <fmt/format.h>

#include "clay/error.h"
#include "clay/mesh_to_clay.h"
#include "clay/store.h"
#include "clay/surface.h"
#include "engine/prepare_clay.h"
#include "haptics/part_mesh.h"
#include "io/mesh_file.h"
#include "io/mesh_writer.h"

namespace argil::engine {

double unitMm(const std::string& units) {
  struct Unit {
    const char* name;
    double mm;
  };
  for (const Unit& u : {Unit{"mm", 1}, Unit{"um", 1e-3}, Unit{"cm", 10}, Unit{"m", 1000}, Unit{"in", 25.4}, Unit{"ft", 304.8}})
    if (units == u.name) return u.mm;
  throw Error(fmt::format("units {}: give mm, um, cm, m, in or ft", units));
}

ImportedThing importMesh(const std::filesystem::path& file, const MeshImport& how, Job* job) {
  const double mm = unitMm(how.units);
  io::MeshFile read = io::readMesh(file, job);
  ImportedThing imported;
  imported.notes = std::move(read.notes);
  if (mm != 1) {
    for (Vec3d& position : read.mesh.positions) position *= mm;
  }
  if (how.fitMm) imported.notes.push_back(fitMesh(read.mesh, *how.fitMm));
  const auto mesh = std::make_shared<const clay::TriangleMesh>(std::move(read.mesh));
  if (how.onRead) how.onRead(mesh);
  try {
    if (how.asPart) {
      Part part;
      part.mesh = mesh;
      part.felt = std::make_shared<const haptics::PartMesh>(*part.mesh, job);
      imported.part = std::move(part);
      return imported;
    }
    clay::ImportOptions options;
    options.grid.voxelMm = how.voxelMm ? *how.voxelMm : clay::suggestVoxelMm(*mesh);
    clay::Imported made = clay::meshToClay(clay::Store::make(), *mesh, options, job);
    imported.version = std::move(made.version);
    for (std::string& sentence : made.report.sentences()) imported.notes.push_back(std::move(sentence));
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file.string(), e.what()), e.kind());
  }
  return imported;
}

clay::TriangleMesh meshOf(const Document& document, Id piece, bool visibleOnly, Job* job) {
  clay::TriangleMesh all;
  for (const Piece& each : document.pieces) {
    if (piece != 0 ? each.id != piece : visibleOnly && !each.visible) continue;
    if (job) job->step(0);
    clay::Surface surface(false);
    surface.update(each.version);
    clay::TriangleMesh mesh = surface.toMesh();
    const auto first = static_cast<uint32_t>(all.positions.size());
    if (all.positions.size() + mesh.positions.size() > UINT32_MAX) throw Error("together the pieces have too many vertices for one file: export them one by one");
    for (const Vec3d& position : mesh.positions) all.positions.push_back(each.pose.apply(position));
    for (auto triangle : mesh.triangles) {
      for (uint32_t& corner : triangle) corner += first;
      all.triangles.push_back(triangle);
    }
  }
  if (all.triangles.empty()) throw Error("there is no clay to export: show a piece, or export the hidden ones too");
  return all;
}

std::string writeMeshFile(const std::filesystem::path& file, const clay::TriangleMesh& mesh, Job* job) {
  io::WriteOptions write;
  write.distinct = true;
  const io::WriteReport report = io::writeMesh(file, mesh, write, job);
  std::string sentence = fmt::format("{}: {} triangles written as {}, {:.1f} MB.", file.filename().string(), report.triangles, report.format, double(report.bytes) * 1e-6);
  if (!report.warning.empty()) sentence += " " + report.warning;
  return sentence;
}

}  // namespace argil::engine
