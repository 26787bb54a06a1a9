// argil convert: from one format to another, straight or by way of clay.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/job_scope.h"
#include "clay/base/rounded_up.h"
#include "clay/cage/cage_maker.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/whole/change_precision.h"
#include "engine/models/cad_export.h"
#include "engine/models/export_presets.h"
#include "engine/models/load_document.h"
#include "engine/saving/saved_document.h"
#include "io/bytes/input.h"
#include "io/bytes/output_files.h"
#include "io/cad/step_file.h"
#include "io/models/added_formats.h"
#include "io/models/colour_list.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"
#include "io/textured/textured_mesh.h"
#include "ui3d/cli/mesh_input.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

// Above one a count of triangles, else a part of what there is.
uint64_t wantedTriangles(double reduce, uint64_t triangles) {
  if (!(reduce > 0) || !std::isfinite(reduce))
    throw Error(fmt::format("--reduce {}: give a count of triangles, or a part of them between 0 and 1", reduce));
  return reduce < 1 ? static_cast<uint64_t>(reduce * static_cast<double>(triangles)) : static_cast<uint64_t>(reduce);
}

engine::ModelExport exportOf(const ConvertOptions& options, const std::vector<io::ModelObject>& objects) {
  engine::ModelExport how;
  how.visibleOnly = false;
  if (io::isCad(options.output))
    how.cadErrorMm = options.errorMm;
  else
    how.errorMm = options.errorMm;
  how.grade = options.surface;
  how.draco = options.draco;
  if (options.faces || options.errorMm)
    how.cadQuads = options.faces ? static_cast<size_t>(*options.faces) : engine::kMostFacesWithin;
  if (options.quads) how.quads = static_cast<size_t>(*options.quads);
  if (options.textures) how.texturePixels = *options.textures;
  how.mirrored = options.mirror;
  how.alongGuides = options.alongGuides;
  how.maskDensity = options.maskDensity;
  how.recentre = options.recentre;
  how.putBack = options.putBack;
  if (options.reduce) {
    uint64_t triangles = 0;
    for (const io::ModelObject& object : objects) triangles += object.mesh.triangles.size();
    how.triangles = wantedTriangles(*options.reduce, triangles);
  }
  if (!options.destination.empty())
    engine::applyPreset(engine::exportPresetNamed(options.destination), options.output, how);
  return how;
}

// Lists the files that the call may write: those that are there already, where their number is known after the work.
io::Files outputsOf(const ConvertOptions& options) {
  const std::string ending = io::endingOf(options.output), frameEnding = io::frameEndingOf(ending);
  if (!frameEnding.empty()) return io::numberedBeside(options.output, "-", frameEnding);
  io::Files files{options.output};
  const engine::ModelExport how = exportOf(options, {});
  if (!how.quads || ending != ".obj") return files;
  const std::filesystem::path folder = options.output.parent_path();
  const std::string stem = options.output.stem().string();
  for (const std::string& name : io::texturedNames(options.output, 1)) {
    if (name.ends_with(".png") && how.texturePixels == 0) continue;
    files.push_back(folder / name);
    if (!name.ends_with(".png")) continue;
    for (const std::filesystem::path& each : io::numberedBeside(options.output, "_", name.substr(stem.size())))
      files.push_back(each);
  }
  return files;
}

void convertClay(const ConvertOptions& options) {
  engine::ModelImport how;
  how.units = options.place.units;
  how.up = options.place.up;
  how.heightMm = options.place.heightMm;
  how.stands = options.place.stands;
  how.voxelMm = options.voxelMm;
  how.guides = options.guides;
  how.precision = precisionOf(options.bits.value_or(32));
  engine::LoadedDocument loaded;
  {
    const ProgressLine line("reading " + options.input.filename().string(), options.job);
    loaded = engine::loadDocument(options.input, how, options.job);
  }
  for (const std::string& note : loaded.notes) fmt::print("{}\n", note);
  if (options.bits) {
    auto document = std::make_shared<engine::Document>(*loaded.document);
    for (engine::Piece& piece : document->pieces)
      if (piece.version)
        piece.version = clay::withPrecision(piece.version, precisionOf(*options.bits), clay::WorkPart(options.job));
    loaded.document = std::move(document);
  }
  const ProgressLine line("writing " + options.output.filename().string(), options.job);
  if (options.output.extension() == ".argil") {
    engine::saveDocument(options.output, *loaded.document, options.job);
    const std::string without = loaded.steps == 0
                                    ? std::string()
                                    : fmt::format(", without the {} step{} of history that {} holds", loaded.steps,
                                                  loaded.steps == 1 ? "" : "s", options.input.string());
    fmt::print("{}: saved{}\n", options.output.string(), without);
    return;
  }
  engine::ModelExport what = exportOf(options, {});
  // What part of the triangles is wanted is known when there are some.
  if (options.reduce) what = exportOf(options, engine::modelOf(*loaded.document, what, options.job));
  for (const std::string& sentence : engine::writeModelFiles({options.output}, *loaded.document, what, options.job))
    fmt::print("{}\n", sentence);
}

