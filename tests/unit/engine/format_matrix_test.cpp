// What comes in, format by format: each cell of the table in docs/formats.md is right, or told in one line, or is
// nothing that the format can say. Files are written by Argil where it writes such files, else by hand
// (tests/support/written_models.h).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <set>

#include "clay/error.h"
#include "clay/mesh_topology.h"
#include "clay/nearest_triangle.h"
#include "clay/weld.h"
#include "engine/model_files.h"
#include "io/model_writer.h"
#include "tests/support/written_models.h"

namespace argil::engine {
namespace {

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
const std::vector<Column> kColumns = {
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
  const char* unit = "";  // of 3MF
  [[nodiscard]] std::vector<ModelObject> placed() const {
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
ModelObject block(const char* name = "block", const Vec3d& at = Vec3d(3, -7, 5), double scale = 1) {
  ModelObject object;
  object.name = name;
  object.mesh = samples::cube(0.5, Vec3d::Constant(0.5));
  for (Vec3d& p : object.mesh.positions) p = scale * (at + p.cwiseProduct(Vec3d(30, 20, 12)));
  object.mesh.positions[7] -= scale * Vec3d(6, 4, 0);
  return object;
}

Colour gradient(const Vec3d& p) {
  const auto part = [](double v) { return uint8_t(std::lround(128 + 120 * std::sin(v))); };
  return {part(p.x() / 12), part(p.y() / 9 + 1), part(p.z() / 7 + 2), 255};
}

ModelObject painted(Says how) {
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

Eigen::Affine3d moved(const Vec3d& by) {
  return Eigen::Affine3d(Eigen::Translation3d(by));
}
Eigen::Affine3d turned(double degrees, const Vec3d& axis) {
  return Eigen::Affine3d(Eigen::AngleAxisd(degrees * M_PI / 180, axis.normalized()));
}

// The rows. `tells` are words of the sentences that say what was found or lost; `right`: told or not, the clay is as
// expected.
struct Row {
  const char* name;
  const char* what;
  std::optional<Says> needs;
  std::function<Scene()> scene;
  std::vector<const char*> tells = {};
  bool right = true;
};
const std::vector<Row> kRows = {
    {"units", "inches in 3MF, metres in glTF", units, [] { return Scene{.objects = {block()}, .unit = "inch"}; }},
    {"transforms", "turned, moved, and stretched below", transforms,
     [] {
       Eigen::Affine3d stretch = Eigen::Affine3d::Identity();
       stretch.scale(Vec3d(1, 1.5, 0.75));
       return Scene{{block()}, {moved({40, 10, -5}) * turned(35, {1, 2, 3})}, stretch};
     }},
    {"instances", "one mesh in three places", instances,
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
    {"colours by corner", "each side with a gradient of its own", byCorner, [] { return Scene{{painted(byCorner)}}; }},
    {"colours by face",
     "red and blue sides",
     byFace,
     [] { return Scene{{painted(byFace)}}; },
     {"materials and their colours"}},
    {"several objects", "one inside the box of the other", several,
     [] {
       return Scene{{block("outer"), block("beside", {40, 0, 0}), block("small", {0, 40, 0}, 0.4)}};
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
     {"34 objects"}},
    {"an open sheet among solids",
     "the sheet bounds nothing",
     several,
     [] {
       Scene scene{{block("solid"), block("sheet", {40, 0, 0})}};
       scene.objects[1].mesh.triangles.resize(2);
       return scene;
     },
     {"2 objects", "Walls thinner"}},
    {"holes",
     "a triangle is missing",
     {},
     [] {
       Scene scene{{block()}};
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
     "a fin of a tenth of a voxel on a block",
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
     {"Walls thinner"},
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

// Writes the scene in the column's format.
void writeScene(const std::filesystem::path& path, const Column& column, const Row& row, const Scene& scene) {
  const std::string ending = path.extension();
  const bool text = std::string(column.file).starts_with("text");
  const bool gltf = ending == ".glb" || ending == ".gltf";
  const auto ours = [&](const std::vector<ModelObject>& objects) {
    static_cast<void>(io::writeModel(path, {objects, {}}, {.text = text}));
  };
  if (scene.objects.empty()) {  // Our writers refuse this.
    const std::string header = std::string(80, ' ') + std::string(4, '\0');
    if (ending == ".stl") return spill(path, text ? "solid a\nendsolid a\n" : header);
    if (ending == ".obj") return spill(path, "o nothing\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    if (ending == ".ply" && text) return spill(path, samples::plyText({}));
    if (ending == ".ply")
      return spill(path,
                   "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float "
                   "y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n");
    if (ending == ".off") return spill(path, samples::offText({}));
    if (ending == ".3mf") return spill(path, samples::threeMf("<resources></resources><build></build>"));
    if (ending == ".drc") return spill(path, "");
    ours({block()});
    return spill(path,
                 samples::withJson(samples::slurp(path),
                                   {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"name", "a"}}}}}));
  }
  if (!scene.places.empty()) {
    if (ending == ".3mf") return spill(path, samples::threeMfPlaced(scene.objects[0], scene.places, scene.inner));
    ours({scene.objects[0]});
    return spill(path, samples::gltfPlaced(samples::slurp(path), scene.places, scene.inner));
  }
  if (*scene.unit != 0 && !gltf) {
    clay::TriangleMesh mesh = scene.objects[0].mesh;
    for (Vec3d& p : mesh.positions) p /= 25.4;
    return spill(path, samples::threeMf("<resources><object id=\"1\" type=\"model\">" + samples::meshXml(mesh) +
                                            "</object></resources><build><item objectid=\"1\"/></build>",
                                        "unit=\"inch\""));
  }
  if (ending == ".stl" && text) return spill(path, samples::stlText(scene.objects));
  if (ending == ".stl" && row.needs == byFace) return spill(path, samples::stlColoured(scene.objects[0]));
  if (ending == ".ply" && text) return spill(path, samples::plyText(scene.objects[0]));
  if (ending == ".off") return spill(path, samples::offText(scene.objects[0]));
  if (ending == ".3mf" && row.needs == byCorner) return spill(path, samples::threeMfCorners(scene.objects[0]));
  if (ending == ".obj" && row.needs == byFace) {
    std::string materials;
    spill(path, samples::objWithMaterials(scene.objects[0], "a.mtl", materials));
    return spill(path.parent_path() / "a.mtl", materials);
  }
  ours(scene.objects);
}

constexpr double kColour = 25;  // of 255: what the steepest gradient changes within a voxel

Vec3d rgb(const Colour& c) {
  return {double(c.red), double(c.green), double(c.blue)};
}

// On the triangle, with the weight 0.6 at this corner and 0.2 at the others.
Vec3d colourOn(const ModelObject& object, size_t triangle, size_t near) {
  if (!object.triangleColours.empty()) return rgb(object.triangleColours[triangle]);
  Vec3d colour = Vec3d::Zero();
  for (size_t k = 0; k < 3; ++k)
    colour += (k == near ? 0.6 : 0.2) * rgb(object.vertexColours[object.mesh.triangles[triangle][k]]);
  return colour;
}

// What is wrong with the clay, or nothing.
std::string wrongIn(const ImportedModel& imported, const std::vector<ModelObject>& expected, double voxelMm,
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

std::string withoutName(const std::string& sentence, const std::filesystem::path& path) {
  const std::string name = path.string() + ": ";
  return sentence.starts_with(name) ? sentence.substr(name.size()) : sentence;
}

std::string cell(const std::filesystem::path& path, const Row& row, const Scene& scene) {
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
    return "told: " + withoutName(sentence, path);
  }
  if (wrong.empty()) return "right";
  for (const std::string& sentence : said) wrong += "; " + withoutName(sentence, path);
  return "WRONG: " + wrong;
}

// The page: tables whose cells say right, or the number of the sentence that tells.
class Page {
 public:
  void table(const std::vector<std::string>& columns) {
    text_ += "\n| |";
    for (const std::string& column : columns) text_ += " " + column + " |";
    text_ += "\n|---|";
    for (size_t i = 0; i < columns.size(); ++i) text_ += "---|";
    text_ += "\n";
  }
  void row(const std::string& name, const std::string& what) { text_ += "| **" + name + "**: " + what + " |"; }
  void cell(const std::string& said) {
    if (!said.starts_with("told: ")) {
      text_ += " " + said + " |";
      return;
    }
    const auto at = std::find(sentences_.begin(), sentences_.end(), said.substr(6));
    text_ += fmt::format(" told {} |", at - sentences_.begin() + 1);
    if (at == sentences_.end()) sentences_.push_back(said.substr(6));
  }
  void endRow() { text_ += "\n"; }
  void text(const std::string& words) { text_ += words; }
  [[nodiscard]] std::string finish() {
    text_ += "\n## The sentences\n\n";
    for (size_t i = 0; i < sentences_.size(); ++i) text_ += fmt::format("{}. {}\n", i + 1, sentences_[i]);
    return text_;
  }

 private:
  std::string text_;
  std::vector<std::string> sentences_;
};

void tableOfWhatComesIn(Page& page) {
  const samples::Folder folder;
  std::vector<std::string> names;
  for (const Column& column : kColumns) names.emplace_back(column.name);
  page.table(names);
  for (const Row& row : kRows) {
    page.row(row.name, row.what);
    for (const Column& column : kColumns) {
      if (row.needs && !column.says.contains(*row.needs)) {
        page.cell("–");
        continue;
      }
      const auto path = folder / column.file;
      const Scene scene = row.scene();
      writeScene(path, column, row, scene);
      const std::string said = cell(path, row, scene);
      EXPECT_FALSE(said.starts_with("WRONG")) << row.name << " in " << column.name << ": " << said;
      page.cell(said);
    }
    page.endRow();
  }
}

// What goes out: as our own reader finds it again, or as was told before it was written.
struct Out {
  const char* name;
  const char* file;
  bool draco = false;
};
constexpr Out kOut[] = {{"STL", "a.stl"},
                        {"OBJ", "a.obj"},
                        {"PLY", "a.ply"},
                        {"3MF", "a.3mf"},
                        {"GLB", "a.glb"},
                        {"glTF", "a.gltf"},
                        {"GLB, Draco", "b.glb", true},
                        {".drc", "a.drc"}};

std::string wrongAgain(const std::vector<ModelObject>& got, double unit, const std::vector<ModelObject>& wanted,
                       Says what) {
  if (got.size() != wanted.size()) return fmt::format("{} objects", got.size());
  for (size_t i = 0; i < got.size(); ++i) {
    const ModelObject &mine = got[i], &its = wanted[i];
    if (what == names && mine.name != its.name) return "named " + mine.name;
    if (mine.mesh.triangles.size() != its.mesh.triangles.size()) return "other triangles";
    const bool some = what == byVertex || what == byFace;
    for (size_t t = 0; t < mine.mesh.triangles.size(); ++t) {
      // Readers may number anew, so the triangle is found by where it lies.
      const auto middle = [](const ModelObject& object, size_t which, double scale) {
        Vec3d sum = Vec3d::Zero();
        for (const uint32_t v : object.mesh.triangles[which]) sum += scale * object.mesh.positions[v] / 3;
        return sum;
      };
      size_t same = 0;
      double least = HUGE_VAL;
      for (size_t k = 0; k < its.mesh.triangles.size(); ++k)
        if (const double d = (middle(its, k, 1) - middle(mine, t, unit)).norm(); d < least) least = d, same = k;
      if (least > 1e-3) return fmt::format("a triangle {:.3g} mm off", least);
      if (!some) continue;
      if (mine.vertexColours.empty() && mine.triangleColours.empty()) return "no colours";
      const auto mean = [](const ModelObject& object, size_t which) {
        Vec3d sum = Vec3d::Zero();
        for (size_t near = 0; near < 3; ++near) sum += colourOn(object, which, near) / 3;
        return sum;
      };
      if ((mean(mine, t) - mean(its, same)).cwiseAbs().maxCoeff() > 1) return "another colour";
    }
  }
  return {};
}

void tableOfWhatGoesOut(Page& page) {
  const samples::Folder folder;
  std::vector<std::string> columns;
  for (const Out& out : kOut) columns.emplace_back(out.name);
  page.table(columns);
  for (const Row& row : kRows) {
    if (row.needs != names && row.needs != byVertex && row.needs != byFace && row.needs != several) continue;
    page.row(row.name, row.what);
    const std::vector<ModelObject> objects = row.scene().objects;
    for (const Out& out : kOut) {
      const auto path = folder / out.file;
      const io::WriteOptions options{.draco = out.draco};
      const std::vector<std::string> told = io::lossesOf(path, {objects, {}}, options);
      static_cast<void>(io::writeModel(path, {objects, {}}, options));
      const io::ModelFile read = io::readModel(path);
      const std::string wrong = wrongAgain(read.objects, read.unitMm.value_or(1), objects, *row.needs);
      EXPECT_TRUE(wrong.empty() || !told.empty()) << row.name << " to " << out.name << ": " << wrong;
      page.cell(told.empty() ? "right" : "told: " + told.front());
    }
    page.endRow();
  }
}

TEST(FormatMatrix, EveryCellIsRightOrTold) {
  Page page;
  page.text(
      "# Formats, case by case\n\nWhat becomes of a model on its way into clay and out of it. *right*: as the file has "
      "it. *told*: in one line, the sentence of that number below. –: files of the format cannot say it.\n\nThis page "
      "is written by the test `FormatMatrix` of `unit_engine`, which fails where it is no longer true "
      "(`ARGIL_WRITE_PAGE=1` writes it anew).\n\n## In\n");
  tableOfWhatComesIn(page);
  page.text(
      "\nA file that names no unit is read as millimetres unless another is chosen; how a model stands is in "
      "`engine/NOTES.md`.\n\n## Out\n");
  tableOfWhatGoesOut(page);
  const std::string made = page.finish();
  const std::filesystem::path file = std::filesystem::path(ARGIL_SOURCE_DIR) / "docs/formats.md";
  if (std::getenv("ARGIL_WRITE_PAGE") != nullptr) spill(file, made);
  EXPECT_EQ(samples::slurp(file), made);
}

// The same cases as Debian's Blender writes them: it gets each scene as JSON and exports it in its own way. What a
// format cannot hold it bakes (transforms), joins (objects) or leaves out.

constexpr const char* kBlender = R"py(
import numpy; numpy.bool = bool  # Debian's glTF add-on is older than its numpy.
import bpy, json, mathutils, sys
def linear(c): c /= 255; return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
def colour(c): return [linear(c[0]), linear(c[1]), linear(c[2]), 1]
for job in json.load(open('scenes.json')):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    name, ending = job['file'], job['file'].split('.')[-1]
    k = 0.001 if ending in ('glb', 'gltf') else 1.0
    def matrix(rows):
        m = mathutils.Matrix(rows)
        m.translation = m.translation * k
        return m
    made = []
    for each in job['objects']:
        mesh = bpy.data.meshes.new(each['name'])
        mesh.from_pydata([[k * x for x in p] for p in each['positions']], [], each['triangles'])
        if each['vertex_colours'] and ending == 'ply':  # It writes these alone.
            a = mesh.color_attributes.new('Col', 'BYTE_COLOR', 'CORNER')
            for loop in mesh.loops: a.data[loop.index].color_srgb = [x / 255 for x in each['vertex_colours'][loop.vertex_index]] + [1]
        elif each['vertex_colours']:
            a = mesh.color_attributes.new('Col', 'FLOAT_COLOR', 'POINT')
            for at, c in zip(a.data, each['vertex_colours']): at.color = colour(c)
        if each['triangle_colours']:
            kinds = {}
            for face, c in zip(mesh.polygons, each['triangle_colours']):
                if tuple(c) not in kinds:
                    kinds[tuple(c)] = len(kinds)
                    m = bpy.data.materials.new('m%d' % len(kinds))
                    m.use_nodes = True
                    m.node_tree.nodes['Principled BSDF'].inputs['Base Color'].default_value = colour(c)
                    mesh.materials.append(m)
                face.material_index = kinds[tuple(c)]
        made.append(mesh)
    places = job['places'] or [None] * len(made)
    for i, place in enumerate(places):
        mesh = made[0] if job['places'] else made[i]
        o = bpy.data.objects.new(mesh.name, mesh)
        bpy.context.collection.objects.link(o)
        if place:
            parent = bpy.data.objects.new('above', None)
            bpy.context.collection.objects.link(parent)
            parent.matrix_world = matrix(place)
            o.parent = parent
            o.matrix_local = matrix(job['inner'])
    bpy.context.view_layer.update()
    for o in bpy.data.objects: o.select_set(True)
    bpy.context.view_layer.objects.active = [o for o in bpy.data.objects if o.type == 'MESH'][0]
    if ending == 'glb': bpy.ops.export_scene.gltf(filepath=name, export_format='GLB')
    elif ending == 'gltf': bpy.ops.export_scene.gltf(filepath=name, export_format='GLTF_EMBEDDED')
    elif ending == 'obj': bpy.ops.wm.obj_export(filepath=name, forward_axis='Y', up_axis='Z', export_colors=True)
    elif ending == 'ply': bpy.ops.export_mesh.ply(filepath=name, use_ascii='text' in name, use_colors=True)
    else: bpy.ops.export_mesh.stl(filepath=name, ascii='text' in name)
)py";

nlohmann::json jsonOf(const Scene& scene, const std::string& file) {
  nlohmann::json job = {{"file", file}, {"places", nlohmann::json::array()}};
  const auto rows = [](const Eigen::Affine3d& t) {
    nlohmann::json matrix;
    for (int r = 0; r < 4; ++r)
      matrix.push_back({t.matrix()(r, 0), t.matrix()(r, 1), t.matrix()(r, 2), t.matrix()(r, 3)});
    return matrix;
  };
  const auto rgbs = [](const std::vector<Colour>& colours) {
    nlohmann::json list = nlohmann::json::array();
    for (const Colour& c : colours) list.push_back({c.red, c.green, c.blue});
    return list;
  };
  for (const Eigen::Affine3d& place : scene.places) job["places"].push_back(rows(place));
  job["inner"] = rows(scene.inner);
  for (const ModelObject& object : scene.objects) {
    nlohmann::json positions;
    for (const Vec3d& p : object.mesh.positions) positions.push_back({p.x(), p.y(), p.z()});
    job["objects"].push_back({{"name", object.name},
                              {"positions", positions},
                              {"triangles", object.mesh.triangles},
                              {"vertex_colours", rgbs(object.vertexColours)},
                              {"triangle_colours", rgbs(object.triangleColours)}});
  }
  return job;
}

TEST(LongFormatMatrix, BlenderWritesTheSameCases) {
  if (std::system("command -v blender >/dev/null 2>&1") != 0) GTEST_SKIP() << "blender is not installed";
  const samples::Folder folder;
  struct Job {
    const Row& row;
    const Column& column;
    std::string file;
  };
  std::vector<Job> jobs;
  nlohmann::json scenes;
  for (const Row& row : kRows)
    for (const Column& column : kColumns) {
      const std::string ending = std::filesystem::path(column.file).extension();
      const Scene scene = row.scene();
      const bool cannot = ending == ".off" || ending == ".3mf" || ending == ".drc" || scene.objects.empty();
      const bool painted = row.needs == byVertex || row.needs == byCorner || row.needs == byFace;
      // Of all the corners in one place it writes one colour to PLY.
      const bool drops = painted && (ending == ".stl" || (ending == ".ply" && row.needs != byVertex));
      if (cannot || drops) continue;
      jobs.push_back({row, column, std::to_string(jobs.size()) + column.file});
      scenes.push_back(jsonOf(scene, jobs.back().file));
    }
  spill(folder / "scenes.json", scenes.dump());
  spill(folder / "write.py", kBlender);
  const std::string out = (folder / "said.txt").string();
  ASSERT_EQ(std::system(("cd " + folder.path().string() + " && blender -b --python-exit-code 1 --python write.py >" +
                         out + " 2>&1")
                            .c_str()),
            0)
      << samples::slurp(out);
  for (const Job& job : jobs) {
    Scene scene = job.row.scene();
    scene.objects = scene.placed();
    scene.places.clear();
    const std::string ending = std::filesystem::path(job.file).extension();
    if ((ending == ".stl" || ending == ".ply") && scene.objects.size() > 1)
      scene.objects = {io::merged(std::move(scene.objects))};
    if (ending == ".obj")  // It writes no blanks.
      for (ModelObject& object : scene.objects) std::replace(object.name.begin(), object.name.end(), ' ', '_');
    const std::string said = cell(folder / job.file, job.row, scene);
    std::cout << job.row.name << ", " << job.column.name << ": " << said << "\n";
    EXPECT_FALSE(said.starts_with("WRONG")) << job.row.name << ", " << job.column.name << ": " << said;
  }
}

}  // namespace
}  // namespace argil::engine
