// saving_session FOLDER SEED RADIUS_MM VOXEL_MM: works on FOLDER/work.argil (or on an untitled ball when it is not
// there) in real time, as the studio's edit thread does, until it is killed. FOLDER/progress tells what was done when.

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/jobs.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "tests/soak/engine/keeping_script.h"

using namespace argil;

int main(int count, char** arguments) {
  if (count != 5) return 2;
  const std::filesystem::path folder = arguments[1], file = folder / "work.argil";
  const uint64_t seed = std::strtoull(arguments[2], nullptr, 10);
  const double radius = std::strtod(arguments[3], nullptr), voxel = std::strtod(arguments[4], nullptr);
  soak::Progress& progress = *soak::mapProgress(folder / "progress", false);

  engine::OpenedDocument opened;
  std::string writer = engine::newWriter();
  if (std::filesystem::exists(file)) {
    opened = engine::openDocument(file);
  } else {
    clay::Grid grid;
    grid.voxelMm = voxel;
    opened.states = {{.label = {},
                      .document = std::make_shared<const engine::Document>(
                          engine::Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radius)))}};
    opened.documentRecords = std::make_shared<engine::DocumentRecords>();
  }
  std::shared_ptr<const engine::Base> base = opened.base;
  engine::AutosaveOptions options;
  options.folder = folder / "state";
  engine::Autosave autosave(options, [&](const std::string& trouble) {
    if (trouble.empty()) return;
    if (progress.journalErrors.fetch_add(1) == 0) progress.troubledNs = soak::nowNs();
  });
  engine::Session session(opened.states, opened.done);
  session.setReader([&](uint64_t kept, const engine::Document& near) {
    return engine::readState(*opened.documentRecords, base, {}, kept, near);
  });
  autosave.begin(opened.states, opened.done, opened.documentRecords, base, writer);
  session.setWatch(&autosave);

  std::optional<engine::BackgroundJob> saving;
  std::shared_ptr<const engine::Base> saved;
  uint64_t savedOps = 0;
  const auto finishSave = [&] {
    if (!saving || !saving->done()) return;
    try {
      saving->wait();
      base = saved;
      autosave.saved(base);
      progress.savedOp = savedOps;
      ++progress.saves;
    } catch (const Error& e) {
      if (++progress.saveErrors == 1) std::fprintf(stderr, "told: %s\n", e.what());
    }
    saving.reset();
  };

  progress.hash[0] = soak::hashOf(*session.document());
  progress.readyNs = soak::nowNs();
  auto next = std::chrono::steady_clock::now();
  const auto acted = [&] {
    const uint64_t number = progress.actions;
    if (number >= soak::Progress::kActions) std::exit(0);
    progress.at[number] = soak::nowNs();
    progress.actions = number + 1;
  };
  for (uint64_t number = 0; number < soak::Progress::kOps; ++number) {
    const soak::Op op = soak::opOf(seed, number, radius, voxel);
    if (op.kind == soak::Op::Kind::stroke) {
      session.beginStroke(op.tool);
      for (size_t i = 0; i < op.points.size(); ++i) {
        session.addPoint(0.001 * double(i), op.points[i]);
        acted();
        if (i % 2 == 0) session.publish();
        finishSave();
        next = std::max(next + std::chrono::milliseconds(1),
                        std::chrono::steady_clock::now() - std::chrono::milliseconds(50));
        std::this_thread::sleep_until(next);
      }
      session.endStroke();
    } else {
      if (op.kind == soak::Op::Kind::undo) session.undo();
      if (op.kind == soak::Op::Kind::redo) session.redo();
      if (op.kind == soak::Op::Kind::move)
        session.change("Move", [](engine::Document& d) { d.pieces[0].pose.translation.x() += 0.125; });
      acted();
    }
    progress.hash[number + 1] = soak::hashOf(*session.document());
    progress.ops = number + 1;
    finishSave();
    if (op.save && !saving) {
      engine::SaveRequest request{session.states(), session.undoSteps(), {}, opened.documentRecords, base, {}, writer};
      savedOps = number + 1;
      autosave.saving(file);
      saving.emplace([request, file, &saved](Job& job) { saved = engine::saveDocument(file, request, &job); });
    }
    const engine::Autosave::Counts counts = autosave.counts();
    progress.autosaveCpuS = counts.cpuS;
    progress.autosaveBytes = counts.bytes;
    progress.autosaveSteps = double(counts.steps);
  }
  return 0;
}
