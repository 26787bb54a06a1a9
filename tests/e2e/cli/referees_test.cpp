// What other programs say of what we write, and we of what they write: a painted ball of 20 mm about (10, 20, 30).
// Programs that are not installed are skipped with a word. Blender, PrusaSlicer, assimp, MeshLab and admesh as Debian
// has them; gltf-validator of npm. What they make of hand-made cases is in unit_engine, LongFormatMatrix; lib3mf reads
// what we write in unit_io, and gltf-validator the odd cases.

#include "tests/e2e/support/referees.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/models/model_file.h"
#include "tests/support/package_samples.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

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
            with open(name + '.seen', 'w') as seen:
                for i in range(0, len(of), max(1, len(of) // 500)):
                    print(*p[of[i]], *[255 * srgb(x) for x in a.data[i].color[:3]], file=seen)
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
        for m in [o.data for o in bpy.data.objects if o.type == 'MESH']:  # Its PLY writer knows this kind of colours alone.
            old = m.color_attributes[0]
            colours = [tuple(c.color_srgb) for c in old.data]
            new = m.color_attributes.new('bytes', 'BYTE_COLOR', 'CORNER')
            for i, l in enumerate(m.loops): new.data[i].color_srgb = colours[i if old.domain == 'CORNER' else l.vertex_index]
            m.color_attributes.active_color = new
        bpy.ops.export_mesh.ply(filepath='theirs.ply', global_scale=1000)
)py";

// The largest difference of a colour that another program saw in a file, of 255, from what we read in it.
double colourDifference(const fs::path& file) {
  const io::ModelFile read = io::readModel(file);
  const io::ModelObject& ours = read.objects.at(0);
  std::ifstream seen(file.string() + ".seen");
  double most = 0, number[6];
  size_t points = 0;
  while (seen >> number[0] >> number[1] >> number[2] >> number[3] >> number[4] >> number[5]) {
    const Vec3d at = Vec3d(number[0], number[1], number[2]) / read.unitMm.value_or(1);
    size_t nearest = 0;
    for (size_t i = 1; i < ours.mesh.positions.size(); ++i)
      if ((ours.mesh.positions[i] - at).squaredNorm() < (ours.mesh.positions[nearest] - at).squaredNorm()) nearest = i;
    const io::Colour& c = ours.vertexColours.at(nearest);
    most = std::max({most, std::abs(number[3] - c.red), std::abs(number[4] - c.green), std::abs(number[5] - c.blue)});
    ++points;
  }
  EXPECT_GT(points, 400u) << file;
  return most;
}

TEST_F(LongReferees, BlenderSeesTheSameAndWeSeeWhatItWrites) {
  if (!installed("blender")) GTEST_SKIP() << "blender is not installed";
  std::ofstream(scratch / "look.py") << kLook;
  std::istringstream said(
      outputOf("blender -b --python-exit-code 1 --python look.py -- ours.glb ours.gltf ours.obj ours.ply ours.stl",
               scratch.path()));
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
    EXPECT_EQ(seen["triangles"], 60156);
    if (file != "ours.stl") {
      EXPECT_LT(seen.value("colours", 99.0), 1);
      EXPECT_LE(colourDifference(scratch / file), 1);
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
  for (const char* name : {"theirs.glb", "theirs.obj", "theirs.stl", "theirs.ply"}) {
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
      ASSERT_EQ(argil({"convert", (scratch / name).string(), (scratch / "back.argil").string(), "--voxel", "0.5",
                       "--overwrite"})
                    .code,
                0);
      EXPECT_NE(argil({"inspect", (scratch / "back.argil").string()}).out.find("colour"), std::string::npos);
    }
  }
}

// Two pieces are two objects of their names, where a format has them.
TEST_F(LongReferees, BlenderSeesPiecesByTheirNames) {
  if (!installed("blender")) GTEST_SKIP() << "blender is not installed";
  std::ofstream two(scratch / "two.obj");
  for (int part = 0; part < 2; ++part) {
    two << (part == 0 ? "o left arm\n" : "o Öhr 2\n");
    for (int k = 0; k < 8; ++k)
      two << "v " << (k & 1) * 10 + 20 * part << ' ' << (k >> 1 & 1) * 10 << ' ' << (k >> 2) * 10 << '\n';
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
      two << "f " << a + 1 + 8 * part << ' ' << b + 1 + 8 * part << ' ' << c + 1 + 8 * part << '\n';
  }
  two.close();
  ASSERT_EQ(argil({"convert", (scratch / "two.obj").string(), (scratch / "two.argil").string(), "--voxel", "0.5"}).code,
            0);
  for (const char* name : {"pieces.glb", "pieces.gltf", "pieces.obj"})
    ASSERT_EQ(argil({"convert", (scratch / "two.argil").string(), (scratch / name).string()}).code, 0);
  std::ofstream(scratch / "look.py") << kLook;
  std::istringstream said(outputOf(
      "blender -b --python-exit-code 1 --python look.py -- pieces.glb pieces.gltf pieces.obj", scratch.path()));
  std::map<std::string, std::set<std::string>> names;
  for (std::string line; std::getline(said, line);)
    if (line.rfind("SAID ", 0) == 0) {
      const Json seen = Json::parse(line.substr(5));
      names[seen["file"]].insert(seen["name"].get<std::string>());
    }
  EXPECT_EQ(names.size(), 3u);
  for (const auto& [file, all] : names) EXPECT_EQ(all, (std::set<std::string>{"left arm", "Öhr 2"})) << file;
}

// Rendered as it comes in, with a plain diffuse material, and, to see that the difference shows, with a dark metal.
constexpr const char* kRender = R"py(
import numpy; numpy.bool = bool
import bpy, json, math
def rendered(name, change):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath='ours.glb')
    for m in bpy.data.materials:
        if m.use_nodes: change(m.node_tree, m.node_tree.nodes['Principled BSDF'])
    s = bpy.context.scene
    def put(kind, data, turn):
        o = bpy.data.objects.new(kind, data)
        s.collection.objects.link(o)
        o.rotation_euler = turn
        return o
    s.camera = put('camera', bpy.data.cameras.new('camera'), (math.radians(90), 0, 0))
    s.camera.data.clip_start = 0.001
    s.camera.location = (0.01, -0.1, 0.03)
    put('sun', bpy.data.lights.new('sun', 'SUN'), (math.radians(50), math.radians(20), 0)).data.energy = 3
    s.world = bpy.data.worlds.new('world')
    s.render.film_transparent = True
    s.render.engine, s.cycles.samples, s.cycles.use_denoising = 'CYCLES', 16, False
    s.render.resolution_x, s.render.resolution_y = 160, 160
    s.view_settings.view_transform = 'Standard'
    s.render.filepath = name
    bpy.ops.render.render(write_still=True)
    pixels = numpy.array(bpy.data.images.load(bpy.path.abspath(name)).pixels[:]).reshape(-1, 4)
    return pixels
