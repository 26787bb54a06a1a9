#pragma once
// What a crash left, and its way back into a session.

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/saving/autosave.h"
#include "engine/saving/journal.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"

namespace argil::engine {

/// What a crash left.
struct Recoverable {
  std::filesystem::path journal;
  std::filesystem::path file;                      ///< The document that it belongs to; empty: it was untitled.
  std::chrono::system_clock::time_point from, to;  ///< First and last thing in it.
  uint64_t steps = 0;                              ///< Since the last save.
  bool midStroke = false;                          ///< A stroke was cut off: it is ended where its samples end.
  uint64_t strokes = 0;                            ///< Known by their samples alone: a recovery repeats them.
  uint64_t leavesOut = 0;    ///< So many of the last of them, as the repetition of the first of these ended a program.
  bool damaged = false;      ///< Something of it cannot be read: a recovery brings what is whole, or repairs it.
  bool fileMissing = false;  ///< `file` cannot be read where it was: see RecoverChoice.
  std::string sentence;      ///< For the user: what and from when, or why nothing can be had.
  /// A recovery may bring something back.
  [[nodiscard]] bool some() const { return steps > 0 || midStroke || damaged; }
};

/// What a journal holds, read without its clay. Throws Error for a journal in which nothing can be found; one whose
/// work was all saved has zero steps and no stroke.
[[nodiscard]] Recoverable examine(const std::filesystem::path& journal);

/// How a journal is recovered.
struct RecoverChoice {
  /// Where the saved document under the journal lies by now; empty: where it was. Another document is refused.
  std::filesystem::path base;
  bool withoutLast = false;  ///< Leaves out the last of the strokes that would be repeated.
  bool repair = false;       ///< Where the saved document is missing: what the journal alone holds, its holes filled.
  /// A repetition that was noted under another name ended with the machine: that is no stroke's fault unless it happens
  /// twice.
  std::string boot = bootId();
};

/// A document as it was when its program ended.
struct Recovered {
  OpenedDocument document;  ///< Its base is null when the saved file has changed since, or is gone.
  /// Where states without a document are read, besides the base.
  std::vector<std::shared_ptr<io::RecordSource>> sources;
  std::optional<Autosave::Continued> continued;
  std::string writer;
  /// Strokes that are known by their samples alone, the last of them perhaps cut off: replay() does them in a session
  /// that begins with `document`.
  std::vector<JournalStroke> strokes;
  std::filesystem::path file;                  ///< The document that it belongs to; empty: untitled.
  std::string sentence;                        ///< What was recovered.
  std::shared_ptr<io::JournalReader> journal;  ///< With its lock: replay() notes there what it is about to do.
  std::string boot;                            ///< RecoverChoice::boot.
  std::optional<JournalReplay> before;         ///< A repetition that came to no end.
  uint64_t leftOut = 0;                        ///< The last strokes of the journal that are not in `strokes`,
  bool ended = false;                          ///< as the repetition of the first of them ended a program.
};

/// Throws Error when nothing can be had, or another Argil has it; Cancelled. The journal stays as it is.
[[nodiscard]] Recovered recover(const std::filesystem::path& journal, Job* job = nullptr,
                                const RecoverChoice& choice = {});

/// Does the strokes again, as they were, and ends them. What can no more be done (a piece that is gone) is left out;
/// returns how many were.
size_t replay(Session& session, const std::vector<JournalStroke>& strokes);
/// The same in a session of its own; the history of `recovered` then ends with what came of them, and no strokes are
/// left in it. Each is noted in the journal, on the disk, before it is begun: a stroke that ends the program does so
/// once, as the next recovery stops before it. So the journal has to stay until what comes back is on the disk:
/// Autosave::begin() sees to that. What hinders the notes (a full disk) is told in the document's notes. Throws
/// Cancelled: then nothing has changed. `watch` hears of the session.
size_t replay(Recovered& recovered, Job* job = nullptr, SessionWatch* watch = nullptr);

/// Journals in a folder that no living Argil has and that hold unsaved work, newest first. Removed are those without
/// any, and older ones of a document whose newest one was read to its end.
[[nodiscard]] std::vector<Recoverable> recoverable(const std::filesystem::path& folder);

}  // namespace argil::engine
