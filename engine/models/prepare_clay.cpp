#include "engine/models/prepare_clay.h"

#include <fmt/format.h>

#include <algorithm>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/import/mesh_to_clay.h"
#include "engine/models/cut_negatives.h"
#include "engine/models/import_place.h"
#include "engine/models/load_document.h"
#include "engine/models/model_colours.h"
#include "io/bytes/input.h"
#include "io/models/model_file.h"

namespace argil::engine {
namespace {

constexpr double kMade = 0.9;  // of an import, when there is clay and no colour yet
constexpr double kShapeVoxelMm = 0.5;

// Turns y up to z up; what looked along +z then looks along -y, to the front.
void standUp(clay::TriangleMesh& mesh) {
  for (Vec3d& position : mesh.positions) position = Vec3d(position.x(), -position.z(), position.y());
}

bool isYUp(const io::ModelFile& file, Up up) {
  return up == Up::y || (up == Up::custom && (file.format.starts_with("OBJ") || file.format.starts_with("OFF")));
}

bool beginsWithAPiece(const Script& script) {
  if (script.operations.empty() || script.operations.front().before > 0) return false;
  const PieceJob* row = findPieceJob(script.operations.front().id);
  return row && row->makesNew();
}

PreparedClay importMesh(std::shared_ptr<clay::Store> store, const std::filesystem::path& file, const Script& script,
                        const std::optional<double>& voxelMm, Job* job) {
  PreparedClay prepared;
  if (holdsClay(file)) {
    const LoadedDocument loaded = loadDocument(file, {}, job);
    const Piece* piece = loaded.document->piece(loaded.document->active);
    if (!piece) throw Error(file.string() + ": has no piece to work on");
    prepared.version = piece->version;
    prepared.document = *loaded.document;
    prepared.notes = loaded.notes;
    if (voxelMm || script.fitMm)
      prepared.notes.push_back("The clay stays as it was saved: voxel and size of the script do not apply to it.");
    return prepared;
  }
  io::ModelFile model = io::readModel(file, job);
  prepared.notes = std::move(model.notes);
  io::ModelObject read = io::merged(std::move(model.objects));
  const std::optional<io::Colour> mean = io::meanColour(read);
  clay::TriangleMesh* const meshes[] = {&read.mesh};
  std::vector<clay::TriangleMesh*> negatives;
  for (io::ModelObject& negative : model.negatives) {
    negative.assembly = read.assembly;  // as all objects are one here
    negatives.push_back(&negative.mesh);
  }
  const bool turned = isYUp(model, script.up);
  for (const Meshes& some : {Meshes(meshes), Meshes(negatives)}) {
    for (clay::TriangleMesh* mesh : some) {
      for (Vec3d& position : mesh->positions) position *= model.unitMm.value_or(1);
      if (turned) standUp(*mesh);
    }
  }
  if (turned) prepared.notes.push_back("Turned so that its y axis points up.");
  if (script.fitMm) prepared.notes.push_back(fitMeshes(meshes, *script.fitMm, negatives));
  const Vec3d moved = bringNear(meshes, negatives);
  if (std::string words = movedWords(moved); !words.empty()) prepared.notes.push_back(std::move(words));
  clay::Imported imported;
  try {
    const ClayQuality quality = script.quality.value_or(Quality()).clay;
    clay::ImportOptions options;
    options.grid.voxelMm = voxelMm ? *voxelMm : clay::suggestVoxelMm(read.mesh, int(quality.voxelsAcross));
    options.grid.band = static_cast<float>(quality.band);
    imported = clay::meshToClay(std::move(store), read.mesh, options, job);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what(), e.kind());
  }
  const auto sentences = imported.report.sentences();
  prepared.notes.insert(prepared.notes.end(), sentences.begin(), sentences.end());
  prepared.version = withColours(std::move(imported.version), read.mesh, read, clay::WorkPart(job, kMade, 1));
  prepared.version = withoutNegatives(std::move(prepared.version), read.assembly, model.negatives, prepared.notes, job);
  if (prepared.version.stats().bricks == 0)
    throw Error(file.string() + ": nothing is left when its negative volumes are cut away");
  prepared.document = Document::of(prepared.version);
  if (const auto colour = pieceColourOf(read, mean)) prepared.document.pieces.front().colour = *colour;
  if (!script.fitMm) prepared.document.pieces.front().fileOffsetMm = fileOffset(moved);
  return prepared;
}

// Of a block or a ball; of another beginning what shapes are made with.
double longestSide(const Script& script) {
  if (const auto* block = std::get_if<BlockSetup>(&script.clay)) return block->sizeMm.maxCoeff();
  if (const auto* sphere = std::get_if<SphereSetup>(&script.clay)) return 2 * sphere->radiusMm;
  return kShapeVoxelMm * script.quality->clay.voxelsAcross;
}

PreparedClay makeClay(std::shared_ptr<clay::Store> store, const Script& script, const PrepareOptions& options) {
  const std::optional<double> voxelMm = options.voxelMm ? options.voxelMm : script.voxelMm;
  if (!options.input.empty()) return importMesh(std::move(store), options.input, script, voxelMm, options.job);
  if (const auto* import = std::get_if<ImportSetup>(&script.clay)) {
    return importMesh(std::move(store), import->file, script, voxelMm, options.job);
  }
  PreparedClay prepared;
  clay::Grid grid;
  grid.voxelMm = voxelMm.value_or(kShapeVoxelMm);
  if (script.quality) {
    grid.band = static_cast<float>(script.quality->clay.band);
    if (!voxelMm) grid.voxelMm = longestSide(script) / script.quality->clay.voxelsAcross;
  }
  if (const auto* block = std::get_if<BlockSetup>(&script.clay)) {
    grid.originMm = block->centreMm;
    prepared.version = clay::makeBlock(std::move(store), grid, block->centreMm, block->sizeMm, block->roundMm);
  } else if (const auto* sphere = std::get_if<SphereSetup>(&script.clay)) {
    grid.originMm = sphere->centreMm;
    prepared.version = clay::makeSphere(std::move(store), grid, sphere->centreMm, sphere->radiusMm);
  } else if (beginsWithAPiece(script)) {
    return prepared;
  } else {
    throw Error("the script sets up no clay: give it a block, a sphere or an import in \"setup\", or a mesh with -i");
  }
  prepared.document = Document::of(prepared.version);
  return prepared;
}

}  // namespace

PreparedClay prepareClay(std::shared_ptr<clay::Store> store, const Script& script, const PrepareOptions& options) {
  PreparedClay prepared = makeClay(std::move(store), script, options);
  if (script.quality) prepared.document.quality = script.quality->strokes;
  // Seen alone: the script's own are what its hands feel.
  for (const GuideSetup& each : script.guides) {
    if (each.kind != GuideSetup::Kind::lockToCurve && each.kind != GuideSetup::Kind::wellAtCurve) continue;
    Guide curve;
    curve.kind = Guide::Kind::curve;
    curve.pointsMm = each.pointsMm;
    curve.closed = each.closed;
    prepared.document.add(std::move(curve));
  }
  return prepared;
}

}  // namespace argil::engine