void convertMesh(const ConvertOptions& options) {
  engine::ModelLook look;
  {
    const ProgressLine line("reading " + options.input.filename().string(), options.job);
    if (options.place.units != "auto")
      (void)engine::unitMm(options.place.units);  // A wrong name is told before the work.
    look = engine::lookAtModel(options.input, options.job);
  }
  const engine::Placement placement = engine::placementOf(look, options.place);
  for (const std::string& note : look.model->notes) fmt::print("{}\n", note);
  if (!options.place.up.empty() || options.place.heightMm || options.place.units == "auto")
    fmt::print("{}\n", engine::placeWords(look, placement, options.place));
  io::ModelFile model = *std::exchange(look.model, nullptr);
  if (std::any_of(model.objects.begin(), model.objects.end(), [](const auto& each) { return !each.places.empty(); }))
    fmt::print("Pictures become colours of vertices: detail between vertices is lost.\n");
  for (io::ModelObject& object : model.objects) io::picturesToVertices(object);
  engine::place(model.objects, placement);
  for (io::ModelObject& object : model.objects) {
    if (engine::turnOutwards(object.mesh))
      fmt::print("{} was inside out and was turned around.\n", object.name.empty() ? "The mesh" : object.name);
  }
  const engine::ModelExport how = exportOf(options, model.objects);
  if (how.recentre) fmt::print("{}\n", engine::recentre(model.objects));
  if (!model.negatives.empty()) fmt::print("{}; give --voxel.\n", io::notCutAway(model.negatives.size()));
  if (how.triangles || how.errorMm) {
    const ProgressLine line("reducing", options.job);
    fmt::print("{}\n", engine::reduceModel(model.objects, how, options.job));
  }
  if (const std::string left = engine::partCorners(model.objects); !left.empty()) fmt::print("{}\n", left);
  if (model.objects.size() == 1 && model.objects[0].name.empty()) model.objects[0].name = options.input.stem().string();
  for (const std::string& sentence : io::lossesOf(options.output, {model.objects, {}})) fmt::print("{}\n", sentence);
  const ProgressLine line("writing " + options.output.filename().string(), options.job);
  io::WriteOptions write;
  write.tolerance = 1e-3;
  write.weld = true;
  // Vertices that close a body are all meant, wherever they lie.
  const auto closes = [](const io::ModelObject& each) { return clay::checkTopology(each.mesh).boundaryEdges == 0; };
  write.distinct =
      io::endingOf(options.output) == ".stl" && std::all_of(model.objects.begin(), model.objects.end(), closes);
  write.draco = how.draco;
  const io::WriteReport report = io::writeModel(options.output, {model.objects, model.metadata}, write, options.job);
  if (report.deviation > 0)
    fmt::print("Packing moved the surface by at most {:.2g} mm.\n", clay::roundedUp(report.deviation));
  if (!report.warning.empty()) fmt::print(stderr, "{}\n", report.warning);
  fmt::print("{}: {} triangles, {} vertices, {} bytes, {}\n", options.output.string(), report.triangles,
             report.vertices, report.bytes, report.format);
}

}  // namespace

