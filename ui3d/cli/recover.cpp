// argil recover: what crashed sessions left, and its way into a file.

#include <cstdio>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "clay/error.h"
#include "engine/kept_document.h"
#include "engine/recovery.h"
#include "engine/session.h"
#include "io/journal_file.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

std::string localTime(std::chrono::system_clock::time_point at) { return fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::localtime(std::chrono::system_clock::to_time_t(at))); }

}  // namespace

void recover(const RecoverOptions& options) {
  if (options.journal.empty()) {
    const auto found = engine::recoverable(io::journalFolder());
    for (const engine::Recoverable& each : found) {
      fmt::print("{}\n  {}\n", each.journal.string(), each.sentence);
      if (each.steps > 0) fmt::print("  from {} to {}\n", localTime(each.from), localTime(each.to));
    }
    fmt::print("{} to recover{}\n", found.empty() ? "nothing" : std::to_string(found.size()), found.empty() ? "" : ": argil recover JOURNAL -o FILE.argil");
    return;
  }
  if (options.output.empty()) throw Error("-o: name the document to write (.argil)");
  engine::Recovered recovered;
  {
    const ProgressLine line("reading " + options.journal.filename().string(), options.job);
    recovered = engine::recover(options.journal, options.job);
  }
  engine::OpenedDocument& document = recovered.document;
  engine::Session session(document.states, document.done);
  const size_t leftOut = engine::replay(session, recovered.strokes);
  engine::SaveRequest request;
  request.states = session.states();
  request.done = session.undoSteps();
  request.archive = document.archive;
  request.base = document.base;
  request.sources = recovered.sources;
  // The journal stays and may be recovered once more: ids that are given from here on are those of another work.
  request.writer = engine::newWriter();
  (void)engine::saveDocument(options.output, request, options.job);
  fmt::print("{}\n", recovered.sentence);
  for (const std::string& note : document.notes) fmt::print("{}\n", note);
  if (leftOut > 0) fmt::print("{} strokes could not be repeated and are left out.\n", leftOut);
  fmt::print("{}: saved; the journal is still there\n", options.output.string());
}

}  // namespace argil::cli
