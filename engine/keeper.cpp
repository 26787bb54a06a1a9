#include "engine/keeper.h"

#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <variant>

#include "clay/error.h"
#include "engine/journal.h"
#include "io/journal_file.h"

namespace argil::engine {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kMostWait{100};
constexpr size_t kHistoryKept = 100;  // steps that a new journal takes over, besides those that can be redone

WallTime now() { return std::chrono::system_clock::now(); }

double threadCpuS() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// Names sort by time; a program can begin several in a second.
std::filesystem::path journalName(const std::filesystem::path& folder) {
  static std::atomic<unsigned> count{0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now().time_since_epoch()).count();
  return folder / fmt::format("{:015}-{}-{}.journal", ms, getpid(), count++);
}

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
  std::shared_ptr<Archive> archive;
  std::shared_ptr<const Base> base;
  std::string writer;
  std::optional<Keeper::Continued> continued;
};
struct Saving {
  std::filesystem::path file;
};
struct Saved {
  std::shared_ptr<const Base> base;
};
using Event = std::variant<JournalPoint, StrokeBegan, StrokeEnded, Stepped, Went, Begun, Saving, Saved>;

}  // namespace

struct Keeper::State {
  State(const KeeperOptions& given, std::function<void(const std::string&)> teller) : options(given), tell(std::move(teller)) {}

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
  void syncLoop();
  void askSync();
  void requireSynced();
  void putStates();
  void take(JournalPoint& point);
  void take(StrokeBegan& event);
  void take(StrokeEnded&);
  void take(Stepped& event);
  void take(Went& event);
  void take(Begun& event);
  void take(Saving& event);
  void take(Saved& event);

  /// The journal, when it can take an event now.
  io::JournalWriter* sound() { return journal && fits && !journal->broken() ? journal.get() : nullptr; }

  const KeeperOptions options;
  const std::function<void(const std::string&)> tell;

  std::mutex mutex;  // guards these
  std::condition_variable wake, flushedOne;
  std::vector<Event> events;
  bool stop = false, leaving = false;
  uint64_t flushWanted = 0, flushed = 0;
  Counts counts;

  // The disk's thread: it alone waits for the disk, so that what was made goes on to the system meanwhile. Guarded by the mutex too.
  std::condition_variable syncWake, syncIdle;
  std::shared_ptr<io::JournalWriter> toSync;
  bool syncing = false;
  std::string syncTrouble;
  std::vector<std::shared_ptr<io::JournalWriter>> retired;  // removed when the one after them is on the disk
  std::vector<std::filesystem::path> retiredFiles;

  // The thread's own.
  struct Entry {
    std::string label;
    DocumentPtr document;
    io::RecordId kept = 0;
    uint64_t number = 0;   // of the step in this journal; 0: from before
    bool stated = true;    // its document is in the journal or in the base
  };
  std::vector<Entry> history;
  size_t done = 0;
  std::shared_ptr<Archive> archive;
  std::shared_ptr<const Base> base;
  std::string writer;
  std::optional<Continued> continued;
  std::filesystem::path savingTo;   // a save that has not been heard of since
  std::optional<JournalStroke> stroke;
  size_t strokeWritten = 0;      // of its points
  std::shared_ptr<io::JournalWriter> journal;
  uint64_t journalBegan = 0;     // bytes when it had begun
  io::RecordSet held;
  uint64_t number = 0;
  bool begin = false;            // a new journal is due; until it is there the old one goes on
  bool fits = false;             // the journal is of the document in work
  bool behind = false;           // some step has no document in it yet
  double retry = options.retryS;
  Clock::time_point retryAt{};
  bool troubled = false;
  uint64_t bytesBefore = 0;
  double syncBefore = 0;

  std::thread thread, disk;
};

// Puts the points that came since the last time.
void Keeper::State::take(JournalPoint& point) {
  if (stroke) stroke->points.push_back(point);
}

void Keeper::State::take(StrokeBegan& event) {
  stroke.emplace();
  stroke->tool = event.tool;
  stroke->images = event.images;
  strokeWritten = 0;
  if (io::JournalWriter* sink = sound()) putStrokeBegin(*sink, event.tool, event.images, event.at);
}

