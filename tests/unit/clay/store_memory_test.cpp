// What a model costs beside its clay: a document may have a thousand of them.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/memory_guard.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"

namespace argil::clay {
namespace {

constexpr uint64_t kMostOverhead = 100'000;  // bytes

Version ball(double radius, Precision precision = Precision::float32) {
  Grid grid;
  grid.voxelMm = 1;
  return makeSphere(Store::make(precision), grid, Vec3d::Zero(), radius);
}

void collectAll(Store& store) {
  while (store.collect()) {
  }
}

uint64_t overhead(const Version& version) {
  const Store::Usage usage = version.store()->usage();
  return usage.slabBytes - version.stats().bytes();
}

TEST(StoreMemory, ASmallModelTakesLittleBesideItsClay) {
  for (const Precision precision : {Precision::float32, Precision::fixed16}) {
    for (const double radius : {2.0, 6.0, 12.0, 20.0}) {
      const Version model = ball(radius, precision);
      // As often as a session looks.
      for (int i = 0; i < 3; ++i) collectAll(*model.store());
      EXPECT_LE(overhead(model), kMostOverhead + model.stats().bytes() / 4) << radius;
    }
  }
}

TEST(StoreMemory, AModelThatIsEditedHasStockWaitingForIt) {
  Version model = ball(60);
  collectAll(*model.store());
  const uint64_t born = model.store()->usage().slabBytes;
  BrushStroke stroke(model, Brush::of(Method::carve));
  // What is in stock is never taken from the system while the stroke goes on, once the collector has seen that there is
  // a stroke.
  uint64_t grownInStroke = 0;
  std::vector<Version> kept;  // as undo does: every dab needs memory that nobody has used yet
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.03 * i;
    const Vec3d at(60 * std::cos(angle), 60 * std::sin(angle), 0);
    const uint64_t before = model.store()->usage().slabBytes;
    stroke.apply({at, at, 6});
    kept.push_back(stroke.publish());
    if (i > 10) grownInStroke += model.store()->usage().slabBytes - before;
    collectAll(*model.store());
  }
  EXPECT_EQ(grownInStroke, 0u);
  model = stroke.finish();
  EXPECT_GT(model.store()->usage().slabBytes, born);
}

// A stamp of a large tip takes many chunks at once: what the last one took is there for the next.
TEST(StoreMemory, StockIsAsMuchAsStampsTakeUpToABound) {
  Version model = ball(150);
  collectAll(*model.store());
  const auto bytes = [&] { return model.store()->usage().slabBytes; };
  uint64_t inStroke = 0, between = 0;
  std::vector<Version> kept;
  {
    BrushStroke stroke(model, Brush::of(Method::add));
    for (int i = 0; i < 16; ++i) {
      const auto at = [](int k) { return Vec3d(150 * std::cos(0.1 * k), 150 * std::sin(0.1 * k), 0); };
      const uint64_t before = bytes();
      stroke.apply({at(i), at(i + 1), 110});
      kept.push_back(stroke.publish());
      const uint64_t after = bytes();
      collectAll(*model.store());
      if (i > 3) inStroke += after - before, between += bytes() - after;
    }
    model = stroke.finish();
  }
  EXPECT_LT(inStroke, between / 4) << "bytes from the system in stamps, and between them";
  // What took all of a large model at once calls for no second one.
  kept.clear();
  collectAll(*model.store());
  Version large = ball(320);
  collectAll(*large.store());
  Editor editor(large);
  std::array<float, kBrickVoxels> half;
  half.fill(0.5f);
  large.forEachBrick([&](const Brick& brick) { editor.setVoxels(brick.coord, half); });
  const Version all = editor.commit();
  const uint64_t before = large.store()->usage().slabBytes;
  collectAll(*large.store());
  EXPECT_GT(before, uint64_t{120} << 20);
  EXPECT_LE(large.store()->usage().slabBytes - before, uint64_t{40} << 20);
}

TEST(StoreMemory, CollectingIsAskedForWhenThereIsSomethingToFree) {
  Version model = ball(20);
  collectAll(*model.store());
  EXPECT_FALSE(model.store()->wantsCollecting());
  Editor editor(model);
  editor.setTile({0, 0, 0}, Tile::outside);
  Version other = editor.commit();
  other = {};
  EXPECT_TRUE(model.store()->wantsCollecting());
  collectAll(*model.store());
  EXPECT_FALSE(model.store()->wantsCollecting());
  EXPECT_EQ(model.store()->usage().versions, 1u);
}

// The system's files as a machine, a container and a machine that tells nothing have them.
TEST(MemoryRoom, IsTheLeastOfTheMachinesAndItsGroups) {
  namespace fs = std::filesystem;
  const fs::path root = fs::temp_directory_path() / fmt::format("argil-memory-room-{}", getpid());
  const auto put = [&](const char* file, const std::string& text) {
    fs::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text;
  };
  constexpr uint64_t kMiB = 1 << 20;
  EXPECT_FALSE(memoryRoom(root).available);
  put("proc/meminfo", "MemTotal:       8388608 kB\nMemFree:          100 kB\nMemAvailable:    2097152 kB\n");
  EXPECT_EQ(memoryRoom(root).total, 8192 * kMiB);
  EXPECT_EQ(memoryRoom(root).available, 2048 * kMiB);
  put("proc/self/cgroup", "0::/user.slice/app.scope\n");
  put("sys/fs/cgroup/user.slice/app.scope/memory.max", "max\n");
  put("sys/fs/cgroup/user.slice/app.scope/memory.current", "1073741824\n");
  EXPECT_EQ(memoryRoom(root).available, 2048 * kMiB) << "a group without a limit";
  put("sys/fs/cgroup/user.slice/memory.max", "2147483648\n");
  put("sys/fs/cgroup/user.slice/memory.current", "1610612736\n");
  EXPECT_EQ(memoryRoom(root).available, 512 * kMiB) << "the limit of the group above";
  put("sys/fs/cgroup/user.slice/memory.stat", "anon 1\ninactive_file 268435456\n");
  EXPECT_EQ(memoryRoom(root).available, 768 * kMiB) << "files can be read again";
  put("sys/fs/cgroup/user.slice/memory.current", "4294967296\n");
  EXPECT_EQ(memoryRoom(root).available, 0u);
  put("proc/meminfo", "MemTotal: many\nMemAvailable:    99999999999999999999999 kB\n");
  EXPECT_FALSE(memoryRoom(root).total);
  fs::remove_all(root);
}

TEST(MemoryGuard, RefusesBeforeTheReserveIsTouched) {
  constexpr uint64_t kMiB = 1 << 20;
  uint64_t available = 4096 * kMiB;
  int looks = 0;
  MemoryGuard guard([&] {
    ++looks;
    return MemoryRoom{16384 * kMiB, available};
  });
  // Its reserve is 512 MiB of 16 GiB.
  uint64_t taken = 0;
  const auto claim = [&](uint64_t bytes) {
    guard.claim(bytes);
    taken += bytes;
    available -= std::min(available, bytes);
  };
  EXPECT_THROW(
      {
        for (int i = 0; i < 4096; ++i) claim(2 * kMiB);
      },
      std::bad_alloc);
  EXPECT_GE(taken, (4096 - 512 - 64) * kMiB);
  EXPECT_LE(taken, (4096 - 512) * kMiB);
  EXPECT_LE(looks, 64 + 2) << "a look each 64 MiB";
  EXPECT_THROW(claim(2 * kMiB), std::bad_alloc) << "and again";
  available = 2048 * kMiB;
  claim(1500 * kMiB);
  EXPECT_THROW(claim(100 * kMiB), std::bad_alloc);
}

MemoryRoom noRoom() {
  return {uint64_t{8} << 30, MemoryGuard::kLeastReserve};
}

// What has no room is refused while it is made; what there was stays, and has room again later.
TEST(MemoryGuard, ClayAndSurfacesAreRefusedWhereTheSystemWouldHaveNoneLeft) {
  const Version before = ball(250), other = ball(30);
  const uint64_t hash = before.hash();
  Surface surface;
  {
    const PretendedMemory none(noRoom);
    EXPECT_THROW(surface.update(before), std::bad_alloc);
    EXPECT_THROW((void)offset(before, 5), std::bad_alloc);
    EXPECT_EQ(before.hash(), hash);
  }
  surface.update(before);
  EXPECT_GT(surface.quadCount(), 0u);
  const PretendedMemory little([] { return MemoryRoom{uint64_t{8} << 30, uint64_t{1} << 30}; });
  Grid fine = before.grid();
  fine.voxelMm = 0.1;
  try {
    (void)resample(before, fine, Eigen::Isometry3d::Identity());
    ADD_FAILURE() << "not refused";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("at a voxel size of 0.1 mm would take about"), std::string::npos) << e.what();
  }
}