def diffuse(tree, old):
    new = tree.nodes.new('ShaderNodeBsdfDiffuse')
    fed = old.inputs['Base Color']
    if fed.is_linked: tree.links.new(fed.links[0].from_socket, new.inputs['Color'])
    else: new.inputs['Color'].default_value = fed.default_value
    tree.links.new(new.outputs[0], [n for n in tree.nodes if n.type == 'OUTPUT_MATERIAL'][0].inputs['Surface'])
def metal(tree, old): old.inputs['Metallic'].default_value, old.inputs['Roughness'].default_value = 1, 0.4
import os
here = os.getcwd() + '/'
ours = rendered(here + 'ours.png', lambda tree, old: None)
plain, dark = rendered(here + 'plain.png', diffuse), rendered(here + 'metal.png', metal)
lit = plain[:, 3] > 0.99
ours, plain, dark = ours[:, :3], plain[:, :3], dark[:, :3]
print('SAID ' + json.dumps({'lit': float(lit.mean()), 'light': float(ours[lit].mean()),
      'colours': float(numpy.abs(ours[lit].max(axis=1) - ours[lit].min(axis=1)).mean()),
      'plain': float(numpy.abs(ours - plain)[lit].mean()), 'metal': float(numpy.abs(ours - dark)[lit].mean())}))
)py";

