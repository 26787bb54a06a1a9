// argil bench day, part (c): hours of mixed work from a seed, without waiting for the hand.

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "bench/day.h"
#include "bench/models.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/saving/undo_budget.h"
#include "engine/session/surfaces.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/tool_table.h"

namespace argil::bench {
namespace {

namespace fs = std::filesystem;
using namespace engine;

constexpr uint64_t kSeed = 20261121;
// full within the first quarter, so that quarters can be compared
constexpr uint64_t kUndoBytes = uint64_t{192} << 20;
constexpr double kMillions = 1;
// Random strokes lay more than they take: within an hour a ball is five times the surface that it was. A quarter is
// comparable with another because its clay is: the hand begins anew.
constexpr double kSaveEveryS = 600, kJobEveryS = 900, kAnewEveryS = 600;
constexpr double kHandMms = 100, kModelMm = 40, kSampleS = 1.0 / 250;
constexpr int kBatch = 4;
constexpr int kQuarters = 4;

uint64_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  uint64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

struct Quarter {
  Samples batch, undo, save, job;
  uint64_t strokes = 0, most = 0, resident = 0, onDisk = 0, bricks = 0, undoBytes = 0;
};

// A document in work with all that a workbench has beside it, on one thread and in virtual time.
class Day {
 public:
  explicit Day(const fs::path& folder) : folder_(folder), random_(kSeed) {
    const BenchModel model = benchSphere(kMillions);
    saveDocument(folder_ / "day.argil", Document::of(model.version));
    opened_ = openDocument(folder_ / "day.argil");
    base_ = opened_.base;
    session_ = std::make_unique<Session>(opened_.states, opened_.done);
    first_ = session_->version();
    AutosaveOptions keep;
    keep.folder = folder_ / "journals";
    autosave_ = std::make_unique<Autosave>(keep, [](const std::string& trouble) {
      if (!trouble.empty()) fmt::print(stderr, "{}\n", trouble);
    });
    records_ = autosave_->begin(opened_.states, opened_.done, opened_.documentRecords, base_, writer_);
    session_->setWatch(autosave_.get());
    session_->setReader([this](uint64_t kept, const Document& near) {
      return readStep(*autosave_, *opened_.documentRecords, records_, kept, near);
    });
    follow();
    // Nothing in memory but what the session needs: the first states are its own now.
    opened_.states.clear();
  }
  ~Day() { session_->setWatch(nullptr); }

  // Does the next thing; returns how long the hand took, seconds.
  double next(Quarter& quarter) {
    const double dice = random_.unit();
    double seconds = 1 + 6 * random_.unit();
    if (dice < 0.75) {
      seconds += stroke(quarter);
    } else if (dice < 0.95) {
      const bool back = random_.unit() < 0.65;
      for (uint64_t i = 1 + random_.below(6); i > 0; --i) {
        const CoreStopwatch watch;
        if (back ? !session_->undo() : !session_->redo()) break;
        follow();
        quarter.undo.add(watch.us());
      }
    }
    settle(quarter);
    return seconds;
  }

  void save(Quarter& quarter) {
    const fs::path file = folder_ / "day.argil";
    const CoreStopwatch watch;
    autosave_->saving(file);
    base_ = saveDocument(
        file, {session_->states(), session_->undoSteps(), {}, opened_.documentRecords, base_, {records_}, writer_});
    autosave_->saved(base_);
    quarter.save.add(watch.us());
  }

  // From the first ball, in the same document: a step like others.
  void beginAnew(Quarter& quarter) {
    session_->change("Begin anew", [&](Document& document) { document.pieces[0].version = *first_; });
    follow();
    settle(quarter);
  }

  void job(Quarter& quarter) {
    const DocumentPtr before = session_->document();
    constexpr std::array<std::string_view, 3> kJobs = {"smooth-all", "fill-voids", "remove-crumbs"};
    const PieceJob* row = findPieceJob(kJobs[random_.below(kJobs.size())]);
    const CoreStopwatch watch;
    const PieceResult result = runPieceJob(*row, *before, standardArguments(*row, *before));
    session_->change(std::string(row->name), [&](Document& document) { applyPieceResult(result, *before, document); });
    follow();
    quarter.job.add(watch.us());
    settle(quarter);
  }

