// .vdb files: what OpenVDB itself reads in them, and what becomes of the files of others.
#include "io/models/vdb_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/openvdb_grids.h"
#include "clay/store/vdb_bridge.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

std::filesystem::path dataFile(const char* name) {
  const char* root = std::getenv("ARGIL_DATA");
  return root == nullptr ? std::filesystem::path() : std::filesystem::path(root) / "vdb" / name;
}

class VdbFile : public testing::Test {
 protected:
  VdbFile() { clay::initializeVdb(); }
  void write(const openvdb::GridPtrVec& grids) { openvdb::io::File(path_.string()).write(grids); }
  std::vector<VdbObject> readBack(const openvdb::GridBase::Ptr& grid, double unitMm = 1) {
    write({grid});
    return readVdb(path_, unitMm);
  }
  std::string refusal(const openvdb::GridBase::Ptr& grid) {
    write({grid});
    return samples::errorOf([&] { static_cast<void>(readVdb(path_)); });
  }
  static openvdb::FloatGrid::Ptr ball(float radius = 10, float voxel = 0.5f, float band = 3) {
    auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(radius, openvdb::Vec3f(1, 2, 3), voxel, band);
    grid->setName("ball");
    return grid;
  }
  /// Signed distance in mm at a place of the world, from the nearest voxel.
  static double distanceAt(const clay::Version& version, const Vec3d& world) {
    const Vec3d v = version.grid().toVoxel(world);
    const Coord voxel = {int(std::lround(v.x())), int(std::lround(v.y())), int(std::lround(v.z()))};
    return double(version.find(voxel >> 3)
                      .phi(clay::Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7), version.grid().band)) *
           version.grid().voxelMm;
  }
  /// Whether it is a ball about (1, 2, 3) · unit of that radius, everywhere on a line through it.
  static void expectBall(const clay::Version& version, double radius, double unit = 1, double voxels = 0.1) {
    const clay::Grid& grid = version.grid();
    for (double t = -1.5; t <= 1.5; t += 0.05) {
      const Vec3d at =
          grid.toWorld(grid.toVoxel(unit * Vec3d(1, 2, 3) + t * radius * Vec3d(0.36, 0.48, 0.8)).array().round());
      const double exact = (at - unit * Vec3d(1, 2, 3)).norm() - radius, most = double(grid.band) * grid.voxelMm;
      EXPECT_NEAR(distanceAt(version, at), std::clamp(exact, -most, most), voxels * grid.voxelMm);
    }
  }

  samples::Folder folder_;
  std::filesystem::path path_ = folder_ / "a.vdb";
};

