#pragma once
// What a crash left, and its way back into a session.

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/journal.h"
#include "engine/keeper.h"
#include "engine/kept_document.h"
#include "engine/session.h"

namespace argil::engine {

/// What a crash left.
struct Recoverable {
  std::filesystem::path journal;
  std::filesystem::path file;        ///< The document that it belongs to; empty: it was untitled.
  std::chrono::system_clock::time_point from, to;  ///< First and last thing in it.
  uint64_t steps = 0;                ///< Since the last save.
  bool midStroke = false;            ///< A stroke was cut off: it is ended where its samples end.
  std::string sentence;              ///< For the person: what and from when, or why nothing can be had.
};

/// What a journal holds, read without its clay. Throws Error for a journal in which nothing can be found; one whose work was all saved has zero steps and no stroke.
[[nodiscard]] Recoverable examine(const std::filesystem::path& journal);

/// A document as it was when its program ended.
struct Recovered {
  OpenedDocument document;               ///< Its base is null when the saved file has changed since, or is gone.
  std::vector<std::shared_ptr<io::RecordSource>> sources;  ///< Where states without a document are read, besides the base.
  std::optional<Keeper::Continued> continued;
  std::string writer;
  /// Strokes that are known by their samples alone, the last of them perhaps cut off: replay() does them in the session that begins with `document`.
  std::vector<JournalStroke> strokes;
  std::filesystem::path file;            ///< The document that it belongs to; empty: untitled.
  std::string sentence;                  ///< What was recovered.
};

/// Throws Error when nothing can be had, or another Argil has it; Cancelled. The journal stays as it is.
[[nodiscard]] Recovered recover(const std::filesystem::path& journal, Job* job = nullptr);

/// Does the strokes again, as they were, and ends them. What can no more be done (a piece that is gone) is left out; returns how many were.
size_t replay(Session& session, const std::vector<JournalStroke>& strokes);

/// Journals in a folder that no living Argil has and that hold unsaved work, newest first; those without are removed.
[[nodiscard]] std::vector<Recoverable> recoverable(const std::filesystem::path& folder);

}  // namespace argil::engine
