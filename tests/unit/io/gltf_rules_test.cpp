// Every glTF that we write keeps the rules of the format, and the checker that says so finds what is planted. In the
// long tier Khronos' own validator says the same of all of these files (npm install -g gltf-validator).

#include "tests/support/gltf_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "io/models/model_writer.h"
#include "tests/support/mesh_samples.h"
#include "tests/unit/io/gltf_peer.h"

namespace argil::io {
namespace {

using Json = nlohmann::ordered_json;
using samples::GltfIssue;
using samples::Severity;
using testing::Contains;

constexpr Colour kRed{255, 0, 0, 255}, kGlass{0, 200, 255, 100};

ModelObject cube(double half = 10, const Vec3d& middle = Vec3d::Zero()) {
  ModelObject object;
  object.mesh = samples::cube(half, middle);
  return object;
}

ModelObject paintedCube() {
  ModelObject object = cube();
  for (int i = 0; i < 8; ++i) object.vertexColours.push_back({uint8_t(30 * i), 200, uint8_t(255 - i), 255});
  return object;
}

// A wavy sheet of n × n vertices.
ModelObject sheet(uint32_t n) {
  ModelObject object;
  for (uint32_t j = 0; j < n; ++j)
    for (uint32_t i = 0; i < n; ++i) object.mesh.positions.emplace_back(i, j, std::sin(0.1 * i) * std::cos(0.07 * j));
  for (uint32_t j = 0; j + 1 < n; ++j)
    for (uint32_t i = 0; i + 1 < n; ++i) {
      const uint32_t at = j * n + i;
      object.mesh.triangles.push_back({at, at + 1, at + n});
      object.mesh.triangles.push_back({at + 1, at + n + 1, at + n});
    }
  return object;
}

struct Sample {
  const char* name;
  std::function<std::vector<ModelObject>()> make;
};
const std::vector<Sample> kSamples = {
    {"plain", [] { return std::vector{cube()}; }},
    {"of one colour",
     [] {
       ModelObject o = cube();
       o.colour = kRed;
       return std::vector{o};
     }},
    {"translucent",
     [] {
       ModelObject o = cube();
       o.colour = kGlass;
       return std::vector{o};
     }},
    {"painted by vertex", [] { return std::vector{paintedCube()}; }},
    {"painted by vertex, translucent",
     [] {
       ModelObject o = paintedCube();
       o.vertexColours[3] = kGlass;
       return std::vector{o};
     }},
    {"painted by triangle",
     [] {
       ModelObject o = cube();
       for (size_t i = 0; i < o.mesh.triangles.size(); ++i) o.triangleColours.push_back(i % 3 ? kRed : kGlass);
       return std::vector{o};
     }},
    {"several pieces, one empty",
     [] {
       std::vector<ModelObject> all = {cube(), paintedCube(), {}, cube(5, {100, 0, -3}), cube(5, {0, 70, 0})};
       all[0].colour = kRed, all[3].colour = kRed, all[4].colour = kGlass;
       return all;
     }},
    {"odd names",
     [] {
       std::vector<ModelObject> all(8, cube());
       const char* names[] = {
           "\"quoted\\", "\xc3\xb6\xe2\x82\xac\xf0\x9f\x90\xb0", "\xff\xfe not UTF-8", "a\nb\t\x01", "", "same", "same",
           "@buffer@"};
       for (size_t i = 0; i < 8; ++i) all[i].name = names[i];
       all[2].name += std::string(1, '\0') + std::string(10000, 'n');
       return all;
     }},
    {"triangles without an area",
     [] {
       ModelObject o = cube();
       o.mesh.positions.push_back({10, 10, 10});
       o.mesh.triangles.insert(o.mesh.triangles.end(), {{8, 7, 8}, {7, 8, 7}, {0, 0, 0}});
       ModelObject flat;  // Its triangles cancel each other, and a corner has none at all.
       flat.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
       flat.mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
       ModelObject line;
       line.mesh.positions = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
       line.mesh.triangles = {{0, 1, 2}};
       ModelObject point;
       point.mesh.positions = {{3, 3, 3}, {3, 3, 3}, {3, 3, 3}};
       point.mesh.triangles = {{0, 1, 2}};
       return std::vector{o, flat, line, point};
     }},
    {"65 535 vertices",
     [] {
       ModelObject o = sheet(255);
       o.mesh.positions.resize(65535, {0, 0, 9});
       return std::vector{o};
     }},
    {"more than 65 535 vertices", [] { return std::vector{sheet(300)}; }},
    {"huge",
     [] {
       return std::vector{cube(1e30), cube(1e20, {1e30, 0, 0})};
     }},
    {"tiny",
     [] {
       return std::vector{cube(1e-9), cube(1e-30), cube(1e-41), cube(1e-60)};
     }},
    {"far away",
     [] {
       return std::vector{cube(1, {1e9, -1e9, 1e9}), cube(0.001, {1e6, 0.1, 0})};
     }},
    {"coordinates that are no round numbers",
     [] {
       return std::vector{cube(10.0 / 3, {0.1, 0.2, 0.3}), cube(M_PI)};
     }},
};

struct Way {
  const char* ending;
  bool draco;
};
constexpr Way kWays[] = {{".glb", false}, {".gltf", false}, {".glb", true}, {".gltf", true}};

std::string written(const samples::Folder& folder, const std::vector<ModelObject>& objects, const Way& way,
                    const std::string& name = "a") {
  WriteOptions options;
  options.draco = way.draco;
  const auto path = folder / (name + way.ending);
  static_cast<void>(writeModel(path, {objects, {{"Title", "a \"title\" \xff"}, {"", ""}}}, options));
  return samples::slurp(path);
}

TEST(GltfRules, WhatWeWriteKeepsThem) {
  const samples::Folder folder;
  for (const Sample& sample : kSamples)
    for (const Way& way : kWays) {
      SCOPED_TRACE(std::string(sample.name) + way.ending + (way.draco ? ", Draco" : ""));
      const auto issues = samples::gltfIssues(written(folder, sample.make(), way));
      EXPECT_EQ(samples::errorsAndWarnings(issues), "");
      for (const GltfIssue& issue : issues) EXPECT_NE(issue.code, "UNUSED_OBJECT") << issue.pointer;
      // The checker does not unpack Draco; the peer does, and looks for counts and boxes that are not true.
      for (const PeerObject& peer :
           way.draco ? readByPeer(folder / ("a" + std::string(way.ending))) : std::vector<PeerObject>()) {
        for (const auto& corners : peer.triangles)
          for (const uint32_t corner : corners) ASSERT_LT(corner, peer.positionsMm.size());
        for (const Vec3d& normal : peer.normals) ASSERT_NEAR(normal.norm(), 1, 0.005);
      }
    }
}

// A .glb apart: its JSON and its bytes.
struct Parts {
  Json json;
  std::string bin;

