#include "engine/models/model_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <utility>

#include "clay/base/error.h"
#include "clay/base/rounded_up.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/mesh/corners_apart.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/surface/vertex_channels.h"
#include "engine/models/cad_export.h"
#include "engine/models/cut_negatives.h"
#include "engine/models/face_guides.h"
#include "engine/models/model_colours.h"
#include "engine/models/quad_export.h"
#include "haptics/scene/part_mesh.h"
#include "io/bytes/input.h"
#include "io/cad/step_file.h"
#include "io/models/model_writer.h"
#include "io/models/vdb_file.h"
#include "io/textured/textured_mesh.h"

namespace argil::engine {
namespace {

constexpr size_t kMostObjects = 32;  // that become pieces or parts of their own
constexpr double kMade = 0.9;        // of an import, when there is clay and no colour yet

// The name is the file's where the object has none: the caller knows it.
Piece pieceOf(const io::ModelObject& object, const std::optional<io::Colour>& mean, clay::Version version) {
  Piece piece;
  piece.name = object.name;
  if (const auto colour = pieceColourOf(object, mean)) piece.colour = *colour;
  piece.version = std::move(version);
  return piece;
}

constexpr double kFinestSaved = 32;  // times as fine as voxels that nobody chose

// Metadata of a 3MF file of ours; its writer puts the namespace before it.
constexpr std::string_view kVoxelSizes = "VoxelSizeMm", kOurs = "argil:";

// Of the pieces, in the order of the objects.
std::vector<std::pair<std::string, std::string>> voxelSizes(const Document& document, const ModelExport& what,
                                                            const std::vector<io::ModelObject>& objects) {
  std::string sizes;
  size_t count = 0;
  for (const Piece& each : document.pieces) {
    if (what.piece != 0 ? each.id != what.piece : what.visibleOnly && !each.visible) continue;
    if (count == objects.size() || objects[count].name != each.name) continue;  // one without a surface
    sizes += fmt::format("{}{}", count == 0 ? "" : " ", each.version.grid().voxelMm);
    ++count;
  }
  if (count != objects.size()) return {};
  return {{std::string(kVoxelSizes), std::move(sizes)}};
}

ImportedModel importVdb(const std::filesystem::path& file, const ModelImport& how, Job* job) {
  ImportedModel imported;
  for (io::VdbObject& object : io::readVdb(file, unitMm(how.units == "auto" ? "mm" : how.units), job)) {
    Piece piece;
    piece.name = object.name;
    piece.pose.rotation = object.rotation;
    if (object.colour) piece.colour = colourOf(*object.colour);
    piece.version = std::move(object.version);
    imported.pieces.push_back(std::move(piece));
    for (std::string& note : object.notes) imported.notes.push_back(std::move(note));
  }
  if (how.asPart || how.fitMm || how.voxelMm || !how.up.empty() || how.heightMm)
    imported.notes.push_back("A level set comes in as the clay that it is: other wishes do not apply to it.");
  return imported;
}

void requireSome(const ImportedModel& imported) {
  if (imported.pieces.empty()) throw Error("nothing is left when the file's negative volumes are cut away");
}

void makePieces(io::ModelFile& read, const ModelImport& how, ImportedModel& imported, Job* job) {
  const uint32_t assembly = read.objects.front().assembly;
  const std::vector<io::ModelObject> objects =
      read.objects.size() > 1 ? std::move(read.objects) : std::vector<io::ModelObject>();
  io::ModelObject all = io::merged(objects.empty() ? std::move(read.objects) : std::vector<io::ModelObject>(objects));
  all.assembly = assembly;
  const std::optional<io::Colour> meanOfAll = io::meanColour(all);  // While it has its mesh.
  const auto whole = std::make_shared<const clay::TriangleMesh>(std::move(all.mesh));
  if (how.onRead) how.onRead(whole);
  clay::ImportOptions options;
  const double usual = how.voxelMm ? *how.voxelMm : clay::suggestVoxelMm(*whole);
  options.grid.voxelMm = usual;
  // What was scaled is not as fine as it was.
  const bool asSaved = !how.voxelMm && !how.fitMm && !how.heightMm;
  std::vector<double> saved = asSaved ? savedVoxelsMm(read) : std::vector<double>();
  // A file must not ask for more memory than any clay of its size had.
  for (double& each : saved)
    if (each < usual / kFinestSaved) each = usual;
  // `of`: the name before its notes; empty where there is one piece.
  const auto add = [&](const io::ModelObject& object, const clay::TriangleMesh& mesh,
                       const std::optional<io::Colour>& mean, const std::string& of) {
    clay::Imported made = clay::meshToClay(clay::Store::make(how.precision), mesh, options, job);
    made.version = withColours(std::move(made.version), mesh, object, clay::WorkPart(job, kMade, 1));
    std::vector<std::string> notes = made.report.sentences();
    made.version = withoutNegatives(std::move(made.version), object.assembly, read.negatives, notes, job);
    if (made.version.stats().bricks == 0)
      notes.push_back(fmt::format("Nothing is left of {}: all of it is cut away.",
                                  object.name.empty() ? "an object" : object.name));
    else
      imported.pieces.push_back(pieceOf(object, mean, std::move(made.version)));
    for (const std::string& sentence : notes)
      imported.notes.push_back(of.empty() ? sentence : fmt::format("{}: {}", of, sentence));
  };
  if (!objects.empty()) {
    const size_t notes = imported.notes.size();
    const io::ModelObject* at = &objects.front();
    try {
      for (size_t i = 0; i < objects.size(); ++i) {
        const io::ModelObject& object = objects[i];
        at = &object;
        options.grid.voxelMm = saved.size() == objects.size() ? saved[i] : usual;
        add(object, object.mesh, io::meanColour(object),
            object.name.empty() ? fmt::format("Object {}", i + 1) : io::displayName(object.name));
      }
      requireSome(imported);
      return;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      // Some object is no solid alone: together they may be one.
      imported.pieces.clear();
      imported.notes.resize(notes);
      imported.notes.push_back(fmt::format("{} objects became one piece: {} is no solid alone.", objects.size(),
                                           at->name.empty() ? "one of them" : at->name));
    }
  }
  options.grid.voxelMm = saved.empty() ? usual : *std::min_element(saved.begin(), saved.end());
  add(all, *whole, meanOfAll, {});
  requireSome(imported);
}

Part partOf(io::ModelObject&& object, Job* job) {
  Part part;
  part.name = object.name;
  if (const auto colour = io::meanColour(object)) part.colour = colourOf(*colour);
  part.mesh = std::make_shared<const clay::TriangleMesh>(std::move(object.mesh));
  part.felt = std::make_shared<const haptics::PartMesh>(*part.mesh, job);
  return part;
}

}  // namespace

double unitMm(const std::string& units) {
  struct Unit {
    const char* name;
    double mm;
  };
  for (const Unit& u :
       {Unit{"mm", 1}, Unit{"um", 1e-3}, Unit{"cm", 10}, Unit{"m", 1000}, Unit{"in", 25.4}, Unit{"ft", 304.8}})
    if (units == u.name) return u.mm;
  throw Error(fmt::format("units {}: give mm, um, cm, m, in or ft", units));
}

std::vector<double> savedVoxelsMm(const io::ModelFile& model) {
  constexpr double kLeast = 1e-4, kMost = 1e4;
  const auto sizes = std::find_if(model.metadata.begin(), model.metadata.end(), [](const auto& each) {
    return each.first.starts_with(kOurs) && std::string_view(each.first).substr(kOurs.size()) == kVoxelSizes;
  });
  if (sizes == model.metadata.end()) return {};
  std::vector<double> found;
  const char *at = sizes->second.data(), *const end = at + sizes->second.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !(value >= kLeast && value <= kMost)) return {};
    found.push_back(value);
    at = next;
    while (at < end && *at == ' ') ++at;
  }
  return found;
}