/// Seconds and MiB that reading takes, and what it says.
struct Cost {
  std::string said;
  double seconds;
  double mebibytes;
};
// In a process of its own: what its readers take is not mixed with what those of other tests took.
Cost costOf(const std::filesystem::path& file) {
  int way[2];
  if (::pipe(way) != 0) throw std::runtime_error("no pipe");
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    std::string said;
    try {
      static_cast<void>(readVdb(file));
    } catch (const Error& error) {
      said = error.what();
    }
    rusage used{};
    ::getrusage(RUSAGE_CHILDREN, &used);
    const std::string all = std::to_string(used.ru_maxrss) + " " + said;
    const bool whole = ::write(way[1], all.data(), all.size()) == ssize_t(all.size());
    ::_exit(whole ? 0 : 1);
  }
  ::close(way[1]);
  std::string all;
  char part[512];
  for (ssize_t n = 0; (n = ::read(way[0], part, sizeof part)) > 0;) all.append(part, size_t(n));
  ::close(way[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  Cost cost;
  cost.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  const size_t space = all.find(' ');
  cost.mebibytes = std::strtod(all.c_str(), nullptr) / 1024;
  cost.said = space == std::string::npos ? std::string() : all.substr(space + 1);
  return cost;
}

// Every word of the head of a file becomes a number that no file holds: lengths of names, counts of grids and nodes,
// sizes of packed pieces. Nothing is taken for it.
TEST_F(VdbFile, ADamagedFileIsRefusedBeforeMemoryIsTaken) {
  write({ball(95, 1)});
  const std::string whole = samples::slurp(path_);
  ASSERT_GT(whole.size(), size_t{2} << 20);
  // A reader has 40 MiB of libraries; a tree of this file takes a few times its size.
  const double most = 60 + 10 * double(whole.size()) / double(1 << 20);
  size_t refused = 0;
  for (const uint32_t word : {0x7fffffffu, 0x40000000u, 0x00ffffffu}) {
    for (size_t at = 20; at < 1200; at += 37) {
      std::string damaged = whole;
      std::memcpy(&damaged[at], &word, sizeof word);
      samples::spill(path_, damaged);
      const Cost cost = costOf(path_);
      refused += !cost.said.empty();
      EXPECT_LT(cost.mebibytes, most) << "byte " << at << ": " << cost.said;
      EXPECT_LT(cost.seconds, 5) << "byte " << at << ": " << cost.said;
      if (cost.mebibytes >= most) return;  // which all others would repeat
    }
  }
  EXPECT_GT(refused, 30u);
  for (const size_t part : {2u, 3u, 10u, 100u}) {
    samples::spill(path_, whole.substr(0, whole.size() / part));
    EXPECT_THAT(costOf(path_).said, testing::AnyOf(HasSubstr("its data ends too early"), HasSubstr("is damaged")));
  }
}

TEST_F(VdbFile, ATransformThatMakesAMillionOfOneVoxelIsRefused) {
  for (const openvdb::Vec3d& edges :
       {openvdb::Vec3d(1, 1, 1e-4), openvdb::Vec3d(1, 1e-3, 1), openvdb::Vec3d(1e5, 1e5, 1)}) {
    const auto grid = ball();
    auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    transform->preScale(edges);
    grid->setTransform(transform);
    write({grid});
    const Cost cost = costOf(path_);
    EXPECT_THAT(cost.said, HasSubstr("million voxels in grid ball"));
    EXPECT_LT(cost.seconds, 5);
  }
  // What is scaled by axis within reason is made anew as before.
  const auto grid = ball();
  auto transform = openvdb::math::Transform::createLinearTransform(0.5);
  transform->preScale(openvdb::Vec3d(1, 1, 2));
  grid->setTransform(transform);
  write({grid});
  EXPECT_THAT(readVdb(path_).at(0).notes, Contains(HasSubstr("is skewed, mirrored or scaled by axis")));
}

TEST_F(VdbFile, OpenVdbReadsWhatWeWrite) {
  clay::Grid grid;
  grid.voxelMm = 0.3;
  grid.originMm = {5, -6, 7.25};
  const auto unit = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(30, openvdb::Vec3f(1, 2, 3), 1, 3);
  const clay::Version version = clay::fromVdb(clay::Store::make(), grid, {unit});
  const WriteReport report = writeVdb(path_, {{"first", version}, {"second", version}});
  EXPECT_EQ(report.bytes, std::filesystem::file_size(path_));
  EXPECT_EQ(folder_.entries(), 1u);

  openvdb::io::File file(path_.string());
  file.open(false);
  const auto grids = file.getGrids();
  ASSERT_EQ(grids->size(), 2u);
  const auto first = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("first"));
  EXPECT_EQ(first->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(first->getCreator(), "Argil");
  EXPECT_EQ(first->background(), float(double(grid.band) * 0.3));
  EXPECT_EQ(first->indexToWorld(openvdb::Vec3d(10, 20, 30)),
            openvdb::Vec3d(5 + 0.3 * 10, -6 + 0.3 * 20, 7.25 + 0.3 * 30));
  uint64_t bricks = 0;
  version.forEachBrick([&](const clay::Brick& brick) {
    ++bricks;
    const auto* leaf = first->tree().probeConstLeaf({brick.coord.x * 8, brick.coord.y * 8, brick.coord.z * 8});
    ASSERT_NE(leaf, nullptr);
    for (unsigned i = 0; i < 512; ++i) {
      ASSERT_EQ(leaf->getValue(i), float(double(brick.phi(i)) * 0.3));
      ASSERT_EQ(leaf->isValueOn(i), std::abs(brick.phi(i)) < grid.band);
    }
  });
  EXPECT_EQ(first->tree().leafCount(), bricks);
  EXPECT_LT(first->tree().getValue({1, 2, 3}), 0);  // solid, not a shell

  const auto objects = readVdb(path_);
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[1].name, "second");
  EXPECT_THAT(objects[0].notes, IsEmpty());
  const clay::Version& again = objects[0].version;
  EXPECT_EQ(again.grid(), grid);
  EXPECT_EQ(again.stats().bricks, version.stats().bricks);
  EXPECT_EQ(again.activeVoxels(), version.activeVoxels());
  EXPECT_EQ(again.stats().nodes, version.stats().nodes);
  version.forEachBrick([&](const clay::Brick& brick) {
    const clay::Slot there = again.find(brick.coord);
    ASSERT_FALSE(there.isTile());
    for (int i = 0; i < 512; ++i) ASSERT_NEAR(there.brick()->phi(i), brick.phi(i), 4e-7);
  });
}