// Before the work, in numbers: about what it takes with its surface, and more where faces lie along the axes.
TEST(MemoryGuard, SimpleShapesSayWhatTheyWouldTake) {
  Grid grid;
  grid.voxelMm = 1;
  const std::vector<std::function<Version(std::shared_ptr<Store>)>> shapes = {
      [&](auto store) {
        return makeSphere(store, grid, {3, 4, 5}, 300);
      },
      [&](auto store) {
        return makeBlock(store, grid, {3, 4, 5}, {350, 150, 90}, 0);
      },
      [&](auto store) {
        return makeCone(store, grid, {3, 4, 5}, 150, 10, 200);
      },
      [&](auto store) {
        return makeTorus(store, grid, {3, 4, 5}, 150, 60);
      }};
  for (const Precision precision : {Precision::float32, Precision::fixed16})
    for (const auto& shape : shapes) {
      const Version made = shape(Store::make(precision));
      Surface surface(false);
      surface.update(made, 2);
      const double took = double(made.stats().bytes()) + 32.0 * double(surface.quadCount());
      const PretendedMemory none(noRoom);
      try {
        (void)shape(Store::make(precision));
        ADD_FAILURE() << "not refused";
      } catch (const Error& e) {
        const std::string sentence = e.what(), words = "would take about ";
        ASSERT_NE(sentence.find(words), std::string::npos) << sentence;
        const double said = std::stod(sentence.substr(sentence.find(words) + words.size())) * 1e9;
        EXPECT_GT(said, 0.85 * took) << sentence;
        EXPECT_LT(said, 1.5 * took) << sentence;
      }
    }
}

}  // namespace
}  // namespace argil::clay
