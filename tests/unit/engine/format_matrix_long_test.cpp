// The same cases as other programs write them. Absent programs are skipped with a word; lib3mf is there for all tests.

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "tests/support/lib3mf_writer.h"
#include "tests/unit/engine/format_cases.h"

/// lib3mf leaves some of libzip's memory behind, even when all of its objects are released.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libzip\nleak:lib3MF\n";
}

namespace argil::engine {
using namespace cases;
namespace {

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

// Converters for the formats that Blender does not write, out of a PLY.
struct Converter {
  const char* program;
  const char* column;
  const char* command;  // {0} becomes {1}
  std::set<Says> says;
};
const Converter kConverters[] = {
    {"meshlabserver", "OFF", "xvfb-run -a meshlabserver -i {0} -o {1} -m vc fc", {byVertex, byCorner, byFace}},
    {"draco_encoder", ".drc", "draco_encoder -i {0} -o {1} -qp 20", {byVertex, byCorner}},
    {"prusa-slicer", "3MF", "prusa-slicer --dont-arrange --export-3mf --output {1} {0}", {}},
};

Vec3d lowOf(const std::vector<ModelObject>& objects) {
  Eigen::AlignedBox3d box;
  for (const ModelObject& object : objects)
    for (const Vec3d& p : object.mesh.positions) box.extend(p);
  return box.min();
}

class LongFormatMatrixOf : public testing::TestWithParam<Converter> {};

TEST_P(LongFormatMatrixOf, OtherWritersAreReadTheSame) {
  const Converter& converter = GetParam();
  if (std::system(fmt::format("command -v {} >/dev/null 2>&1", converter.program).c_str()) != 0)
    GTEST_SKIP() << converter.program << " is not installed";
  const samples::Folder folder;
  for (const Row& row : kRows) {
    if (row.needs && !converter.says.contains(*row.needs)) continue;
    const Column& column = *std::find_if(kColumns.begin(), kColumns.end(), [&](const Column& each) {
      return each.name == std::string(converter.column);
    });
    Scene scene = row.scene();
    if (scene.objects.empty()) continue;
    const auto from = folder / (converter.says.empty() ? "from.stl" : "from.ply"), to = folder / column.file;
    static_cast<void>(io::writeModel(from, {scene.objects, {}}));
    const std::string command = fmt::format(fmt::runtime(converter.command), from.string(), to.string());
    std::filesystem::remove(to);
    const int code = std::system(("cd " + folder.path().string() + " && " + command + " >said.txt 2>&1").c_str());
    if (code != 0 || !std::filesystem::exists(to)) {
      std::cout << row.name << ", " << converter.program << ": it does not write this\n";
      continue;
    }
    if (converter.says.empty()) {  // A slicer puts things onto its bed.
      const Vec3d by = lowOf(io::readModel(to).objects) - lowOf(scene.objects);
      for (auto* objects : {&scene.objects, &scene.meant})
        for (ModelObject& object : *objects)
          for (Vec3d& p : object.mesh.positions) p += by;
    }
    const std::string said = cell(to, row, scene);
    std::cout << row.name << ", " << column.name << " of " << converter.program << ": " << said << "\n";
    EXPECT_FALSE(said.starts_with("WRONG")) << row.name << ": " << said;
  }
}
INSTANTIATE_TEST_SUITE_P(All, LongFormatMatrixOf, testing::ValuesIn(kConverters), [](const auto& each) {
  std::string name = each.param.program;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(FormatMatrix, Lib3mfWritesTheSameCases) {
  const samples::Folder folder;
  const auto path = folder / "a.3mf";
  for (const Row& row : kRows) {
    Scene scene = row.scene();
    if (scene.objects.empty() || row.scene().objects.size() > 32) continue;
    samples::writeByLib3mf(path, scene.objects, scene.places, scene.inner, *scene.unit != 0);
    const std::string said = cell(path, row, scene);
    EXPECT_FALSE(said.starts_with("WRONG")) << row.name << ": " << said;
  }
}

}  // namespace
}  // namespace argil::engine