// A second grid may be hollow where the first is full.
TEST_F(VdbFile, GridsOfAFileStandAlone) {
  write({ball(30, 0.5f), ball(4, 0.5f)});
  const std::vector<VdbObject> all = readVdb(path_, 1);
  ASSERT_EQ(all.size(), 2u);
  expectBall(all[0].version, 30);
  expectBall(all[1].version, 4);
  const auto small = readBack(ball(4, 0.5f));
  EXPECT_EQ(all[1].version.hash(), small.at(0).version.hash());
}

TEST_F(VdbFile, UnitsAndKindsOfNumbers) {
  auto plain = readBack(ball());
  expectBall(plain[0].version, 10);
  EXPECT_EQ(plain[0].version.grid().voxelMm, 0.5);
  EXPECT_THAT(plain[0].notes, IsEmpty());
  expectBall(readBack(ball(), 25.4)[0].version, 254, 25.4);
  auto half = ball();
  half->setSaveFloatAsHalf(true);
  expectBall(readBack(half)[0].version, 10);
  auto twice = std::make_shared<openvdb::DoubleGrid>(*ball());
  twice->setGridClass(openvdb::GRID_LEVEL_SET);
  expectBall(readBack(twice)[0].version, 10);
}

TEST_F(VdbFile, OtherLevelSetsAreMadeAnew) {
  const auto narrow = readBack(ball(10, 0.5f, 2));
  expectBall(narrow[0].version, 10, 1, 0.2);
  EXPECT_THAT(narrow[0].notes, Contains(HasSubstr("fewer than 3 voxels")));

  auto steep = ball();
  for (auto value = steep->beginValueOn(); value; ++value) value.setValue(*value * 0.2f);
  const auto anew = readBack(steep);
  expectBall(anew[0].version, 10, 1, 0.2);
  EXPECT_THAT(anew[0].notes, Contains(HasSubstr("holds no distances")));

  auto skewed = ball();
  openvdb::Mat4R matrix = openvdb::Mat4R::identity();
  matrix.preScale(openvdb::Vec3d(0.5, 0.5, 0.6));
  matrix.postRotate(openvdb::math::Z_AXIS, 0.7);
  skewed->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  const auto straight = readBack(skewed);
  EXPECT_THAT(straight[0].notes, Contains(HasSubstr("skewed, mirrored or scaled by axis")));
  const openvdb::Vec3d middle = skewed->indexToWorld(openvdb::Vec3d(2, 4, 6));
  EXPECT_NEAR(distanceAt(straight[0].version, {middle.x() + 10, middle.y(), middle.z()}), 0, 0.3);
  EXPECT_LT(distanceAt(straight[0].version, {middle.x(), middle.y(), middle.z()}), -1);
}