ImportedModel importModel(const std::filesystem::path& file, const ModelImport& how, Job* job) {
  if (io::endingOf(file) == ".vdb") return importVdb(file, how, job);
  const ImportPlace wish = how.place();
  if (wish.units != "auto") (void)unitMm(wish.units);  // A wrong name is told before the file is read.
  if (!wish.up.empty() && wish.up != "auto") (void)upAxisNamed(wish.up);
  io::ModelFile read;
  ImportedModel imported;
  std::optional<FaceGuides> faces;
  Vec3d moved = Vec3d::Zero();
  {
    const ModelLook look = how.look ? *how.look : lookAtModel(file, job);
    Placement placement;
    try {
      placement = placementOf(look, wish);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", file.string(), e.what()), e.kind());
    }
    read = *look.model;
    imported.notes = read.notes;
    if (!wish.up.empty() || wish.heightMm || wish.units == "auto")
      imported.notes.push_back(placeWords(look, placement, wish));
    moved = placement.moveMm;
    if (how.guides) faces.emplace(read.objects);
    place(read.objects, placement);
    place(read.negatives, placement);
    if (faces)
      for (Vec3d& place : faces->places().positions) place = placement.apply(place);
  }
  if (read.objects.size() > kMostObjects || how.fitMm) {
    const uint32_t assembly = read.objects.front().assembly;
    if (read.objects.size() > 1)
      imported.notes.push_back(fmt::format(
          "{} objects became one: {}.", read.objects.size(),
          how.fitMm ? std::string("they are scaled together") : fmt::format("{} at most stay apart", kMostObjects)));
    read.objects = {io::merged(std::move(read.objects))};
    read.objects.front().assembly = assembly;
    for (io::ModelObject& negative : read.negatives) negative.assembly = assembly;
  }
  std::vector<clay::TriangleMesh*> solids, negatives;
  for (io::ModelObject& object : read.objects) solids.push_back(&object.mesh);
  for (io::ModelObject& object : read.negatives) negatives.push_back(&object.mesh);
  if (faces) negatives.push_back(&faces->places());
  if (how.fitMm) imported.notes.push_back(fitMeshes(solids, *how.fitMm, negatives));
  const Vec3d near = bringNear(solids, negatives);
  moved += near;
  if (std::string words = movedWords(near); !words.empty()) imported.notes.push_back(std::move(words));
  if (faces) {
    FaceGuides::Made made = faces->make();
    imported.guides = std::move(made.guides);
    imported.notes.push_back(std::move(made.note));
  }
  try {
    if (how.asPart) {
      if (!read.negatives.empty()) imported.notes.push_back(io::notCutAway(read.negatives.size()));
      for (io::ModelObject& object : read.objects) imported.parts.push_back(partOf(std::move(object), job));
    } else {
      makePieces(read, how, imported, job);
      // A model that was scaled to a size has no place to go back to.
      if (!how.fitMm)
        for (Piece& piece : imported.pieces) piece.fileOffsetMm = fileOffset(moved);
    }
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file.string(), e.what()), e.kind());
  }
  return imported;
}

