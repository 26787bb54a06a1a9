// Brushes of plugins' libraries: the same clay as ever, and whatever they do wrong costs the stroke and nothing else.

#include "engine/plugins/plugin_brush.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <thread>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/plugins/plugin_folders.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

using clay::Stamp;
using clay::Version;
using testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kConfined = false;  // sanitizers leave the process as it is
#else
constexpr bool kConfined = true;
#endif

Version sphere() {
  clay::Grid grid;
  grid.originMm = Vec3d::Constant(grid.voxelMm / 2);  // a plane between bricks through the middle
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 20);
}

std::vector<Stamp> stamps(int count = 8) {
  std::vector<Stamp> all;
  Vec3d at(6, 3, 39);
  for (int i = 0; i < count; ++i) {
    const Vec3d to = at + Vec3d(1.3, 0.4, -0.2);
    all.push_back({at, to, 9, 0.6f});
    at = to;
  }
  return all;
}

std::shared_ptr<clay::Brush> brushOf(std::shared_ptr<const clay::ExternalBrush> external,
                                     std::vector<float> values = {}) {
  auto brush = std::make_shared<clay::Brush>();
  brush->operations.push_back({clay::Property::distance, clay::Method::external});
  brush->external = std::move(external);
  brush->values = std::move(values);
  return brush;
}

Version stroked(const Version& base, const std::shared_ptr<const clay::Brush>& brush, int publishEvery = 1000,
                int threads = 1, bool mirrored = false) {
  clay::BrushStroke stroke(base, brush, {}, threads);
  int n = 0;
  for (const Stamp& each : stamps()) {
    Stamp image = each;
    image.a.x() = -1 - each.a.x();
    image.b.x() = -1 - each.b.x();
    image.axes.row(0) *= -1;
    if (mirrored)
      stroke.apply(std::array{each, image});
    else
      stroke.apply(each);
    if (++n % publishEvery == 0) (void)stroke.publish();
  }
  return stroke.finish();
}

bool symmetric(const Version& made) {
  bool same = true;
  made.forEachBrick([&](const clay::Brick& brick) {
    const clay::Slot slot = made.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      same = same && brick.phi(i) == slot.phi(clay::Brick::offset(7 - (i >> 6), (i >> 3) & 7, i & 7), 3);
  });
  return same;
}

const std::vector<float> kStrips{3, 0.7f, 0.3f};

// Within a voxel of the surface. Farther out what lies beside the bricks that hold some surface is known differently.
void expectWrittenDownIs(clay::Method method, const char* example, double radius, double within) {
  SCOPED_TRACE(example);
  // Something to smooth.
  clay::BrushStroke rough(sphere(), clay::Brush::of(clay::Method::raise));
  for (const Stamp& each : stamps()) rough.apply(each);
  const Version base = rough.finish();
  const auto stroked = [&](const std::shared_ptr<const clay::Brush>& brush) {
    clay::BrushStroke stroke(base, brush);
    for (Stamp each : stamps()) {
      each.radius = radius;
      stroke.apply(each);
    }
    return stroke.finish();
  };
  const Version written = stroked(brushOf(tests::brushIn(tests::examplePlugin(example))));
  const Version built = stroked(clay::Brush::of(method));
  float most = 0, moved = 0;
  built.forEachBrick([&](const clay::Brick& brick) {
    const clay::Slot other = written.find(brick.coord), was = base.find(brick.coord);
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < 1) {
        most = std::max(most, std::abs(brick.phi(i) - other.phi(i, 3)));
        moved = std::max(moved, std::abs(brick.phi(i) - was.phi(i, 3)));
      }
  });
  EXPECT_LT(most, within);
  EXPECT_GT(moved, 0.05);
}

TEST(PluginBrush, SmoothingThatIsWrittenDownIsSmoothing) {
  expectWrittenDownIs(clay::Method::smooth, "soften", 9, 0.001);
  expectWrittenDownIs(clay::Method::smooth, "wide-mean", 20, 0.003);  // whose means of means end at the stamp's bricks
}

TEST(PluginBrush, TheSameHoweverItIsPublishedAndOnAnyThreads) {
  const Version base = sphere();
  for (const char* name : {"soften", "clay-strips"}) {
    SCOPED_TRACE(name);
    const auto values = std::string(name) == "soften" ? std::vector<float>() : kStrips;
    const auto external = tests::brushIn(tests::examplePlugin(name));
    const auto brush = brushOf(external, values);
    const uint64_t hash = stroked(base, brush).hash();
    EXPECT_NE(hash, base.hash());
    EXPECT_EQ(stroked(base, brush, 1).hash(), hash);
    EXPECT_EQ(stroked(base, brush, 3).hash(), hash);
    EXPECT_EQ(external->processes().started(), 1u) << "a process serves one stroke after the other";
    EXPECT_EQ(stroked(base, brushOf(tests::brushIn(tests::examplePlugin(name)), values), 5, 4).hash(), hash);
    EXPECT_TRUE(symmetric(stroked(base, brush, 1000, 1, true)));
  }
}

