// argil bench undo: what a long history costs in memory, and how long undo and redo take in memory and on the disk.

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/base/error.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/session.h"
#include "engine/saving/undo_budget.h"

namespace argil::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kSteps = 500;
constexpr double kToolVoxels = 20;
constexpr int kLeastPoints = 20, kMostPoints = 1600;  // a fifth of a radius apart: strokes of 4 to 320 radii

// A stroke across the sphere, published as an edit thread would.
void stroke(engine::Session& session, const BenchModel& model, engine::Random& random) {
  const clay::Grid grid = session.version().grid();
  const double radius = model.radiusVoxels * grid.voxelMm;
  engine::Tool tool;
  tool.radiusMm = kToolVoxels * grid.voxelMm;
  tool.id = std::array{"carve", "add", "smooth"}[random.below(3)];
  const int points = kLeastPoints + static_cast<int>(random.below(kMostPoints - kLeastPoints));
  Vec3d at = random.inBall().normalized(),
        step = random.inBall().cross(at).normalized() * (0.2 * tool.radiusMm / radius);
  session.beginStroke(tool);
  for (int i = 0; i < points; ++i) {
    session.addPoint(0.001 * i, Vec3d(3, 5, 7) + radius * at.normalized());
    if (i % 4 == 3) session.publish();
    at += step;
  }
  session.endStroke();
}

uint64_t collected(const engine::Session& session) {
  const clay::Version now = session.version();
  while (now.store()->collect(1 << 16)) {
  }
  return now.store()->usage().bytes() - now.stats().bytes();
}

// What a session, its autosave and its budget do together in a workbench.
struct Work {
  Work(engine::OpenedDocument& opened, const fs::path& folder)
      : session(opened.states, opened.done), documentRecords(opened.documentRecords) {
    engine::AutosaveOptions keep;
    keep.folder = folder / "journals";
    autosave = std::make_unique<engine::Autosave>(keep, [](const std::string& trouble) {
      if (!trouble.empty()) fmt::print(stderr, "{}\n", trouble);
    });
    records = autosave->begin(opened.states, opened.done, documentRecords, opened.base, engine::newWriter());
    session.setWatch(autosave.get());
    session.setReader([this](uint64_t kept, const engine::Document& near) {
      return engine::readStep(*autosave, *documentRecords, records, kept, near);
    });
  }
  ~Work() { session.setWatch(nullptr); }
  engine::UndoUse settle() {
    return budget.keep(session, [this](const engine::DocumentPtr& document) { return autosave->kept(document); });
  }

  engine::Session session;
  std::shared_ptr<engine::DocumentRecords> documentRecords;
  std::unique_ptr<engine::Autosave> autosave;
  std::shared_ptr<engine::SavedHistory> records;
  engine::UndoBudget budget;
};

}  // namespace

void benchUndo(BenchReport& report, const BenchOptions& options) {
  benchUndoPicture(report, options);
  BenchModel model = benchSphere(benchSizes(options.largest).back());
  const fs::path folder = (options.folder.empty() ? fs::temp_directory_path() : options.folder) /
                          fmt::format("argil-bench-undo-{}", getpid());
  report.heading(fmt::format(
      "undo: {} strokes of {} to {} radii, tool of {} voxels, carve, add and smooth; {} MiB for undo; files in {}",
      kSteps, kLeastPoints / 5, kMostPoints / 5, kToolVoxels, engine::UndoBudget::kStandard >> 20,
      folder.parent_path().string()));
  fs::create_directories(folder);
  engine::saveDocument(folder / "model.argil", engine::Document::of(model.version), options.job);
  model.version = {};
  {
    engine::OpenedDocument opened = engine::openDocument(folder / "model.argil", options.job);
    Work work(opened, folder);
    engine::Session& session = work.session;
    engine::Random random(17);
    const uint64_t first = session.version().hash();
    Samples counting;
    engine::UndoUse use;
    for (int i = 0; i < kSteps; ++i) {
      if (options.job) options.job->step(double(i) / kSteps);
      stroke(session, model, random);
      work.autosave->flush();
      Stopwatch watch;
      use = work.settle();
      counting.add(watch.us());
    }
    const auto name = [&](const char* what) { return fmt::format("undo/{}/{}", what, model.name); };
    report.add([&] {
      BenchResult r = counting.result(name("count"));
      r.note = "what a new step costs to count, and to let others go";
      return r;
    }());
    BenchResult memory;
    memory.name = name("memory");
    memory.unit = "MiB";
    memory.median = std::ldexp(double(use.bytes), -20);
    memory.n = kSteps;
    memory.bytes = use.bytes;
    memory.note = fmt::format(
        "{} steps in memory, {} on disk; the store holds {:.1f} MiB beside the newest version; journals {:.0f} MiB",
        use.inMemory, use.onDisk, std::ldexp(double(collected(session)), -20),
        std::ldexp(double(work.autosave->counts().bytes), -20));
    report.add(memory);

    const uint64_t last = session.version().hash();
    Samples inMemory[2], onDisk[2];
    uint64_t most = 0;
    for (const bool back : {true, false}) {
      for (int i = 0; i < kSteps; ++i) {
        if (options.job) options.job->step(double(i) / kSteps);
        const size_t to = session.undoSteps() + (back ? -1 : 1);
        const bool resident = session.states()[to].document != nullptr;
        Stopwatch watch;
        if (back)
          session.undo();
        else
          session.redo();
        (resident ? inMemory : onDisk)[back ? 0 : 1].add(watch.us());
        most = std::max(most, work.settle().bytes);
      }
      if (session.version().hash() != (back ? first : last))
        throw Error("bench undo: a step came back as another one; this is a fault in Argil", Error::Kind::work);
    }
    for (const bool back : {true, false}) {
      const char* what = back ? "undo" : "redo";
      const Samples &swap = inMemory[back ? 0 : 1], &read = onDisk[back ? 0 : 1];
      if (swap.count() > 0) report.add(swap.result(name(fmt::format("{}-in-memory", what).c_str())));
      if (read.count() == 0) continue;
      BenchResult r = read.result(name(fmt::format("{}-from-disk", what).c_str()));
      r.note = fmt::format("slowest {:.1f} ms", read.quantile(1) / 1000);
      report.add(std::move(r));
    }
    BenchResult peak;
    peak.name = name("memory-most");
    peak.unit = "MiB";
    peak.median = std::ldexp(double(most), -20);
    peak.n = 2 * kSteps;
    peak.bytes = most;
    peak.note = "while all steps were undone and redone; both ends were equal to the bit";
    report.add(peak);
  }
  fs::remove_all(folder);
}

}  // namespace argil::bench
