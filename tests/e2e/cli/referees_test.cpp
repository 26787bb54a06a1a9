// What other programs say of what we write, and we of what they write: a painted ball of 20 mm about (10, 20, 30).
// Programs that are not installed are skipped with a word. Blender, PrusaSlicer, assimp and admesh as Debian has them.

#include "tests/e2e/cli/command.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/support/package_samples.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

bool installed(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

std::string outputOf(const std::string& command, const fs::path& scratch) {
  const fs::path out = scratch / "said.txt";
  const int code = std::system(("cd " + scratch.string() + " && " + command + " >" + out.string() + " 2>&1").c_str());
  EXPECT_EQ(code, 0) << command << "\n" << slurp(out);
  return slurp(out);
}

// One colour a vertex, smooth over 20 mm.
void writeBall(const fs::path& file) {
  constexpr int kAround = 96, kUp = 48;
  std::ostringstream vertices, faces;
  int count = 0, triangles = 0;
  const auto vertex = [&](double x, double y, double z) {
    const auto byte = [](double v) { return std::lround(128 + 100 * v); };
    vertices << x + 10 << ' ' << y + 20 << ' ' << z + 30 << ' ' << byte(std::sin(x / 6)) << ' ' << byte(std::cos(y / 7))
             << ' ' << byte(std::sin(z / 8 + 1)) << '\n';
    return count++;
  };
  const auto face = [&](int a, int b, int c) { faces << "3 " << a << ' ' << b << ' ' << c << '\n', ++triangles; };
  const int top = vertex(0, 0, 20);
  for (int j = 1; j < kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const double b = M_PI / 2 - M_PI * j / kUp, a = 2 * M_PI * i / kAround;
      vertex(20 * std::cos(b) * std::cos(a), 20 * std::cos(b) * std::sin(a), 20 * std::sin(b));
    }
  const int bottom = vertex(0, 0, -20);
  const auto at = [](int j, int i) { return 1 + (j - 1) * kAround + i % kAround; };
  for (int i = 0; i < kAround; ++i) face(top, at(1, i), at(1, i + 1)), face(bottom, at(kUp - 1, i + 1), at(kUp - 1, i));
  for (int j = 1; j < kUp - 1; ++j)
    for (int i = 0; i < kAround; ++i)
      face(at(j, i), at(j + 1, i), at(j + 1, i + 1)), face(at(j, i), at(j + 1, i + 1), at(j, i + 1));
  std::ofstream(file) << "ply\nformat ascii 1.0\nelement vertex " << count
                      << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
                         "green\nproperty uchar blue\nelement face "
                      << triangles << "\nproperty list uchar int vertex_indices\nend_header\n"
                      << vertices.str() << faces.str();
}

class LongReferees : public testing::Test {
 protected:
  void SetUp() override {
    writeBall(scratch / "ball.ply");
    Outcome made =
        argil({"convert", (scratch / "ball.ply").string(), (scratch / "ball.argil").string(), "--voxel", "0.5"});
    ASSERT_EQ(made.code, 0) << made.err;
    for (const char* ending : {"glb", "gltf", "obj", "ply", "stl", "3mf"}) {
      made =
          argil({"convert", (scratch / "ball.argil").string(), (scratch / (std::string("ours.") + ending)).string()});
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }
  Scratch scratch;
};

// Prints a line of JSON for each object: box in mm, colours' distance from what was painted (root mean square of 255),
// roughness and metal of its material; and writes what it read from ours.glb in its own way.
constexpr const char* kLook = R"py(
import numpy; numpy.bool = bool  # Debian's glTF add-on is older than its numpy.
import bpy, json, math, sys
def srgb(c): return 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055
def painted(p): return [128 + 100 * math.sin((p[0] - 10) / 6), 128 + 100 * math.cos((p[1] - 20) / 7), 128 + 100 * math.sin((p[2] - 30) / 8 + 1)]
for name in sys.argv[sys.argv.index('--') + 1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ending, scale = name.split('.')[-1], 1
    if ending in ('glb', 'gltf'): bpy.ops.import_scene.gltf(filepath=name); scale = 1000
    elif ending == 'obj': bpy.ops.wm.obj_import(filepath=name, forward_axis='Y', up_axis='Z')
    elif ending == 'ply': bpy.ops.import_mesh.ply(filepath=name)
    else: bpy.ops.import_mesh.stl(filepath=name)
    for o in [o for o in bpy.data.objects if o.type == 'MESH']:
        m = o.data
        p = [scale * (o.matrix_world @ v.co) for v in m.vertices]
        said = {'file': name, 'name': o.name, 'triangles': len(m.polygons), 'low': [min(q[k] for q in p) for k in range(3)], 'high': [max(q[k] for q in p) for k in range(3)]}
        if m.color_attributes:
            a = m.color_attributes[0]
            of = [l.vertex_index for l in m.loops] if a.domain == 'CORNER' else range(len(m.vertices))
            d = [255 * srgb(x) - y for c, v in zip(a.data, of) for x, y in zip(c.color[:3], painted(p[v]))]
            said['colours'] = math.sqrt(sum(x * x for x in d) / len(d))
        for s in [s for s in m.materials if s and s.use_nodes]:
            b = s.node_tree.nodes['Principled BSDF'].inputs
            said['roughness'], said['metallic'] = b['Roughness'].default_value, b['Metallic'].default_value
        print('SAID ' + json.dumps(said))
    if name == 'ours.glb':
        bpy.ops.export_scene.gltf(filepath='theirs.glb', export_format='GLB')
        bpy.ops.wm.obj_export(filepath='theirs.obj', forward_axis='Y', up_axis='Z', global_scale=1000, export_colors=True)
        bpy.ops.object.select_all(action='SELECT')
        bpy.ops.export_mesh.stl(filepath='theirs.stl', global_scale=1000)
)py";

TEST_F(LongReferees, blenderSeesTheSameAndWeSeeWhatItWrites) {
  if (!installed("blender")) GTEST_SKIP() << "blender is not installed";
  std::ofstream(scratch / "look.py") << kLook;
  std::istringstream said(
      outputOf("blender -b --python look.py -- ours.glb ours.gltf ours.obj ours.ply ours.stl", scratch.path()));
  int files = 0;
  for (std::string line; std::getline(said, line);) {
    if (line.rfind("SAID ", 0) != 0) continue;
    const Json seen = Json::parse(line.substr(5));
    const std::string file = seen["file"];
    SCOPED_TRACE(line);
    ++files;
    const double middle[] = {10, 20, 30};
    for (size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(seen["low"][k].get<double>(), middle[k] - 20, 0.03);
      EXPECT_NEAR(seen["high"][k].get<double>(), middle[k] + 20, 0.03);
    }
    if (file != "ours.stl") {
      EXPECT_LT(seen.value("colours", 99.0), 1);
    }
    if (file == "ours.glb" || file == "ours.gltf" || file == "ours.obj") {
      EXPECT_EQ(seen["name"], "ball");
    }
    if (file == "ours.glb" || file == "ours.gltf") {
      EXPECT_EQ(seen["roughness"], 1.0);
      EXPECT_EQ(seen["metallic"], 0.0);
    }
  }
  EXPECT_EQ(files, 5);
  for (const char* name : {"theirs.glb", "theirs.obj", "theirs.stl"}) {
    SCOPED_TRACE(name);
    const Outcome seen = argil({"inspect", (scratch / name).string(), "--json"});
    ASSERT_EQ(seen.code, 0) << seen.err;
    const Json mesh = Json::parse(seen.out)["mesh"];
    EXPECT_TRUE(mesh["closed"]) << mesh;
    EXPECT_EQ(mesh["bodies"], 1);
    EXPECT_NEAR(mesh["volume_mm3"].get<double>(), 33445, 60);
    const double middle[] = {10, 20, 30};
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(mesh["low_mm"][k].get<double>(), middle[k] - 20, 0.03);
    if (std::string(name) != "theirs.stl") {
      // Its colours are the clay's, and go out again.
      ASSERT_EQ(argil({"convert", (scratch / name).string(), (scratch / "back.argil").string(), "--voxel", "0.5"}).code,
                0);
      EXPECT_NE(argil({"inspect", (scratch / "back.argil").string()}).out.find("colour"), std::string::npos);
    }
  }
}

TEST_F(LongReferees, prusaSlicerFindsNothingToMend) {
  if (!installed("prusa-slicer")) GTEST_SKIP() << "prusa-slicer is not installed";
  for (const char* name : {"ours.stl", "ours.3mf", "ours.obj"}) {
    const std::string said = outputOf(std::string("prusa-slicer --info ") + name, scratch.path());
    EXPECT_NE(said.find("manifold = yes"), std::string::npos) << said;
    EXPECT_NE(said.find("number_of_parts =  1"), std::string::npos) << said;
    EXPECT_NE(said.find("volume = 3344"), std::string::npos) << said;
  }
}

// A block of 40 × 40 × 20 with a pocket cut away, a modifier and a support: through PrusaSlicer's own hands.
TEST_F(LongReferees, projectsOfPrusaSlicerAreCutAsItCutsThem) {
  if (!installed("prusa-slicer")) GTEST_SKIP() << "prusa-slicer is not installed";
  std::string vertices, triangles, volumes;
  int corners = 0, faces = 0;
  const auto box = [&](const char* kind, const Vec3d& low, const Vec3d& high) {
    for (int k = 0; k < 8; ++k)
      vertices += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", k & 1 ? high.x() : low.x(),
                              k & 2 ? high.y() : low.y(), k & 4 ? high.z() : low.z());
    for (const auto& [a, b, c] : std::vector<std::array<int, 3>>{{0, 2, 1},
                                                                 {1, 2, 3},
                                                                 {4, 5, 6},
                                                                 {5, 7, 6},
                                                                 {0, 1, 4},
                                                                 {1, 5, 4},
                                                                 {2, 6, 3},
                                                                 {3, 6, 7},
                                                                 {0, 4, 2},
                                                                 {2, 4, 6},
                                                                 {1, 3, 5},
                                                                 {3, 7, 5}})
      triangles += fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>", corners + a, corners + b, corners + c);
    volumes += fmt::format(
        "<volume firstid=\"{}\" lastid=\"{}\"><metadata type=\"volume\" key=\"volume_type\" value=\"{}\"/></volume>",
        faces, faces + 11, kind);
    corners += 8, faces += 12;
  };
  box("ModelPart", {0, 0, 0}, {40, 40, 20});
  box("NegativeVolume", {10, 10, 10}, {30, 30, 25});
  box("ParameterModifier", {-5, -5, -5}, {5, 5, 30});
  box("SupportEnforcer", {36, 0, 0}, {40, 4, 4});
  std::ofstream(scratch / "in.3mf", std::ios::binary) << samples::threeMf(
      "<resources><object id=\"1\" type=\"model\"><mesh><vertices>" + vertices + "</vertices><triangles>" + triangles +
          "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build>",
      "unit=\"millimeter\"",
      {{"Metadata/Slic3r_PE_model.config",
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config><object id=\"1\" instances_count=\"1\">" + volumes +
            "</object></config>"}});
  static_cast<void>(outputOf("prusa-slicer --export-3mf --output project.3mf in.3mf", scratch.path()));
  ASSERT_EQ(
      argil({"convert", (scratch / "project.3mf").string(), (scratch / "cut.stl").string(), "--voxel", "0.25"}).code,
      0);
  const Json mesh = Json::parse(argil({"inspect", (scratch / "cut.stl").string(), "--json"}).out)["mesh"];
  EXPECT_NEAR(mesh["volume_mm3"].get<double>(), 28000, 28);
}

TEST_F(LongReferees, assimpAndAdmeshReadThem) {
  if (!installed("assimp") || !installed("admesh")) GTEST_SKIP() << "assimp or admesh is not installed";
  for (const char* name : {"ours.glb", "ours.gltf", "ours.obj", "ours.ply", "ours.stl", "ours.3mf"}) {
    const std::string said = outputOf(std::string("assimp info ") + name, scratch.path());
    EXPECT_NE(said.find("Faces:              60156"), std::string::npos) << name << said;
  }
  const std::string said = outputOf("admesh ours.stl", scratch.path());
  EXPECT_NE(said.find("Number of parts       :     1"), std::string::npos) << said;
  EXPECT_NE(said.find("Total disconnected facets        :     0"), std::string::npos) << said;
}

}  // namespace
}  // namespace argil::tests
