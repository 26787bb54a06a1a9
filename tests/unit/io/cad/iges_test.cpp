// IGES files: what the lines say, without a program that reads them.

#include "io/cad/iges_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "clay/base/error.h"
#include "clay/cage/fit_cage.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::Folder;

clay::Version ball(double radius) {
  clay::Grid grid;
  grid.voxelMm = 1;
  static const auto store = clay::Store::make();
  return clay::makeSphere(store, grid, Vec3d::Zero(), radius);
}

/// A file by its columns: entities by the number of their directory entry.
struct Columns {
  struct Entity {
    int type = 0, form = 0, colour = 0;
    std::vector<std::string> parameters;
  };
  std::map<int, Entity> entities;
  std::map<char, int> lines;
  std::string globals, last;

  explicit Columns(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line, first;
    std::map<int, std::string> data;
    while (std::getline(in, line)) {
      EXPECT_EQ(line.size(), 80u) << line;
      const char section = line.at(72);
      EXPECT_EQ(std::stoi(line.substr(73)), ++lines[section]) << line;
      const auto field = [](const std::string& text, size_t i) { return std::stoi(text.substr(8 * i, 8)); };
      if (section == 'G') globals += line.substr(0, 72);
      if (section == 'T') last = line.substr(0, 72);
      if (section == 'P') data[std::stoi(line.substr(65, 7))] += line.substr(0, 64);
      if (section != 'D') continue;
      if (lines['D'] % 2 == 1) {
        first = line;
        continue;
      }
      Entity& entity = entities[lines['D'] - 1];
      EXPECT_EQ(field(first, 0), field(line, 0));
      entity = {field(line, 0), field(line, 4), field(line, 2), {}};
      starts_[lines['D'] - 1] = {field(first, 1), field(line, 3)};
    }
    int next = 1;
    for (auto& [number, entity] : entities) {
      EXPECT_EQ(starts_[number].first, next) << "where its parameters begin";
      next += starts_[number].second;
      // Values between commas, blanks before them only; text says how long it is.
      const std::string& text = data[number];
      for (size_t at = 0; at < text.size() && (at == 0 || text[at - 1] != ';');) {
        at = text.find_first_not_of(' ', at);
        size_t end = text.find_first_of(",;H", at);
        if (text.at(end) == 'H') end += 1 + std::stoul(text.substr(at));
        entity.parameters.push_back(text.substr(at, end - at));
        EXPECT_TRUE(text.at(end) == ',' || text.at(end) == ';') << entity.parameters.back();
        at = end + 1;
      }
      EXPECT_EQ(std::stoi(entity.parameters.at(0)), entity.type);
    }
    EXPECT_EQ(next, lines['P'] + 1);
  }
  [[nodiscard]] std::vector<int> of(int type) const {
    std::vector<int> out;
    for (const auto& [number, entity] : entities)
      if (entity.type == type) out.push_back(number);
    return out;
  }
  [[nodiscard]] int number(int entity, size_t parameter) const {
    return std::stoi(entities.at(entity).parameters.at(parameter));
  }
  [[nodiscard]] double real(int entity, size_t parameter) const {
    return std::stod(entities.at(entity).parameters.at(parameter));
  }

 private:
  std::map<int, std::pair<int, int>> starts_;
};

