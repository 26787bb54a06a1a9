#pragma once
// Formats × cases: what a file of a format holds, and what its clay should be. A cell is right, or told in one line, or
// is nothing that the format can say.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <set>

#include "clay/base/error.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/weld.h"
#include "engine/models/model_files.h"
#include "io/models/model_writer.h"
#include "tests/support/written_models.h"

namespace argil::engine::cases {

using io::Colour;
using io::ModelObject;
using samples::spill;

// The columns, and what files of a format can say beside triangles.
enum class Says { units, transforms, instances, mirrors, names, byVertex, byCorner, byFace, several };
using enum Says;
struct Column {
  const char* name;
  const char* file;
  std::set<Says> says;
};
inline const std::vector<Column> kColumns = {
    {"STL, text", "text.stl", {names, several}},
    {"STL, binary", "a.stl", {byFace}},
    {"OBJ", "a.obj", {names, byVertex, byCorner, byFace, several}},
    {"PLY, text", "text.ply", {byVertex, byCorner, byFace}},
    {"PLY, binary", "a.ply", {byVertex, byCorner, byFace}},
    {"OFF", "a.off", {byVertex, byCorner, byFace}},
    {"3MF", "a.3mf", {units, transforms, instances, mirrors, names, byVertex, byCorner, byFace, several}},
    {"GLB", "a.glb", {units, transforms, instances, mirrors, names, byVertex, byCorner, byFace, several}},
    {"glTF", "a.gltf", {units, transforms, instances, mirrors, names, byVertex, byCorner, byFace, several}},
    {".drc", "a.drc", {byVertex, byCorner, byFace}},
};

// What a file holds, and so what the clay should be, in mm with z up.
struct Scene {
  std::vector<ModelObject> objects;
  std::vector<Eigen::Affine3d> places = {};  // Of the first object, outside and
  Eigen::Affine3d inner = Eigen::Affine3d::Identity();
  const char* unit = "";                // of 3MF
  std::vector<ModelObject> meant = {};  // Instead of the objects.
  [[nodiscard]] std::vector<ModelObject> placed() const {
    if (!meant.empty()) return meant;
    if (places.empty()) return objects;
    std::vector<ModelObject> all;
    for (const Eigen::Affine3d& place : places) {
      ModelObject& object = all.emplace_back(objects[0]);
      const Eigen::Affine3d whole = place * inner;
      for (Vec3d& p : object.mesh.positions) p = whole * p;
      if (whole.linear().determinant() < 0)
        for (auto& triangle : object.mesh.triangles) std::swap(triangle[0], triangle[1]);
    }
    return all;
  }
};

// A block of 30 × 20 × 12 with one corner pulled in: no turn and no mirror makes it the same.
inline ModelObject block(const char* name = "block", const Vec3d& at = Vec3d(3, -7, 5), double scale = 1) {
  ModelObject object;
  object.name = name;
  object.mesh = samples::cube(0.5, Vec3d::Constant(0.5));
  for (Vec3d& p : object.mesh.positions) p = scale * (at + p.cwiseProduct(Vec3d(30, 20, 12)));
  object.mesh.positions[7] -= scale * Vec3d(6, 4, 0);
  return object;
}

inline Colour gradient(const Vec3d& p) {
  const auto part = [](double v) { return uint8_t(std::lround(128 + 120 * std::sin(v))); };
  return {part(p.x() / 12), part(p.y() / 9 + 1), part(p.z() / 7 + 2), 255};
}

inline ModelObject painted(Says how) {
  ModelObject object = block();
  constexpr Colour kRed{255, 0, 0, 255}, kBlue{0, 0, 255, 255};
  const clay::TriangleMesh mesh = object.mesh;
  if (how == byVertex)
    for (const Vec3d& p : mesh.positions) object.vertexColours.push_back(gradient(p));
  if (how == byFace)
    for (size_t t = 0; t < mesh.triangles.size(); ++t) object.triangleColours.push_back(t % 4 < 2 ? kRed : kBlue);
  if (how == byCorner) {  // Every vertex is of one triangle; the two triangles of a side have one gradient.
    object.mesh = {};
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto first = uint32_t(object.mesh.positions.size());
      for (const uint32_t v : mesh.triangles[t]) {
        object.mesh.positions.push_back(mesh.positions[v]);
        object.vertexColours.push_back(gradient(mesh.positions[v] + Vec3d::Constant(10.0 * double(t / 2))));
      }
      object.mesh.triangles.push_back({first, first + 1, first + 2});
    }
  }
  return object;
}

inline Eigen::Affine3d moved(const Vec3d& by) {
  return Eigen::Affine3d(Eigen::Translation3d(by));
}
inline Eigen::Affine3d turned(double degrees, const Vec3d& axis) {
  return Eigen::Affine3d(Eigen::AngleAxisd(degrees * M_PI / 180, axis.normalized()));
}

