// argil inspect: what a file holds, and what it costs as clay.

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clay/base/error.h"
#include "clay/base/job_scope.h"
#include "clay/mesh/crossing_triangles.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "clay/surface/surface.h"
#include "clay/surface/surface_topology.h"
#include "engine/document/size_words.h"
#include "engine/models/import_place.h"
#include "engine/models/load_document.h"
#include "engine/text/quality_text.h"
#include "ui3d/cli/inspect_cost.h"
#include "ui3d/cli/inspect_print.h"
#include "ui3d/cli/inspect_pull.h"
#include "ui3d/cli/mesh_input.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

namespace {

constexpr clay::Grade kGrade = clay::Grade::fine;  // as files have it
constexpr double kWorthSaying = 1e-3;              // of the surface
constexpr double kUneven = 0.1;                    // voxels that a wall which stands upright may be uneven by
// The same for a mesh, which has no voxels: a part of its size, and what rounding to 0.001 mm in a file does at least.
constexpr double kUnevenMesh = 1e-4, kUnevenMeshMm = 0.003;

// What a version pays for beside its distances.
std::string channelsOf(const clay::Version& version) {
  std::string names;
  const auto add = [&](clay::Channel channel, const char* name) {
    if (version.has(channel)) names += (names.empty() ? "" : ", ") + std::string(name);
  };
  add(clay::Channel::cover, "colour");
  add(clay::Channel::material, "material");
  add(clay::Channel::mask, "mask");
  return names.empty() ? "no channels" : fmt::format("{}: {} channel bricks", names, version.stats().channelBricks);
}

nlohmann::ordered_json topologyJson(const clay::TopologyReport& t) {
  nlohmann::ordered_json json;
  json["triangles"] = t.triangles;
  json["vertices"] = t.vertices;
  json["bodies"] = t.bodies;
  json["closed"] = t.solid();
  json["boundary_edges"] = t.boundaryEdges;
  json["non_manifold_edges"] = t.nonManifoldEdges;
  json["flipped_edges"] = t.flippedEdges;
  json["non_manifold_vertices"] = t.nonManifoldVertices;
  json["degenerate_triangles"] = t.degenerateTriangles;
  json["volume_mm3"] = t.volume;
  json["area_mm2"] = t.area;
  json["low_mm"] = {t.low.x(), t.low.y(), t.low.z()};
  json["high_mm"] = {t.high.x(), t.high.y(), t.high.z()};
  return json;
}

void printTopology(const clay::TopologyReport& t) {
  const Vec3d size = t.high - t.low;
  fmt::print("  size        {:.6g} × {:.6g} × {:.6g} mm\n", size.x(), size.y(), size.z());
  fmt::print("  triangles   {} on {} vertices, {} bod{}\n", t.triangles, t.vertices, t.bodies,
             t.bodies == 1 ? "y" : "ies");
  fmt::print("  closed      {}{}\n", t.solid() ? "yes: a 2-manifold" : "no",
             t.solid() && t.degenerateTriangles > 0
                 ? fmt::format(", beside {} triangle{} without area", t.degenerateTriangles,
                               t.degenerateTriangles == 1 ? "" : "s")
                 : std::string());
  if (!t.solid())
    fmt::print(
        "  defects     {} boundary edges, {} non-manifold edges, {} flipped edges, {} non-manifold vertices, {} "
        "degenerate triangles\n",
        t.boundaryEdges, t.nonManifoldEdges, t.flippedEdges, t.nonManifoldVertices, t.degenerateTriangles);
  fmt::print("  volume      {} mm³{}\n", engine::figure(t.volume, 6), t.solid() ? "" : " (of an open mesh: about)");
  fmt::print("  area        {} mm²\n", engine::figure(t.area, 6));
}

// What a document holds and what it pays for.
void inspectClay(const InspectOptions& options) {
  if (options.voxelMm) throw Error("--voxel: clay has its voxels already; leave it out");
  const auto print = printOf(options);
  const bool pull = pullAsked(options);
  const engine::LoadedDocument loaded = engine::loadDocument(options.input, {}, options.job);
  const engine::Document& document = *loaded.document;
  nlohmann::ordered_json json;
  json["file"] = options.input.string();
  json["format"] = loaded.what;
  json["notes"] = loaded.notes;
  json["history_steps"] = loaded.steps;
  json["guides"] = document.guides.size();
  json["quality"] = engine::strokeQualityJson(document.quality);
  if (!options.json) {
    fmt::print("{}: {}, {} piece{}, {} part{}, {} guide{}, {} step{} of history\n", options.input.string(), loaded.what,
               document.pieces.size(), document.pieces.size() == 1 ? "" : "s", document.parts.size(),
               document.parts.size() == 1 ? "" : "s", document.guides.size(), document.guides.size() == 1 ? "" : "s",
               loaded.steps, loaded.steps == 1 ? "" : "s");
    for (const std::string& note : loaded.notes) fmt::print("  note        {}\n", note);
    if (const auto& quality = json["quality"]; !quality.empty())
      fmt::print("  quality     of strokes to come: {}\n", quality.dump());
  }
  std::vector<clay::Surface> held;
  for (const engine::Piece& piece : document.pieces) {
    clay::Surface surface(options.cost, kGrade);
    surface.update(piece.version, 2);
    const clay::TopologyReport skin = clay::surfaceTopology(surface);
    const clay::VersionStats stats = piece.version.stats();
    const uint64_t active = piece.version.activeVoxels();
    json["pieces"].push_back({{"name", piece.name},
                              {"voxel_mm", piece.version.grid().voxelMm},
                              {"bricks", stats.bricks},
                              {"bytes", stats.bytes()},
                              {"active_voxels", active},
                              {"channel_bricks", stats.channelBricks},
                              {"hash", fmt::format("{:016x}", piece.version.hash())},
                              {"surface", topologyJson(skin)}});
    std::optional<engine::PullReport> pulled;
    if (pull) {
      clay::TriangleMesh mesh = surface.toMesh();
      for (Vec3d& each : mesh.positions) each = piece.pose.apply(each);
      pulled = pullOf(options, mesh, kUneven * piece.version.grid().voxelMm);
    }
    if (options.cost) held.push_back(std::move(surface));
    if (options.json) {
      if (pulled) json["pieces"].back()["mould"] = pullJson(*pulled);
      if (print)
        json["pieces"].back()["print"] =
            printJson(*print, engine::checkPrint(piece.version, piece.pose, *print, options.job));
      continue;
    }
    fmt::print("{}: voxels of {} mm{}{}\n", piece.name, piece.version.grid().voxelMm, piece.visible ? "" : ", hidden",
               piece.locked ? ", locked" : "");
    fmt::print("  costs       {} bricks, {:.1f} MiB, {} active voxels; {}\n", stats.bricks,
               static_cast<double>(stats.bytes()) / (1 << 20), active, channelsOf(piece.version));
    printTopology(skin);
    if (print) sayPrint(*print, engine::checkPrint(piece.version, piece.pose, *print, options.job));
    if (pulled) sayPull(options, *pulled);
  }
  for (const engine::Part& part : document.parts) {
    const clay::TopologyReport mesh = clay::checkTopology(*part.mesh);
    json["parts"].push_back({{"name", part.name}, {"mesh", topologyJson(mesh)}});
    if (options.json) continue;
    fmt::print("{}: a part\n", part.name);
    printTopology(mesh);
  }
  if (print) {
    const Meetings met = meetings(document, print->gapMm, options.job);
    json["pieces_that_meet"] = meetingsJson(met);
    if (!options.json) sayMeetings(met, print->gapMm);
  }
  if (options.cost) json["memory"] = memoryCosts(document, held, !options.json);
  if (options.json) fmt::print("{}\n", json.dump(2));
}

}  // namespace