// A mirror keeps edges and angles, but no rotation does it.
TEST_F(VdbFile, TurnedOnesStayAsTheyAre) {
  const auto asItIs = readBack(ball())[0].version;
  auto turned = ball();
  openvdb::Mat4R matrix = openvdb::Mat4R::identity();
  matrix.preScale(openvdb::Vec3d(0.5, 0.5, 0.5));
  matrix.postRotate(openvdb::math::Z_AXIS, 0.7);
  matrix.postRotate(openvdb::math::X_AXIS, -2.9);
  matrix.postTranslate(openvdb::Vec3d(7, 8, 9));
  turned->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  const auto kept = readBack(turned, 10);
  EXPECT_THAT(kept[0].notes, IsEmpty());
  EXPECT_EQ(kept[0].version.activeVoxels(), asItIs.activeVoxels());
  const openvdb::Vec3d middle = 10 * turned->indexToWorld(openvdb::Vec3d(2, 4, 6));
  const Vec3d inClay = kept[0].rotation.conjugate() * Vec3d(middle.x(), middle.y(), middle.z());
  for (const Vec3d& way : {Vec3d(1, 0, 0), Vec3d(0, 0.6, 0.8), Vec3d(-0.8, 0.6, 0)})
    EXPECT_NEAR(distanceAt(kept[0].version, inClay + 100 * way), 0, 5);
  matrix.preScale(openvdb::Vec3d(1, 1, -1));
  turned->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  EXPECT_THAT(readBack(turned)[0].notes, Contains(HasSubstr("mirrored")));
}

// Cd as Houdini has it, of another voxel size, for all level sets of the file; NAME.Cd goes before it; a velocity is
// none.
TEST_F(VdbFile, ColoursOfOthers) {
  auto of = [](const char* name, double voxel, openvdb::Vec3f colour) {
    auto grid = openvdb::Vec3SGrid::create();
    grid->setName(name);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    grid->denseFill({openvdb::Coord(int(-12 / voxel)), openvdb::Coord(int(16 / voxel))}, colour);
    return grid;
  };
  const auto cd = of("Cd", 0.8, {1, 0, 0.2140411f}), own = of("second.Cd", 0.5, {0, 1, 0}), v = of("v", 0.5, {1, 1, 1});
  auto second = ball(4, 0.5f);
  second->setName("second");
  const auto lost = of("third.Cd", 0.5, {0, 1, 0});
  write({v, own, ball(), second, cd, lost});
  const std::vector<VdbObject> all = readVdb(path_);
  ASSERT_EQ(all.size(), 2u);
  for (const VdbObject& each : all) {
    const std::array<int, 3> wish = each.name == "second" ? std::array{0, 255, 0} : std::array{255, 0, 127};
    uint64_t voxels = 0;
    each.version.forEachBrick([&](const clay::Brick& brick) {
      for (int i = 0; i < 512; ++i) {
        const bool in = std::abs(brick.phi(i)) < each.version.grid().band;
        voxels += in;
        const auto byte = [&](clay::Channel channel) { return int(each.version.find(channel, brick.coord).value(i)); };
        ASSERT_EQ(byte(clay::Channel::cover), in ? 255 : 0);
        ASSERT_EQ(byte(clay::Channel::red), in ? wish[0] : 0);
        ASSERT_EQ(byte(clay::Channel::green), in ? wish[1] : 0);
        ASSERT_EQ(byte(clay::Channel::blue), in ? wish[2] : 0);
      }
    });
    EXPECT_GT(voxels, 1000u);
  }
  std::vector<std::string> notes = all[0].notes;
  notes.insert(notes.end(), all[1].notes.begin(), all[1].notes.end());
  EXPECT_THAT(notes,
              testing::UnorderedElementsAre(HasSubstr("grid v is"), HasSubstr("grid third.Cd has colours of no")));
}