// The rows. `tells` are words of the sentences that say what was found or lost; `right`: the clay is as expected even
// where something is told.
struct Row {
  const char* name;
  const char* what;
  std::optional<Says> needs;
  std::function<Scene()> scene;
  std::vector<const char*> tells = {};
  bool right = true;
};
inline const std::vector<Row> kRows = {
    {"units", "inches in 3MF, metres in glTF", units, [] { return Scene{.objects = {block()}, .unit = "inch"}; }},
    {"transforms", "a stretched object in a group that is turned and moved", transforms,
     [] {
       Eigen::Affine3d stretch = Eigen::Affine3d::Identity();
       stretch.scale(Vec3d(1, 1.5, 0.75));
       return Scene{{block()}, {moved({40, 10, -5}) * turned(35, {1, 2, 3})}, stretch};
     }},
    {"instances", "one mesh in three places, one of them turned", instances,
     [] {
       return Scene{{block()}, {moved({0, 0, 0}), moved({60, 0, 0}) * turned(90, {0, 0, 1}), moved({0, 60, 9})}};
     }},
    {"negative scale", "mirrored", mirrors,
     [] {
       Eigen::Affine3d mirror = Eigen::Affine3d::Identity();
       mirror.scale(Vec3d(-1, 1, 1));
       return Scene{{block()}, {moved({50, 0, 0})}, mirror};
     }},
    {"names", "two objects", names,
     [] {
       return Scene{{block("left arm"), block("right arm", {50, 0, 0})}};
     }},
    {"colours by vertex", "a gradient", byVertex, [] { return Scene{{painted(byVertex)}}; }},
    {"colours by corner", "each side has a gradient of its own", byCorner, [] { return Scene{{painted(byCorner)}}; }},
    {"colours by face",
     "red and blue sides",
     byFace,
     [] { return Scene{{painted(byFace)}}; },
     {"materials and their colours"},
     false},
    {"several objects", "three, side by side", several,
     [] {
       return Scene{{block("large"), block("beside", {40, 0, 0}), block("small", {0, 40, 0}, 0.4)}};
     }},
    {"more than 32 objects",
     "34 of them",
     several,
     [] {
       Scene scene;
       for (int i = 0; i < 34; ++i)
         scene.objects.push_back(block("one of many", {40.0 * (i % 6), 30.0 * (i / 6), 0}));  // NOLINT
       return scene;
     },
     {"34 objects"},
     false},
    {"an open sheet among solids",
     "a block, and two triangles that bound nothing",
     several,
     [] {
       Scene scene{{block("solid"), block("sheet", {40, 0, 0})}};
       scene.objects[1].mesh.triangles.resize(2);
       return scene;
     },
     {"2 objects", "Walls thinner"},
     false},
    {"holes",
     "a triangle is missing",
     {},
     [] {
       Scene scene{.objects = {block()}, .meant = {block()}};
       scene.objects[0].mesh.triangles.pop_back();
       return scene;
     },
     {"open along 3 edges"}},
    {"inverted",
     "inside out",
     {},
     [] {
       Scene scene{{block()}};
       for (auto& triangle : scene.objects[0].mesh.triangles) std::swap(triangle[0], triangle[1]);
       return scene;
     },
     {"inside out"}},
    {"non-manifold",
     "two blocks share an edge",
     {},
     [] {
       ModelObject object;
       object.mesh = samples::cube(10);
       clay::TriangleMesh other = samples::cube(10, {20, 20, 0});
       for (auto& triangle : other.triangles) {
         for (uint32_t& v : triangle) v += 8;
         object.mesh.triangles.push_back(triangle);
       }
       object.mesh.positions.insert(object.mesh.positions.end(), other.positions.begin(), other.positions.end());
       object.mesh = clay::weldExact(object.mesh);
       return Scene{{object}};
     },
     {"more than two faces"}},
    {"thin",
     "a block with a fin thinner than a voxel",
     {},
     [] {
       ModelObject object;
       object.mesh = samples::cube(5);
       clay::TriangleMesh fin = samples::cube(0.5, {5.4, 0, 0});
       for (auto& triangle : fin.triangles) {
         for (uint32_t& v : triangle) v += 8;
         object.mesh.triangles.push_back(triangle);
       }
       for (const Vec3d& p : fin.positions)
         object.mesh.positions.emplace_back(p.x() * 3 - 10, p.y() * 8, p.z() * 0.05 + 0.1);
       return Scene{{object}};
     },
     {"Walls"},
     false},
    {"empty", "no triangle", {}, [] { return Scene{}; }, {"no triangles", "is empty", "holds no"}, false},
    {"huge",
     "30 km long",
     {},
     [] {
       return Scene{{block("block", {0, 0, 0}, 1e6)}};
     },
     {"smaller unit"},
     false},
    {"tiny",
     "30 nm long",
     {},
     [] {
       return Scene{{block("block", {0, 0, 0}, 1e-6)}};
     },
     {"larger unit"},
     false},
};

