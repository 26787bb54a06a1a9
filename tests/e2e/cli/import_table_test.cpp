// Every real model is imported or refused as its list of sources says it deserves. ARGIL_TABLE=FILE writes what became
// of each as a table.

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "tests/e2e/support/command.h"
#include "tests/support/tier.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

/// What is no surface, or damaged: with what the sentence must say.
const std::map<std::string, std::string> kRefused = {
    {"mesh/empty.stl", "holds no triangles"},
    {"mesh/invalid.off", "announces 4 faces"},
    {"mesh/malformed.obj", "a face names vertex 0"},
    {"mesh/notenoughindices.obj", "a face has 2 corners"},
    {"3mf/MUSTFAIL_Chapter3.4c_MissingResourceElement.3mf", "resources"},
    {"gltf/IndexOutOfRange/IndexOutOfRange.gltf", "names vertex 255 of 24"},
    {"vdb/smoke.vdb", "fog volume"},
};
/// What is read, but bounds no solid: as a part it is kept as it is.
const std::map<std::string, std::string> kNoSolid = {
    {"mesh/many_small_holes.ply", "open sheet"},
    {"mesh/non_manif_hole.ply", "open sheet"},
    {"3mf/malformed_property_index_oob.3mf", "no inside"},
};

/// The list counts a mesh once; these place one several times.
const std::map<std::string, uint64_t> kPlaced = {
    {"3mf/MUSTPASS_Chapter3.2c_MultipleItemsTransform.3mf", 60},
    {"gltf/2CylinderEngine_draco/2CylinderEngine.gltf", 110336},
};

/// In metres, hundreds of them: as clay it would have voxels of a metre and still take minutes.
const std::set<std::string> kLarge = {"gltf/2CylinderEngine_draco/2CylinderEngine.gltf"};

/// They take as long as all others together; what is special about each is tested as clay of its own.
const std::set<std::string> kForTheLongTests = {
    "mesh/dragon_vrip_871k.ply.gz", "mesh/koala_100k.obj",    "mesh/stanford-bunny.obj", "mesh/nefertiti_lowres.obj",
    "mesh/dragon_vrip_res3.ply",    "mesh/armadillo_29k.obj", "mesh/cycloidal.ply"};

struct Row {
  std::string file, verdict, trianglesIn, report, closed, trianglesOut;
};

std::string joined(const Json& sentences) {
  std::string text;
  for (const Json& each : sentences) text += (text.empty() ? "" : " ") + each.get<std::string>();
  return text;
}

std::string lowerEnding(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return ending;
}

/// Triangles of each file as SOURCES.md has them.
std::map<std::string, uint64_t> countsOfOthers(const fs::path& data) {
  std::map<std::string, uint64_t> counts;
  std::ifstream in(data / "SOURCES.md");
  const std::regex row(R"(\| ([^ |]+) \| \d+ \| (\d+) tris.*)");
  std::smatch found;
  for (std::string line; std::getline(in, line);)
    if (std::regex_match(line, found, row)) counts[found[1]] = std::stoull(found[2]);
  return counts;
}

std::vector<fs::path> realModels(const fs::path& data) {
  std::vector<fs::path> files;
  for (const char* folder : {"mesh", "3mf", "gltf", "vdb"})
    for (const auto& entry : fs::recursive_directory_iterator(data / folder))
      if (entry.is_regular_file() && entry.path().extension() != ".bin") files.push_back(entry.path());
  for (const auto& entry : fs::directory_iterator(data / "cad"))
    if (lowerEnding(entry.path()) == ".stl") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Arguments for clay with a voxel that is coarse enough to be quick and fine enough to show what the model is. What is
/// smaller than a grain in mm was made in metres.
std::vector<std::string> asCoarseClay(const fs::path& file, const Json& mesh) {
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis)
    longest = std::max(longest, mesh["high_mm"][axis].get<double>() - mesh["low_mm"][axis].get<double>());
  const bool metres = longest < 0.2;
  const double voxel = std::min(longest * (metres ? 1000 : 1) / 96, 1000.0);
  return {"inspect", file.string(), "--json", "--units", metres ? "m" : "mm", "--voxel", std::to_string(voxel)};
}

std::string sentenceOf(const Outcome& o) {
  std::string text = o.err.substr(0, o.err.find('\n'));
  return text.rfind("argil: ", 0) == 0 ? text.substr(7) : text;
}