TEST(Iges, SolidsShareTheirSidesAndHoldTheVeryNumbers) {
  const Folder folder;
  const auto path = folder / "ball.igs";
  const clay::PatchSurface surface =
      clay::fitPatches(clay::combine(ball(20), ball(8), clay::Combination::cut), 120, 1, clay::WorkPart(nullptr))
          .surface;
  CadBody body{"Hohle Kügel, 2;", &surface, Eigen::Isometry3d::Identity(), std::array<float, 3>{0.5f, 0, 1}};
  body.pose.translation() = Vec3d(0.1, 0, 0);
  {
    AtomicFile file(path);
    writeIges(file, "two words", std::span(&body, 1));
    file.commit();
  }
  const Columns iges(path);
  const int faces = int(surface.patches.size());
  EXPECT_EQ(iges.of(128).size(), size_t(faces));
  EXPECT_EQ(iges.of(510).size(), size_t(faces));
  EXPECT_EQ(iges.of(126).size(), size_t(2 * faces));
  EXPECT_EQ(iges.globals.substr(0, 30), "1H,,1H;,9Htwo words,9Htwo word");
  ASSERT_EQ(iges.of(186).size(), 1u);
  const int solid = iges.of(186)[0];
  EXPECT_EQ(iges.number(solid, 3), 1) << "a cavity";
  EXPECT_EQ(iges.number(solid, 1 + 2 * 2 + 1), 0);
  EXPECT_EQ(iges.entities.at(iges.number(solid, 8)).parameters.at(2), "15HHohle K_gel, 2;");
  ASSERT_EQ(iges.of(314).size(), 1u);
  EXPECT_EQ(iges.entities.at(solid).colour, -iges.of(314)[0]);
  EXPECT_EQ(iges.real(iges.of(314)[0], 1), 50);

  // Each side is used by two faces, once in each direction, and each face by one shell.
  std::map<int, std::vector<int>> uses;
  for (const int loop : iges.of(508)) {
    EXPECT_EQ(iges.number(loop, 1), 4);
    for (size_t s = 0; s < 4; ++s) uses[iges.number(loop, 4 + 5 * s)].push_back(iges.number(loop, 5 + 5 * s));
  }
  EXPECT_EQ(uses.size(), size_t(2 * faces));
  for (const auto& [edge, directions] : uses) {
    ASSERT_EQ(directions.size(), 2u);
    EXPECT_NE(directions[0], directions[1]);
  }
  int shelled = 0;
  for (const int shell : iges.of(514)) shelled += iges.number(shell, 1);
  EXPECT_EQ(shelled, faces);

  // Control points of a face, its first parameter's index the fastest; ends of sides are their vertices.
  const int first = iges.of(128)[0];
  const size_t nets = 10 + 2 * 18 + clay::kPatchPoints * clay::kPatchPoints;
  for (size_t b = 0; b < clay::kPatchPoints; ++b)
    for (size_t a = 0; a < clay::kPatchPoints; ++a)
      for (size_t k = 0; k < 3; ++k)
        ASSERT_EQ(iges.real(first, nets + 3 * (b * clay::kPatchPoints + a) + k),
                  (body.pose * surface.points[surface.patches[0][a][b]])[int(k)]);
  const int edges = iges.of(504).at(0), vertices = iges.of(502).at(0);
  for (size_t e = 0; e < uses.size(); ++e) {
    const int curve = iges.number(edges, 2 + 5 * e);
    for (size_t k = 0; k < 3; ++k) {
      const size_t points = 7 + 18 + clay::kPatchPoints;
      ASSERT_EQ(iges.real(curve, points + k),
                iges.real(vertices, 2 + 3 * (size_t(iges.number(edges, 4 + 5 * e)) - 1) + k));
      ASSERT_EQ(iges.real(curve, points + 3 * (clay::kPatchPoints - 1) + k),
                iges.real(vertices, 2 + 3 * (size_t(iges.number(edges, 6 + 5 * e)) - 1) + k));
    }
  }
}

TEST(Iges, RefusesWhatIsNoSurface) {
  const Folder folder;
  clay::PatchSurface surface = clay::fitPatches(ball(10), 24, 1, clay::WorkPart(nullptr)).surface;
  AtomicFile file(folder / "a.igs");
  EXPECT_THROW(writeIges(file, "a", {}), Error);
  surface.points[5].y() = NAN;
  const CadBody body{"Ball", &surface};
  EXPECT_THROW(writeIges(file, "a", std::span(&body, 1)), Error);
}

}  // namespace
}  // namespace argil::io
