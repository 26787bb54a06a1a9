// Damaged files in formats that the reader process parses: read with what readers promise, or one sentence; nothing
// else, and never late.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <random>
#include <thread>

#include "clay/cage/fit_cage.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "io/bytes/child_process.h"
#include "io/cad/step_file.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"
#include "io/models/reader_process.h"
#include "io/models/vdb_file.h"
#include "tests/support/iges_samples.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/reader_fork.h"
#include "tests/support/step_samples.h"
#include "tests/support/tier.h"

namespace argil::io {
namespace {

constexpr uint32_t kSeed = 20265;
constexpr int kRoundsOfReader = 10;

int rounds() {
  return tests::rounds(20, 200);
}

/// One to four changes: bytes, words of extreme size, digits of its JSON, pieces cut out or doubled, an early end.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](size_t n) { return n == 0 ? 0 : random() % n; };
  for (size_t changes = 1 + below(4); changes > 0 && !bytes.empty(); --changes) {
    const size_t at = below(bytes.size());
    switch (below(7)) {
      case 0:
        bytes[at] = char(below(256));
        break;
      case 1:
        bytes[at] = char(bytes[at] ^ char(1 << below(8)));
        break;
      case 2: {
        constexpr uint32_t kWords[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000, 0x10000000};
        const uint32_t word = kWords[below(std::size(kWords))];
        if (at + 4 <= bytes.size()) std::memcpy(&bytes[at], &word, 4);
        break;
      }
      case 3: {
        const size_t digit = bytes.find_first_of("0123456789", at);
        if (digit != std::string::npos) bytes[digit] = char('0' + below(10));
        break;
      }
      case 4:
        bytes.erase(at, 1 + below(16));
        break;
      case 5:
        bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(16)));
        break;
      default:
        if (below(4) == 0) bytes.resize(at);
    }
  }
  return bytes;
}

// Most of a STEP file's time is that of loading OpenCASCADE. While one of these lives, files are read by forks of a
// reader that has it loaded.
class Forks {
 public:
  Forks()
      : server_(std::filesystem::canonical("/proc/self/exe").parent_path() / "reader_forks",
                {tests::forkName(::getpid())}, {}) {
    for (int i = 0; i < 2000 && !ready(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const auto program = std::filesystem::canonical("/proc/self/exe").parent_path() / "reader_fork";
    ::setenv("ARGIL_READER", program.c_str(), 1);
  }
  ~Forks() { ::unsetenv("ARGIL_READER"); }
  Forks(const Forks&) = delete;
  Forks& operator=(const Forks&) = delete;

 private:
  static bool ready() {
    const int socket = tests::forkSocket(tests::forkName(::getpid()).c_str(), false);
    if (socket >= 0) ::close(socket);
    return socket >= 0;
  }
  ChildProcess server_;
};

class DamagedForOthers : public testing::TestWithParam<const char*> {};

TEST_P(DamagedForOthers, IsReadOrOneSentence) {
  const samples::Folder folder;
  const std::string name = GetParam();
  const auto path = folder / name;
  const bool vdb = name.ends_with(".vdb"), step = name.ends_with(".step"), iges = name.ends_with(".igs");
  if ((step || iges) && !readsCad()) GTEST_SKIP() << "this build has no OpenCASCADE";
  if (name == "screw.step") {
    const char* data = std::getenv("ARGIL_DATA");
    if (!data) GTEST_SKIP() << "ARGIL_DATA is not set: no file of another program";
    std::filesystem::copy_file(std::filesystem::path(data) / "cad" / name, path);
  } else if (name == "block.step") {
    samples::spill(path, samples::stepOfBoredBlock({20, 30, 10}, 6));
  } else if (step) {
    clay::Grid grid;
    grid.voxelMm = 1;
    const clay::PatchSurface surface =
        clay::fitPatches(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 12), 24, 1, clay::WorkPart(nullptr))
            .surface;
    AtomicFile out(path);
    const CadBody body{.name = "Ball", .surface = &surface, .colour = std::array{0.2f, 0.4f, 0.6f}};
    writeStep(out, "ball", std::span(&body, 1));
    out.commit();
  } else if (iges) {
    samples::spill(path, samples::igesOf(samples::boxFaces({10, 20, 30})));
  } else if (vdb) {
    writeVdb(path, {{"ball", clay::makeSphere(clay::Store::make(), {}, Vec3d(1, 2, 3), 5)}});
  } else {
    std::vector<ModelObject> objects(2);
    objects[0].mesh = samples::cube();
    objects[0].colour = Colour{10, 20, 30, 255};
    objects[1].mesh = samples::cube(2, Vec3d(5, 5, 5));
    objects[1].vertexColours.resize(8, Colour{1, 2, 3, 4});
    WriteOptions options;
    options.draco = name != "plain.glb";
    static_cast<void>(writeModel(path, {objects, {}}, options));
  }
  const std::string whole = samples::slurp(path);
  const uint32_t seed = tests::seed(kSeed);
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  int read = 0, crashed = 0;
  std::optional<Forks> forks;
  for (int i = 0; i < rounds(); ++i) {
    // The first ones by the reader itself.
    if (i == kRoundsOfReader && (step || iges) && std::getenv("ARGIL_READER") == nullptr) forks.emplace();
    const std::string bytes = damaged(whole, random);
    if (bytes.empty()) continue;
    samples::spill(path, bytes);
    try {
      if (vdb) {
        for (const VdbObject& object : readVdb(path)) EXPECT_GT(object.version.stats().bricks, 0u);
      } else {
        const ModelFile model = readModel(path);
        EXPECT_FALSE(model.objects.empty());
        for (const ModelObject& object : model.objects) {
          EXPECT_FALSE(object.mesh.triangles.empty());
          for (const Vec3d& p : object.mesh.positions) EXPECT_TRUE(p.allFinite());
          static_cast<void>(clay::checkTopology(object.mesh));
        }
      }
      ++read;
    } catch (const Error& error) {
      const std::string sentence = error.what();
      EXPECT_EQ(sentence.find(path.string() + ": "), 0u) << sentence << " in round " << i;
      EXPECT_EQ(sentence.find_first_of("\r\n"), std::string::npos) << sentence;
      EXPECT_EQ(sentence.find("should not"), std::string::npos) << sentence << " in round " << i;
      crashed += sentence.find("crash") != std::string::npos;
    }
  }
  RecordProperty("read", read);
  RecordProperty("crashed", crashed);
  std::printf("%s: %d of %d read, %d ended the reader\n", name.c_str(), read, rounds(), crashed);
}

INSTANTIATE_TEST_SUITE_P(Formats, DamagedForOthers,
                         testing::Values("packed.glb", "plain.glb", "text.gltf", "one.drc", "ball.vdb", "ball.step",
                                         "screw.step", "box.igs", "block.step"));

}  // namespace
}  // namespace argil::io
