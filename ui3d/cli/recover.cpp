// argil recover: what crashed sessions left, and its way into a file.

#include <cstdio>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "clay/base/error.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/session/recovery.h"
#include "io/bytes/output_files.h"
#include "io/records/journal_file.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

std::string localTime(std::chrono::system_clock::time_point at) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::localtime(std::chrono::system_clock::to_time_t(at)));
}

// Names the saved document that a journal builds on; nothing where the journal cannot say.
std::filesystem::path baseOf(const std::filesystem::path& journal) {
  try {
    return engine::examine(journal).file;
  } catch (const Error&) {
    return {};  // engine::recover() repairs such a journal, or tells what is wrong.
  }
}

}  // namespace

void recover(const RecoverOptions& options) {
  if (options.journal.empty()) {
    const auto found = engine::recoverable(io::journalFolder());
    for (const engine::Recoverable& each : found) {
      fmt::print("{}\n  {}\n", each.journal.string(), each.sentence);
      if (each.steps > 0) fmt::print("  from {} to {}\n", localTime(each.from), localTime(each.to));
      if (each.fileMissing)
        fmt::print("  --base FILE names where {} lies by now; --repair does without it\n", each.file.string());
      if (each.strokes > 0 && each.leavesOut == 0)
        fmt::print("  --without-last leaves out the stroke that was under way\n");
    }
    fmt::print("{} to recover{}\n", found.empty() ? "nothing" : std::to_string(found.size()),
               found.empty() ? "" : ": argil recover JOURNAL -o FILE.argil");
    return;
  }
  if (options.output.empty()) throw Error("-o: name the document to write (.argil)");
  const io::Files inputs{options.journal, options.base.empty() ? baseOf(options.journal) : options.base};
  io::requireNewFiles(inputs, {&options.output, 1}, options.overwrite);
  engine::Recovered recovered;
  engine::RecoverChoice choice;
  choice.base = options.base;
  choice.withoutLast = options.withoutLast;
  choice.repair = options.repair;
  {
    const ProgressLine line("reading " + options.journal.filename().string(), options.job);
    recovered = engine::recover(options.journal, options.job, choice);
  }
  size_t leftOut = 0;
  if (!recovered.strokes.empty()) {
    const ProgressLine line("repeating the last strokes", options.job);
    leftOut = engine::replay(recovered, options.job);
  }
  const engine::OpenedDocument& document = recovered.document;
  engine::SaveRequest request;
  request.states = document.states;
  request.done = document.done;
  request.documentRecords = document.documentRecords;
  request.base = document.base;
  request.sources = recovered.sources;
  // The journal stays and may be recovered once more: ids that are given from here on are those of another work.
  request.writer = engine::newWriter();
  if (const auto base = engine::saveDocument(options.output, request, options.job); !base->unflushed.empty())
    throw Error(base->unflushed, Error::Kind::work);
  fmt::print("{}\n", recovered.sentence);
  for (const std::string& note : document.notes) fmt::print("{}\n", note);
  if (leftOut > 0) fmt::print("{} strokes could not be repeated and are left out.\n", leftOut);
  fmt::print("{}: saved; the journal is still there\n", options.output.string());
}

}  // namespace argil::cli