TEST(ImportTable, EveryRealModelGetsWhatItDeserves) {
  if (!realData()) GTEST_SKIP() << "ARGIL_DATA is not set";
  const fs::path data = realData();
  const std::map<std::string, uint64_t> counts = countsOfOthers(data);
  EXPECT_GT(counts.size(), 30u);
  std::vector<Row> rows;
  for (const fs::path& file : realModels(data)) {
    const std::string name = fs::relative(file, data).string();
    if (kForTheLongTests.contains(name) && !longTier()) continue;
    SCOPED_TRACE(name);
    Row& row = rows.emplace_back();
    row.file = name;
    const Outcome read = argil({"inspect", file.string(), "--json"});
    const auto refused = kRefused.find(name);
    if (refused != kRefused.end()) {
      row.verdict = "refused";
      row.report = sentenceOf(read);
      EXPECT_EQ(read.code, 2) << read.err;
      EXPECT_EQ(std::count(read.err.begin(), read.err.end(), '\n'), 1) << read.err;
      EXPECT_NE(read.err.find(refused->second), std::string::npos) << read.err;
      continue;
    }
    EXPECT_EQ(read.code, 0) << read.err;
    if (read.code != 0) {
      row.verdict = "REFUSED";
      row.report = sentenceOf(read);
      continue;
    }
    const Json mesh = Json::parse(read.out);
    if (mesh.contains("pieces")) {  // A level set is clay already.
      row.verdict = "imported";
      row.report = joined(mesh.value("notes", Json::array()));
      const Json& skin = mesh["pieces"][0]["surface"];
      row.closed = skin["closed"].get<bool>() ? "yes" : "NO";
      row.trianglesOut = skin["triangles"].dump();
      EXPECT_EQ(mesh["pieces"].size(), 1u);
      EXPECT_TRUE(skin["closed"].get<bool>());
      continue;
    }
    row.trianglesIn = mesh["mesh"]["triangles"].dump();
    if (const auto placed = kPlaced.find(name); placed != kPlaced.end())
      EXPECT_EQ(mesh["mesh"]["triangles"], placed->second);
    else if (const auto expected = counts.find(name); expected != counts.end())
      EXPECT_EQ(mesh["mesh"]["triangles"], expected->second);
    else
      ADD_FAILURE() << "SOURCES.md does not say how many triangles it has";
    if (kLarge.contains(name)) {
      row.verdict = "read, kept as a part";
      continue;
    }
    const Outcome made = argil(asCoarseClay(file, mesh["mesh"]));
    if (const auto sheet = kNoSolid.find(name); sheet != kNoSolid.end()) {
      row.verdict = "read, no solid";
      row.report = sentenceOf(made);
      EXPECT_EQ(made.code, 2) << made.err;
      EXPECT_NE(made.err.find(sheet->second), std::string::npos) << made.err;
      continue;
    }
    EXPECT_EQ(made.code, 0) << made.err;
    if (made.code != 0) {
      row.verdict = "read, NO CLAY";
      row.report = sentenceOf(made);
      continue;
    }
    const Json clay = Json::parse(made.out);
    row.verdict = "imported";
    row.report = joined(clay["notes"]) + (clay["notes"].empty() ? "" : "; ") + joined(clay["repair"]);
    row.closed = clay["surface"]["closed"].get<bool>() ? "yes" : "NO";
    row.trianglesOut = clay["surface"]["triangles"].dump();
    EXPECT_TRUE(clay["surface"]["closed"].get<bool>());
    EXPECT_GT(clay["surface"]["triangles"].get<uint64_t>(), 100u);
    // Of walls that are lost a clay of no thickness may be left.
    EXPECT_TRUE(clay["surface"]["volume_mm3"].get<double>() > 0 ||
                row.report.find("100.0 % of the volume") != row.report.npos)
        << row.report;
    EXPECT_FALSE(clay["repair"].empty());
  }
  EXPECT_GE(rows.size(), longTier() ? 40u : 34u);
  if (const char* table = std::getenv("ARGIL_TABLE")) {
    std::ofstream out(table);
    out << "| file | verdict | triangles in | report | closed surface out | triangles out "
           "|\n|---|---|---|---|---|---|\n";
    for (Row& row : rows) {
      // Where the files lie is of no interest.
      for (size_t at; (at = row.report.find(data.string() + "/")) != std::string::npos;)
        row.report.erase(at, data.string().size() + 1);
      out << "| " << row.file << " | " << row.verdict << " | " << row.trianglesIn << " | " << row.report << " | "
          << row.closed << " | " << row.trianglesOut << " |\n";
    }
  }
}

}  // namespace
}  // namespace argil::tests