// A reduced mesh has other vertices: each takes the colour of the nearest corner of the nearest triangle there was.
std::vector<io::Colour> coloursOn(const clay::TriangleMesh& mesh, const clay::TriangleMesh& before,
                                  const std::vector<io::Colour>& colours) {
  const clay::NearestTriangle nearest(before);
  std::vector<io::Colour> moved;
  moved.reserve(mesh.positions.size());
  uint32_t hint = UINT32_MAX;
  for (const Vec3d& p : mesh.positions) {
    hint = nearest.nearest(p, hint).triangle;
    const auto& corners = nearest.corners(hint);
    moved.push_back(colours[*std::min_element(corners.begin(), corners.end(), [&](uint32_t a, uint32_t b) {
      return (before.positions[a] - p).squaredNorm() < (before.positions[b] - p).squaredNorm();
    })]);
  }
  return moved;
}

namespace {

// A piece that goes out.
struct Outgoing {
  const Piece* piece;
  clay::Surface surface;
  io::ModelObject object;  // without its mesh
  Vec3d back = Vec3d::Zero();
  std::map<uint32_t, Vec3d> moved = {};  // vertices that would lie where another corner of their triangle lies

  [[nodiscard]] Vec3d place(const Vec3d& p) const { return piece->pose.apply(p) + back; }
};

std::vector<Outgoing> outgoing(const Document& document, const ModelExport& what, Job* job) {
  std::vector<Outgoing> all;
  for (const Piece& each : document.pieces) {
    if (what.piece != 0 ? each.id != what.piece : what.visibleOnly && !each.visible) continue;
    if (job) job->step(0);
    Outgoing one{&each, clay::Surface(false, what.grade), {}};
    one.surface.update(each.version, 2);
    if (one.surface.quadCount() == 0) continue;
    one.object.name = each.name;
    one.object.colour = fileColourOf(each);
    one.object.vertexColours = vertexColoursOf(one.surface, each);
    if (what.putBack) one.back = each.fileOffsetMm;
    one.moved = clay::cornersApart([&one](const clay::MeshPiece& visit) {
      std::vector<Vec3d> placed;
      one.surface.forEachSlab(clay::SlabOf::both, [&](const clay::SurfaceSlab& slab) {
        placed.clear();
        for (const Vec3d& p : slab.positions) placed.push_back(one.place(p));
        visit(slab.firstVertex, placed, slab.triangles);
      });
    });
    all.push_back(std::move(one));
  }
  if (all.empty()) throw Error("there is no clay to export: show a piece, or export the hidden ones too");
  return all;
}

std::vector<io::ModelObject> withMeshes(std::vector<Outgoing> all) {
  std::vector<io::ModelObject> objects;
  for (Outgoing& one : all) {
    one.object.mesh = one.surface.toMesh();
    for (Vec3d& position : one.object.mesh.positions) position = one.place(position);
    for (const auto& [vertex, place] : one.moved) one.object.mesh.positions[vertex] = place;
    objects.push_back(std::move(one.object));
    one.surface = clay::Surface(false);
  }
  return objects;
}

// Into a format of one mesh, slab by slab: a file of a surface that has no room beside itself, as writeModel() makes
// it.
io::WriteReport streamed(const std::filesystem::path& file, const std::vector<Outgoing>& all,
                         const io::WriteOptions& options, Job* job) {
  io::MeshCounts counts;
  for (const Outgoing& one : all) {
    counts.vertices += one.surface.vertexCount();
    counts.triangles += 2 * one.surface.quadCount();
  }
  counts.colours = std::any_of(all.begin(), all.end(), [](const Outgoing& one) {
    return one.object.colour || !one.object.vertexColours.empty();
  });
  io::MeshWriter writer(file, counts, options, job);
  std::vector<Vec3d> placed;
  std::vector<io::Colour> colours;
  for (const Outgoing& one : all) {
    one.surface.forEachSlab(clay::SlabOf::vertices, [&](const clay::SurfaceSlab& slab) {
      placed.clear();
      for (const Vec3d& p : slab.positions) placed.push_back(one.place(p));
      for (auto at = one.moved.lower_bound(slab.firstVertex);
           at != one.moved.end() && at->first - slab.firstVertex < placed.size(); ++at)
        placed[at->first - slab.firstVertex] = at->second;
      const std::vector<io::Colour>& painted = one.object.vertexColours;
      if (!counts.colours)
        colours.clear();
      else if (painted.empty())
        colours.assign(placed.size(), one.object.colour.value_or(io::Colour()));
      else
        colours.assign(painted.begin() + slab.firstVertex,
                       painted.begin() + slab.firstVertex + ptrdiff_t(placed.size()));
      writer.vertices(placed, colours);
    });
  }
  uint32_t first = 0;
  std::vector<std::array<uint32_t, 3>> moved;
  for (const Outgoing& one : all) {
    if (!one.object.name.empty() || all.size() > 1) writer.object(one.object.name);
    one.surface.forEachSlab(clay::SlabOf::triangles, [&](const clay::SurfaceSlab& slab) {
      moved.clear();
      for (const auto& [a, b, c] : slab.triangles) moved.push_back({a + first, b + first, c + first});
      writer.triangles(moved);
    });
    first += static_cast<uint32_t>(one.surface.vertexCount());
  }
  return writer.finish();
}

}  // namespace

