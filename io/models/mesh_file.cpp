#include "io/models/mesh_file.h"

#include <utility>

#include "clay/base/error.h"
#include "clay/mesh/triangulate.h"
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

namespace argil::io {

void PolygonList::add(MeshFile& file, std::span<const uint32_t> corners, std::span<const uint32_t> given) {
  std::vector<std::array<uint32_t, 3>>& triangles = file.mesh.triangles;
  ++file.faces;
  if (triangles.size() + corners.size() > UINT32_MAX)
    throw Error("the model has more than " + std::to_string(UINT32_MAX) + " triangles; reduce it first");
  if (corners.size() > 3) {
    ++file.polygons;
    polygons_.emplace_back(uint32_t(triangles.size()), uint32_t(corners.size()));
  }
  if (!given.empty()) {
    places.resize(triangles.size(), {kNone, kNone, kNone});
    for (size_t i = 2; i < given.size(); ++i) places.push_back({given[0], given[i - 1], given[i]});
  }
  for (size_t i = 2; i < corners.size(); ++i) triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

void PolygonList::divide(MeshFile& file, Job* job) {
  constexpr size_t kBetweenLooks = 4096;
  clay::Triangulator triangulator;
  std::vector<uint32_t> corners;
  std::vector<Vec3d> positions;
  std::vector<std::array<uint32_t, 3>> divided;
  uint64_t crossed = 0;
  if (!places.empty()) places.resize(file.mesh.triangles.size(), {kNone, kNone, kNone});
  // Replaces a fan by triangles of its corners, which `divided` names.
  const auto arrange = [&](std::span<std::array<uint32_t, 3>> fan) {
    corners.assign({fan[0][0], fan[0][1]});
    for (const auto& triangle : fan) corners.push_back(triangle[2]);
    for (size_t t = 0; t < divided.size(); ++t)
      fan[t] = {corners[divided[t][0]], corners[divided[t][1]], corners[divided[t][2]]};
  };
  for (size_t p = 0; p < polygons_.size(); ++p) {
    if (p % kBetweenLooks == 0 && job != nullptr && job->cancelled()) throw Cancelled();
    const auto [first, count] = polygons_[p];
    const std::span fan = std::span(file.mesh.triangles).subspan(first, count - 2);
    positions.assign({file.mesh.positions[fan[0][0]], file.mesh.positions[fan[0][1]]});
    for (const auto& triangle : fan) positions.push_back(file.mesh.positions[triangle[2]]);
    divided.clear();
    crossed += !triangulator.add(positions, divided);
    arrange(fan);
    if (!places.empty()) arrange(std::span(places).subspan(first, count - 2));
  }
  polygons_.clear();
  if (crossed > 0)
    file.notes.push_back(std::to_string(crossed) + (crossed == 1 ? " face crosses itself" : " faces cross themselves") +
                         ": parts may be missing or covered twice; repair the model in the program that made it");
}

}  // namespace argil::io
