#pragma once
// What an autosave is made of: its thread's side and what others reach. For engine/saving/autosave*.cpp alone.

#include <sys/stat.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "engine/saving/autosave.h"
#include "engine/saving/journal.h"
#include "io/records/journal_file.h"

namespace argil::engine {

struct Autosave::State {
  using Clock = std::chrono::steady_clock;
  struct StrokeBegan {
    Tool tool;
    StrokeImages images;
    WallTime at;
  };
  struct StrokeEnded {};
  struct Stepped {
    std::string label;
    DocumentPtr after;
    bool merged;
    WallTime at;
  };
  struct Went {
    size_t done;
    WallTime at;
  };
  struct Begun {
    std::vector<HistoryState> states;
    size_t done;
    std::shared_ptr<DocumentRecords> documentRecords;
    std::shared_ptr<const Base> base;
    std::string writer;
    std::optional<Autosave::Continued> continued;
    std::shared_ptr<SavedHistory> records;
  };
  struct Spilled {
    size_t state;
  };
  struct CameBack {
    size_t state;
    DocumentPtr document;
  };
  struct Saving {
    std::filesystem::path file;
  };
  struct Saved {
    std::shared_ptr<const Base> base;
  };
  using Event =
      std::variant<JournalPoint, StrokeBegan, StrokeEnded, Stepped, Went, Begun, Spilled, CameBack, Saving, Saved>;

  static constexpr uint64_t kNowhere = UINT64_MAX;

  State(const AutosaveOptions& given, std::function<void(const std::string&)> teller)
      : options(given), tell(std::move(teller)) {}

  void queue(Event event) {
    bool first;
    {
      const std::lock_guard lock(mutex);
      first = events.empty();
      events.push_back(std::move(event));
    }
    if (first) wake.notify_one();
  }

  void run();
  void turn(std::vector<Event>& batch);
  bool beginJournal();
  bool baseLost();
  void syncLoop();
  void askSync();
  void requireSynced();
  void putStates();
  void tellKept();
  void take(JournalPoint& point);
  void take(StrokeBegan& event);
  void take(StrokeEnded&);
  void take(Stepped& event);
  void take(Went& event);
  void take(Begun& event);
  void take(Spilled& event);
  void take(CameBack& event);
  void take(Saving& event);
  void take(Saved& event);

  /// The journal, when it can take an event now.
  io::JournalWriter* sound() { return journal && fits && !journal->broken() ? journal.get() : nullptr; }

  const AutosaveOptions options;
  const std::function<void(const std::string&)> tell;

  /// A layer of `records`, and the bytes of its journal with which something is there whole.
  struct Place {
    uint64_t layer = kNowhere, at = 0;
  };

  std::mutex mutex;  // guards these
  std::condition_variable wake, flushedOne;
  std::vector<Event> events;
  bool stop = false, leaving = false;
  uint64_t flushWanted = 0, flushed = 0;
  uint64_t turnWanted = 0, turned = 0;  // catching up
  Counts counts;
  // documents that can be read
  std::map<std::weak_ptr<const Document>, std::pair<io::RecordId, Place>, std::owner_less<>> known;
  // so much of that layer's journal is on the disk; of older ones all that an Entry counts on
  uint64_t syncedLayer = 0, syncedAt = 0;

  // The disk's thread: it alone waits for the disk, so that what was made goes on to the system meanwhile. Guarded by
  // the mutex too.
  std::condition_variable syncWake, syncIdle;
  std::shared_ptr<io::JournalWriter> toSync;
  uint64_t toSyncLayer = 0;
  bool syncing = false;
  std::string syncTrouble;
  std::vector<std::shared_ptr<io::JournalWriter>> retired;  // removed when the one after them is on the disk
  std::vector<std::filesystem::path> retiredFiles;

  // The thread's own.
  struct Entry {
    std::string label;
    DocumentPtr document;
    io::RecordId kept = 0;
    uint64_t number = 0;  // of the step in this journal; 0: from before
    bool stated = true;   // its document is in the journal or in the base
    Place place;          // where all of it can be read
    Place copy;           // and in a newer layer, which takes over once it is known to be on the disk
  };
  std::vector<Entry> history;
  size_t done = 0;
  std::shared_ptr<DocumentRecords> documentRecords;
  std::shared_ptr<const Base> base;
  struct stat baseSeen {};  // of its file, when that was last found to be the base
  std::string writer;
  uint64_t sequence = 0;  // of the writer's journals so far
  std::optional<Continued> continued;
  std::filesystem::path savingTo;  // a save that has not been heard of since
  std::optional<JournalStroke> stroke;
  size_t strokeWritten = 0;  // of its points
  std::shared_ptr<SavedHistory> records;
  std::shared_ptr<io::JournalWriter> journal;
  uint64_t layer = 0, layers = 0;  // the journal's, and how many there were; 0 is what the document began with
  uint64_t journalBegan = 0;       // bytes when it had begun
  io::RecordSet held;
  uint64_t number = 0;
  bool begin = false;   // a new journal is due; until it is there the old one goes on
  bool fits = false;    // the journal is of the document in work
  bool behind = false;  // some step has no document in it yet
  double retry = options.retryS;
  Clock::time_point retryAt{};
  bool troubled = false;
  uint64_t bytesBefore = 0;
  double syncBefore = 0;

  std::thread thread, disk;
};

}  // namespace argil::engine