std::vector<io::ModelObject> modelOf(const Document& document, const ModelExport& what, Job* job) {
  return withMeshes(outgoing(document, what, job));
}

std::string reduceModel(std::vector<io::ModelObject>& objects, const ModelExport& how, Job* job) {
  uint64_t before = 0, after = 0;
  for (const io::ModelObject& object : objects) before += object.mesh.triangles.size();
  double most = 0;
  for (io::ModelObject& object : objects) {
    clay::ReduceOptions options;
    options.errorMm = how.errorMm;
    if (how.triangles)
      options.triangles = std::max<uint64_t>(
          4, uint64_t(double(*how.triangles) * double(object.mesh.triangles.size()) / double(before)));
    clay::Reduced reduced = clay::reduce(object.mesh, options, job);
    if (!object.vertexColours.empty())
      object.vertexColours = coloursOn(reduced.mesh, object.mesh, object.vertexColours);
    object.mesh = std::move(reduced.mesh);
    clay::moveCornersApart(object.mesh);
    most = std::max(most, reduced.deviation.most());
    after += object.mesh.triangles.size();
  }
  return fmt::format("Reduced from {} to {} triangles; the surface moved by at most {:.2g} mm, measured both ways.",
                     before, after, clay::roundedUp(most));
}

std::string partCorners(std::vector<io::ModelObject>& objects) {
  uint64_t left = 0;
  for (io::ModelObject& object : objects) {
    if (clay::checkTopology(object.mesh).boundaryEdges == 0) clay::moveCornersApart(object.mesh);
    const std::vector<bool> out = clay::haveOnePlaceTwice(object.mesh);
    const auto keepOthers = [&out](auto& list) {
      size_t kept = 0;
      for (size_t i = 0; i < list.size(); ++i)
        if (!out[i]) list[kept++] = list[i];
      list.resize(kept);
    };
    left += uint64_t(std::count(out.begin(), out.end(), true));
    if (!object.triangleColours.empty()) keepOthers(object.triangleColours);
    keepOthers(object.mesh.triangles);
  }
  std::erase_if(objects, [](const io::ModelObject& object) { return object.mesh.triangles.empty(); });
  if (objects.empty()) throw Error("no triangle has three corners in different places: there is no surface to write");
  if (left == 0) return {};
  return fmt::format("{} with two corners in one place {} left out.",
                     left == 1 ? "1 triangle" : fmt::format("{} triangles", left), left == 1 ? "was" : "were");
}

