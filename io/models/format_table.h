#pragma once
// The mesh formats as rows of a table, and what a row needs. For this module's files.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "io/bytes/byte_sink.h"
#include "io/bytes/input.h"
#include "io/models/mesh_file.h"
#include "io/models/mesh_writer.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"

namespace argil::io {

/// Writes one format: begin, all vertices in order, all triangles in order (each object's behind its name), end. What
/// it is given was checked.
class MeshEncoder {
 public:
  virtual ~MeshEncoder() = default;
  virtual void begin(ByteSink& sink, const MeshCounts& counts) = 0;
  virtual void vertices(ByteSink& sink, std::span<const Vec3d> positions) = 0;
  /// The same when counts.colours, one colour a vertex. A format without colours leaves them out.
  virtual void colouredVertices(ByteSink& sink, std::span<const Vec3d> positions, std::span<const Colour> colours) {
    static_cast<void>(colours);
    vertices(sink, positions);
  }
  /// The triangles that follow are those of an object of this name. A format without names leaves it out.
  virtual void object(ByteSink& sink, const std::string& name) {
    static_cast<void>(sink);
    static_cast<void>(name);
  }
  virtual void triangles(ByteSink& sink, std::span<const std::array<uint32_t, 3>> triangles) = 0;
  /// The same when counts.triangleColours, one colour a triangle. A format without them leaves them out.
  virtual void colouredTriangles(ByteSink& sink, std::span<const std::array<uint32_t, 3>> list,
                                 std::span<const Colour> colours) {
    static_cast<void>(colours);
    triangles(sink, list);
  }
  virtual void end(ByteSink& sink) = 0;
};

struct Format {
  std::string_view name;
  std::string_view extension;  ///< Lower case with its dot.
  /// True when the content can be nothing else. `bytes` may be the beginning of the file alone for a row that is read
  /// in a process.
  bool (*recognizes)(const Input&);
  // How it is read: exactly one of the three, or none when the format is only written.
  MeshFile (*parseMesh)(const Input&) = nullptr;
  ModelFile (*parseModel)(const Input&) = nullptr;
  std::function<ModelFile(const std::filesystem::path&, Job*)> readInProcess = nullptr;
  // How it is written: piece by piece, or as a whole, or not.
  std::unique_ptr<MeshEncoder> (*encoder)(const WriteOptions&) = nullptr;
  /// Puts the model, which was checked, into the file and says in the report what was lost; the caller counts and
  /// commits. May throw Error, Cancelled.
  std::function<void(AtomicFile&, const ModelView&, const WriteOptions&, WriteReport&, Job*)> write = nullptr;
  bool singlePrecision = false;  ///< Coordinates are written as 32-bit numbers.
  // What a file of it can say.
  bool objects = false;  ///< Several, with names.
  bool colours = false;  ///< Of vertices, and so of the whole.
  bool triangleColours = false;
  bool byEnding = false;              ///< Was added: its ending says more than what other formats find in the content.
  std::string_view frameEnding = {};  ///< AddedFormat::frameEnding.
};

/// Those of the program, then those that were added (added_formats.h). Any thread; what was returned stays.
[[nodiscard]] std::span<const Format> formats();

bool recognizesStl(const Input&);
ModelFile parseStl(const Input&);
std::unique_ptr<MeshEncoder> makeStlEncoder(const WriteOptions&);

bool recognizesObj(const Input&);
ModelFile parseObj(const Input&);
std::unique_ptr<MeshEncoder> makeObjEncoder(const WriteOptions&);

bool recognizesPly(const Input&);
MeshFile parsePly(const Input&);
std::unique_ptr<MeshEncoder> makePlyEncoder(const WriteOptions&);

bool recognizesOff(const Input&);
MeshFile parseOff(const Input&);

bool recognizesGlb(const Input&);
bool recognizesGltf(const Input&);
ModelFile readGltf(const std::filesystem::path&, Job*);
void writeGlb(AtomicFile&, const ModelView&, const WriteOptions&, WriteReport&, Job*);
/// With its buffers inside, as two files do not appear as one.
void writeGltf(AtomicFile&, const ModelView&, const WriteOptions&, WriteReport&, Job*);

bool recognizesDraco(const Input&);
ModelFile readDraco(const std::filesystem::path&, Job*);
void writeDraco(AtomicFile&, const ModelView&, const WriteOptions&, WriteReport&, Job*);

bool recognizesStep(const Input&);
bool recognizesIges(const Input&);
/// STEP and IGES, in mm.
ModelFile readCad(const std::filesystem::path&, Job*);

}  // namespace argil::io
