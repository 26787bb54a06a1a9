// A document of a thousand pieces costs what its pieces cost, and a long day ends as it began.

#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "engine/document/random.h"
#include "engine/saving/undo_budget.h"
#include "engine/session/edit_loop.h"
#include "engine/session/surfaces.h"

namespace argil::engine {
namespace {

constexpr uint64_t kSeed = 20261121;
constexpr double kBallMm = 12;

clay::Version ball(double radiusMm = kBallMm) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radiusMm);
}

Document row(size_t count) {
  Document document;
  for (size_t i = 0; i < count; ++i) {
    Piece piece;
    piece.version = ball();
    piece.pose.translation = {3 * kBallMm * double(i), 0, 0};
    piece.id = document.nextId++;
    piece.name = "Clay " + std::to_string(piece.id);
    document.pieces.push_back(std::move(piece));
  }
  document.active = 1;
  return document;
}

double cpuMs() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

uint64_t residentBytes() {
  uint64_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident * 4096;
}

// A session with all that hangs on it in a window, in virtual time.
struct Desk {
  explicit Desk(Document document) : session(std::move(document)) {
    EditLoop::Options options;
    options.onDocument = [this](const DocumentPtr& now, int64_t ns) { surfaces.follow(*now, ns); };
    loop = std::make_unique<EditLoop>(
        session, haptics::Scene(), [this](std::unique_ptr<const haptics::Scene> next) { scene = std::move(next); },
        options);
    Tool tool{"carve", 2.5};
    loop->setTool(tool);
    turn();
  }
  void turn() {
    loop->turn(ring);
    while (surfaces.behind()) {
      if (surfaces.arrived()) surfaces.follow(*session.document(), 0);
      std::this_thread::yield();
    }
  }
  // A circle on the ball; every two milliseconds a turn. Returns the time of each turn, ms of this thread.
  std::vector<double> stroke(const Vec3d& axis, size_t samples = 300) {
    std::vector<double> turns;
    const Vec3d u = axis.unitOrthogonal(), v = axis.cross(u);
    for (size_t i = 0; i < samples + 2; ++i) {
      haptics::StylusSample sample;
      sample.index = index++;
      sample.timeS = 0.001 * double(sample.index);
      sample.buttons = i < samples ? 1 : 0;
      sample.flags = i < samples ? uint32_t{haptics::kCutting} : 0u;
      const double angle = 0.01 * double(i);
      sample.cutPoint = sample.proxy = kBallMm * (std::cos(angle) * u + std::sin(angle) * v);
      sample.tool = 1;
      ring.push(sample);
      if (i % 2 == 0) continue;
      const double begin = cpuMs();
      loop->turn(ring);
      turns.push_back(cpuMs() - begin);
    }
    (void)surfaces.take();
    return turns;
  }
  Surfaces surfaces;
  Session session;
  haptics::SampleRing ring{1000};
  std::unique_ptr<const haptics::Scene> scene;
  std::unique_ptr<EditLoop> loop;
  uint64_t index = 0;
};

double sum(const std::vector<double>& all) {
  double total = 0;
  for (const double one : all) total += one;
  return total;
}