void Keeper::State::take(StrokeEnded&) {
  if (!stroke) return;
  if (io::JournalWriter* sink = sound()) {
    putStrokePoints(*sink, {stroke->points.begin() + std::ptrdiff_t(strokeWritten), stroke->points.end()});
    putStrokeEnd(*sink);
  }
  stroke.reset();
}

void Keeper::State::take(Stepped& event) {
  history.resize(done + 1);
  const bool merged = event.merged && done > 0;
  Entry entry{event.label, event.after, 0, ++number, false};
  if (merged) {
    history.back() = std::move(entry);
  } else {
    history.push_back(std::move(entry));
    ++done;
  }
  if (io::JournalWriter* sink = sound()) {
    if (stroke) {
      putStrokePoints(*sink, {stroke->points.begin() + std::ptrdiff_t(strokeWritten), stroke->points.end()});
      strokeWritten = stroke->points.size();
    }
    putStep(*sink, number, event.label, merged, event.at);
  }
}

void Keeper::State::take(Went& event) {
  done = std::min(event.done, history.size() - 1);
  if (io::JournalWriter* sink = sound()) putWent(*sink, done, event.at);
}

void Keeper::State::take(Begun& event) {
  history.clear();
  for (HistoryState& state : event.states) history.push_back({std::move(state.label), std::move(state.document), state.kept, 0, true});
  done = event.done;
  archive = std::move(event.archive);
  base = std::move(event.base);
  writer = std::move(event.writer);
  continued = std::move(event.continued);
  stroke.reset();
  savingTo.clear();
  begin = true;
  fits = false;
  retryAt = {};
}

void Keeper::State::take(Saving& event) {
  savingTo = std::move(event.file);
  if (io::JournalWriter* sink = sound()) putSaving(*sink, savingTo);
}

void Keeper::State::take(Saved& event) {
  base = std::move(event.base);
  savingTo.clear();
  begin = true;
  retryAt = {};
}

// False when the archive is not to be had and there is a journal that can go on.
bool Keeper::State::beginJournal() {
  begin = true;  // until it is there
  Archive::Lock lock = sound() ? archive->tryLock(kMostWait) : archive->lock();
  if (!lock) return false;
  auto fresh = std::make_shared<io::JournalWriter>(journalName(options.folder));
  try {
    io::RecordSet freshHeld;
    if (base) freshHeld = base->held;
    JournalBegin head;
    head.writer = writer;
    if (base) {
      head.file = std::filesystem::absolute(base->path);
      head.save = base->save;
      head.savedState = base->state;
    }
    head.at = now();
    {
      const size_t first = done > kHistoryKept ? done - kHistoryKept : 0;
      head.done = done;
      for (size_t i = 0; i < history.size(); ++i) {
        Entry& entry = history[i];
        io::RecordId kept = freshHeld.contains(entry.kept) ? entry.kept : 0;  // 0: its place in the history stays, but no file has it
        if (kept == 0 && i >= first) {
          try {
            if (entry.document) {
              kept = archive->put(entry.document, freshHeld, *fresh, io::RecordCodec::raw);
            } else if (continued) {
              archive->copy(*continued->source, entry.kept, freshHeld, *fresh);
              kept = entry.kept;
            }
          } catch (const Error&) {
            if (entry.document || fresh->broken()) throw;
          }
        }
        if (kept != 0) entry.kept = kept;
        entry.stated = true;
        entry.number = 0;
        head.states.emplace_back(entry.label, kept);
      }
      putBegin(*fresh, head, archive->ids(), freshHeld);
      std::vector<DocumentPtr> inUse;
      for (const Entry& entry : history) inUse.push_back(entry.document);
      archive->tidy(inUse);
    }
    lock.unlock();
    if (!savingTo.empty()) putSaving(*fresh, savingTo);
    if (stroke) {
      putStrokeBegin(*fresh, stroke->tool, stroke->images, head.at);
      putStrokePoints(*fresh, stroke->points);
      strokeWritten = stroke->points.size();
    }
    fresh->write();
    held = std::move(freshHeld);
  } catch (...) {
    fresh->remove();
    throw;
  }
  if (journal) {
    bytesBefore += journal->bytes();
    syncBefore += journal->syncSeconds();
  }
  {
    const std::lock_guard guard(mutex);
    if (journal) retired.push_back(std::move(journal));
    if (continued) retiredFiles.push_back(continued->journal);
    syncTrouble.clear();  // of the one before
  }
  continued.reset();
  journal = std::move(fresh);
  askSync();
  journalBegan = journal->bytes();
  number = 0;
  begin = false;
  fits = true;
  const std::lock_guard guard(mutex);
  ++counts.generations;
  return true;
}