TEST(PluginBrush, LargeTipsAreDividedAmongThreadsAndBatches) {
  clay::Grid grid;
  grid.voxelMm = 0.1;
  const Version base = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 20);
  std::vector<uint64_t> hashes;
  for (const int threads : {1, 4}) {
    clay::BrushStroke stroke(base, brushOf(tests::brushIn(tests::examplePlugin("clay-strips")), kStrips), {}, threads);
    for (int i = 0; i < 3; ++i) stroke.apply({Vec3d(4.0 * i, 0, 200), Vec3d(4.0 * i + 4, 0, 200), 120});
    EXPECT_GT(stroke.touched(), 3 * 1024u) << "more than one batch";
    hashes.push_back(stroke.finish().hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Strips lie beside each other, end at a height of their own, and leave closed clay.
TEST(PluginBrush, ClayStripsAreStrips) {
  clay::Grid grid;
  grid.voxelMm = 0.25;
  const Version base = clay::makeBlock(clay::Store::make(), grid, Vec3d(0, 0, -10), Vec3d(40, 40, 20), 1);
  clay::BrushStroke stroke(base, brushOf(tests::brushIn(tests::examplePlugin("clay-strips")), {3, 0.6f, 0.25f}));
  const double radius = 20;  // voxels: 5 mm
  for (int pass = 0; pass < 3; ++pass)
    for (int i = -20; i < 20; ++i) stroke.apply({Vec3d(2.0 * i, 0, 0), Vec3d(2.0 * i + 2, 0, 0), radius});
  const Version made = stroke.finish();
  clay::Surface surface(false);
  surface.update(made);
  EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed());
  // Height of the surface across the path, voxels.
  const auto heightAt = [&](int y) {
    int z = 12;
    while (z > -3 && made.find(Coord{0, y, z} >> 3).phi(clay::Brick::offset(0, y & 7, z & 7), 3) >= 0) --z;
    return z;
  };
  // Three strips of 8 voxels, 13.3 apart: the middle of one, between two, the next, beyond all.
  EXPECT_NEAR(heightAt(0), 0.25 * radius, 1.5);
  EXPECT_LE(heightAt(7), 1);
  EXPECT_NEAR(heightAt(13), 0.25 * radius, 2);
  EXPECT_LE(heightAt(22), 0);
}

struct Bad {
  const char* name;
  PluginFault fault;
  const char* says;
  int applied = 2;  // stamps that are in the clay
};

class BadPlugin : public testing::TestWithParam<Bad> {
 protected:
  std::filesystem::path folder_ = std::filesystem::temp_directory_path() / "bad";
  void TearDown() override { std::filesystem::remove_all(folder_); }
};

TEST_P(BadPlugin, CostsTheStampAndNothingElse) {
  const Bad& bad = GetParam();
  if (!kConfined && std::string(bad.name) == "hog") GTEST_SKIP() << "sanitizers take the limits of memory away";
  const auto external =
      tests::brushIn(tests::badPlugin(folder_, bad.name), {.memoryBytes = uint64_t{1} << 30, .comparesWindow = true});
  const auto good = tests::brushIn(tests::badPlugin(folder_, "good"));
  const Version base = sphere();
  const std::vector<Stamp> all = stamps();
  const auto brush = brushOf(external);
  brush->adds = true;
  const auto peer = std::make_shared<clay::Brush>(*brush);
  peer->external = good;
  std::unique_ptr<clay::BrushStroke> stroke;
  int applied = 0;
  try {
    stroke = std::make_unique<clay::BrushStroke>(base, brush);
    for (const Stamp& each : all) {
      stroke->apply(each);
      ++applied;
    }
    FAIL() << "nothing was found";
  } catch (const PluginError& error) {
    EXPECT_EQ(nameOf(error.fault()), nameOf(bad.fault)) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(bad.says));
    EXPECT_THAT(error.what(), HasSubstr(std::string("Bad ") + bad.name)) << "the plugin is named";
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
  ASSERT_EQ(applied, bad.applied);
  if (!stroke) return;
  // What comes behind does nothing, and the stroke leaves the clay as before the stamp.
  for (const Stamp& each : all) stroke->apply(each);
  const Version left = stroke->finish();
  clay::BrushStroke whole(base, peer);
  for (int i = 0; i < bad.applied; ++i) whole.apply(all[static_cast<size_t>(i)]);
  // A stamp that does nothing moves what trails on.
  const Version should = whole.finish();
  clay::Surface a(false), b(false);
  a.update(left);
  b.update(should);
  EXPECT_EQ(clay::checkTopology(a.toMesh()).triangles, clay::checkTopology(b.toMesh()).triangles);
  EXPECT_EQ(left.hash(), should.hash());
}

INSTANTIATE_TEST_SUITE_P(
    All, BadPlugin,
    testing::Values(
        Bad{"crash", PluginFault::crashed, "crashed (Segmentation fault)"},
        Bad{"exit", PluginFault::crashed, "ended its process"}, Bad{"kill", PluginFault::crashed, "crashed (Killed)"},
        Bad{"hang", PluginFault::hung, "without an answer and was stopped"},
        Bad{"sleep", PluginFault::hung, "did not answer"}, Bad{"nan", PluginFault::notFinite, "not finite"},
        Bad{"infinite", PluginFault::notFinite, "not finite"},
        Bad{"outside", PluginFault::outside, "outside of its batch"},
        Bad{"input", PluginFault::outside, "outside of its batch"}, Bad{"hog", PluginFault::memory, "MiB of memory"},
        Bad{"fails", PluginFault::failed, "the moon is in the wrong place"},
        Bad{"status", PluginFault::failed, "does not say why"}, Bad{"begins_not", PluginFault::failed, "failed", 0},
        Bad{"constructor_crash", PluginFault::crashed, "while it was loaded", 0},
        Bad{"constructor_hang", PluginFault::hung, "did not answer", 0},
        Bad{"init_crash", PluginFault::crashed, "while it began", 0},
        Bad{"init_fails", PluginFault::failed, "it needs a tambourine", 0},
        Bad{"entry_null", PluginFault::noEntry, "cannot work here", 0},
        Bad{"wrong_version", PluginFault::noEntry, "does not export argil_plugin_1", 0},
        Bad{"id", PluginFault::notAsSaid, "calls itself test.other", 0},
        Bad{"version", PluginFault::notAsSaid, "is version 2.0.0", 0},
        Bad{"nothing", PluginFault::notAsSaid, "has no test.bad.nothing.brush", 0},
        Bad{"short", PluginFault::notAsSaid, "has no test.bad.short.brush", 0},
        Bad{"margin", PluginFault::notAsSaid, "reads 2 voxels", 0},
        Bad{"numbers", PluginFault::notAsSaid, "has 1 numbers", 0}),
    [](const auto& each) { return std::string(each.param.name); });

// What is refused fails with EPERM: the plugin lives, and it is known what it tried.
TEST(PluginBrush, WhatItMayNotDoIsRefusedAndKnown) {
  if (!kConfined) GTEST_SKIP() << "sanitizers leave the process as it is";
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "refused";
  const std::vector<std::pair<const char*, const char*>> all{
      {"fork", "start another process"}, {"socket", "open a connection"}, {"file", "look at files"}};
  for (const auto& [name, tried] : all) {
    SCOPED_TRACE(name);
    const auto external = tests::brushIn(tests::badPlugin(folder, name));
    EXPECT_NE(stroked(sphere(), brushOf(external)).hash(), sphere().hash());
    const auto process = external->processes().take(1);
    EXPECT_EQ(process->refusedCall(), tried);
    EXPECT_TRUE(process->alive());
    EXPECT_EQ(process->unconfined(), "");
  }
}

// Whatever a plugin gives, the clay stays a narrow band of finite distances, changed under the tip alone.
TEST(PluginBrush, NonsenseDoesNoHarm) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "nonsense";
  const Version base = sphere(), made = stroked(base, brushOf(tests::brushIn(tests::badPlugin(folder, "huge"))));
  EXPECT_NE(made.hash(), base.hash());
  made.forEachBrick([&](const clay::Brick& brick) {
    for (int i = 0; i < clay::kBrickVoxels; ++i) ASSERT_LE(std::abs(brick.phi(i)), 3);
  });
  clay::Surface surface(false);
  surface.update(made);
  EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed());
}

