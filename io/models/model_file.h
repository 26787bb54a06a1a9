#pragma once
// Models from files, with what meshes alone do not say: several objects, names, units, colours.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"
#include "io/models/picture.h"

namespace argil::io {

/// sRGB with alpha, 255 opaque.
struct Colour {
  uint8_t red = 255, green = 255, blue = 255, alpha = 255;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// What a face of a CAD model gives to construct with: the plane that it lies in, the axis or the middle that it turns
/// around.
struct ModelFace {
  enum class Kind : uint8_t { plane, axis, middle };
  Kind kind = Kind::plane;
  Vec3d at = Vec3d::Zero();       ///< Middle of the part of the plane or the axis that is used; the middle.
  Vec3d along = Vec3d::UnitZ();   ///< The plane's normal, outwards; the axis.
  Vec3d across = Vec3d::UnitX();  ///< Perpendicular to it.
  double width = 0, depth = 0;    ///< A plane's sizes along and perpendicular to `across`; length and radius; radius.
};

/// A base colour picture as a surface has it.
struct SurfacePicture {
  enum class Wrap : uint8_t { repeat, mirror, clamp };  ///< Beyond the picture's edges.
  enum class Alpha : uint8_t {
    opaque,  ///< The picture's alpha counts for nothing.
    mask,    ///< Below `cutoff` there is no colour.
    blend,   ///< So much of the colour covers what is below.
  };
  std::shared_ptr<const ColourImage> picture;
  std::array<float, 4> factor{1, 1, 1, 1};  ///< Multiplies the picture: linear light and alpha.
  Wrap wrapU = Wrap::repeat, wrapV = Wrap::repeat;
  Alpha alpha = Alpha::opaque;
  float cutoff = 0.5f;
  bool tinted = false;  ///< Multiplied by the colours of vertices, too.
};

/// Places on a picture of a triangle's corners: 0 to 1, v from the top down.
struct PicturePlaces {
  static constexpr uint32_t kNone = UINT32_MAX;
  std::array<std::array<float, 2>, 3> corners{};
  uint32_t picture = kNone;  ///< In ModelObject::pictures; kNone: the triangle has none.
};

/// One thing of a model, placed: all transforms of the file are applied (an odd mirror also turns the triangles).
struct ModelObject {
  std::string name;                     ///< As the file has it; may be empty.
  clay::TriangleMesh mesh;              ///< In the file's unit.
  std::vector<Colour> vertexColours;    ///< One a vertex, or empty.
  std::vector<Colour> triangleColours;  ///< One a triangle, or empty: goes before vertexColours.
  std::optional<Colour> colour;         ///< Of the whole, where the file says so.
  std::vector<SurfacePicture> pictures;
  std::vector<PicturePlaces> places;  ///< One a triangle, or empty: pictures go before all other colours.
  std::vector<ModelFace> faces;       ///< Of STEP and IGES: planes, cylinders, cones, tori, balls. In the file's unit.
  uint32_t assembly = 0;  ///< Objects of one are printed as one: what is cut away is cut from those of the same.
};

/// What a file held. All coordinates are finite, all indices in range, each object has at least one triangle and there
/// is at least one object; nothing is promised about topology.
struct ModelFile {
  std::vector<ModelObject> objects;
  std::vector<ModelObject>
      negatives;  ///< What slicers cut away from the objects of the same assembly; held to the same promises.
  std::optional<double> unitMm;  ///< mm in one unit where the format says so (3MF; glTF: 1000); none: ask the person.
  std::string format;            ///< "STL (binary)", "3MF", "glTF (binary, Draco)", ...
  uint64_t faces = 0;            ///< As the file has them, before polygons became triangles.
  uint64_t polygons = 0;         ///< Faces of more than three corners.
  bool welded = false;           ///< Vertices of equal coordinates were made one.
  std::vector<std::pair<std::string, std::string>> metadata;  ///< Title, designer and the like.
  std::vector<std::string> notes;  ///< What was there and is not kept, a sentence each, for the person.
};

/// Reads a model of any format there is: STL, OBJ, PLY, OFF, 3MF, glTF, Draco, STEP, IGES; the first four and 3MF also
/// out of .gz and a .zip of one model. The content says which, the ending only where the content does not. What other
/// people's libraries parse is parsed in a process of its own (reader_process.h). Throws Error as readMesh does;
/// Cancelled. Any thread.
[[nodiscard]] ModelFile readModel(const std::filesystem::path& path, Job* job = nullptr);

/// ".stl, .obj, ...": what readModel reads, and what writeModel writes.
[[nodiscard]] std::string readableEndings();
[[nodiscard]] std::string writableEndings();

/// The same from memory, for formats that this program reads itself.
[[nodiscard]] ModelFile parseModel(std::span<const std::byte> bytes, const std::string& name, Job* job = nullptr);

/// The objects as one. Colours stay where some object has them: the others are white. Where some have colours of
/// vertices and some of triangles, triangles get the mean of their corners.
[[nodiscard]] ModelObject merged(std::vector<ModelObject>&& objects);

/// Rounded to the nearest.
[[nodiscard]] Colour meanOf(const Colour& a, const Colour& b, const Colour& c);

/// What a reader says that leaves ModelFile::negatives out.
[[nodiscard]] std::string notCutAway(size_t negatives);

/// Mean of an object's colours by area; none when it has none. Alpha is the mean of how much pictures cover.
[[nodiscard]] std::optional<Colour> meanColour(const ModelObject& object);

}  // namespace argil::io