  explicit Parts(const std::string& glb) {
    uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    json = Json::parse(glb.substr(20, length));
    bin = glb.substr(28 + length);
  }
  [[nodiscard]] std::string glb() const {
    std::string text = json.dump(), bytes = "glTF";
    text.resize((text.size() + 3) / 4 * 4, ' ');
    samples::append(bytes, uint32_t(2));
    samples::append(bytes, uint32_t(28 + text.size() + bin.size()));
    samples::append(bytes, uint32_t(text.size()));
    bytes += "JSON" + text;
    samples::append(bytes, uint32_t(bin.size()));
    return bytes + std::string("BIN\0", 4) + bin;
  }
  // Puts a number into a bufferView's bytes.
  template <class T>
  void poke(size_t view, size_t at, T value) {
    std::memcpy(bin.data() + json["bufferViews"][view]["byteOffset"].get<size_t>() + at, &value, sizeof value);
  }
};

// Views and accessors of the painted cube: 0 positions, 1 normals, 2 colours, 3 indices.
struct Fault {
  const char* code;
  std::function<void(Parts&)> plant;
};
const std::vector<Fault> kFaults = {
    {"UNDEFINED_PROPERTY", [](Parts& p) { p.json["asset"].erase("version"); }},
    {"UNKNOWN_ASSET_MAJOR_VERSION", [](Parts& p) { p.json["asset"]["version"] = "3.0"; }},
    {"UNEXPECTED_PROPERTY", [](Parts& p) { p.json["nodes"][0]["colour"] = 1; }},
    {"TYPE_MISMATCH", [](Parts& p) { p.json["nodes"][0]["name"] = 7; }},
    {"EMPTY_ENTITY", [](Parts& p) { p.json["nodes"][0]["children"] = Json::array(); }},
    {"DUPLICATE_ELEMENTS",
     [](Parts& p) {
       p.json["scenes"][0]["nodes"] = {0, 0};
     }},
    {"INVALID_INDEX", [](Parts& p) { p.json["nodes"][0]["mesh"] = -1; }},
    {"UNRESOLVED_REFERENCE", [](Parts& p) { p.json["nodes"][0]["mesh"] = 5; }},
    {"VALUE_NOT_IN_RANGE", [](Parts& p) { p.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 1.5; }},
    {"VALUE_NOT_IN_LIST", [](Parts& p) { p.json["materials"][0]["alphaMode"] = "GLASS"; }},
    {"ARRAY_LENGTH_NOT_IN_LIST",
     [](Parts& p) {
       p.json["nodes"][0]["translation"] = {1, 2};
     }},
    {"MATERIAL_ALPHA_CUTOFF_INVALID_MODE", [](Parts& p) { p.json["materials"][0]["alphaCutoff"] = 0.5; }},
    {"UNDECLARED_EXTENSION",
     [](Parts& p) {
       p.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
           {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
     }},
    {"UNUSED_EXTENSION_REQUIRED", [](Parts& p) { p.json["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }},
    {"UNUSED_OBJECT",
     [](Parts& p) {
       p.json["materials"].push_back({{"doubleSided", true}});
     }},
    {"NODE_LOOP",
     [](Parts& p) {
       p.json["nodes"].push_back({{"children", {2}}});
       p.json["nodes"].push_back({{"children", {1}}});
     }},
    {"NODE_PARENT_OVERRIDE",
     [](Parts& p) {
       p.json["nodes"].push_back({{"children", {0}}});
       p.json["nodes"].push_back({{"children", {0}}});
       p.json["scenes"][0]["nodes"] = {1, 2};
     }},
    {"SCENE_NON_ROOT_NODE",
     [](Parts& p) {
       p.json["nodes"].push_back({{"children", {0}}});
       p.json["scenes"][0]["nodes"] = {0, 1};
     }},
    {"NODE_MATRIX_TRS",
     [](Parts& p) { p.json["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}; }},
    {"ROTATION_NON_UNIT",
     [](Parts& p) {
       p.json["nodes"][0]["rotation"] = {0, 0, 0.5, 0.5};
     }},
    {"ACCESSOR_TOO_LONG", [](Parts& p) { p.json["accessors"][1]["count"] = 25; }},
    {"ACCESSOR_OFFSET_ALIGNMENT",
     [](Parts& p) { p.json["accessors"][0]["byteOffset"] = 2, p.json["accessors"][0]["count"] = 23; }},
    {"ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
     [](Parts& p) { p.json["bufferViews"][1]["byteOffset"] = p.json["bufferViews"][1]["byteOffset"].get<int>() - 2; }},
    {"ACCESSOR_NORMALIZED_INVALID", [](Parts& p) { p.json["accessors"][0]["normalized"] = true; }},
    {"ACCESSOR_SMALL_BYTESTRIDE", [](Parts& p) { p.json["bufferViews"][0]["byteStride"] = 8; }},
    {"VALUE_MULTIPLE_OF", [](Parts& p) { p.json["bufferViews"][0]["byteStride"] = 14; }},
    {"BUFFER_VIEW_TOO_LONG", [](Parts& p) { p.json["bufferViews"][3]["byteLength"] = 100000; }},
    {"BUFFER_VIEW_TARGET_OVERRIDE", [](Parts& p) { p.json["bufferViews"][3]["target"] = 34962; }},
    {"BUFFER_VIEW_INVALID_BYTE_STRIDE", [](Parts& p) { p.json["bufferViews"][3]["byteStride"] = 4; }},
    {"MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE",
     [](Parts& p) { p.json["bufferViews"][3]["byteStride"] = 4, p.json["bufferViews"][3].erase("target"); }},
    {"MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE",
     [](Parts& p) {
       p.json["accessors"][1]["bufferView"] = 0, p.json["accessors"][1]["count"] = 1,
       p.json["accessors"][0]["count"] = 1;
     }},
    {"MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", [](Parts& p) { p.json["accessors"][1]["count"] = 23; }},
    {"MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS", [](Parts& p) { p.json["accessors"][0].erase("min"); }},
    {"MESH_PRIMITIVE_INVALID_ATTRIBUTE",
     [](Parts& p) { p.json["meshes"][0]["primitives"][0]["attributes"]["COLOUR"] = 2; }},
    {"MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", [](Parts& p) { p.json["accessors"][2].erase("normalized"); }},
    {"MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT",
     [](Parts& p) {
       p.json["meshes"][0]["primitives"][0]["attributes"] = {{"POSITION", 0}, {"_ID", 1}};
       p.json["accessors"][1]["componentType"] = 5125;
     }},
    {"MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
     [](Parts& p) { p.json["accessors"][3]["componentType"] = 5126; }},
    {"MESH_PRIMITIVE_INCOMPATIBLE_MODE", [](Parts& p) { p.json["accessors"][3]["count"] = 35; }},
    {"MESH_PRIMITIVE_NO_POSITION",
     [](Parts& p) { p.json["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); }},
    {"ACCESSOR_USAGE_OVERRIDE", [](Parts& p) { p.json["meshes"][0]["primitives"][0]["indices"] = 2; }},
    {"ACCESSOR_MIN_MISMATCH", [](Parts& p) { p.json["accessors"][0]["min"][1] = -0.0100001; }},
    {"ACCESSOR_MAX_MISMATCH", [](Parts& p) { p.poke(0, 4, 0.02f); }},
    {"ACCESSOR_INVALID_FLOAT", [](Parts& p) { p.poke(1, 8, NAN); }},
    {"ACCESSOR_VECTOR3_NON_UNIT", [](Parts& p) { p.poke(1, 0, 0.5f); }},
    {"ACCESSOR_NON_CLAMPED",
     [](Parts& p) {
       p.json["accessors"][2] = {{"bufferView", 0}, {"componentType", 5126}, {"count", 24}, {"type", "VEC3"}};
       p.json["bufferViews"][0]["byteStride"] = 12;
     }},
    {"ACCESSOR_INDEX_OOB", [](Parts& p) { p.poke(3, 8, uint32_t(24)); }},
    {"ACCESSOR_INDEX_PRIMITIVE_RESTART", [](Parts& p) { p.poke(3, 8, UINT32_MAX); }},
    {"ACCESSOR_INDEX_TRIANGLE_DEGENERATE", [](Parts& p) { p.poke(3, 0, uint32_t(3)), p.poke(3, 4, uint32_t(3)); }},
    {"BUFFER_BYTE_LENGTH_MISMATCH", [](Parts& p) { p.bin.resize(p.bin.size() - 4); }},
    {"BUFFER_GLB_CHUNK_TOO_BIG", [](Parts& p) { p.bin.append(4, '\0'); }},
    {"DATA_URI_GLB",
     [](Parts& p) {
       p.json["buffers"][0] = {{"byteLength", 3}, {"uri", "data:application/octet-stream;base64,AAAA"}};
     }},
};

// The same for the container, which the rows above leave whole.
struct TornFault {
  const char* code;
  std::function<void(std::string&)> plant;
};
uint32_t jsonLength(const std::string& glb) {
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  return length;
}
void put(std::string& glb, size_t at, uint32_t value) {
  std::memcpy(glb.data() + at, &value, 4);
}
const std::vector<TornFault> kTornFaults = {
    {"GLB_UNEXPECTED_END_OF_HEADER", [](std::string& b) { b.resize(10); }},
    {"GLB_INVALID_VERSION", [](std::string& b) { put(b, 4, 1); }},
    {"GLB_LENGTH_TOO_SMALL", [](std::string& b) { put(b, 8, 12); }},
    {"GLB_LENGTH_MISMATCH", [](std::string& b) { put(b, 8, uint32_t(b.size() + 4)); }},
    {"GLB_EXTRA_DATA", [](std::string& b) { b.append(4, '\0'); }},
    {"GLB_CHUNK_LENGTH_UNALIGNED", [](std::string& b) { put(b, 12, jsonLength(b) - 1); }},
    {"GLB_CHUNK_TOO_BIG", [](std::string& b) { put(b, 20 + jsonLength(b), 100000); }},
    {"GLB_UNEXPECTED_FIRST_CHUNK", [](std::string& b) { b.replace(16, 4, "BLOB"); }},
    {"GLB_UNEXPECTED_END_OF_CHUNK_DATA", [](std::string& b) { b.resize(b.size() - 8); }},
    {"INVALID_JSON", [](std::string& b) { b[20] = '['; }},
};

struct Planted {
  std::string code, bytes;
};
std::vector<Planted> planted(const samples::Folder& folder) {
  const std::string whole = written(folder, {paintedCube()}, {".glb", false});
  std::vector<Planted> all;
  for (const Fault& fault : kFaults) {
    Parts parts(whole);
    fault.plant(parts);
    all.push_back({fault.code, parts.glb()});
  }
  for (const TornFault& fault : kTornFaults) {
    std::string bytes = whole;
    fault.plant(bytes);
    all.push_back({fault.code, bytes});
  }
  return all;
}

TEST(GltfRules, FaultsAreFound) {
  const samples::Folder folder;
  const std::string whole = written(folder, {paintedCube()}, {".glb", false});
  EXPECT_EQ(Parts(whole).glb(), whole) << "taken apart and put together again";
  for (const Planted& fault : planted(folder)) {
    std::vector<std::string> codes;
    for (const GltfIssue& issue : samples::gltfIssues(fault.bytes)) codes.push_back(issue.code);
    EXPECT_THAT(codes, Contains(fault.code));
  }
}

// Khronos' validator.

constexpr const char* kRunValidator = R"js(
const validator = require('gltf-validator'), fs = require('fs');
(async () => {
  for (const file of process.argv.slice(2)) {
    const names = ['error', 'warning', 'info', 'hint'];
    let report;
    try { report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {maxIssues: 0}); }
    catch (said) { console.log('SAID ' + file + ' error INVALID_FILE ' + said); continue; }
    console.log('SAID ' + file + ' read');
    for (const m of report.issues.messages) console.log('SAID ' + file + ' ' + names[m.severity] + ' ' + m.code + ' ' + m.pointer + ' ' + m.message);
  }
})();
)js";

class LongGltfValidator : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system(
            "NODE_PATH=${NODE_PATH:-$(npm root -g 2>/dev/null)} node -e \"require('gltf-validator')\" >/dev/null "
            "2>&1") != 0)
      GTEST_SKIP() << "gltf-validator is not installed (npm install -g gltf-validator)";
    samples::spill(folder / "run.js", kRunValidator);
  }
  // What it says of each file of the folder, a line each without the file's name.
  std::map<std::string, std::vector<std::string>> said(const std::string& files) {
    const std::string out = (folder / "said.txt").string();
    EXPECT_EQ(std::system(("cd " + folder.path().string() +
                           " && NODE_PATH=${NODE_PATH:-$(npm root -g 2>/dev/null)} node run.js " + files + " >" + out)
                              .c_str()),
              0);
    std::map<std::string, std::vector<std::string>> lines;
    std::istringstream text(samples::slurp(out));
    for (std::string line; std::getline(text, line);) {
      std::istringstream words(line);
      std::string mark, file, rest;
      words >> mark >> file;
      std::getline(words, rest);
      if (mark == "SAID") lines[file].push_back(rest.substr(1));
    }
    return lines;
  }
  samples::Folder folder;
};

TEST_F(LongGltfValidator, FindsNothingInWhatWeWrite) {
  size_t files = 0;
  for (const Way& way : kWays)
    for (size_t i = 0; i < kSamples.size(); ++i) {
      static_cast<void>(
          written(folder, kSamples[i].make(), way, (way.draco ? "packed-" : "plain-") + std::to_string(i)));
      ++files;
    }
  const auto all = said("*.glb *.gltf");
  EXPECT_EQ(all.size(), files);
  for (const auto& [file, lines] : all) {
    EXPECT_EQ(lines.front(), "read") << file;
    for (const std::string& line : lines)
      EXPECT_FALSE(line.starts_with("error") || line.starts_with("warning")) << file << ": " << line;
  }
}

TEST_F(LongGltfValidator, FindsTheSameFaults) {
  const std::vector<Planted> faults = planted(folder);
  for (size_t i = 0; i < faults.size(); ++i)
    samples::spill(folder / ("fault-" + std::to_string(i) + ".glb"), faults[i].bytes);
  const auto all = said("fault-*.glb");
  for (size_t i = 0; i < faults.size(); ++i) {
    const auto found = all.find("fault-" + std::to_string(i) + ".glb");
    ASSERT_NE(found, all.end());
    EXPECT_THAT(found->second, Contains(testing::HasSubstr(" " + faults[i].code + " "))) << faults[i].code;
  }
}

}  // namespace
}  // namespace argil::io