TEST(PluginBrush, AfterThreeFaultsItIsLeftAlone) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "thrice";
  const auto external = tests::brushIn(tests::badPlugin(folder, "crash"));
  for (int i = 0; i < PluginProcesses::kMostFaults; ++i)
    EXPECT_THROW((void)stroked(sphere(), brushOf(external)), PluginError);
  try {
    (void)stroked(sphere(), brushOf(external));
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("failed 3 times and is not used again"));
  }
  EXPECT_EQ(external->processes().started(), 3u);
}

TEST(PluginBrush, AProcessThatEndsWhileItWaitsIsStartedAnew) {
  const auto external = tests::brushIn(tests::examplePlugin("soften"));
  const uint64_t hash = stroked(sphere(), brushOf(external)).hash();
  for (int i = 0; i < 5; ++i) {
    ::kill(external->processes().newest(), SIGKILL);  // however soon it is noticed
    EXPECT_EQ(stroked(sphere(), brushOf(external)).hash(), hash);
  }
}

TEST(PluginBrush, StrokesAtTheSameTimeHaveProcessesOfTheirOwn) {
  const auto external = tests::brushIn(tests::examplePlugin("clay-strips"));
  const uint64_t hash = stroked(sphere(), brushOf(external, kStrips)).hash();
  std::vector<std::thread> threads;
  std::atomic<int> right{0};
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 3; ++k)
        if (stroked(sphere(), brushOf(external, kStrips), 1).hash() == hash) ++right;
    });
  for (std::thread& each : threads) each.join();
  EXPECT_EQ(right, 12);
  EXPECT_LE(external->processes().started(), 5u);
}