void Keeper::State::putStates() {
  if (std::none_of(history.begin(), history.end(), [](const Entry& e) { return !e.stated; })) return;
  // What happened is with the system already; documents come when nobody keeps the archive waiting.
  journal->write();
  const Archive::Lock lock = archive->tryLock(kMostWait);
  behind = !lock.owns_lock();
  if (behind) return;
  uint64_t put = 0;
  for (Entry& entry : history) {
    if (entry.stated || !entry.document) continue;
    entry.kept = archive->put(entry.document, held, *journal, io::RecordCodec::raw);
    putState(*journal, entry.number, entry.kept);
    entry.stated = true;
    ++put;
  }
  const std::lock_guard guard(mutex);
  counts.steps += put;
}

void Keeper::State::turn(std::vector<Event>& batch) {
  try {
    for (Event& event : batch) {
      try {
        std::visit([this](auto& each) { take(each); }, event);
      } catch (const Error&) {
        // The journal is broken; what it should have got is in the next one, as what is known here goes on.
        if (!journal || !journal->broken()) throw;
      }
    }
    if (!archive || options.folder.empty()) return;
    requireSynced();
    if (journal && journal->bytes() - journalBegan > options.rollBytes) begin = true;
    bool fresh = false;
    if (begin || !sound()) {
      if (Clock::now() >= retryAt) fresh = beginJournal();
      else if (!sound()) return;
    }
    if (!fresh) {
      if (stroke) {
        putStrokePoints(*journal, {stroke->points.begin() + std::ptrdiff_t(strokeWritten), stroke->points.end()});
        strokeWritten = stroke->points.size();
      }
      putStates();
      journal->write();
      askSync();
    }
    retry = options.retryS;
    if (std::exchange(troubled, false)) tell("");
  } catch (const std::exception& e) {
    retryAt = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(retry));
    retry = std::min(2 * retry, options.mostRetryS);
    begin = true;
    troubled = true;
    tell(fmt::format("The journal cannot be kept: {}. Work goes on in memory: save it, or make room.", e.what()));
  }
}

void Keeper::State::askSync() {
  {
    const std::lock_guard lock(mutex);
    toSync = journal;
  }
  syncWake.notify_one();
}

// What the disk's thread met is told here, where all else is.
void Keeper::State::requireSynced() {
  const std::lock_guard lock(mutex);
  if (!syncTrouble.empty()) throw Error(std::exchange(syncTrouble, {}), Error::Kind::work);
}

void Keeper::State::syncLoop() {
  std::unique_lock lock(mutex);
  for (;;) {
    syncWake.wait(lock, [this] { return stop || toSync; });
    if (!toSync) break;
    const auto behindUs = std::exchange(toSync, nullptr);
    const auto old = std::exchange(retired, {});
    const auto oldFiles = std::exchange(retiredFiles, {});
    syncing = true;
    lock.unlock();
    std::string trouble;
    try {
      behindUs->sync();
      for (const auto& each : old) each->remove();
      for (const auto& each : oldFiles) {
        std::error_code ignored;
        std::filesystem::remove(each, ignored);
      }
    } catch (const Error& e) {
      trouble = e.what();
    }
    lock.lock();
    syncing = false;
    if (!trouble.empty()) {
      retired.insert(retired.end(), old.begin(), old.end());
      retiredFiles.insert(retiredFiles.end(), oldFiles.begin(), oldFiles.end());
      syncTrouble = std::move(trouble);
    }
    syncIdle.notify_all();
  }
}

