// What comes in and goes out, format by format: docs/formats.md is made of it. Files are written by Argil where it
// writes such files, else by hand (tests/support/written_models.h).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/unit/engine/format_cases.h"

namespace argil::engine {
using namespace cases;
namespace {

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
      "`engine/models/NOTES.md`.\n\n## Out\n");
  tableOfWhatGoesOut(page);
  const std::string made = page.finish();
  const std::filesystem::path file = std::filesystem::path(ARGIL_SOURCE_DIR) / "docs/formats.md";
  if (std::getenv("ARGIL_WRITE_PAGE") != nullptr) spill(file, made);
  EXPECT_EQ(samples::slurp(file), made);
}

}  // namespace
}  // namespace argil::engine