// A kill at any moment: the stroke that it hits ends, all others are whole.
TEST(PluginBrush, KilledAtAnyMoment) {
  const Version base = sphere();
  const std::vector<Stamp> all = stamps();
  std::vector<uint64_t> prefixes;
  for (size_t n = 0; n <= all.size(); ++n) {
    clay::BrushStroke stroke(base, brushOf(tests::brushIn(tests::examplePlugin("clay-strips")), kStrips));
    for (size_t i = 0; i < n; ++i) stroke.apply(all[i]);
    prefixes.push_back(stroke.finish().hash());
  }
  std::mt19937_64 random(1);
  int hit = 0;
  const int rounds = tests::byTier(40, 4000);
  for (int round = 0; round < rounds; ++round) {
    const auto external = tests::brushIn(tests::examplePlugin("clay-strips"));
    clay::BrushStroke stroke(base, brushOf(external, kStrips));
    const auto after = std::chrono::microseconds(random() % 1500);
    std::thread killer([pid = external->processes().newest(), after] {
      std::this_thread::sleep_for(after);
      ::kill(pid, SIGKILL);
    });
    size_t applied = 0;
    try {
      for (const Stamp& each : all) {
        stroke.apply(each);
        ++applied;
      }
    } catch (const PluginError& error) {
      EXPECT_EQ(error.fault(), PluginFault::crashed) << error.what();
      ++hit;
    }
    EXPECT_EQ(stroke.finish().hash(), prefixes[applied]) << "round " << round << ", " << applied << " stamps";
    killer.join();
  }
  EXPECT_GT(hit, rounds / 10) << "kills come too late";
}

// Over argil_plugin.hpp: what it throws ends the stroke with its own words.
TEST(PluginBrush, InCPlusPlus) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "cplusplus" / "smooth.argil-plugin";
  fs::create_directories(folder / kPluginMachine);
  fs::copy_file(fs::path(ARGIL_BAD_PLUGINS) / "bad_smooth.so", folder / kPluginMachine / "smooth.so",
                fs::copy_options::overwrite_existing);
  std::ofstream(folder / kPluginFile) << R"({"format": 1, "id": "test.smooth", "name": "Smooth", "version": "1.0.0",
    "licence": "CC0-1.0", "help": "For tests.", "library": "smooth.so", "brushes": [{"id": "smooth", "name": "Smooth",
    "help": "Smooths.", "bricks": {"margin": 1, "leaves": "values"}, "numbers": [{"id": "fails", "name": "Fails",
    "help": "Whether.", "low": 0, "high": 1, "standard": 0}]}]})";
  const auto external = tests::brushIn(folder);
  const Version base = sphere(), made = stroked(base, brushOf(external, {0}));
  EXPECT_NE(made.hash(), base.hash());
  EXPECT_EQ(stroked(base, brushOf(external, {0}), 2, 3).hash(), made.hash());
  try {
    (void)stroked(base, brushOf(external, {1}));
    FAIL();
  } catch (const PluginError& error) {
    EXPECT_THAT(error.what(), HasSubstr("Smooth failed: the wind has turned"));
  }
}

