// STEP files: what the text says, without a program that reads it.

#include "io/cad/step_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "clay/base/error.h"
#include "clay/cage/fit_cage.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::Folder;

clay::PatchSurface ring() {
  clay::Grid grid;
  grid.voxelMm = 1;
  return clay::fitPatches(clay::makeTorus(clay::Store::make(), grid, Vec3d::Zero(), 25, 9), 200, 1,
                          clay::WorkPart(nullptr))
      .surface;
}

/// Entities by number: name and text of the arguments.
struct Entities {
  std::map<size_t, std::pair<std::string, std::string>> all;
  explicit Entities(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    while (std::getline(in, line)) {
      if (line.empty() || line[0] != '#') continue;
      const size_t equals = line.find('='), open = line.find('(', equals);
      all[std::stoul(line.substr(1))] = {line.substr(equals + 1, open - equals - 1),
                                         line.substr(open, line.size() - open - 1)};
    }
  }
  [[nodiscard]] static std::vector<size_t> references(const std::string& text) {
    std::vector<size_t> out;
    bool quoted = false;
    for (size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\'') quoted = !quoted;
      if (!quoted && text[i] == '#') out.push_back(std::stoul(text.substr(i + 1)));
    }
    return out;
  }
  [[nodiscard]] std::vector<size_t> named(const std::string& name) const {
    std::vector<size_t> out;
    for (const auto& [number, entity] : all)
      if (entity.first == name) out.push_back(number);
    return out;
  }
};

TEST(Step, EverySideIsUsedTwiceAndEverythingNamedIsThere) {
  const Folder folder;
  const auto path = folder / "ring.step";
  const clay::PatchSurface surface = ring();
  {
    AtomicFile file(path);
    const CadBody body{"Ring", &surface, Eigen::Isometry3d::Identity(), std::array<float, 3>{0.5f, 0, 1}};
    writeStep(file, "ring", std::span(&body, 1));
    file.commit();
  }
  const Entities entities(path);
  const size_t faces = surface.patches.size();
  EXPECT_EQ(entities.named("ADVANCED_FACE").size(), faces);
  EXPECT_EQ(entities.named("B_SPLINE_SURFACE_WITH_KNOTS").size(), faces);
  EXPECT_EQ(entities.named("EDGE_CURVE").size(), 2 * faces);
  EXPECT_EQ(entities.named("VERTEX_POINT").size(), surface.cage.positions.size());
  EXPECT_EQ(entities.named("MANIFOLD_SOLID_BREP").size(), 1u);
  std::map<size_t, std::set<std::string>> uses;
  for (const size_t each : entities.named("ORIENTED_EDGE")) {
    const std::string& text = entities.all.at(each).second;
    EXPECT_TRUE(uses[Entities::references(text).at(0)].insert(text.substr(text.size() - 4)).second)
        << "a side that is used twice in one direction";
  }
  EXPECT_EQ(uses.size(), 2 * faces);
  for (const auto& [edge, directions] : uses) EXPECT_EQ(directions.size(), 2u) << edge;
  size_t last = 0;
  for (const auto& [number, entity] : entities.all) {
    EXPECT_EQ(number, ++last);
    for (const size_t each : Entities::references(entity.second))
      EXPECT_TRUE(each < number && entities.all.count(each)) << number;
  }
  // Control points of a side are those of both its faces.
  for (const size_t each : entities.named("EDGE_CURVE")) {
    const std::vector<size_t> ends = Entities::references(entities.all.at(each).second);
    const std::vector<size_t> points = Entities::references(entities.all.at(ends.at(2)).second);
    ASSERT_EQ(points.size(), size_t(clay::kPatchPoints));
    EXPECT_EQ(Entities::references(entities.all.at(ends[0]).second).at(0), points.front());
    EXPECT_EQ(Entities::references(entities.all.at(ends[1]).second).at(0), points.back());
  }
}

TEST(Step, NumbersAreTheVeryDoublesAndHaveAPoint) {
  const Folder folder;
  const auto path = folder / "ring.step";
  clay::PatchSurface surface = ring();
  surface.points[0] = {1e-9, -3, 0.1};
  surface.points[1] = {1e22, 5e-324, 123456789.125};
  {
    AtomicFile file(path);
    const CadBody body{"Ring", &surface};
    writeStep(file, "ring", std::span(&body, 1));
    file.commit();
  }
  const Entities entities(path);
  const std::regex real(R"(-?\d+\.\d*(E[+-]?\d+)?)");
  size_t index = 0;
  for (const size_t each : entities.named("CARTESIAN_POINT")) {
    if (++index == 1) continue;  // of the axes
    std::string text = entities.all.at(each).second;
    text = text.substr(text.rfind('(') + 1, text.find(')') - text.rfind('(') - 1);
    std::stringstream in(text);
    std::string number;
    for (int k = 0; std::getline(in, number, ','); ++k) {
      EXPECT_TRUE(std::regex_match(number, real)) << number;
      ASSERT_EQ(std::strtod(number.c_str(), nullptr), surface.points[index - 2][k]) << number;
    }
  }
  EXPECT_EQ(index, surface.points.size() + 1);
}

TEST(Step, NamesAreWrittenAsTheFormatWantsThem) {
  const Folder folder;
  const auto path = folder / "names.step";
  const clay::PatchSurface surface = ring();
  {
    AtomicFile file(path);
    const CadBody body{"Büste \\ d'Or 🙂\n", &surface};
    writeStep(file, "it's", std::span(&body, 1));
    file.commit();
  }
  const std::string text{std::istreambuf_iterator<char>(std::ifstream(path).rdbuf()), {}};
  EXPECT_NE(text.find(R"('B\X2\00FC\X0\ste \\ d''Or \X2\D83DDE42\X0\')"), std::string::npos);
  EXPECT_NE(text.find("FILE_NAME('it''s'"), std::string::npos);
}

TEST(Step, NothingIsLeftOfWhatCannotBeWritten) {
  const Folder folder;
  clay::PatchSurface surface = ring();
  surface.points[7].y() = NAN;
  {
    AtomicFile file(folder / "nan.step");
    const CadBody body{"Ring", &surface};
    EXPECT_THROW(writeStep(file, "ring", std::span(&body, 1)), Error);
    EXPECT_THROW(writeStep(file, "ring", {}), Error);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "nan.step"));
  EXPECT_TRUE(isStep("a.STEP"));
  EXPECT_TRUE(isStep("a.b.stp"));
  EXPECT_FALSE(isStep("step"));
}

}  // namespace
}  // namespace argil::io
