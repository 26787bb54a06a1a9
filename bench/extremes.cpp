// Where the arithmetic stops holding: digits that stay when every operation rounds another way, relations that need no
// oracle, and limits; docs/extremes.csv keeps what it says.

#include <fmt/format.h>
#include <xmmintrin.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <functional>
#include <utility>

#include "bench/bench.h"
#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/mirror.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"

namespace argil::bench {

namespace {

using clay::Grid;
using clay::Version;
using engine::Session;

constexpr double kVoxel = 0.25;                      // mm; a power of two, so that scaling by another is exact
constexpr double kBall = 24, kTip = 5, kStep = 0.8;  // voxels
constexpr int kPoints = 40;
constexpr double kBand = 3, kLeastShare = 1e-9;
constexpr int kSpots = 300, kUndos = 100'000;

// All in voxels of a grid whose voxel is `voxelMm` and whose origin lies at `originMm`, moved by `byVoxels`.
struct Place {
  double voxelMm = kVoxel;
  Vec3d originMm = Vec3d::Zero();
  Vec3d byVoxels = Vec3d::Zero();
  clay::Precision precision = clay::Precision::float32;
  bool publishes = false;  // after each point
  [[nodiscard]] Vec3d mm(const Vec3d& voxels) const { return originMm + (voxels + byVoxels) * voxelMm; }
};

Version ball(const Place& place, const Vec3d& at = Vec3d::Zero(), double radius = kBall) {
  Grid grid;
  grid.voxelMm = place.voxelMm;
  grid.originMm = place.originMm;
  return clay::makeSphere(clay::Store::make(place.precision), grid, place.mm(at), radius * place.voxelMm);
}

// A tool drawn around a part of the ball, a little into it.
Version stroke(const engine::ToolRow& row, const Place& place) {
  Session session(ball(place));
  engine::Tool tool = engine::standardTool(row);
  tool.radiusMm = kTip * place.voxelMm;
  tool.heightMm = tool.blendMm = place.voxelMm;
  session.beginStroke(tool);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = i * kStep / kBall;
    session.addPoint(0.002 * i, place.mm((kBall - 0.5) * Vec3d(std::cos(angle), std::sin(angle), 0.3 * angle)));
    if (place.publishes) session.publish();
  }
  return session.endStroke();
}

struct Apart {
  double most = 0, squares = 0;
  uint64_t voxels = 0;
  bool finite = true;
  [[nodiscard]] double rms() const { return voxels > 0 ? std::sqrt(squares / double(voxels)) : 0; }
};

// How far two fields lie apart where one of them is in the band, the second moved back by `bricks`.
Apart apart(const Version& a, const Version& b, Coord bricks = {}) {
  Apart all;
  const float band = a.grid().band;
  const auto look = [&](Coord coord, bool both) {
    const clay::Slot one = a.find(coord), other = b.find(coord + bricks);
    if (!both && !one.isTile()) return;  // Seen from the other side.
    for (int v = 0; v < clay::kBrickVoxels; ++v) {
      const float p = one.phi(v, band), q = other.phi(v, band);
      all.finite = all.finite && std::isfinite(p) && std::isfinite(q);
      if (std::abs(p) >= band && std::abs(q) >= band && (p < 0) == (q < 0)) continue;
      const double off = std::abs(double(p) - double(q));
      all.most = std::max(all.most, off);
      all.squares += off * off;
      ++all.voxels;
    }
  };
  a.forEachBrick([&](const clay::Brick& brick) { look(brick.coord, true); });
  b.forEachBrick([&](const clay::Brick& brick) { look(brick.coord - bricks, false); });
  return all;
}

Coord scaled(Coord c, double by) {
  const auto one = [=](int32_t v) { return static_cast<int32_t>(std::lround(v * by)); };
  return {one(c.x), one(c.y), one(c.z)};
}

struct Work {
  std::string name;
  std::function<Version(const Place&)> run;
  bool inBlocks = false;
  double shrinks = 1;  // voxels that it leaves for each that there was
};

std::vector<Work> allWork() {
  std::vector<Work> all;
  for (const engine::ToolRow& row : engine::toolTable())
    if (row.file == engine::ToolFile::none)
      all.push_back({std::string(row.id), [&row](const Place& place) { return stroke(row, place); }});
  const auto other = [](const Place& place) { return ball(place, {20, 6, 3}, 15); };
  const auto with = [&](const char* name, clay::Combination how) {
    all.push_back({name, [=](const Place& place) { return clay::combine(ball(place), other(place), how); }});
  };
  with("join", clay::Combination::join);
  with("cut", clay::Combination::cut);
  all.push_back({"smooth-all",
                 [=](const Place& place) {
                   return clay::smoothAll(clay::combine(ball(place), other(place), clay::Combination::cut), 4, false,
                                          1);
                 },
                 true});
  all.push_back({"thicken", [](const Place& place) { return clay::offset(ball(place), 2 * place.voxelMm, 1); }});
  all.push_back({"resample",
                 [](const Place& place) {
                   Grid coarse = ball(place).grid();
                   coarse.voxelMm *= 1.5;
                   return clay::resample(ball(place), coarse, Eigen::Isometry3d::Identity(), 1);
                 },
                 true, 1 / 1.5});
  return all;
}

// Rounds otherwise while it lives.
class Rounding {
 public:
  explicit Rounding(int mode, bool flush = false) {
    std::fesetround(mode);
    if (flush) _mm_setcsr(_mm_getcsr() | 0x8040u);  // denormals count as 0, in and out
  }
  ~Rounding() {
    std::fesetround(FE_TONEAREST);
    _mm_setcsr(_mm_getcsr() & ~0x8040u);
  }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;
};

class Table {
 public:
  Table(BenchReport& report, Job* job) : report_(report), job_(job) {}
  // `margin`: larger is better; what is kept in docs/extremes.csv.
  void row(const std::string& name, const std::string& unit, double margin, const std::string& note) {
    if (job_) job_->step(0);
    BenchResult result;
    result.name = "extremes/" + name;
    result.unit = unit;
    result.median = margin;
    result.note = note;
    report_.add(result);
  }
  // Those of the band that two fields share.
  void digits(const std::string& name, const Apart& all, const std::string& note) {
    row(name, "digits", all.finite && all.voxels > 0 ? -std::log10(std::max(all.rms() / kBand, kLeastShare)) : 0,
        fmt::format("{}: RMS {:.1e} voxel, {:.1e} at most", note, all.rms(), all.most));
  }
  void equal(const std::string& name, const Apart& all, const std::string& note) {
    row(name, "equal", all.most == 0 && all.finite && all.voxels > 0 ? 1 : 0,
        all.most == 0 ? note : fmt::format("{}; NOT EQUAL: {:.2g} voxel at most", note, all.most));
  }

