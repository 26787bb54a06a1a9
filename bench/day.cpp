// argil bench day, part (a): every tool with tips of any size through strokes of any length.
//
// The hand moves at 100 mm/s, or at 33 tip radii a second where that is less: a tip is looked at closely enough to be 3
// mm wide on the screen, and the hand's speed is one on the screen. It scribbles over a square that it covers in 7.5 s,
// four times, then goes on to the next square of the sphere. It rests on the clay as it is: each sample lies where the
// surface was when the sample before it was applied. Samples come 250 times a second and are published four at a time.
//
// Cost is time of the processor, of all threads together; latency is by the clock and that of a queue: a batch is begun
// when its last sample has come and the batch before it is done.

#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/day.h"
#include "bench/models.h"
#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/session/edit_loop.h"
#include "engine/tools/stroke_path.h"
#include "engine/tools/tool_table.h"

namespace argil::bench {
namespace {

using namespace clay;

constexpr double kHandMms = 100, kHandRadii = 33;
constexpr double kSampleS = 1.0 / 250;
constexpr int kBatch = 4;
constexpr double kCoverS = 7.5, kSquareS = 30;          // to cover a square once, and before the next square
constexpr double kModelMm = 40;                         // radius of the model (bench_models.h)
constexpr double kLeastShare = 0.75, kMostShare = 1.3;  // of the model's radius: the hand digs or builds no farther
constexpr double kMemoryEveryS = 0.25;
constexpr std::array kLengths = {1.0, 10.0, 60.0, 600.0};
constexpr double kShortS = 10;  // longer strokes are compared with one of this length

const Vec3d kCentreMm(3, 5, 7);

// Where the hand is, as a direction from the model's middle.
class Scribble {
 public:
  explicit Scribble(double radiusMm) : speed_(std::min(kHandMms, kHandRadii * radiusMm)) {
    // Rows a radius apart fill a square of side s in s²/r of way; no wider than the sphere allows.
    side_ = std::min(std::sqrt(kCoverS * speed_ * radiusMm), kModelMm);
    rows_ = std::max(1.0, std::round(side_ / radiusMm));
  }
  [[nodiscard]] Vec3d at(double timeS) const {
    const double square = std::floor(timeS / kSquareS), within = timeS - square * kSquareS;
    // Up and down the rows, and back over them: a triangle wave along each axis has no jump anywhere.
    const double way = within * speed_ / side_;
    const double u = wave(way), v = wave(way / rows_);
    const bool turned = static_cast<int64_t>(way / rows_) % 2 == 1;
    const Vec3d offset = (turned ? Vec3d(v, u, 0) : Vec3d(u, v, 0)) * side_;
    // Squares lie on a spiral of the golden angle, so that they spread over the sphere.
    const double z = 1 - 2 * std::fmod(0.31 + square * 0.618034, 1.0), turn = square * 2.399963;
    const Vec3d middle(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
    const Vec3d x = middle.unitOrthogonal(), y = middle.cross(x);
    return (middle * kModelMm + x * offset.x() + y * offset.y()).normalized();
  }

 private:
  // −½ to ½ and back.
  static double wave(double x) {
    const double phase = x - 2 * std::floor(x / 2);
    return phase < 1 ? phase - 0.5 : 1.5 - phase;
  }
  double speed_, side_, rows_;
};

// What a stroke had cost when so much of it was done.
struct Mark {
  double handS, cost;  // cost: time ÷ hand time
  uint64_t touched;    // bricks
};

struct Cell {
  std::vector<Mark> marks;
  bool cutOff = false;
  // Cost of the last 10 s beside that of a stroke on the same clay which began 10 s before them; 0: none was drawn.
  double overFresh = 0;
  Samples latency;
  Samples picture;                   // from one version with its surface to the next, in turns as the studio takes them
  uint64_t beyond = 0, changed = 0;  // bytes
  uint64_t hash = 0;
  [[nodiscard]] const Mark* shortOne() const {
    const auto at = std::find_if(marks.begin(), marks.end(), [](const Mark& each) { return each.handS == kShortS; });
    return at == marks.end() ? nullptr : &*at;
  }
  // Of the dearest stroke above 10 s beside that of 10 s; 0 when there is none.
  [[nodiscard]] double growth() const {
    double most = 0;
    for (const Mark& each : marks)
      if (each.handS > kShortS) most = std::max(most, each.cost);
    return shortOne() ? most / shortOne()->cost : 0;
  }
  // The same in bricks computed for a second of hand: a count, equal on every machine.
  [[nodiscard]] double growthOfBricks() const {
    const Mark* one = shortOne();
    if (!one || marks.back().handS <= kShortS || one->touched == 0) return 0;
    return double(marks.back().touched) / marks.back().handS / (double(one->touched) / one->handS);
  }
};

class Hand {
 public:
  Hand(const Version& base, const engine::Tool& tool)
      : grid_(base.grid()),
        scribble_(tool.radiusMm),
        share_(pressed(tool)),
        radius_(tool.radiusMm / grid_.voxelMm),
        along_(kModelMm / grid_.voxelMm) {}