inline constexpr double kColour = 25;  // of 255: what the steepest gradient changes within a voxel

inline Vec3d rgb(const Colour& c) {
  return {double(c.red), double(c.green), double(c.blue)};
}

// On the triangle, with the weight 0.6 at this corner and 0.2 at the others.
inline Vec3d colourOn(const ModelObject& object, size_t triangle, size_t near) {
  if (!object.triangleColours.empty()) return rgb(object.triangleColours[triangle]);
  Vec3d colour = Vec3d::Zero();
  for (size_t k = 0; k < 3; ++k)
    colour += (k == near ? 0.6 : 0.2) * rgb(object.vertexColours[object.mesh.triangles[triangle][k]]);
  return colour;
}

// What is wrong with the clay, or nothing.
inline std::string wrongIn(const ImportedModel& imported, const std::vector<ModelObject>& expected, double voxelMm,
                           bool colours) {
  if (imported.pieces.size() != expected.size())
    return fmt::format("{} pieces of {} objects", imported.pieces.size(), expected.size());
  Document document;
  for (Piece piece : imported.pieces) document.add(std::move(piece));
  const std::vector<ModelObject> got = modelOf(document, {});
  for (size_t i = 0; i < got.size(); ++i) {
    const ModelObject &mine = got[i], &wanted = expected[i];
    const clay::NearestTriangle toWanted(wanted.mesh), toMine(mine.mesh);
    double far = 0;
    for (const Vec3d& p : mine.mesh.positions) far = std::max(far, std::sqrt(toWanted.nearest(p).squared));
    if (far > 0.75 * voxelMm) return fmt::format("surface {:.3g} voxels off", far / voxelMm);
    for (const Vec3d& p : wanted.mesh.positions) far = std::max(far, std::sqrt(toMine.nearest(p).squared));
    if (far > 1.0 * voxelMm) return fmt::format("a corner {:.3g} voxels off", far / voxelMm);
    if (colours) {
      for (size_t t = 0; t < wanted.mesh.triangles.size(); ++t)
        for (size_t near = 0; near < 3; ++near) {
          // A point near each corner.
          const auto& corners = wanted.mesh.triangles[t];
          Vec3d point = Vec3d::Zero();
          for (size_t k = 0; k < 3; ++k) point += (k == near ? 0.6 : 0.2) * wanted.mesh.positions[corners[k]];
          const uint32_t vertex = toMine.corners(toMine.nearest(point).triangle)[0];
          const Colour is = mine.vertexColours.empty() ? mine.colour.value_or(Colour()) : mine.vertexColours[vertex];
          const Vec3d off = rgb(is) - colourOn(wanted, t, near);
          if (off.cwiseAbs().maxCoeff() > kColour)
            return fmt::format("a colour is {:.0f} off", off.cwiseAbs().maxCoeff());
        }
    }
  }
  return {};
}

inline std::string withoutName(const std::string& sentence, const std::filesystem::path& path) {
  const std::string name = path.string() + ": ";
  return sentence.starts_with(name) ? sentence.substr(name.size()) : sentence;
}

inline std::string cell(const std::filesystem::path& path, const Row& row, const Scene& scene) {
  const std::vector<ModelObject> expected = scene.placed();
  double longest = 0;
  Eigen::AlignedBox3d box;
  for (const ModelObject& object : expected)
    for (const Vec3d& p : object.mesh.positions) box.extend(p);
  if (!box.isEmpty()) longest = box.sizes().maxCoeff();
  ModelImport how;
  if (longest > 1e-3 && longest < 1e3) how.voxelMm = longest / (expected.size() > 1 ? 80 : 40);
  std::vector<std::string> said;
  std::string wrong;
  try {
    const ImportedModel imported = importModel(path, how);
    said = imported.notes;
    wrong = wrongIn(imported, expected, how.voxelMm.value_or(1),
                    row.needs == byVertex || row.needs == byCorner || row.needs == byFace);
    if (row.needs == names && expected.size() > 1)
      for (size_t i = 0; wrong.empty() && i < expected.size(); ++i)
        if (imported.pieces[i].name != expected[i].name) wrong = "named " + imported.pieces[i].name;
  } catch (const Error& error) {
    said = {error.what()};
    wrong = "refused";
  }
  for (const std::string& sentence : said) {
    if (std::none_of(row.tells.begin(), row.tells.end(),
                     [&](const char* words) { return sentence.find(words) != std::string::npos; }))
      continue;
    if (sentence.find('\n') != std::string::npos) return "WRONG: more than one line: " + sentence;
    if (row.right && !wrong.empty()) return "WRONG: " + wrong + "; " + withoutName(sentence, path);
    return "told: " + withoutName(sentence, path);
  }
  if (wrong.empty()) return "right";
  for (const std::string& sentence : said) wrong += "; " + withoutName(sentence, path);
  return "WRONG: " + wrong;
}

}  // namespace argil::engine::cases
