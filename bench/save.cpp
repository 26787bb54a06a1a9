// argil bench save: what it costs to keep work: the journal beside strokes, saving, opening, recovering.

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <thread>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/session/recovery.h"

namespace argil::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kStrokes = 40;
constexpr int kPoints = 300;  // one a millisecond of a person's time, here one after the other
constexpr double kToolVoxels = 20;

// Strokes across the sphere, at fresh places; calls back with the time of each publish, as the edit thread would.
uint64_t sculpt(engine::Session& session, const BenchModel& model, uint64_t seed, Samples& edit,
                const std::function<void()>& afterStroke) {
  engine::Random random(seed);
  const clay::Grid grid = session.version().grid();
  const double radius = model.radiusVoxels * grid.voxelMm;
  engine::Tool tool;
  tool.radiusMm = kToolVoxels * grid.voxelMm;
  uint64_t touched = 0;
  for (int stroke = 0; stroke < kStrokes; ++stroke) {
    const clay::Version before = session.version();
    Vec3d at = random.inBall().normalized(),
          step = random.inBall().cross(at).normalized() * (0.2 * tool.radiusMm / radius);
    session.beginStroke(tool);
    for (int i = 0; i < kPoints; ++i) {
      const Stopwatch watch;
      session.addPoint(0.001 * i, Vec3d(3, 5, 7) + radius * at.normalized());
      session.publish();
      edit.add(watch.us());
      at += step;
    }
    session.endStroke();
    clay::Version::forEachDifference(before, session.version(),
                                     [&](Coord, clay::Slot, clay::Slot b) { touched += b.brick() != nullptr; });
    afterStroke();
  }
  return touched;
}

}  // namespace

void benchSave(BenchReport& report, const BenchOptions& options) {
  report.heading(fmt::format("save: {} strokes of {} samples, tool of {} voxels; files in {}", kStrokes, kPoints,
                             kToolVoxels, fs::temp_directory_path().string()));
  for (const double size : benchSizes(options.largest)) {
    const BenchModel model = benchSphere(size);
    const fs::path folder = fs::temp_directory_path() / fmt::format("argil-bench-keep-{}", getpid());
    fs::create_directories(folder);
    const fs::path file = folder / "model.argil";
    const auto add = [&](const std::string& name, double us, const std::string& note,
                         std::optional<uint64_t> bytes = {}) {
      BenchResult r;
      r.name = fmt::format("save/{}/{}", name, model.name);
      r.median = us;
      r.n = 1;
      r.bytes = bytes;
      r.note = note;
      report.add(std::move(r));
    };
    {
      Stopwatch watch;
      engine::saveDocument(file, engine::Document::of(model.version), options.job);
      add("save-all", watch.us(),
          fmt::format("{} bricks, {:.0f} bytes each", model.version.stats().bricks,
                      double(fs::file_size(file)) / double(model.version.stats().bricks)),
          fs::file_size(file));
    }
    Samples edit[2];
    for (const bool journal : {false, true}) {
      if (options.job) options.job->step(0);
      Stopwatch opening;
      engine::OpenedDocument opened = engine::openDocument(file);
      if (!journal) add("open", opening.us(), "");
      engine::Session session(opened.states, opened.done);
      engine::AutosaveOptions keep;
      keep.folder = folder / "journals";
      engine::Autosave autosave(keep, [](const std::string& trouble) {
        if (!trouble.empty()) fmt::print(stderr, "{}\n", trouble);
      });
      const std::string writer = engine::newWriter();
      if (journal) {
        autosave.begin(opened.states, opened.done, opened.documentRecords, opened.base, writer);
        session.setWatch(&autosave);
        autosave.flush();
      }
      const engine::Autosave::Counts before = autosave.counts();
      Samples cpu;
      double last = before.cpuS;
      const uint64_t touched = sculpt(session, model, 11, edit[journal], [&] {
        if (!journal) return;
        autosave.flush();
        const double now = autosave.counts().cpuS;
        cpu.add(1e6 * (now - last));
        last = now;
      });
      if (!journal) continue;
      const engine::Autosave::Counts after = autosave.counts();
      BenchResult r = cpu.result(fmt::format("save/journal-cpu-a-stroke/{}", model.name));
      r.bricks = touched / kStrokes;
      r.bytes = (after.bytes - before.bytes) / kStrokes;
      r.note = fmt::format(
          "{:.2f}x the bytes of the bricks that strokes changed; the disk was waited for {:.1f} ms a stroke",
          double(after.bytes - before.bytes) / (double(touched) * 2048), 1e3 * (after.syncS - before.syncS) / kStrokes);
      report.add(std::move(r));

      Stopwatch saving;
      engine::SaveRequest request{
          session.states(), session.undoSteps(), {}, opened.documentRecords, opened.base, {}, writer};
      const uintmax_t bytesBefore = fs::file_size(file);
      const auto base = engine::saveDocument(file, request);
      add("save-changes", saving.us(), fmt::format("after {} strokes", kStrokes), fs::file_size(file) - bytesBefore);
      // Strokes on, then what a crash would leave.
      autosave.saved(base);
      Samples more;
      sculpt(session, model, 12, more, [] {});
      autosave.leave();
      session.setWatch(nullptr);
    }
    for (const auto& journal : fs::directory_iterator(folder / "journals")) {
      Stopwatch watch;
      engine::Recovered recovered = engine::recover(journal.path());
      engine::Session session(recovered.document.states, recovered.document.done);
      engine::replay(session, recovered.strokes);
      add("recover", watch.us(), recovered.sentence, fs::file_size(journal.path()));
    }
    {
      // The whole of it is saved again and again on a thread of its own meanwhile.
      engine::OpenedDocument opened = engine::openDocument(file);
      engine::Session session(opened.states, opened.done);
      std::atomic<bool> stop{false};
      std::atomic<int> saves{0};
      std::thread saving([&, document = session.document()] {
        while (!stop) {
          engine::saveDocument(folder / "again.argil", *document);
          ++saves;
        }
      });
      Samples during;
      sculpt(session, model, 11, during, [] {});
      stop = true;
      saving.join();
      BenchResult r = during.result(fmt::format("save/sample-while-saving/{}", model.name));
      r.peer = edit[0].median();
      r.peerName = "without";
      r.note = fmt::format("p99 without {:.1f}; the whole was saved {} times meanwhile", edit[0].quantile(0.99),
                           saves.load());
      report.add(std::move(r));
    }
    BenchResult r = edit[1].result(fmt::format("save/sample-with-journal/{}", model.name));
    r.peer = edit[0].median();
    r.peerName = "without";
    r.note = fmt::format("p99 without {:.1f}", edit[0].quantile(0.99));
    report.add(std::move(r));
    fs::remove_all(folder);
  }
}

}  // namespace argil::bench
