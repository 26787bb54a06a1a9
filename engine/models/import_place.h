#pragma once
// How a model that was read stands in the world: unit, up axis, height, ground. What its file does not say is guessed.

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/wall_thickness.h"
#include "engine/document/size_words.h"
#include "io/models/model_file.h"

namespace argil::engine {

/// The direction of the file that points up in the world, where z is up.
enum class UpAxis : uint8_t { z, y, minusZ, minusY, x, minusX };
/// "z", "y", "-z", "-y", "x", "-x", in the order of the enumeration.
[[nodiscard]] std::span<const std::string_view> upAxisNames();
/// Throws Error for another name.
[[nodiscard]] UpAxis upAxisNamed(const std::string& name);
[[nodiscard]] Vec3d standUp(UpAxis up, const Vec3d& place);

/// What is wished for. Names of units are those of unitMm(), and "auto".
struct ImportPlace {
  std::string units = "mm";             ///< Where the file names none. "auto": guessed.
  std::string up;                       ///< An axis of the file, or "auto": guessed. Empty: as the file lies.
  std::optional<double> heightMm = {};  ///< Scaled until it is so high, 1e-3 to 1e6.
  bool stands = false;                  ///< The lowest point at z = 0, the middle at x = y = 0.
};

/// A model that was read, and what its file does not say.
struct ModelLook {
  std::shared_ptr<const io::ModelFile> model;
  Vec3d low, high;         ///< In the file's own unit and axes.
  double area = 0;         ///< Of all triangles, in the file's unit, squared.
  std::string units;       ///< The unit that the format prescribes, else a guess by its size and the kind of file.
  bool unitsSaid = false;  ///< The format prescribes the unit.
  UpAxis up = UpAxis::z;   ///< The axis that the format prescribes, else a guess by its shape.
  bool upSaid = false;     ///< The format prescribes the axis.
};

/// Throws Error that names the file, Cancelled. Cost: reading the file.
[[nodiscard]] ModelLook lookAtModel(const std::filesystem::path& file, Job* job = nullptr);
/// The same for a model that was read. The ending of `file` says what the format's convention is. O(triangles).
[[nodiscard]] ModelLook lookAtModel(std::shared_ptr<const io::ModelFile> model, const std::filesystem::path& file);

/// What is worth knowing before clay is made of a model, and takes a second.
struct ModelDetails {
  std::vector<bool> solid;  ///< Of each object: closed, so that it bounds a solid; else a sheet or with holes.
  /// Of all, in the file's unit: what voxels would lose. No points for models of more than kMostWallTriangles, whose
  /// search trees take gigabytes.
  clay::WallThickness walls;
};
/// Throws Cancelled.
[[nodiscard]] ModelDetails detailsOf(const ModelLook& look, Job* job = nullptr);
inline constexpr size_t kMostWallTriangles = 8'000'000;

/// A wish made definite for one model: nothing of it is "auto". mm in one unit of the file, and the factor that the
/// height asks for.
struct Placement {
  double mm = 1;
  UpAxis up = UpAxis::z;
  double scale = 1;  ///< On top of `mm`.
  Vec3d sizeMm;      ///< Width, depth and height as they will be.
  Vec3d moveMm;      ///< After scaling and turning.
  [[nodiscard]] Vec3d apply(const Vec3d& place) const { return standUp(up, place) * (mm * scale) + moveMm; }
};
/// Throws Error for a wish that cannot be met (a height of a model without one, a height out of range, an unknown unit
/// or axis).
[[nodiscard]] Placement placementOf(const ModelLook& look, const ImportPlace& wish);
/// Moves all vertices.
void place(std::vector<io::ModelObject>& objects, const Placement& placement);
/// Turns a mesh around that bounds a solid, vertices at one place taken as one, and whose faces point inwards; true
/// when it was. O(triangles).
[[nodiscard]] bool turnOutwards(clay::TriangleMesh& mesh);

using Meshes = std::span<clay::TriangleMesh* const>;

/// Clay reaches 10^6 mm from zero: meshes that lie farther off are moved together, by whole millimetres, until their
/// middle is there; by how much, zero where they did not have to be. `others` go along and do not count.
Vec3d bringNear(Meshes meshes, Meshes others = {});
/// What undoes a move of import (Piece::fileOffsetMm); zero where coordinates would lose a tenth of a µm by it.
[[nodiscard]] Vec3d fileOffset(const Vec3d& movedMm);
/// A sentence for the user; empty for zero.
[[nodiscard]] std::string movedWords(const Vec3d& byMm);

/// Centres meshes at zero together and scales the longest side of them all to `fitMm`; says so in a sentence. `others`
/// go along and do not count.
std::string fitMeshes(Meshes meshes, double fitMm, Meshes others = {});

/// Moves all objects together until their middle is at zero; says by how much.
std::string recentre(std::vector<io::ModelObject>& objects);

/// "inches" for "in".
[[nodiscard]] std::string unitName(const std::string& units);
/// "120 × 80 × 200 mm, its numbers read as mm, z up." for the user.
[[nodiscard]] std::string placeWords(const ModelLook& look, const Placement& placement, const ImportPlace& wish);

}  // namespace argil::engine