void convert(const ConvertOptions& options) {
  const clay::JobScope surfaces(options.job);
  if (options.reduce && options.errorMm) throw Error("--reduce and --error: give one of them");
  requireModel(options.input, options.place);
  const bool toClay = engine::holdsClay(options.output.filename());
  const bool toCad = io::isCad(options.output);
  if (!toClay && !toCad) io::requireWritable(options.output);
  if (options.faces && !toCad)
    throw Error(fmt::format("{}: --faces is for STEP and IGES; leave it out", options.output.string()));
  if (options.faces && !(*options.faces >= 24 && *options.faces <= 20000))
    throw Error(fmt::format("--faces {}: give 24 to 20000", *options.faces));
  if (options.textures && !options.quads) throw Error("--textures: give --quads too");
  if (options.mirror && !options.quads) throw Error("--mirror: give --quads too");
  if (options.alongGuides && !options.quads && !toCad) throw Error("--along-guides: give --quads too");
  if (options.maskDensity != 1 && !options.quads && !toCad) throw Error("--mask-density: give --quads too");
  if (!(options.maskDensity >= 1 / clay::kMostMaskDensity && options.maskDensity <= clay::kMostMaskDensity))
    throw Error(fmt::format("--mask-density {:g}: give {:g} to {:g}", options.maskDensity, 1 / clay::kMostMaskDensity,
                            clay::kMostMaskDensity));
  if (options.quads) {
    if (!io::holdsTextures(options.output))
      throw Error(fmt::format("{}: --quads is for .obj and .glb; leave it out", options.output.string()));
    if (!(*options.quads >= 24 && *options.quads <= 100000))
      throw Error(fmt::format("--quads {}: give 24 to 100000", *options.quads));
    if (options.textures && !(*options.textures >= 16 && *options.textures <= 16384))
      throw Error(fmt::format("--textures {}: give 16 to 16384 pixels", *options.textures));
    if (options.reduce || options.errorMm || options.recentre || options.draco)
      throw Error(
          fmt::format("{}: quads are made anew and keep their place; leave --reduce, --error, --recentre and "
                      "--draco out",
                      options.output.string()));
  }
  if (toCad && (options.reduce || options.recentre))
    throw Error(fmt::format("{}: CAD solids have no triangles, and keep their place; leave --reduce and --recentre out",
                            options.output.string()));
  if (toCad && options.errorMm && !(*options.errorMm > 0 && std::isfinite(*options.errorMm)))
    throw Error(fmt::format("--error {}: give mm above 0", *options.errorMm));
  if (toClay && (options.reduce || options.errorMm))
    throw Error(fmt::format("{}: clay has no triangles to be reduced; leave --reduce and --error out",
                            options.output.string()));
  if (toClay && options.recentre)
    throw Error(fmt::format("{}: clay keeps its place; leave --recentre out", options.output.string()));
  if (options.guides && io::endingOf(options.output) != ".argil")
    throw Error(fmt::format("{}: guides are kept in .argil files alone; leave --guides out", options.output.string()));
  if (options.guides && engine::holdsClay(options.input))
    throw Error(fmt::format("{}: --guides are those of a CAD model's faces; leave it out", options.input.string()));
  if (options.recentre && options.putBack) throw Error("--recentre and --put-back: give one of them");
  const bool byWayOfClay =
      toClay || toCad || options.quads || options.voxelMm || options.bits || engine::holdsClay(options.input);
  if (options.putBack && (!byWayOfClay || io::endingOf(options.output) == ".argil"))
    throw Error(fmt::format("{}: --put-back is for clay that becomes a model or a level set; leave it out",
                            options.output.string()));
  if (!options.destination.empty()) {
    engine::ModelExport none;
    engine::applyPreset(engine::exportPresetNamed(options.destination), options.output, none);
  }
  const std::string ending = io::endingOf(options.output);
  io::requireNewFiles({&options.input, 1}, outputsOf(options), options.overwrite);
  if (!io::frameEndingOf(ending).empty()) {
    const ProgressLine line("writing " + options.output.filename().string(), options.job);
    fmt::print("{}\n", engine::writeHistory(options.output, options.input, exportOf(options, {}), options.job));
    return;
  }
  if (options.draco && ending != ".glb" && ending != ".gltf")
    throw Error(fmt::format("{}: --draco packs .glb and .gltf alone; leave it out", options.output.string()));
  if (byWayOfClay)
    convertClay(options);
  else
    convertMesh(options);
}

}  // namespace argil::cli
