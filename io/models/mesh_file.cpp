#include "io/models/mesh_file.h"

#include <utility>

#include "io/models/format_table.h"

namespace argil::io {

namespace {

MeshFile meshOf(ModelFile&& model) {
  MeshFile file;
  ModelObject all = merged(std::move(model.objects));
  file.colour = meanColour(all);
  file.mesh = std::move(all.mesh);
  file.vertexColours = std::move(all.vertexColours);
  file.triangleColours = std::move(all.triangleColours);
  file.unitMm = model.unitMm;
  file.format = std::move(model.format);
  file.faces = model.faces;
  file.polygons = model.polygons;
  file.welded = model.welded;
  file.notes = std::move(model.notes);
  if (!model.negatives.empty()) file.notes.push_back(notCutAway(model.negatives.size()));
  return file;
}

}  // namespace

MeshFile parseMesh(std::span<const std::byte> bytes, const std::string& name, Job* job) {
  return meshOf(parseModel(bytes, name, job));
}

MeshFile readMesh(const std::filesystem::path& path, Job* job) {
  return meshOf(readModel(path, job));
}

}  // namespace argil::io