clay::TriangleMesh meshOf(const Document& document, Id piece, bool visibleOnly, Job* job) {
  ModelExport what;
  what.piece = piece;
  what.visibleOnly = visibleOnly;
  return io::merged(modelOf(document, what, job)).mesh;
}

std::vector<std::string> writeModelFiles(const std::vector<std::filesystem::path>& files, const Document& document,
                                         const ModelExport& what, Job* job) {
  std::vector<std::string> sentences;
  // What is wrong with a name is told before the work.
  for (const std::filesystem::path& file : files) {
    if (io::endingOf(file) != ".vdb" && !io::isCad(file)) io::requireWritable(file);
  }
  std::vector<Outgoing> clays;
  std::vector<io::ModelObject> objects;
  std::string reduction;
  double tolerance = 0;
  for (const Piece& piece : document.pieces) {
    if (piece.version) tolerance = std::max(tolerance, 0.1 * piece.version.grid().voxelMm);
  }
  const bool remade = what.recentre || what.triangles || what.errorMm;  // what needs meshes
  for (const std::filesystem::path& file : files) {
    io::WriteReport report;
    if (io::isCad(file)) {
      for (std::string& sentence : writeCad(file, document, what, job)) sentences.push_back(std::move(sentence));
      continue;
    }
    if (what.quads && io::holdsTextures(file)) {
      for (std::string& sentence : writeQuads(file, document, what, job)) sentences.push_back(std::move(sentence));
      continue;
    }
    if (io::endingOf(file) == ".vdb") {
      std::vector<io::VdbView> views;
      for (const Piece& each : document.pieces) {
        if (what.piece != 0 ? each.id != what.piece : what.visibleOnly && !each.visible) continue;
        views.push_back({each.name, each.version,
                         each.pose.translation + (what.putBack ? each.fileOffsetMm : Vec3d::Zero()), each.pose.rotation,
                         fileColourOf(each), materialColours(each)});
      }
      if (views.empty()) throw Error("there is no clay to export: show a piece, or export the hidden ones too");
      report = io::writeVdb(file, views, job);
      sentences.push_back(fmt::format("{}: {} level set{} written, {:.1f} MB.", file.filename().string(), views.size(),
                                      views.size() == 1 ? "" : "s", double(report.bytes) * 1e-6));
    } else {
      io::WriteOptions write;
      write.distinct = true;
      write.tolerance = tolerance;
      write.draco = what.draco;
      const auto tellLosses = [&] {
        for (std::string& sentence : io::lossesOf(file, {objects, {}}, write)) sentences.push_back(std::move(sentence));
      };
      const bool made = !objects.empty() && !objects.front().mesh.triangles.empty();  // for a file before
      if (!remade && !made && io::writesPiecewise(file)) {
        if (clays.empty()) clays = outgoing(document, what, job);
        if (objects.empty())
          for (const Outgoing& one : clays) objects.push_back(one.object);
        tellLosses();
        report = streamed(file, clays, write, job);
      } else {
        if (!made) {
          objects = clays.empty() ? modelOf(document, what, job) : withMeshes(std::move(clays));
          clays.clear();
          if (what.recentre) sentences.push_back(recentre(objects));
          if (what.triangles || what.errorMm) reduction = reduceModel(objects, what, job);
        }
        tellLosses();
        const bool keepsVoxels = io::endingOf(file) == ".3mf";
        report = io::writeModel(
            file, {objects, keepsVoxels ? voxelSizes(document, what, objects) : decltype(io::ModelView::metadata)()},
            write, job);
      }
      sentences.push_back(fmt::format("{}: {} triangles written as {}, {:.1f} MB.", file.filename().string(),
                                      report.triangles, report.format, double(report.bytes) * 1e-6));
    }
    if (report.deviation > 0)
      sentences.back() +=
          fmt::format(" Packing moved the surface by at most {:.2g} mm.", clay::roundedUp(report.deviation));
    if (!report.warning.empty()) sentences.back() += " " + report.warning;
  }
  if (!reduction.empty()) sentences.push_back(reduction);
  return sentences;
}

}  // namespace argil::engine