// The desks take turns: what other programs do to the caches meanwhile, they do to all of them.
TEST(ManyPieces, AStrokeAndItsUndoCostWhatTheyCostInADocumentOfOnePiece) {
  struct Cost {
    double stroke = 1e9, undo = 1e9, alone = 1e9;
  };
  struct Table {
    explicit Table(size_t pieces) : desk(row(pieces)) { (void)desk.surfaces.take(); }
    Desk desk;
    Cost cost;
  };
  constexpr std::array<size_t, 3> kCounts{1, 64, 1000};
  std::vector<std::unique_ptr<Table>> tables;
  for (const size_t count : kCounts) {
    const uint64_t before = residentBytes();
    const Desk& desk = tables.emplace_back(std::make_unique<Table>(count))->desk;
    const uint64_t all = residentBytes() - before;
    uint64_t clay = 0, slabs = 0;
    for (const Piece& piece : desk.session.document()->pieces) {
      clay += piece.version.stats().bytes();
      slabs += piece.version.store()->usage().slabBytes;
    }
    std::printf("%4zu pieces: a piece has %.0f kB of clay, %.0f kB of slabs, %.0f kB in all\n", count,
                1e-3 * double(clay) / double(count), 1e-3 * double(slabs) / double(count),
                1e-3 * double(all) / double(count));
    EXPECT_LE((slabs - clay) / count, 100'000u);
  }
  // The goal is 1.5; the bound leaves room for caches that other programs use too. What looked at every piece for every
  // piece was far above it.
  constexpr double kMostTimes = 2;
  const auto dear = [&] {
    return std::any_of(tables.begin(), tables.end(),
                       [&](const auto& table) { return table->cost.stroke > kMostTimes * tables[0]->cost.stroke; });
  };
  // More rounds where it seems dear: what costs by itself costs in each of them.
  constexpr int kRounds = 5, kMostRounds = 40;
  for (int round = 0; round < kRounds || (round < kMostRounds && dear()); ++round) {
    for (const auto& table : tables) {
      Desk& desk = table->desk;
      Cost& cost = table->cost;
      cost.stroke = std::min(cost.stroke, sum(desk.stroke(Vec3d(0, 0, 1))));
      ASSERT_EQ(desk.session.undoSteps(), 1u);
      const auto& states = desk.session.states();
      double begin = cpuMs();
      EXPECT_GT(bytesAlone(*states[1].document, *states[0].document), 0u);
      cost.alone = std::min(cost.alone, cpuMs() - begin);
      begin = cpuMs();
      desk.session.undo();
      desk.loop->turn(desk.ring);
      cost.undo = std::min(cost.undo, cpuMs() - begin);
      EXPECT_EQ(desk.session.counts().clay.bricksMade, tables[0]->desk.session.counts().clay.bricksMade);
      EXPECT_EQ(desk.session.counts().stamps, tables[0]->desk.session.counts().stamps);
    }
  }
  for (size_t i = 0; i < tables.size(); ++i) {
    const Cost& cost = tables[i]->cost;
    std::printf("%4zu pieces: stroke %.1f ms, undo %.2f ms, bytes of a step %.3f ms\n", kCounts[i], cost.stroke,
                cost.undo, cost.alone);
    EXPECT_EQ(tables[i]->desk.scene->pieces.size(), std::min(kCounts[i], haptics::kMaxPieces));
    EXPECT_LE(cost.stroke, kMostTimes * tables[0]->cost.stroke);
  }
  EXPECT_LE(tables[2]->cost.undo, tables[0]->cost.undo + 5);
  EXPECT_LE(tables[2]->cost.alone, tables[0]->cost.alone + 1);
}

// Work in small: strokes, undo and redo, a whole operation now and then, old steps on the disk. The last quarter takes
// no more than the first.
TEST(LongDay, MemoryAndCostDoNotGrowWithTheHours) {
  RecordProperty("seed", std::to_string(kSeed));
  constexpr size_t kQuarters = 4, kStrokes = 250, kStepsInMemory = 20;
  Desk desk(row(3));
  Random random(kSeed);
  struct Quarter {
    uint64_t clay = 0, slabs = 0, resident = 0, bricks = 0;
    double p99 = 0;
  };
  std::vector<Quarter> quarters;
  for (size_t q = 0; q < kQuarters; ++q) {
    Quarter quarter;
    std::vector<double> turns;
    const uint64_t bricks = desk.session.counts().clay.bricksMade;
    for (size_t i = 0; i < kStrokes; ++i) {
      const Id worked = Id(1 + random.below(3));
      desk.session.change("Work on", [&](Document& document) { document.active = worked; });
      const auto one = desk.stroke(random.inBall().normalized(), 60);
      turns.insert(turns.end(), one.begin(), one.end());
      if (i % 5 == 0) {
        desk.session.undo();
        desk.turn();
        if (i % 10 == 0) desk.session.redo();
      }
      // A piece that is worn is made anew, by an operation on the whole of it.
      if (i % 10 == 9) {
        desk.session.change("Join", [&](Document& document) {
          Piece& piece = *document.piece(worked);
          piece.version = clay::combine(piece.version, ball(), clay::Combination::join);
        });
      }
      desk.turn();
      for (size_t state = 0; state + kStepsInMemory < desk.session.undoSteps(); ++state) {
        if (desk.session.states()[state].document) desk.session.spill(state, 1);
      }
      // Not left to the thread that frees: how far it trails on a busy machine is no growth.
      for (const Piece& piece : desk.session.document()->pieces)
        while (piece.version.store()->collect()) {
        }
      if (i % 25 != 0) continue;
      uint64_t clay = 0, slabs = 0;
      for (const Piece& piece : desk.session.document()->pieces) {
        const clay::Store::Usage usage = piece.version.store()->usage();
        clay += usage.bytes();
        slabs += usage.slabBytes;
      }
      quarter.clay = std::max(quarter.clay, clay);
      quarter.slabs = std::max(quarter.slabs, slabs);
    }
    std::sort(turns.begin(), turns.end());
    quarter.p99 = turns[turns.size() * 99 / 100];
    quarter.resident = residentBytes();
    quarter.bricks = desk.session.counts().clay.bricksMade - bricks;
    std::printf("quarter %zu: clay %.1f MB, slabs %.1f MB, resident %.1f MB, %llu bricks made, p99 of a turn %.2f ms\n",
                q + 1, 1e-6 * double(quarter.clay), 1e-6 * double(quarter.slabs), 1e-6 * double(quarter.resident),
                static_cast<unsigned long long>(quarter.bricks), quarter.p99);
    quarters.push_back(quarter);
  }
  const Quarter &first = quarters.front(), &last = quarters.back();
  EXPECT_LE(double(last.clay), 1.2 * double(first.clay));
  // Slabs come by 2 MiB: one more or less of each piece is how far the thread that frees trailed within a stroke.
  EXPECT_LE(double(last.slabs), 1.2 * double(first.slabs) + 3 * double(2 << 20));
  EXPECT_LE(double(last.resident), 1.2 * double(first.resident) + 1e6);
  EXPECT_LE(double(last.bricks), 1.2 * double(first.bricks));
}

}  // namespace
}  // namespace argil::engine
