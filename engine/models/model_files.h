#pragma once
// Models come in from files and go out to them.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/reduce.h"
#include "clay/surface/surface.h"
#include "engine/document/document.h"
#include "engine/models/import_place.h"
#include "io/models/model_file.h"

namespace argil::engine {

/// Voxel sizes, mm, of the pieces that Argil wrote into a 3MF file, in the order of its objects; empty for other files.
[[nodiscard]] std::vector<double> savedVoxelsMm(const io::ModelFile& model);

/// mm in one unit: mm, um, cm, m, in or ft. Throws Error for another name.
[[nodiscard]] double unitMm(const std::string& units);

struct ModelImport {
  std::string units = "mm";            ///< Where the file names none; as ImportPlace::units.
  std::optional<double> voxelMm = {};  ///< None: as savedVoxelsMm() says, else 256 along the longest side; level sets
                                       ///< keep their own.
  clay::Precision precision = clay::Precision::float32;
  std::optional<double> fitMm = {};  ///< Centred at zero and scaled until the longest side is this.
  std::string up = {};               ///< These as ImportPlace has them.
  std::optional<double> heightMm = {};
  bool stands = false;
  std::shared_ptr<const ModelLook> look = {};  ///< The file, where it was read already.
  bool asPart = false;                         ///< Stays as it is: parts.
  bool guides = false;                         ///< Of the faces of a CAD model (FaceGuides).
  [[nodiscard]] ImportPlace place() const { return {units, up, heightMm, stands}; }
  /// Gets the mesh as soon as it is read, in mm, long before it is clay: to be shown meanwhile.
  std::function<void(std::shared_ptr<const clay::TriangleMesh>)> onRead = {};
};
/// Pieces or parts: one an object of the file, or all as one when there are many or some are no solid alone. Parts can
/// be felt.
struct ImportedModel {
  std::vector<Piece> pieces;
  std::vector<Part> parts;
  std::vector<Guide> guides;
  std::vector<std::string> notes;  ///< What was found and done, a sentence each.
};
/// Meshes, models and level sets (.vdb). Throws Error that names the file, Cancelled.
[[nodiscard]] ImportedModel importModel(const std::filesystem::path& file, const ModelImport& how, Job* job = nullptr);

/// What of a document goes out, and how fine.
struct ModelExport {
  Id piece = 0;                           ///< This piece alone; 0: all that count.
  bool visibleOnly = true;                ///< Else every piece.
  std::optional<uint64_t> triangles;      ///< Reduced to at most so many in all, or
  std::optional<double> errorMm;          ///< to as few as keep within this.
  bool recentre = false;                  ///< Moved to zero: 32-bit numbers are finest there.
  bool putBack = false;                   ///< Each piece where the file that it was imported from had it.
  bool draco = false;                     ///< glTF packed with Draco: a tenth of the size; fewer programs open it.
  std::optional<size_t> quads;            ///< OBJ and GLB: quads a piece at most (clay::flatQuads()), not triangles,
  bool mirrored = false;                  ///< images of each other on both sides of a plane that mirrors the clay,
  int texturePixels = 0;                  ///< and pictures of so many pixels a side on them; 0: none.
  size_t cadQuads = 500;                  ///< STEP and IGES: smooth faces of each piece, at most;
  std::optional<double> cadErrorMm;       ///< of these as few as keep within this.
  bool alongGuides = false;               ///< Quads and faces: edges follow the closed curves that are shown,
  double maskDensity = 1;                 ///< and so many times as many lie where the clay is masked, 1/16 to 16.
  clay::Grade grade = clay::Grade::fine;  ///< A file is made once: creases are worth the time.
};

/// The surfaces of the pieces, one object each, in world mm, with names and colours; each closed. Throws Error when
/// there is none, Cancelled.
[[nodiscard]] std::vector<io::ModelObject> modelOf(const Document& document, const ModelExport& what,
                                                   Job* job = nullptr);

/// Reduces each object by its share; says in a sentence what was done and how far the shape moved, measured.
std::string reduceModel(std::vector<io::ModelObject>& objects, const ModelExport& how, Job* job = nullptr);

/// Leaves no triangle with two corners in one place: moves them apart where the triangles close a body, leaves such
/// triangles out elsewhere, and objects that have no others. Says how many were left out; empty for none. Throws Error
/// when nothing is left.
std::string partCorners(std::vector<io::ModelObject>& objects);

/// The same surfaces as one mesh.
[[nodiscard]] clay::TriangleMesh meshOf(const Document& document, Id piece, bool visibleOnly, Job* job = nullptr);

/// Writes a document's pieces to files by the endings of their names, each whole or not at all; gives a sentence for
/// each. Throws Error, Cancelled.
std::vector<std::string> writeModelFiles(const std::vector<std::filesystem::path>& files, const Document& document,
                                         const ModelExport& what, Job* job = nullptr);

/// Writes every state of a saved document, from its beginning to the one that it opens with, to files of their own,
/// NAME-0001 and so on beside `file`, in the format of that one's ending (io::frameEndingOf()); states that look alike
/// once. A document without a history is one state. Each file whole or not at all; gives a sentence. Throws Error,
/// Cancelled: files that were written by then stay.
[[nodiscard]] std::string writeHistory(const std::filesystem::path& file, const std::filesystem::path& document,
                                       const ModelExport& what, Job* job = nullptr);

}  // namespace argil::engine
