#include "engine/models/import_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "engine/models/model_files.h"
#include "io/bytes/input.h"

namespace argil::engine {
namespace {

constexpr double kFarMm = 0.9e6;  // clay's origin may lie 10^6 mm from zero, and has a margin

Eigen::AlignedBox3d boxOf(Meshes meshes) {
  Eigen::AlignedBox3d box;
  for (const clay::TriangleMesh* mesh : meshes)
    for (const Vec3d& position : mesh->positions) box.extend(position);
  return box;
}

constexpr std::array<std::string_view, 6> kUpNames{"z", "y", "-z", "-y", "x", "-x"};
constexpr double kLeastHeightMm = 1e-3, kMostHeightMm = 1e6;

// Where a model's own size tells its unit: the first row of its kind that is longer than the longest side. The limits
// follow what such files usually hold. STL is written by CAD programs, in mm or inches, and seldom by scanners, in
// metres: what is 6 units long and more is 6 mm and more, below that a part of 6 inches is likelier than one of 6 mm.
// The others are written by scanners in metres and by modellers in metres or centimetres.
struct UnitRow {
  bool printing;  // The kind of file: STL, or another one.
  double below;   // Longest side in the unit of the file.
  const char* units;
};
constexpr std::array kUnitRows{
    UnitRow{true, 0.4, "m"}, UnitRow{true, 6, "in"},   UnitRow{true, HUGE_VAL, "mm"},
    UnitRow{false, 3, "m"},  UnitRow{false, 30, "cm"}, UnitRow{false, HUGE_VAL, "mm"},
};

// A flat base that a model stands on: the area of triangles that lie at its lower end and face down, as a part of its
// box's cross section. A hundredth of the height is what scans of flat bases are uneven by; 0.9 is the cosine of 26
// degrees.
constexpr double kBaseHeight = 0.01, kFacesDown = 0.9;
// Bases of real models take 0.05 (the soles of a standing figure) to 0.9 of the cross section; shapes without one have
// less than 0.02.
constexpr double kLeastBase = 0.04;
// The other axis must have so many times more before the convention of the format is not followed.
constexpr double kClearly = 3;

double baseUnder(const io::ModelFile& model, const Vec3d& low, const Vec3d& high, int axis) {
  const Vec3d size = high - low;
  const double section = size[(axis + 1) % 3] * size[(axis + 2) % 3], end = low[axis] + kBaseHeight * size[axis];
  double area = 0;
  for (const io::ModelObject& object : model.objects) {
    const auto& p = object.mesh.positions;
    for (const auto& t : object.mesh.triangles) {
      const Vec3d &a = p[t[0]], &b = p[t[1]], &c = p[t[2]];
      if (std::max({a[axis], b[axis], c[axis]}) > end) continue;
      const Vec3d normal = (b - a).cross(c - a);
      const double twice = normal.norm();
      if (normal[axis] < -kFacesDown * twice) area += twice / 2;
    }
  }
  return section > 0 ? area / section : 0;
}

// STL comes from programs for printers and CAD, where z is up. OBJ, OFF, PLY and Draco come from modellers and
// scanners: y is.
UpAxis guessUp(const io::ModelFile& model, const Vec3d& low, const Vec3d& high, bool zUsual) {
  const double y = baseUnder(model, low, high, 1), z = baseUnder(model, low, high, 2);
  const double usual = zUsual ? z : y, other = zUsual ? y : z;
  const bool otherwise = other >= kLeastBase && other >= kClearly * usual;
  return zUsual != otherwise ? UpAxis::z : UpAxis::y;
}

}  // namespace

std::span<const std::string_view> upAxisNames() {
  return kUpNames;
}

UpAxis upAxisNamed(const std::string& name) {
  const auto at = std::find(kUpNames.begin(), kUpNames.end(), name);
  if (at == kUpNames.end()) throw Error(fmt::format("up {}: give z, y, -z, -y, x, -x or auto", name));
  return static_cast<UpAxis>(at - kUpNames.begin());
}

Vec3d standUp(UpAxis up, const Vec3d& p) {
  switch (up) {
    case UpAxis::z:
      return p;
    case UpAxis::y:
      return {p.x(), -p.z(), p.y()};
    case UpAxis::minusZ:
      return {p.x(), -p.y(), -p.z()};
    case UpAxis::minusY:
      return {p.x(), p.z(), -p.y()};
    case UpAxis::x:
      return {-p.z(), p.y(), p.x()};
    case UpAxis::minusX:
      return {p.z(), p.y(), -p.x()};
  }
  return p;
}

ModelLook lookAtModel(std::shared_ptr<const io::ModelFile> model, const std::filesystem::path& file) {
  ModelLook look;
  Eigen::AlignedBox3d box;
  for (const io::ModelObject& object : model->objects)
    for (const Vec3d& position : object.mesh.positions) box.extend(position);
  for (const io::ModelObject& object : model->objects)
    for (const auto& t : object.mesh.triangles) {
      const auto& p = object.mesh.positions;
      look.area += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm() / 2;
    }
  look.low = box.min();
  look.high = box.max();
  const std::string ending = io::endingOf(file);
  const bool stl = ending == ".stl", gltf = ending == ".gltf" || ending == ".glb", threeMf = ending == ".3mf";
  if (model->unitMm) {
    look.unitsSaid = true;
    for (const char* units : {"mm", "um", "cm", "m", "in", "ft"})
      if (std::abs(unitMm(units) - *model->unitMm) < 1e-9 * *model->unitMm) look.units = units;
    if (look.units.empty()) look.units = fmt::format("{:g} mm", *model->unitMm);
  } else {
    const double longest = (look.high - look.low).maxCoeff();
    look.units = std::find_if(kUnitRows.begin(), kUnitRows.end(), [&](const UnitRow& row) {
                   return row.printing == stl && longest < row.below;
                 })->units;
  }
  look.upSaid = gltf || threeMf;  // The reader of glTF has turned its y up already.
  look.up = look.upSaid ? UpAxis::z : guessUp(*model, look.low, look.high, stl);
  look.model = std::move(model);
  return look;
}

ModelLook lookAtModel(const std::filesystem::path& file, Job* job) {
  return lookAtModel(std::make_shared<const io::ModelFile>(io::readModel(file, job)), file);
}

ModelDetails detailsOf(const ModelLook& look, Job* job) {
  constexpr double kKinds = 0.2;  // of the work, about
  ModelDetails details;
  size_t triangles = 0;
  for (const io::ModelObject& object : look.model->objects) {
    if (job) job->step(kKinds * double(details.solid.size()) / double(look.model->objects.size()));
    // As it becomes clay: vertices of open edges are one at one place.
    details.solid.push_back(clay::checkTopology(clay::weldOpenEdges(object.mesh)).solid());
    triangles += object.mesh.triangles.size();
  }
  if (triangles > kMostWallTriangles) return details;
  const clay::WorkPart part(job, kKinds, 1);
  if (look.model->objects.size() == 1) {
    details.walls = clay::wallThickness(look.model->objects[0].mesh, part);
  } else {
    std::vector<io::ModelObject> copies = look.model->objects;
    details.walls = clay::wallThickness(io::merged(std::move(copies)).mesh, part);
  }
  return details;
}

Placement placementOf(const ModelLook& look, const ImportPlace& wish) {
  Placement placement;
  const double given = wish.units == "auto" ? 0 : unitMm(wish.units);  // A wrong name is told for any file.
  placement.mm = look.model->unitMm.value_or(wish.units == "auto" ? unitMm(look.unitsSaid ? "mm" : look.units) : given);
  placement.up = wish.up.empty() ? UpAxis::z : wish.up == "auto" ? look.up : upAxisNamed(wish.up);
  const Vec3d one = standUp(placement.up, look.low), two = standUp(placement.up, look.high);
  const Vec3d low = one.cwiseMin(two), high = one.cwiseMax(two);
  if (wish.heightMm) {
    if (!(*wish.heightMm >= kLeastHeightMm && *wish.heightMm <= kMostHeightMm))
      throw Error(fmt::format("height {:g}: give {:g} to {:g} mm", *wish.heightMm, kLeastHeightMm, kMostHeightMm));
    const double height = (high.z() - low.z()) * placement.mm;
    if (!(height > 0))
      throw Error(
          "the model is flat along the axis that points up, so it has no height that could be set: choose another "
          "axis");
    placement.scale = *wish.heightMm / height;
  }
  const double all = placement.mm * placement.scale;
  placement.sizeMm = (high - low) * all;
  placement.moveMm = wish.stands ? Vec3d(-all * Vec3d((low.x() + high.x()) / 2, (low.y() + high.y()) / 2, low.z()))
                                 : Vec3d(Vec3d::Zero());
  return placement;
}

bool turnOutwards(clay::TriangleMesh& mesh) {
  clay::TopologyReport found = clay::checkTopology(mesh);
  if (found.boundaryEdges > 0) found = clay::checkTopology(clay::weldOpenEdges(mesh));
  if (!found.solid() || !(found.volume < 0)) return false;
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return true;
}

Vec3d bringNear(Meshes meshes, Meshes others) {
  const Eigen::AlignedBox3d box = boxOf(meshes);
  if (box.isEmpty() || std::max(box.max().cwiseAbs().maxCoeff(), box.min().cwiseAbs().maxCoeff()) < kFarMm)
    return Vec3d::Zero();
  const Vec3d by = -box.center().array().round().matrix();
  for (const Meshes& some : {meshes, others})
    for (clay::TriangleMesh* mesh : some)
      for (Vec3d& position : mesh->positions) position += by;
  return by;
}

Vec3d fileOffset(const Vec3d& movedMm) {
  constexpr double kMostMm = 1e12;
  if (!(movedMm.cwiseAbs().maxCoeff() < kMostMm)) return Vec3d::Zero();
  return -movedMm;
}

std::string movedWords(const Vec3d& by) {
  if (by.isZero(0)) return {};
  return fmt::format(
      "It lay too far from zero for clay and was moved by {:.0f}, {:.0f}, {:.0f} mm; export can put it back.", by.x(),
      by.y(), by.z());
}

std::string fitMeshes(Meshes meshes, double fitMm, Meshes others) {
  const Eigen::AlignedBox3d box = boxOf(meshes);
  const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(longest > 0)) return "The mesh has no extent and was not scaled.";
  const Vec3d centre = box.center();
  const double scale = fitMm / longest;
  for (const Meshes& some : {meshes, others})
    for (clay::TriangleMesh* mesh : some)
      for (Vec3d& position : mesh->positions) position = (position - centre) * scale;
  return fmt::format("Centred at zero and scaled by {:.6g}, its longest side is {:.6g} mm.", scale, fitMm);
}

