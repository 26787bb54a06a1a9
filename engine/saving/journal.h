#pragma once
// What a journal says, apart from clay: what the document was when it began, and every thing done since.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/saving/session.h"
#include "io/records/clay_records.h"
#include "io/records/journal_file.h"
#include "io/records/record.h"

namespace argil::engine {

using WallTime = std::chrono::system_clock::time_point;

struct JournalBegin {
  std::string writer;
  /// Counts the journals of this writer from 1: of two the one with the higher number was begun later, whatever the
  /// clock said. 0: written before there were numbers.
  uint64_t sequence = 0;
  /// Of the Argil that wrote it, as io::kDocumentSchema: above ours, its texts may have keys that are not known.
  uint64_t schema = 0;
  std::filesystem::path file;  ///< The saved document under it; empty: none.
  uint64_t stamp = 0;          ///< Of that document's last save, which names it; 0: none.
  /// Label and record of the history; records are in the journal or in the file.
  std::vector<std::pair<std::string, io::RecordId>> states;
  size_t done = 0;
  io::RecordId savedState = 0;  ///< What the file holds; 0: none.
  WallTime at{};
};

struct JournalPoint {
  PathPoint point;
  bool lift = false;  ///< No point: the tool was lifted.
};

struct JournalStroke {
  Tool tool;
  StrokeImages images;
  std::vector<JournalPoint> points;
  bool ended = false;  ///< False: it was cut off.
};

// One function a kind of record. Throw what the sink throws.
void putBegin(io::RecordSink& sink, const JournalBegin& begin, io::RecordIds& ids, io::RecordSet& held);
/// A step was done; `number` counts them from 1 in this journal. A stroke that it came of is still open. What it led to
/// is told by putState() when it is in the journal.
void putStep(io::RecordSink& sink, uint64_t number, const std::string& label, bool merged, WallTime at);
void putState(io::RecordSink& sink, uint64_t number, io::RecordId state);
void putWent(io::RecordSink& sink, size_t done, WallTime at);
/// A save to this file is about to be tried.
void putSaving(io::RecordSink& sink, const std::filesystem::path& file);
void putStrokeBegin(io::RecordSink& sink, const Tool& tool, const StrokeImages& images, WallTime at);
void putStrokePoints(io::RecordSink& sink, const std::vector<JournalPoint>& points);
void putStrokeEnd(io::RecordSink& sink);

/// A recovery is about to repeat a stroke.
struct JournalReplay {
  uint64_t stroke = 0;  ///< Counted from the last one of the journal, which is 1. 0: none.
  std::string boot;     ///< Of the machine: as bootId() says it.
  uint64_t times = 1;   ///< So many recoveries in a row have begun to repeat it.
};
/// On the disk when it returns; stroke 0: none is being repeated any more. Throws Error (kind work).
void putReplay(io::JournalReader& journal, const JournalReplay& replay);
/// Names the time since the machine was started: what was under way under another name ended with the machine. Empty
/// where the system does not say.
[[nodiscard]] std::string bootId();

/// What became of it all.
struct JournalStory {
  JournalBegin begin;
  /// History as it was at the end, as far as documents of it are in the journal.
  std::vector<std::pair<std::string, io::RecordId>> states;
  struct Led {
    std::vector<JournalStroke> strokes;  ///< From the state before it in the list on, as far as they are known.
    bool all = false;                    ///< They are all that led to it.
  };
  std::vector<Led> ledBy;  ///< Of each state.
  size_t done = 0;
  std::vector<JournalStroke> strokes;  ///< Done after states[done], known by their samples; the last may be cut off.
  WallTime last{};
  std::filesystem::path saving;         ///< The file of the last save that was tried; empty: none.
  uint64_t unread = 0;                  ///< Things that were damaged, or came after a damaged one on which they depend.
  uint64_t damaged = 0;                 ///< Places in the file in which anything may have stood.
  std::optional<JournalReplay> replay;  ///< A recovery had begun to repeat this stroke and did not come to its end.
};
/// Any bytes are allowed. What is told is true: behind a damaged place, where an event may be missing, strokes count
/// only from a step on whose document is there. Throws Error (kind work) when there is no begin.
[[nodiscard]] JournalStory readStory(io::JournalReader& journal);

}  // namespace argil::engine