 private:
  BenchReport& report_;
  Job* job_;
};

bool closed(const Version& version) {
  clay::Surface surface(false);
  surface.update(version);
  return clay::checkTopology(surface.toMesh()).solid();
}

}  // namespace

void benchExtremes(BenchReport& report, const BenchOptions& options) {
  Table table(report, options.job);
  const std::vector<Work> all = allWork();
  report.heading(
      "extremes: digits of the band that stay when all arithmetic rounds down, up, to zero, or without denormals");
  for (const Work& work : all) {
    const Version nearest = work.run({});
    Apart worst;
    for (const auto& [mode, flush] : {std::pair(FE_DOWNWARD, false), std::pair(FE_UPWARD, false),
                                      std::pair(FE_TOWARDZERO, false), std::pair(FE_TONEAREST, true)}) {
      const Version rounded = [&, mode = mode, flush = flush] {
        const Rounding rounding(mode, flush);
        return work.run({});
      }();
      const Apart now = apart(nearest, rounded);
      const bool finite = worst.finite && now.finite;
      const double most = std::max(worst.most, now.most);
      if (now.rms() >= worst.rms()) worst = now;
      worst.finite = finite, worst.most = most;
    }
    table.digits("rounding/" + work.name, worst, "against to nearest");
  }

  report.heading("extremes: what has to come out the same to the bit");
  for (const Work& work : all) {
    const Version here = work.run({});
    for (const double scale : {0x1p-7, 0x1p11})  // 2 µm and half a metre
      table.equal(fmt::format("scale-{:g}/{}", scale, work.name), apart(here, work.run({.voxelMm = kVoxel * scale})),
                  "all lengths times a power of two");
    table.equal("publishing/" + work.name, apart(here, work.run({.publishes = true})), "published after each point");
    const Coord by{24, -48, 24};
    const Apart shifted =
        apart(here, work.run({.byVoxels = by.toVec3d() * clay::kBrickEdge}), scaled(by, work.shrinks));
    // These work in blocks of bricks, whose ends show in the last bit.
    if (work.inBlocks)
      table.digits("shift/" + work.name, shifted, "whole bricks elsewhere");
    else
      table.equal("shift/" + work.name, shifted, "whole bricks elsewhere");
  }
  const Version a = ball({}), b = ball({}, {20, 6, 3}, 15);
  using clay::Combination;
  table.equal("join-itself", apart(a, clay::combine(a, a, Combination::join)), "a piece joined with itself");
  table.equal("join-either-way", apart(clay::combine(a, b, Combination::join), clay::combine(b, a, Combination::join)),
              "two pieces");
  const Version even = clay::smoothAll(a, 4, true, 1);
  Apart threads = apart(even, clay::smoothAll(a, 4, true, 2));
  for (const int count : {3, 64})
    threads.most = std::max(threads.most, apart(even, clay::smoothAll(a, 4, true, count)).most);
  table.equal("threads", threads, "1, 2, 3 and 64 threads");

  report.heading("extremes: far from zero, often, large and small");
  for (const Work& work : all)
    table.digits("sixteen-bits/" + work.name, apart(work.run({}), work.run({.precision = clay::Precision::fixed16})),
                 "against 32 bits");
  for (const double mm : {1e3, 1e6}) {
    Apart worst;
    for (const Work& work : all) {
      const Apart now = apart(work.run({}), work.run({.originMm = Vec3d(mm, -mm, mm) * 0.987654321}));
      if (now.rms() >= worst.rms()) worst = now;
    }
    table.digits(fmt::format("origin-{:g}-mm", mm), worst, "the worst of all work");
  }
  for (const auto& [what, place] :
       {std::pair("origin-1e+09-mm", Place{.originMm = Vec3d(1e9, 0, 0)}),
        std::pair("voxel-1e-06-mm", Place{.voxelMm = 1e-6}), std::pair("voxel-1e+06-mm", Place{.voxelMm = 1e6}),
        std::pair("voxel-nan", Place{.voxelMm = std::nan("")}),
        std::pair("beyond-reach", Place{.byVoxels = Vec3d(2e5, 0, 0)})}) {
    std::string said;
    try {
      (void)ball(place);
    } catch (const Error& error) {
      said = error.what();
    }
    table.row(std::string("refused/") + what, "holds", !said.empty(), said.empty() ? "NOT REFUSED" : said);
  }
  {
    Session session(ball({}));
    engine::Tool tool = engine::standardTool(*engine::findTool("carve"));
    tool.radiusMm = kTip * kVoxel;
    session.beginStroke(tool);
    session.addPoint(0, Place().mm({kBall, 0, 0}));
    session.endStroke();
    const Version after = session.version();
    const uint64_t bricks = after.store()->usage().bricks;
    for (int i = 0; i < kUndos; ++i) session.undo(), session.redo();
    const Apart there = apart(after, session.version());
    const bool flat = after.store()->usage().bricks == bricks;
    table.equal("undo-redo", there,
                fmt::format("{} times; bricks {} before and {} after", kUndos, bricks, after.store()->usage().bricks));
    table.row("undo-redo-memory", "holds", flat ? 1 : 0, "no brick more");
  }
  for (const engine::ToolRow& row : engine::toolTable()) {
    if (row.file != engine::ToolFile::none) continue;
    Session session(ball({}));
    engine::Tool tool = engine::standardTool(row);
    tool.radiusMm = kTip * kVoxel;
    tool.heightMm = tool.blendMm = kVoxel;
    session.beginStroke(tool);
    for (int i = 0; i < kSpots; ++i)
      session.addPoint(0.002 * i, Place().mm({kBall - 0.3 + 0.3 * (i % 2), 0.2 * (i % 3), 0}));
    const Version after = session.endStroke();
    const Apart finite = apart(after, after);
    table.row("one-spot/" + std::string(row.id), "holds", finite.finite && (after.stats().bricks == 0 || closed(after)),
              fmt::format("{} stamps on one spot: closed, all numbers finite", kSpots));
  }
  for (const double radius : {0.5, 100.0}) {
    Session session(ball({}));
    engine::Tool tool = engine::standardTool(*engine::findTool("carve"));
    tool.radiusMm = radius * kVoxel;
    session.beginStroke(tool);
    session.addPoint(0, Place().mm({kBall + 0.8 * radius, 0, 0}));
    const Version after = session.endStroke();
    table.row(fmt::format("radius-{:g}", radius), "holds", closed(after),
              "a dab of that many voxels leaves a closed surface");
  }
}

}  // namespace argil::bench