std::string recentre(std::vector<io::ModelObject>& objects) {
  std::vector<clay::TriangleMesh*> meshes;
  for (io::ModelObject& object : objects) meshes.push_back(&object.mesh);
  const Vec3d by = -boxOf(meshes).center();
  for (clay::TriangleMesh* mesh : meshes)
    for (Vec3d& position : mesh->positions) position += by;
  return fmt::format("Moved by {:.6g}, {:.6g}, {:.6g} mm: its middle is at zero.", by.x(), by.y(), by.z());
}

void place(std::vector<io::ModelObject>& objects, const Placement& placement) {
  for (io::ModelObject& object : objects)
    for (Vec3d& position : object.mesh.positions) position = placement.apply(position);
}

std::string unitName(const std::string& units) {
  for (const auto& [id, name] : {std::pair{"um", "µm"}, {"m", "metres"}, {"in", "inches"}, {"ft", "feet"}})
    if (units == id) return name;
  return units;
}

std::string placeWords(const ModelLook& look, const Placement& placement, const ImportPlace& wish) {
  std::string words = sizeWords(placement.sizeMm);
  words += fmt::format(", its numbers read as {}",
                       unitName(look.unitsSaid || wish.units == "auto" ? look.units : wish.units));
  if (!wish.up.empty()) words += fmt::format(", {} up", upAxisNames()[size_t(placement.up)]);
  if (placement.scale != 1) words += fmt::format(", scaled by {:.4g}", placement.scale);
  return words + ".";
}

}  // namespace argil::engine