void Keeper::State::run() {
  std::vector<Event> batch;
  std::unique_lock lock(mutex);
  for (;;) {
    const auto due = [this] { return stop || !events.empty() || flushWanted != flushed; };
    if (troubled || begin || behind) {
      wake.wait_for(lock, std::chrono::duration<double>(options.retryS), due);
    } else {
      wake.wait(lock, due);
    }
    // What comes within a moment goes to the disk together.
    wake.wait_for(lock, std::chrono::duration<double>(options.syncS), [this] { return stop || flushWanted != flushed; });
    if (stop) break;
    batch.swap(events);
    const uint64_t flushing = flushWanted;
    if (flushing != flushed) retryAt = {};
    lock.unlock();
    turn(batch);
    batch.clear();
    lock.lock();
    if (flushing != flushed) {
      syncIdle.wait(lock, [this] { return stop || (!toSync && !syncing); });
      if (!syncTrouble.empty()) {
        lock.unlock();
        turn(batch);
        lock.lock();
      }
    }
    flushed = flushing;
    flushedOne.notify_all();
    counts.bytes = bytesBefore + (journal ? journal->bytes() : 0);
    counts.syncS = syncBefore + (journal ? journal->syncSeconds() : 0);
    counts.cpuS = threadCpuS();
  }
}

Keeper::Keeper(const KeeperOptions& options, std::function<void(const std::string&)> tell) : state_(std::make_unique<State>(options, std::move(tell))) {
  state_->thread = std::thread([state = state_.get()] { state->run(); });
  state_->disk = std::thread([state = state_.get()] { state->syncLoop(); });
}

Keeper::~Keeper() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->wake.notify_one();
  state_->syncIdle.notify_all();
  state_->thread.join();
  state_->syncWake.notify_one();
  state_->disk.join();
  for (const auto& each : state_->retired) each->remove();
  if (state_->leaving) return;
  if (state_->journal) state_->journal->remove();
  // What was taken over and is not in a journal of ours yet was decided about too.
  if (state_->continued) state_->retiredFiles.push_back(state_->continued->journal);
  for (const Event& event : state_->events) {
    if (const Begun* begun = std::get_if<Begun>(&event); begun && begun->continued) state_->retiredFiles.push_back(begun->continued->journal);
  }
  for (const auto& each : state_->retiredFiles) {
    std::error_code ignored;
    std::filesystem::remove(each, ignored);
  }
}

void Keeper::leave() {
  flush();
  const std::lock_guard lock(state_->mutex);
  state_->leaving = true;
}

void Keeper::begin(std::vector<HistoryState> states, size_t done, std::shared_ptr<Archive> archive, std::shared_ptr<const Base> base, const std::string& writer,
                   std::optional<Continued> continued) {
  state_->queue(Begun{std::move(states), done, std::move(archive), std::move(base), writer, std::move(continued)});
}

void Keeper::saving(const std::filesystem::path& file) { state_->queue(Saving{std::filesystem::absolute(file)}); }

void Keeper::saved(std::shared_ptr<const Base> base) { state_->queue(Saved{std::move(base)}); }

void Keeper::flush() {
  std::unique_lock lock(state_->mutex);
  const uint64_t wanted = ++state_->flushWanted;
  state_->wake.notify_one();
  state_->flushedOne.wait(lock, [&] { return state_->flushed >= wanted || state_->stop; });
}

Keeper::Counts Keeper::counts() const {
  const std::lock_guard lock(state_->mutex);
  return state_->counts;
}

void Keeper::strokeBegan(const Tool& tool, const StrokeImages& images) { state_->queue(StrokeBegan{tool, images, now()}); }
void Keeper::strokePoint(const PathPoint& point) { state_->queue(JournalPoint{point, false}); }
void Keeper::toolLifted() { state_->queue(JournalPoint{{}, true}); }
void Keeper::strokeEnded() { state_->queue(StrokeEnded{}); }
void Keeper::stepped(const std::string& label, const DocumentPtr& after, bool merged) { state_->queue(Stepped{label, after, merged, now()}); }
void Keeper::went(size_t done) { state_->queue(Went{done, now()}); }

}  // namespace argil::engine