  // Centre of the tip on this clay, in mm.
  Vec3d rest(double timeS, const Version& clay) {
    const Vec3d direction = scribble_.at(timeS), centre = grid_.toVoxel(kCentreMm);
    Sampler field(clay);
    // The distance is known within the band: a few steps bring the hand back to a surface that moved.
    for (int i = 0; i < 4; ++i) along_ -= double(field.trilinear(centre + direction * along_));
    const double model = kModelMm / grid_.voxelMm;
    along_ = std::clamp(along_, kLeastShare * model, kMostShare * model);
    return grid_.toWorld(centre + direction * (along_ - share_ * radius_));
  }

 private:
  // How deep the tip's centre lies below the surface, in radii: a tool that cuts away stands out of the clay.
  static double pressed(const engine::Tool& tool) { return tool.id == "carve" ? -0.7 : 0; }
  Grid grid_;
  Scribble scribble_;
  double share_, radius_, along_;
};

// A stroke in work, with the surface that is seen of it: that of `base` at first.
class HandOnClay {
 public:
  HandOnClay(const Version& base, const engine::Tool& tool, Hand hand, Surface& surface, int threads)
      : grid_(base.grid()),
        surface_(surface),
        threads_(threads),
        stroke_(base, brushOf(tool, grid_, base), {}, threads),
        path_(grid_, tool),
        hand_(std::move(hand)),
        shown_(base) {}
  [[nodiscard]] const Version& shown() const { return shown_; }
  [[nodiscard]] const Hand& hand() const { return hand_; }
  [[nodiscard]] uint64_t touched() const { return stroke_.touched(); }

  struct Spent {
    double us, coreUs;
  };
  // The samples from the i-th on; `picture` gets what passes from one surface to the next.
  Spent batch(int64_t i, Samples& picture) {
    std::array<Vec3d, kBatch> points;
    for (int k = 0; k < kBatch; ++k) points[static_cast<size_t>(k)] = hand_.rest(double(i + k) * kSampleS, shown_);
    const Stopwatch watch;
    const CoreStopwatch core;
    Stopwatch since;  // the last picture with something new, or that all was done
    const auto now = [&] { return static_cast<int64_t>(watch.us() * 1e3); };
    const auto show = [&] {
      Version next = stroke_.publish();
      if (next != shown_) {
        shown_ = std::move(next);
        surface_.update(shown_, threads_);
        picture.add(since.us());
        since = {};
      }
      turn_.begin(now());
    };
    const auto showWhenOver = [&] {
      turn_.step(now());
      if (turn_.over()) show();
    };
    turn_.begin(now());
    for (const Vec3d& point : points) {
      stamps_.clear();
      path_.add(point, stamps_);
      for (Stamp& stamp : stamps_) {
        // The tip stands on the model.
        const Vec3d normal = (stamp.b - grid_.toVoxel(kCentreMm)).normalized(), x = normal.unitOrthogonal();
        stamp.axes << x.cast<float>(), normal.cross(x).cast<float>(), normal.cast<float>();
        while (stroke_.step({&stamp, 1})) showWhenOver();
        showWhenOver();
      }
    }
    show();
    return {watch.us(), core.us()};
  }
  Version finish() {
    stamps_.clear();
    path_.finish(stamps_);
    for (const Stamp& stamp : stamps_) stroke_.apply(stamp);
    shown_ = stroke_.finish();
    surface_.update(shown_, threads_);
    return shown_;
  }