// What a mask covers stays to the bit, whatever a library gives for it.
TEST(PluginBrush, WhatIsMaskedStays) {
  const Version base = sphere();
  clay::Editor editor(base);
  base.forEachBrick([&](const clay::Brick& brick) {
    if (brick.coord.y < 0) editor.setChannelTile(clay::Channel::mask, brick.coord, true);
  });
  const Version masked = editor.commit();
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "masked";
  for (const auto& external :
       {tests::brushIn(tests::examplePlugin("soften")), tests::brushIn(tests::badPlugin(folder, "huge"))}) {
    clay::BrushStroke stroke(masked, brushOf(external));
    for (int i = 0; i < 8; ++i) stroke.apply({Vec3d(i, 0, 39), Vec3d(i + 1, 0, 39), 9, 1.0f});
    const Version made = stroke.finish();
    bool free = false;
    made.forEachBrick([&](const clay::Brick& brick) {
      const clay::Slot was = masked.find(brick.coord);
      for (int i = 0; i < clay::kBrickVoxels; ++i) {
        if (brick.coord.y < 0 && std::abs(was.phi(i, 3)) < 3) {
          ASSERT_EQ(brick.phi(i), was.phi(i, 3));
        }
        free = free || (brick.coord.y >= 0 && brick.phi(i) != was.phi(i, 3));
      }
    });
    EXPECT_TRUE(free);
  }
}

// Any fault at any stamp of any stroke: the clay is that of the stamps before it, and the plugin is named.
// ARGIL_FAULTS: how many.
TEST(PluginBrush, AnyFaultAtAnyTime) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "any";
  const Version base = sphere();
  const std::vector<Stamp> all = stamps(12);
  const auto good = tests::brushIn(tests::badPlugin(folder, "good"));
  std::map<std::pair<size_t, size_t>, uint64_t> known;  // of stamps from one to another
  const auto should = [&](size_t from, size_t to) {
    const auto [it, fresh] = known.try_emplace({from, to});
    if (fresh) {
      auto brush = brushOf(good);
      brush->adds = true;
      clay::BrushStroke stroke(base, brush);
      for (size_t i = from; i < to; ++i) stroke.apply(all[i]);
      it->second = stroke.finish().hash();
    }
    return it->second;
  };
  constexpr std::array kFaults{"crash", "exit", "kill", "nan", "infinite", "fails", "status", "good"};
  std::array<std::filesystem::path, kFaults.size()> folders;
  for (size_t i = 0; i < kFaults.size(); ++i) folders[i] = tests::badPlugin(folder, kFaults[i]);
  std::mt19937_64 random(7);
  const char* asked = std::getenv("ARGIL_FAULTS");
  const int wanted = asked ? std::atoi(asked) : tests::byTier(100, 5000);
  int faults = 0, wrong = 0;
  while (faults < wanted && wrong == 0) {
    const size_t which = random() % kFaults.size();
    const auto external = tests::brushIn(folders[which]);
    const auto brush = brushOf(external);
    brush->adds = true;
    // Killed from outside, too; some processes serve several strokes before.
    std::jthread killer;
    const bool kills = which + 1 == kFaults.size();
    for (int round = 0; round < 3; ++round) {
      const size_t from = random() % 4, to = from + 4 + random() % 4;
      size_t at = from;
      std::optional<clay::BrushStroke> stroke;
      try {
        stroke.emplace(base, brush);  // one that was killed a moment ago cannot begin
        if (kills && round == 1)
          killer = std::jthread([pid = external->processes().newest(), after = random() % 1000] {
            std::this_thread::sleep_for(std::chrono::microseconds(after));
            ::kill(pid, SIGKILL);
          });
        for (; at < to; ++at) stroke->apply(all[at]);
      } catch (const PluginError& error) {
        ++faults;
        wrong += std::string(error.what()).find(std::string("Bad ") + kFaults[which]) == std::string::npos;
      }
      wrong += (stroke ? stroke->finish() : base).hash() != (stroke ? should(from, at) : base.hash());
    }
  }
  EXPECT_EQ(wrong, 0) << "after " << faults << " faults";
  std::printf("%d faults\n", faults);
}

TEST(PluginBrush, ALibraryThatIsNotThereIsSaid) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "away";
  const auto made = tests::badPlugin(folder, "good");
  std::filesystem::remove(made / kPluginMachine / "bad.so");
  try {
    (void)stroked(sphere(), brushOf(tests::brushIn(made)));
    FAIL();
  } catch (const PluginError& error) {
    EXPECT_EQ(error.fault(), PluginFault::notThere);
    EXPECT_THAT(error.what(), HasSubstr("it was made for another machine, or is not built yet"));
  }
}

}  // namespace
}  // namespace argil::engine