TEST_F(LongReferees, BlenderRendersItMattAndPainted) {
  if (!installed("blender")) GTEST_SKIP() << "blender is not installed";
  std::ofstream(scratch / "render.py") << kRender;
  const std::string said = outputOf("blender -b --python-exit-code 1 --python render.py", scratch.path());
  if (const char* folder = std::getenv("ARGIL_PICTURES")) fs::copy(scratch / "ours.png", folder);
  const size_t at = said.find("SAID ");
  ASSERT_NE(at, std::string::npos) << said;
  const Json seen = Json::parse(said.substr(at + 5, said.find('\n', at) - at - 5));
  EXPECT_GT(seen["lit"], 0.1) << seen;
  EXPECT_GT(seen["light"], 0.25) << seen;
  EXPECT_GT(seen["colours"], 0.15) << seen;
  EXPECT_LT(seen["plain"], 0.05) << seen;
  EXPECT_GT(seen["metal"], 0.15) << seen;
}

TEST_F(LongReferees, MeshLabFindsOneClosedBodyInItsColours) {
  if (!installed("meshlabserver") || !installed("xvfb-run")) GTEST_SKIP() << "meshlab or xvfb is not installed";
  std::ofstream(scratch / "look.mlx") << "<!DOCTYPE FilterScript><FilterScript><filter name=\"Compute Topological "
                                         "Measures\"/><filter name=\"Compute Geometric Measures\"/></FilterScript>";
  // Debian's MeshLab has no 3MF and ends with an assertion on every OBJ, its own too.
  for (const char* name : {"ours.ply", "ours.stl"}) {
    const std::string said = outputOf(
        std::string("xvfb-run -a meshlabserver -i ") + name + " -o back.ply -m vc -s look.mlx", scratch.path());
    for (const char* words : {"Boundary Edges 0", "composed by 1 connected component", "Mesh is two-manifold",
                              "Mesh has 0 holes", "Genus is 0"})
      EXPECT_NE(said.find(words), std::string::npos) << words << "\n" << said;
    const size_t at = said.find("Mesh Volume  is ");
    ASSERT_NE(at, std::string::npos) << said;
    EXPECT_NEAR(std::stod(said.substr(at + 16)), 33445, 60);
  }
  static_cast<void>(outputOf("xvfb-run -a meshlabserver -i ours.ply -o back.ply -m vc", scratch.path()));
  const io::ModelFile ours = io::readModel(scratch / "ours.ply"), back = io::readModel(scratch / "back.ply");
  EXPECT_EQ(back.objects.at(0).vertexColours, ours.objects.at(0).vertexColours);
  EXPECT_EQ(back.objects.at(0).mesh.triangles, ours.objects.at(0).mesh.triangles);
}

TEST_F(LongReferees, KhronosValidatorFindsNothing) {
  const std::string node = "NODE_PATH=${NODE_PATH:-$(npm root -g 2>/dev/null)} node ";
  if (std::system((node + "-e \"require('gltf-validator')\" >/dev/null 2>&1").c_str()) != 0)
    GTEST_SKIP() << "gltf-validator is not installed (npm install -g gltf-validator)";
  ASSERT_EQ(argil({"convert", (scratch / "ball.argil").string(), (scratch / "packed.glb").string(), "--draco"}).code,
            0);
  std::ofstream(scratch / "validate.js") << R"js(
const validator = require('gltf-validator'), fs = require('fs');
(async () => {
  for (const file of process.argv.slice(2)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {maxIssues: 0});
    console.log('SAID ' + JSON.stringify({file, errors: report.issues.numErrors, warnings: report.issues.numWarnings,
                                          triangles: report.info.totalTriangleCount, all: report.issues.messages}));
  }
})();
)js";
  std::istringstream said(outputOf(node + "validate.js ours.glb ours.gltf packed.glb", scratch.path()));
  int files = 0;
  for (std::string line; std::getline(said, line);) {
    if (line.rfind("SAID ", 0) != 0) continue;
    const Json seen = Json::parse(line.substr(5));
    EXPECT_EQ(seen["errors"], 0) << line;
    EXPECT_EQ(seen["warnings"], 0) << line;
    EXPECT_EQ(seen["triangles"], 60156) << line;
    ++files;
  }
  EXPECT_EQ(files, 3);
}