 private:
  Grid grid_;
  Surface& surface_;
  int threads_;
  BrushStroke stroke_;
  engine::StrokePath path_;
  Hand hand_;
  std::vector<Stamp> stamps_;
  engine::TurnTime turn_{engine::EditLoop::kTurnBudgetNs};
  Version shown_;
};

Cell strokeOf(const BenchModel& model, const engine::Tool& tool, int threads, const BenchOptions& options) {
  const double longestS = options.longestS, capS = options.cellSeconds;
  Job* job = options.job;
  Cell cell;
  const Version base = model.version;
  Store* store = base.store().get();
  const auto collect = [store] {
    while (store->collect()) {
    }
  };
  collect();
  Surface surface;
  surface.update(base);
  const uint64_t before = bytesInUse(store);
  uint64_t most = 0;
  Version shown = base;
  // What the clay and the hand were 20 s before the end; and what had been spent 10 s before it.
  std::optional<std::pair<Version, Hand>> then;
  double thenUs = 0, lastUs = 0;
  const auto samples = static_cast<int64_t>(std::ceil(longestS / kSampleS / kBatch)) * kBatch;
  const auto lastOnes = static_cast<int64_t>(std::lround(kShortS / kSampleS));
  const int64_t compared = samples - lastOnes, fresh = compared - lastOnes;
  {
    HandOnClay work(base, tool, Hand(base, tool), surface, threads);
    double workUs = 0, clockS = 0, memoryAtS = 0;
    std::vector<double> lengths(kLengths.begin(), std::lower_bound(kLengths.begin(), kLengths.end(), longestS));
    lengths.push_back(longestS);
    size_t next = 0;
    const Stopwatch all;
    for (int64_t i = 0; i < samples; i += kBatch) {
      if (longestS >= 4 * kShortS && i == fresh) then.emplace(work.shown(), work.hand());
      if (i == compared) thenUs = workUs;
      const HandOnClay::Spent spent = work.batch(i, cell.picture);
      workUs += spent.coreUs;
      const double firstS = double(i) * kSampleS, lastS = double(i + kBatch - 1) * kSampleS;
      clockS = std::max(clockS, lastS) + spent.us * 1e-6;
      cell.latency.add((clockS - firstS) * 1e6);
      const double handS = double(i + kBatch) * kSampleS;
      collect();
      if (handS >= memoryAtS && !then) {  // From there on that clay is held too, which no stroke does.
        most = std::max(most, bytesInUse(store));
        memoryAtS += kMemoryEveryS;
      }
      cell.cutOff = all.us() > capS * 1e6 && i + kBatch < samples;
      const bool atLength = next < lengths.size() && handS > lengths[next] - kSampleS / 2;
      if (atLength || cell.cutOff)
        cell.marks.push_back({atLength ? lengths[next] : handS, workUs * 1e-6 / handS, work.touched()});
      next += atLength;
      if (job) job->step(0);
      if (cell.cutOff) break;
    }
    lastUs = workUs - thenUs;
    shown = work.finish();
    if (!then) most = std::max(most, bytesInUse(store));
  }
  Version::forEachDifference(
      base, shown, [&](Coord, Slot, Slot now) { cell.changed += now.brick() ? brickBytes(store->precision()) : 0; });
  cell.beyond = most - std::min(most, before + cell.changed);
  cell.hash = shown.hash();
  if (then && !cell.cutOff) {
    surface.update(then->first);
    HandOnClay anew(then->first, tool, then->second, surface, threads);
    double us = 0;
    Samples unused;
    for (int64_t i = fresh; i < samples; i += kBatch) {
      const double spent = anew.batch(i, unused).coreUs;
      if (i >= compared) us += spent;
      collect();
      if (job) job->step(0);
    }
    cell.overFresh = lastUs / us;
  }
  return cell;
}

// The tools that have to keep hand time with tips of any size; the others to 50 voxels.
bool keepsUpAtAnySize(std::string_view id) {
  constexpr std::array kSuch = {"carve", "add", "smooth", "wax", "inflate", "scrape"};
  return std::find(kSuch.begin(), kSuch.end(), id) != kSuch.end();
}

}  // namespace

uint64_t bytesInUse(const Store* store) {
  const struct mallinfo2 heap = mallinfo2();
  return heap.uordblks + heap.hblkhd + (store ? store->usage().bytes() : 0);
}

void benchDayStrokes(BenchReport& report, const BenchOptions& options) {
  const DayLimits limits;
  std::vector<double> sizes = {1};
  if (options.largest > 1) sizes.push_back(options.largest);
  if (options.largest < 1) sizes.front() = options.largest;
  const int threads = options.threads > 0 ? options.threads : engine::Session::strokeThreads();
  uint64_t cells = 0, grown = 0, own = 0, late = 0, slow = 0, heavy = 0, cut = 0;
  for (const double size : sizes) {
    const BenchModel model = benchSphere(size);
    report.heading(fmt::format(
        "day, strokes: sphere of {} with {} of active voxels, {} threads; the hand moves at {:g} mm/s or "
        "{:g} radii a second; a stroke is "
        "cut off after {:g} s of work.\ntime ÷ hand time after 1, 10, 60, 600 s (! above {}); growth "
        "beside 10 s (! above {}), and, without what the clay's growth does, of the last 10 s beside a stroke that "
        "began 10 s before them on the same clay (0: none); latency; p99 from picture to picture, ms (! above {}); "
        "bytes beyond the clay ÷ bytes changed (! above {} and {} MB); bricks computed for a second of "
        "hand, first 10 s and all",
        "40 mm", model.name, threads, kHandMms, kHandRadii, options.cellSeconds, limits.handTime, limits.growth,
        limits.pictureMs, limits.memory, limits.spareBytes >> 20));
    for (const engine::ToolRow& row : engine::toolTable()) {
      if (row.file != engine::ToolFile::none) continue;
      if (!options.tools.empty() &&
          std::find(options.tools.begin(), options.tools.end(), row.id) == options.tools.end())
        continue;
      for (const double radius : options.tips.empty() ? std::vector<double>{2, 12, 50, 200} : options.tips) {
        engine::Tool tool = engine::standardTool(row);
        tool.quality = engine::findQualityPreset("balanced")->quality.strokes;  // as new documents have it
        tool.radiusMm = radius * model.version.grid().voxelMm;
        tool.heightMm = tool.radiusMm / 5;
        tool.blendMm = std::min(tool.radiusMm / 5, 3 * model.version.grid().voxelMm);
        const Cell cell = strokeOf(model, tool, threads, options);
        const Mark& last = cell.marks.back();
        const double growth = cell.growth();
        const bool tooLate = last.cost > limits.handTime && (radius <= 50 || keepsUpAtAnySize(row.id));
        const bool tooGrown = growth > limits.growth, ownGrowth = cell.overFresh > limits.growth;
        const bool tooHeavy = cell.beyond > uint64_t(limits.memory * double(cell.changed)) + limits.spareBytes;
        ++cells;
        late += tooLate, grown += tooGrown, own += ownGrowth, heavy += tooHeavy, cut += cell.cutOff;
        std::string line = fmt::format("  {:<11} r {:>3} {:>4} ", row.id, radius, model.name);
        for (const Mark& each : cell.marks)
          line += fmt::format(" {:>5.1f} s {:>7.4f}{}", each.handS, each.cost,
                              tooLate && each.cost > limits.handTime ? "!" : " ");
        if (cell.cutOff) line += "cut off";
        line += fmt::format("  growth {:>5.2f}{} of bricks {:>5.2f} over a young stroke {:>5.2f}{}", growth,
                            tooGrown ? "!" : " ", cell.growthOfBricks(), cell.overFresh, ownGrowth ? "!" : " ");
        const double picture = cell.picture.quantile(0.99) / 1e3;
        const bool tooSlow = picture > limits.pictureMs;
        slow += tooSlow;
        line += fmt::format("  p50 {:>7.1f} p99 {:>8.1f} ms  picture {:>6.1f}{}", cell.latency.median() / 1e3,
                            cell.latency.quantile(0.99) / 1e3, picture, tooSlow ? "!" : " ");
        line += fmt::format("  {:>6.1f} of {:>6.1f} MB{}", double(cell.beyond) / 1e6, double(cell.changed) / 1e6,
                            tooHeavy ? "!" : " ");
        fmt::print("{} {:016x}\n", line, cell.hash);
        std::fflush(stdout);
        for (const Mark& each : cell.marks) {
          BenchResult r;
          r.name = fmt::format("day/stroke/{}/r{:g}/{}/{:g}s", row.id, radius, model.name, each.handS);
          r.unit = "s/s";
          r.median = each.cost;
          r.n = 1;
          r.threads = threads;
          r.bytes = cell.beyond;
          r.memory = cell.changed;
          r.bricks = static_cast<uint64_t>(double(each.touched) / each.handS);
          r.hash = cell.hash;
          report.keep(std::move(r));
        }
        report.keep(cell.picture.result(fmt::format("day/picture/{}/r{:g}/{}", row.id, radius, model.name)));
        report.keep(cell.latency.result(fmt::format("day/latency/{}/r{:g}/{}", row.id, radius, model.name)));
      }
    }
  }
  fmt::print(
      "\n  {} cells: {} grow ({} by the stroke's own length), {} do not keep hand time, {} show too seldom, {} take "
      "too much memory, {} were cut off\n",
      cells, grown, own, late, slow, heavy, cut);
}

void benchDay(BenchReport& report, const BenchOptions& options) {
  benchDayStrokes(report, options);
  benchDayPieces(report, options);
  benchDayHours(report, options);
  benchDayImport(report, options);
}

}  // namespace argil::bench
