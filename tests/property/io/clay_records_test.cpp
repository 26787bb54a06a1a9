// Clay as records, over random strokes and random damage.

#include "io/records/clay_records.h"

#include <gtest/gtest.h>

#include <random>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "io/records/node_body.h"
#include "tests/support/record_memory.h"

namespace argil::io {
namespace {

using clay::Version;
using testing::RecordMemory;

constexpr uint32_t kSeed = 20261120;

class ClayRecordsProperty : public ::testing::Test {
 protected:
  void SetUp() override { RecordProperty("seed", std::to_string(kSeed)); }

  double within(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  size_t below(size_t count) { return std::uniform_int_distribution<size_t>(0, count - 1)(random_); }

  // A stroke of a few stamps across a ball of this radius about zero.
  Version stroke(const Version& version, double radius) {
    Vec3d at = Vec3d(within(-1, 1), within(-1, 1), within(-1, 1)).normalized() * radius;
    clay::BrushStroke brush(
        version, clay::Brush::of(std::array{clay::Method::carve, clay::Method::add, clay::Method::smooth}[below(3)]));
    const double size = within(2, radius / 3);
    for (size_t i = 0; i < 1 + below(5); ++i) {
      const Vec3d to = at + Vec3d(within(-4, 4), within(-4, 4), within(-4, 4));
      brush.apply({at, to, size, 0.7f});
      at = to;
    }
    return brush.finish();
  }

  static clay::Grid grid() {
    clay::Grid grid;
    grid.voxelMm = 1;
    return grid;
  }
  static Version ball(double radius, clay::Precision precision = clay::Precision::float32) {
    return clay::makeSphere(clay::Store::make(precision), grid(), Vec3d(0.3, 0.2, 0.1), radius);
  }

  static void expectClosed(const Version& version) {
    clay::Surface surface;
    surface.update(version);
    const clay::TriangleMesh mesh = surface.toMesh();
    if (mesh.triangles.empty()) return;
    const clay::TopologyReport report = clay::checkTopology(mesh);
    ASSERT_TRUE(report.closed()) << report.boundaryEdges << " boundary edges, " << report.nonManifoldEdges
                                 << " non-manifold";
  }
  // Canonical, as the editor would make it: what is written and read again is the same.
  static void expectCanonical(const Version& version) {
    const float band = version.grid().band;
    version.forEachBrick([&](const clay::Brick& brick) {
      bool inBand = false;
      for (clay::BrickValues scratch; const float phi : brick.values(scratch)) {
        ASSERT_LE(std::abs(phi), band);
        inBand |= std::abs(phi) < band;
      }
      ASSERT_TRUE(inBand);
    });
    RecordIds ids;
    ClayRecords clay(ids);
    RecordMemory memory;
    RecordSet held;
    const RecordId root = clay.write(version, 1, held, memory, RecordCodec::raw);
    RecordIds others;
    ClayRecords other(others);
    ASSERT_EQ(
        other.read(memory, root, grid(), clay::Store::make(version.store()->precision()), nullptr, 1).version.hash(),
        version.hash());
  }

  std::mt19937 random_{kSeed};
};

TEST_F(ClayRecordsProperty, EveryStateOfALongSessionComesBack) {
  RecordIds ids;
  ClayRecords clay(ids);
  RecordMemory memory;
  RecordSet held;
  std::vector<std::pair<RecordId, uint64_t>> states;
  Version version = ball(25);
  for (int i = 0; i < 150; ++i) {
    const Version next = stroke(version, 25);
    uint64_t changed = 0;
    Version::forEachDifference(version, next,
                               [&](Coord, clay::Slot, clay::Slot now) { changed += now.brick() != nullptr; });
    memory.puts.clear();
    states.emplace_back(clay.write(next, 1, held, memory, i % 2 == 0 ? RecordCodec::raw : RecordCodec::predicted),
                        next.hash());
    if (i > 0) {
      ASSERT_EQ(memory.puts[RecordKind::brick], changed);
      ASSERT_LE(memory.puts[RecordKind::node], 30u);
    }
    version = next;
  }
  // Whole, and each from another one.
  RecordIds others;
  ClayRecords fresh(others);
  size_t nearIndex = 0;
  Version near = fresh.read(memory, states[0].first, grid(), clay::Store::make()).version;
  for (int i = 0; i < 60; ++i) {
    const size_t k = below(states.size());
    const Version whole = ClayRecords(others).read(memory, states[k].first, grid(), clay::Store::make()).version;
    ASSERT_EQ(whole.hash(), states[k].second);
    const Version beside = fresh.readNear(memory, states[k].first, near, states[nearIndex].first).version;
    ASSERT_EQ(beside.hash(), states[k].second);
    ASSERT_EQ(beside.stats().bricks, whole.stats().bricks);
    ASSERT_EQ(beside.stats().nodes, whole.stats().nodes);
    near = beside;
    nearIndex = k;
  }
}

TEST_F(ClayRecordsProperty, LostRecordsAreMendedToAClosedSurface) {
  uint64_t lostBricks = 0, lostBlocks = 0, fromOlder = 0;
  for (int round = 0; round < 20; ++round) {
    RecordIds ids;
    ClayRecords clay(ids);
    RecordMemory whole;
    RecordSet held;
    Version version = ball(within(6, 22));
    for (size_t i = 0; i < below(4); ++i) {
      if (below(2) == 0) clay.write(version, 1, held, whole, RecordCodec::raw);  // earlier states
      version = stroke(version, 15);
    }
    const RecordId root = clay.write(version, 1, held, whole, RecordCodec::predicted);
    for (int damage = 0; damage < 20; ++damage) {
      RecordMemory memory = whole;
      const size_t losses = 1 + below(below(4) == 0 ? memory.records.size() : 8);
      for (size_t i = 0; i < losses && !memory.records.empty(); ++i) {
        const RecordId id = memory.order[below(memory.order.size())];
        if (id == root && below(4) != 0) continue;
        if (below(3) == 0 && memory.records.contains(id))
          memory.records[id][below(memory.records[id].size())] ^= std::byte{16};
        else
          memory.records.erase(id);
      }
      RecordIds others(ids.next());
      ClayRecords reader(others);
      const ReadClay read = reader.read(memory, root, grid(), clay::Store::make(), nullptr, 1, &memory, 1);
      lostBricks += read.bricksLost;
      lostBlocks += read.blocksLost;
      ASSERT_EQ(read.notes.empty(), read.bricksLost + read.blocksLost == 0);
      for (const std::string& note : read.notes) fromOlder += note.find(": 0 were taken") == std::string::npos;
      if (read.bricksLost + read.blocksLost == 0) {
        ASSERT_EQ(read.version.hash(), version.hash());
      }
      ASSERT_NO_FATAL_FAILURE(expectClosed(read.version)) << "round " << round << ", damage " << damage;
      ASSERT_NO_FATAL_FAILURE(expectCanonical(read.version)) << "round " << round << ", damage " << damage;
      // What was repaired is not taken for what the damaged records say: it is written anew and comes back.
      RecordMemory saved = memory;
      RecordSet nothing;
      for (const auto& [id, bytes] : memory.records)
        if (const auto record = parseRecord(bytes); record && record->header.id == id) nothing.add(id);
      std::erase_if(saved.records, [&](const auto& entry) { return !nothing.contains(entry.first); });
      const RecordId again = reader.write(read.version, 1, nothing, saved, RecordCodec::raw);
      RecordIds more;
      ASSERT_EQ(ClayRecords(more).read(saved, again, grid(), clay::Store::make(), nullptr, 1).version.hash(),
                read.version.hash());
    }
  }
  EXPECT_GT(lostBricks, 1000u);
  EXPECT_GT(lostBlocks, 50u);
  EXPECT_GT(fromOlder, 50u);
}

// A whole block of 64 voxels across the surface of a ball: what lies two bricks deep in it touches nothing that is
// known.
TEST_F(ClayRecordsProperty, ALostBlockIsFilledAsTheClayAroundItSays) {
  RecordIds ids;
  ClayRecords clay(ids);
  RecordMemory memory;
  RecordSet held;
  const Version version = ball(100);
  const RecordId root = clay.write(version, 1, held, memory, RecordCodec::raw);
  const Coord first{8, 0, 0};
  size_t lost = 0;
  std::erase_if(memory.records, [&](const auto& entry) {
    const auto record = parseRecord(entry.second);
    const auto node = record ? parseNode(*record) : std::nullopt;
    const bool block = node && node->level == 1 && node->first == first;
    lost += block;
    return block;
  });
  ASSERT_EQ(lost, 1u);
  RecordIds others(ids.next());
  ClayRecords reader(others);
  const ReadClay read = reader.read(memory, root, grid(), clay::Store::make(), nullptr, 1, &memory, 1);
  EXPECT_EQ(read.blocksLost, 1u);
  // Leaves that touch nothing but lost ones, of which the clay is inside about half; and how many of all are as they
  // were.
  int inside = 0, outside = 0, right = 0, wrong = 0;
  for (int i = 0; i < 512; ++i) {
    const Coord c{i >> 6, (i >> 3) & 7, i & 7};
    const clay::Slot slot = read.version.find(first + c), was = version.find(first + c);
    if (was.brick() == nullptr && slot.brick() == nullptr) ++(slot == was ? right : wrong);
    if (std::min({c.x, c.y, c.z}) == 0 || std::max({c.x, c.y, c.z}) == 7) continue;
    inside += slot == clay::Slot(clay::Tile::inside);
    outside += slot == clay::Slot(clay::Tile::outside);
  }
  EXPECT_GT(inside, 20);
  EXPECT_GT(outside, 20);
  EXPECT_GT(right, 5 * wrong);
  ASSERT_NO_FATAL_FAILURE(expectClosed(read.version));
}

TEST_F(ClayRecordsProperty, SixteenBitsComeBackToTheBit) {
  RecordIds ids;
  ClayRecords clay(ids);
  RecordMemory memory;
  RecordSet held;
  Version version = ball(15, clay::Precision::fixed16);
  for (int i = 0; i < 6; ++i) {
    const RecordId root = clay.write(version, 1, held, memory, i % 2 == 0 ? RecordCodec::raw : RecordCodec::predicted);
    RecordIds others(ids.next());
    const Version back =
        ClayRecords(others).read(memory, root, grid(), clay::Store::make(clay::Precision::fixed16), nullptr, 2).version;
    ASSERT_EQ(back.hash(), version.hash());
    ASSERT_EQ(back.stats().bytes(), version.stats().bytes());
    expectCanonical(back);
    EXPECT_THROW((void)ClayRecords(others).read(memory, root, grid(), clay::Store::make(), nullptr, 1), Error)
        << "floats cannot hold these records";
    version = stroke(version, 15);
  }
}

}  // namespace
}  // namespace argil::io