 private:
  double stroke(Quarter& quarter) {
    const clay::Grid grid = session_->version().grid();
    constexpr std::array<std::string_view, 10> kTools = {"carve",  "add",    "smooth", "wax",   "inflate",
                                                         "scrape", "crease", "tug",    "paint", "layer"};
    const ToolRow* row = findTool(kTools[random_.below(kTools.size())]);
    Tool tool = standardTool(*row);
    tool.radiusMm = std::exp2(1 + 4.6 * random_.unit()) * grid.voxelMm;  // 2 to 48 voxels
    tool.heightMm = tool.radiusMm / 5;
    tool.blendMm = std::min(tool.radiusMm / 5, 3 * grid.voxelMm);
    const double seconds = 0.5 + 4 * random_.unit() * random_.unit(), speed = std::min(kHandMms, 33 * tool.radiusMm);
    const Vec3d middle(3, 5, 7);
    Vec3d at = random_.inBall().normalized();
    Vec3d heading = random_.inBall().cross(at).normalized();
    session_->beginStroke(tool);
    const auto samples = static_cast<int>(seconds / kSampleS);
    double along = kModelMm / grid.voxelMm;
    for (int i = 0; i < samples; i += kBatch) {
      std::array<Vec3d, kBatch> points;
      {
        const clay::Version now = session_->version();
        clay::Sampler field(now);
        const Vec3d centre = grid.toVoxel(middle);
        for (Vec3d& point : points) {
          for (int k = 0; k < 12; ++k) along -= double(field.trilinear(centre + at * along));
          along = std::clamp(along, 0.7 * kModelMm / grid.voxelMm, 1.4 * kModelMm / grid.voxelMm);
          point = middle + at * along * grid.voxelMm;
          at = (at + heading * (speed * kSampleS / kModelMm)).normalized();
          heading = (heading + 0.1 * random_.inBall()).normalized();
          heading = (heading - heading.dot(at) * at).normalized();
        }
      }
      const CoreStopwatch watch;
      for (int k = 0; k < kBatch; ++k) session_->addPoint((i + k) * kSampleS, points[static_cast<size_t>(k)]);
      session_->publish();
      follow();
      quarter.batch.add(watch.us());
    }
    session_->endStroke();
    follow();
    ++quarter.strokes;
    return seconds;
  }

  void follow() {
    surfaces_.follow(*session_->document(), 0);
    (void)surfaces_.take();
  }

  void settle(Quarter& quarter) {
    autosave_->catchUp();
    const UndoUse use =
        budget_.keep(*session_, [this](const DocumentPtr& document) { return autosave_->kept(document); });
    quarter.onDisk = use.onDisk;
    quarter.undoBytes = std::max(quarter.undoBytes, use.bytes);
    quarter.bricks = session_->version().stats().bricks;
    const clay::Store* store = session_->version().store().get();
    quarter.most = std::max(quarter.most, bytesInUse(store));
    quarter.resident = std::max(quarter.resident, residentBytes());
  }

  fs::path folder_;
  Random random_;
  OpenedDocument opened_;
  std::shared_ptr<const Base> base_;
  std::string writer_ = newWriter();
  std::unique_ptr<Autosave> autosave_;
  std::shared_ptr<SavedHistory> records_;
  std::unique_ptr<Session> session_;
  std::optional<clay::Version> first_;
  Surfaces surfaces_;
  UndoBudget budget_{kUndoBytes};
};

void reportQuarter(BenchReport& report, int number, const Quarter& q, const Quarter& first) {
  const DayLimits limits;
  const auto beside = [&](double now, double then) {
    const double ratio = then > 0 ? now / then : 0;
    return fmt::format("{:.2f}× the first quarter's{}", ratio, ratio > limits.hours ? " !" : "");
  };
  BenchResult r = q.batch.result(fmt::format("day/hours/batch/quarter{}", number));
  r.memory = q.most;
  r.note = fmt::format(
      "{} strokes; p99 {}; bytes in use {}; resident {:.0f} MB; {} bricks of clay; {:.0f} MB of steps, {} of them on "
      "disk",
      q.strokes, beside(q.batch.quantile(0.99), first.batch.quantile(0.99)), beside(double(q.most), double(first.most)),
      double(q.resident) / 1e6, q.bricks, double(q.undoBytes) / 1e6, q.onDisk);
  report.add(std::move(r));
  r = q.undo.result(fmt::format("day/hours/undo/quarter{}", number));
  r.note = fmt::format("median {}", beside(q.undo.median(), first.undo.median()));
  report.add(std::move(r));
  r = q.save.result(fmt::format("day/hours/save/quarter{}", number));
  r.note = fmt::format("median {}", beside(q.save.median(), first.save.median()));
  report.add(std::move(r));
}

}  // namespace

void benchDayHours(BenchReport& report, const BenchOptions& options) {
  report.heading(fmt::format(
      "day, hours: {:g} simulated hours of strokes with ten tools, undo, redo, a save every {:g} min, a "
      "job every {:g} min, {:g} M voxels begun anew every {:g} min; "
      "{} MiB for undo; journal on; seed {}; by quarters",
      options.hours, kSaveEveryS / 60, kJobEveryS / 60, kMillions, kAnewEveryS / 60, kUndoBytes >> 20, kSeed));
  const fs::path folder = (options.folder.empty() ? fs::temp_directory_path() : options.folder) /
                          fmt::format("argil-bench-day-{}", getpid());
  fs::create_directories(folder);
  {
    Day day(folder);
    Quarter first;
    double timeS = 0, saveS = kSaveEveryS, jobS = kJobEveryS, anewS = kAnewEveryS;
    const double quarterS = options.hours * 3600 / kQuarters;
    for (int i = 1; i <= kQuarters; ++i) {
      Quarter quarter;
      while (timeS < i * quarterS) {
        timeS += day.next(quarter);
        if (timeS >= saveS) {
          day.save(quarter);
          saveS += kSaveEveryS;
        }
        if (timeS >= jobS) {
          day.job(quarter);
          jobS += kJobEveryS;
        }
        if (timeS >= anewS) {
          day.beginAnew(quarter);
          anewS += kAnewEveryS;
        }
        if (options.job) options.job->step(std::min(1.0, timeS / (kQuarters * quarterS)));
      }
      if (i == 1) first = quarter;
      reportQuarter(report, i, quarter, first);
    }
  }
  fs::remove_all(folder);
}

}  // namespace argil::bench
