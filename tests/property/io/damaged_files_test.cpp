// Files that were cut off or damaged: an Error of one line or a mesh that keeps its promises, never anything else.
#include <gtest/gtest.h>

#include <random>

#include "clay/mesh/mesh_topology.h"
#include "io/models/mesh_file.h"
#include "io/models/mesh_writer.h"
#include "tests/support/damage.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

constexpr uint32_t kSeed = 20262;

struct Sample {
  std::string name;
  std::string bytes;
  bool binary;
};

/// A cube in each format, read and written kinds.
std::vector<Sample> makeSamples() {
  const samples::Folder folder;
  const auto written = [&](const char* name, const WriteOptions& options, bool binary) {
    writeMesh(folder / name, samples::cube(), options);
    return Sample{name, samples::slurp(folder / name), binary};
  };
  std::vector<Sample> all;
  all.push_back(written("a.stl", {}, true));
  all.push_back(written("b.stl", {.text = true}, false));
  all.push_back(written("c.obj", {}, false));
  all.push_back(written("d.ply", {}, true));
  all.push_back(written("e.ply", {.doubles = true}, true));
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty uchar red\nproperty float y\nproperty float "
      "z\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float uv\nelement edge 1\nproperty "
      "int a\nend_header\n"
      "0 1 0 0\n1 1 0 0\n1 1 1 0\n0 1 1 0\n3 0 1 2 2 0.5 0.5\n4 0 1 2 3 0\n7\n";
  all.push_back({"f.ply", text, false});
  all.push_back(
      {"g.off", "COFF # comment\n4 2 0\n0 0 0 255 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 0 1 2 3 0.5 0.5 0.5\n", false});
  all.push_back(
      {"h.obj",
       "# cage\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ng x\nf 1/1/1 2/1 \\\n 3//1\nf -4 -3 -2 -1\n",
       false});
  std::string big =
      "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 3\r\nproperty double x\r\nproperty short y\r\nproperty "
      "list uchar char t\r\n"
      "property float z\r\nelement face 1\r\nproperty list int ushort vertex_index\r\nend_header\r\n";
  for (int v = 0; v < 3; ++v) {
    samples::append(big, double(v), true);
    samples::append(big, int16_t(v * v), true);
    samples::append(big, uint8_t(1), true);
    samples::append(big, int8_t(5), true);
    samples::append(big, float(v), true);
  }
  samples::append(big, int32_t(3), true);
  for (const uint16_t i : {0, 1, 2}) samples::append(big, i, true);
  all.push_back({"i.ply", big, true});
  return all;
}

/// True when it loads; checks what either way promises.
bool loads(std::string_view bytes, const std::string& name) {
  // An own allocation of the exact length, so that a sanitizer sees every byte read beyond it.
  const std::vector<std::byte> exact(samples::bytesOf(bytes).begin(), samples::bytesOf(bytes).end());
  try {
    const MeshFile file = parseMesh(exact, name);
    EXPECT_FALSE(file.mesh.triangles.empty());
    for (const Vec3d& p : file.mesh.positions) EXPECT_TRUE(p.allFinite());
    (void)clay::checkTopology(file.mesh);
    return true;
  } catch (const Error& error) {
    const std::string sentence = error.what();
    EXPECT_EQ(sentence.find(name + ": "), 0u) << sentence;
    EXPECT_EQ(sentence.find_first_of("\r\n"), std::string::npos) << sentence;
    EXPECT_EQ(error.kind(), Error::Kind::input) << sentence;
    return false;
  }
}

TEST(DamagedFiles, TheSamplesLoad) {
  for (const Sample& sample : makeSamples()) EXPECT_TRUE(loads(sample.bytes, sample.name)) << sample.name;
}

TEST(DamagedFiles, CutAtEveryByte) {
  for (const Sample& sample : makeSamples()) {
    for (size_t length = 0; length < sample.bytes.size(); ++length) {
      const bool loaded = loads(std::string_view(sample.bytes).substr(0, length), sample.name);
      if (sample.binary) {
        EXPECT_FALSE(loaded) << sample.name << " cut at " << length;
      }
    }
  }
}

TEST(DamagedFiles, CutTextNeverGivesMoreThanTheWhole) {
  // A text may be cut where it still makes sense (OBJ), and then gives fewer triangles; every other format notices.
  for (const Sample& sample : makeSamples()) {
    if (sample.binary) continue;
    const size_t whole = parseMesh(samples::bytesOf(sample.bytes), sample.name).mesh.triangles.size();
    for (size_t length = 0; length + 2 < sample.bytes.size(); ++length) {
      try {
        const MeshFile file =
            parseMesh(samples::bytesOf(std::string_view(sample.bytes).substr(0, length)), sample.name);
        EXPECT_LE(file.mesh.triangles.size(), whole);
        if (sample.name.ends_with(".ply")) {
          ADD_FAILURE() << sample.name << " cut at " << length;
        }
      } catch (const Error&) {
      }
    }
  }
}

TEST(DamagedFiles, MutatedBytes) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  const std::vector<Sample> all = makeSamples();
  const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
  constexpr std::string_view kInteresting[] = {
      "-1", "4294967295", "99999999999999999999", "nan", "inf", "1e999", "0", "\n", "\\\n", "#", "/"};
  int loaded = 0;
  for (int i = 0; i < 20000; ++i) {
    const Sample& sample = all[below(all.size())];
    const std::string bytes = samples::damaged(sample.bytes, kInteresting, random);
    loaded += loads(bytes, all[below(4) == 0 ? below(all.size()) : size_t(&sample - all.data())].name);
    if (HasFailure()) FAIL() << "mutation " << i << " of " << sample.name;
  }
  // Neither end of the road may be empty, or the mutations test nothing.
  EXPECT_GT(loaded, 1000);
  EXPECT_LT(loaded, 19000);
}

TEST(DamagedFiles, RealBinaryFilesCutAtFiftyPlaces) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const samples::Folder folder;
  for (const char* name : {"featuretype.STL", "gebco7510_55cl_utm.stl", "goblet_vase.stl", "cycloidal.ply",
                           "many_small_holes.ply", "non_manif_hole.ply"}) {
    const std::string whole = samples::slurp(data / name);
    ASSERT_TRUE(loads(whole, name));
    for (size_t i = 0; i < 50; ++i) {
      const size_t length = whole.size() * i / 50 + (i % 7);
      samples::spill(folder / name, std::string_view(whole).substr(0, length));
      const std::string error = samples::errorOf([&] { (void)readMesh(folder / name); });
      EXPECT_NE(error.find(name), std::string::npos) << error;
    }
    EXPECT_FALSE(loads(std::string_view(whole).substr(0, whole.size() - 1), name));
  }
}

TEST(DamagedFiles, RealTextFilesCutAtFiftyPlaces) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  for (const char* name :
       {"thin_tray_1002_tray_bottom.STL", "elephant-with-holes.off", "dragon_vrip_res3.ply", "suzanne.obj"}) {
    const std::string whole = samples::slurp(data / name);
    for (size_t i = 0; i < 50; ++i) {
      const bool loaded = loads(std::string_view(whole).substr(0, whole.size() * i / 50 + (i % 7)), name);
      if (!std::string_view(name).ends_with(".obj")) {
        EXPECT_FALSE(loaded) << name << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace argil::io