TEST_F(VdbFile, FarAwayComesNear) {
  const auto near = ball();
  auto far = openvdb::FloatGrid::create(near->background());
  const openvdb::Coord shift(8 * 100000, 0, -8 * 50000);
  for (auto leaf = near->tree().cbeginLeaf(); leaf; ++leaf) {
    auto* to = far->tree().touchLeaf(leaf->origin() + shift);
    for (unsigned i = 0; i < 512; ++i) to->setValueOn(i, leaf->getValue(i));
  }
  far->setGridClass(openvdb::GRID_LEVEL_SET);
  auto transform = openvdb::math::Transform::createLinearTransform(0.5);
  transform->postTranslate(-0.5 * shift.asVec3d());
  far->setTransform(transform);
  expectBall(readBack(far)[0].version, 10);
}

TEST_F(VdbFile, Refusals) {
  auto fog = ball();
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  EXPECT_THAT(refusal(fog), HasSubstr("grid ball is a fog volume"));
  EXPECT_THAT(refusal(openvdb::Vec3SGrid::create()), HasSubstr("holds no level set"));
  auto bad = ball();
  bad->tree().setValue({20, 4, 6}, NAN);
  EXPECT_THAT(refusal(bad), HasSubstr("not finite"));
  auto open = ball();
  for (int x = -20; x < 40; ++x) open->tree().addTile(1, {x * 8, 0, 0}, open->background(), false);
  EXPECT_THAT(refusal(open), HasSubstr("changes from inside to outside"));
  // A well that is open at its top: each brick goes with the tiles beside it, the tiles above do not with each other.
  auto well = openvdb::FloatGrid::create(3);
  well->setGridClass(openvdb::GRID_LEVEL_SET);
  for (int x = 32; x < 56; ++x)
    for (int y = 32; y < 56; ++y)
      for (int z = 32; z < 40; ++z) {
        const bool inside = std::min(x, y) >= 40 && std::max(x, y) < 48 && z > 32;
        well->tree().setValueOn({x, y, z}, inside ? -2.5f : 2.5f);
      }
  EXPECT_THAT(refusal(well), HasSubstr("changes from inside to outside"));
  auto empty = openvdb::FloatGrid::create(3);
  empty->setGridClass(openvdb::GRID_LEVEL_SET);
  EXPECT_THAT(refusal(empty), HasSubstr("no surface"));
  write({ball(), fog});
  const auto objects = readVdb(path_);
  EXPECT_EQ(objects.size(), 1u);
  EXPECT_THAT(objects[0].notes, Contains(HasSubstr("is a fog volume, which is not kept")));
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readVdb(path_, 1e-9)); }),
              HasSubstr("a.vdb: grid \"ball\" cannot be clay"));
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readVdb(folder_ / "none.vdb")); }), HasSubstr("none.vdb"));
}

TEST_F(VdbFile, FullFolderOrCancelLeaveTheOldFile) {
  samples::spill(path_, "old");
  const auto unit = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(30, openvdb::Vec3f(0, 0, 0), 1, 3);
  const clay::Version version = clay::fromVdb(clay::Store::make(), {}, {unit});
  Job job;
  job.cancel();
  EXPECT_THROW(writeVdb(path_, {{"a", version}}, &job), Cancelled);
  EXPECT_EQ(samples::slurp(path_), "old");
  EXPECT_EQ(folder_.entries(), 1u);
  EXPECT_THAT(samples::errorOf([&] { writeVdb("/dev/full", {{"a", version}}); }), HasSubstr("/dev/full"));
}

TEST_F(VdbFile, FilesOfOthers) {
  if (dataFile("").empty()) GTEST_SKIP() << "ARGIL_DATA is not set";
  const auto sphere = readVdb(dataFile("sphere.vdb"));
  ASSERT_EQ(sphere.size(), 1u);
  EXPECT_GT(sphere[0].version.activeVoxels(), 10000u);
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readVdb(dataFile("smoke.vdb"))); }), HasSubstr("fog volume"));
}

}  // namespace
}  // namespace argil::io