void inspect(const InspectOptions& options) {
  const clay::JobScope surfaces(options.job);
  requireModel(options.input, options.place);
  if (engine::holdsClay(options.input)) return inspectClay(options);
  const auto print = printOf(options);
  const bool pull = pullAsked(options);
  if (print && (!options.voxelMm || options.cost))
    throw Error("--print looks at clay: give the model's --voxel too, and leave out --cost");
  io::MeshFile file = readMeshIn(options.input, options.place, options.job);
  // As it becomes clay: vertices of open edges are one at one place.
  const clay::TriangleMesh welded = clay::weldOpenEdges(file.mesh);
  const clay::TopologyReport asGiven = clay::checkTopology(file.mesh), mesh = clay::checkTopology(welded);
  const uint64_t crossings = clay::countCrossings(welded, options.job);
  if (mesh.vertices < asGiven.vertices)
    file.notes.push_back(fmt::format("{} vertices of open edges lie where others do and are taken as one with them",
                                     asGiven.vertices - mesh.vertices));
  if (mesh.solid() && mesh.volume < 0) file.notes.emplace_back("it is inside out: clay and exports turn it around");
  const clay::WallThickness walls = file.mesh.triangles.size() > engine::kMostWallTriangles
                                        ? clay::WallThickness{}
                                        : clay::wallThickness(file.mesh, clay::WorkPart(options.job));
  const double keeping = walls.keepingVoxelMm();
  nlohmann::ordered_json json;
  json["file"] = options.input.string();
  json["format"] = file.format;
  if (keeping > 0) json["wall_keeping_voxel_mm"] = keeping;
  json["notes"] = file.notes;
  json["mesh"] = topologyJson(mesh);
  json["mesh"]["crossing_pairs"] = crossings;
  if (!options.json) {
    fmt::print("{}: {}\n", options.input.string(), file.format);
    for (const std::string& note : file.notes) fmt::print("  note        {}\n", note);
    printTopology(mesh);
    if (crossings > 0)
      fmt::print(
          "  crossing    {}{} pair{} of triangles cross{} each other: volume and area count some places more than "
          "once\n",
          crossings >= clay::kMostCrossings ? "at least " : "", crossings, crossings == 1 ? "" : "s",
          crossings == 1 ? "es" : "");
    if (keeping > 0) fmt::print("  walls       voxels of {:.3g} mm keep them all\n", keeping);
    if (options.voxelMm && walls.shareThinner(*options.voxelMm) > kWorthSaying)
      fmt::print("  at risk     {:.2g} % of the surface bounds walls thinner than voxels of {} mm\n",
                 100 * walls.shareThinner(*options.voxelMm), *options.voxelMm);
  }
  if (pull) {
    const engine::PullReport pulled =
        pullOf(options, file.mesh, std::max(kUnevenMeshMm, kUnevenMesh * (mesh.high - mesh.low).maxCoeff()));
    json["mould"] = pullJson(pulled);
    if (!options.json) sayPull(options, pulled);
  }
  if (options.cost) {
    json["cost"] = planCosts(file.mesh, options.voxelMm, !options.json);
  } else if (options.voxelMm) {
    clay::TriangleMesh* const meshes[] = {&file.mesh};
    if (const std::string moved = engine::movedWords(engine::bringNear(meshes)); !moved.empty() && !options.json)
      fmt::print("{}\n", moved);
    const clay::Imported imported = meshAsClay(options.input, file.mesh, options.voxelMm, options.job, !options.json);
    clay::Surface surface(false, kGrade);
    surface.update(imported.version, 2);
    const clay::TopologyReport skin = clay::surfaceTopology(surface);
    const clay::VersionStats stats = imported.version.stats();
    const uint64_t active = imported.version.activeVoxels();
    json["clay"] = {{"voxel_mm", imported.version.grid().voxelMm},
                    {"bricks", stats.bricks},
                    {"bytes", stats.bytes()},
                    {"active_voxels", active}};
    json["repair"] = imported.report.sentences();
    json["surface"] = topologyJson(skin);
    std::optional<engine::PrintReport> report;
    if (print) report = engine::checkPrint(imported.version, {}, *print, options.job);
    if (report && options.json) json["print"] = printJson(*print, *report);
    if (!options.json) {
      fmt::print("as clay with voxels of {} mm\n", imported.version.grid().voxelMm);
      fmt::print("  costs       {} bricks, {:.1f} MiB, {} active voxels; {}\n", stats.bricks,
                 static_cast<double>(stats.bytes()) / (1 << 20), active, channelsOf(imported.version));
      printTopology(skin);
      if (report) sayPrint(*print, *report);
    }
  }
  if (options.json) fmt::print("{}\n", json.dump(2));
}

}  // namespace argil::cli