// A valid solid whose volume is the ball's, and nothing to sew.
TEST_F(LongReferees, OpenCascadeReadsOurStepAsASolid) {
  if (!installed("occt-draw-7.6")) GTEST_SKIP() << "occt-draw-7.6 is not installed";
  const Outcome made =
      argil({"convert", (scratch / "ball.argil").string(), (scratch / "ours.step").string(), "--faces", "200"});
  ASSERT_EQ(made.code, 0) << made.err;
  std::ofstream(scratch / "look.tcl") << "pload MODELING XDE\nstepread ours.step a *\nputs [checkshape a_1]\n"
                                         "puts [nbshapes a_1]\nputs [vprops a_1 1e-6]\nputs [bopcheck a_1]\n";
  const std::string said = outputOf("occt-draw-7.6 -b -f look.tcl", scratch.path());
  // It looks for its libraries by the names that they have for those who build with them.
  if (said.find("Could not open: libTK") != std::string::npos)
    GTEST_SKIP() << "the libraries of occt-draw are not found";
  EXPECT_NE(said.find("This shape seems to be valid"), std::string::npos) << said;
  EXPECT_NE(said.find("SOLID     : 1"), std::string::npos) << said;
  const size_t mass = said.find("Mass :");
  ASSERT_NE(mass, std::string::npos) << said;
  EXPECT_NEAR(std::stod(said.substr(mass + 6)), 33445, 15);  // of the ball with its flat triangles
}

TEST_F(LongReferees, PrusaSlicerSlicesWithoutAWarning) {
  if (!installed("prusa-slicer")) GTEST_SKIP() << "prusa-slicer is not installed";
  for (const char* name : {"ours.stl", "ours.3mf", "ours.obj"}) {
    std::string said = outputOf(
        std::string("prusa-slicer --support-material --export-gcode --output out.gcode ") + name, scratch.path());
    std::transform(said.begin(), said.end(), said.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    EXPECT_EQ(said.find("warning"), std::string::npos) << said;
    EXPECT_EQ(said.find("error"), std::string::npos) << said;
    EXPECT_NE(said.find("exported"), std::string::npos) << said;
    EXPECT_GT(fs::file_size(scratch / "out.gcode"), 100000u);
    fs::remove(scratch / "out.gcode");
  }
}

TEST_F(LongReferees, PrusaSlicerFindsNothingToMend) {
  if (!installed("prusa-slicer")) GTEST_SKIP() << "prusa-slicer is not installed";
  for (const char* name : {"ours.stl", "ours.3mf", "ours.obj"}) {
    const std::string said = outputOf(std::string("prusa-slicer --info ") + name, scratch.path());
    EXPECT_NE(said.find("manifold = yes"), std::string::npos) << said;
    EXPECT_NE(said.find("number_of_parts =  1"), std::string::npos) << said;
    EXPECT_NE(said.find("volume = 3344"), std::string::npos) << said;
  }
}

// A block of 40 × 40 × 20 with a pocket cut away, a modifier and a support: through PrusaSlicer's own hands.
TEST_F(LongReferees, ProjectsOfPrusaSlicerAreCutAsItCutsThem) {
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

TEST_F(LongReferees, AssimpAndAdmeshReadThem) {
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
