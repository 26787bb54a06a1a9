#include "engine/saving/autosave.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <utility>

#include "clay/base/error.h"
#include "engine/saving/autosave_state.h"
#include "haptics/base/clock.h"

namespace argil::engine {
namespace {

constexpr std::chrono::seconds kMostCatchingUp{2};
constexpr std::chrono::seconds kLookEvery{1};  // at the saved file, while nothing happens

WallTime now() {
  return std::chrono::system_clock::now();
}

}  // namespace

// Puts the points that came since the last time.
void Autosave::State::take(JournalPoint& point) {
  if (stroke) stroke->points.push_back(point);
}

void Autosave::State::take(StrokeBegan& event) {
  stroke.emplace();
  stroke->tool = event.tool;
  stroke->images = event.images;
  strokeWritten = 0;
  if (io::JournalWriter* sink = sound()) putStrokeBegin(*sink, event.tool, event.images, event.at);
}

void Autosave::State::take(StrokeEnded&) {
  if (!stroke) return;
  if (io::JournalWriter* sink = sound()) {
    putStrokePoints(*sink, {stroke->points.begin() + std::ptrdiff_t(strokeWritten), stroke->points.end()});
    putStrokeEnd(*sink);
  }
  stroke.reset();
}

void Autosave::State::take(Stepped& event) {
  history.resize(done + 1);
  const bool merged = event.merged && done > 0;
  Entry entry{event.label, event.after, 0, ++number, false, {}, {}};
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

void Autosave::State::take(Went& event) {
  done = std::min(event.done, history.size() - 1);
  if (io::JournalWriter* sink = sound()) putWent(*sink, done, event.at);
}

void Autosave::State::take(Begun& event) {
  history.clear();
  for (HistoryState& state : event.states)
    history.push_back({std::move(state.label),
                       std::move(state.document),
                       state.kept,
                       0,
                       true,
                       {state.kept != 0 ? 0 : kNowhere, 0},
                       {}});
  records = std::move(event.records);
  done = event.done;
  documentRecords = std::move(event.documentRecords);
  base = std::move(event.base);
  baseSeen = {};
  writer = std::move(event.writer);
  if (continued) {
    // Another document was opened before a journal of ours stood for the recovered one: that was decided about.
    const std::lock_guard guard(mutex);
    retiredFiles.push_back(continued->journal);
  }
  continued = std::move(event.continued);
  sequence = continued ? continued->sequence : 0;
  stroke.reset();
  savingTo.clear();
  begin = true;
  fits = false;
  retryAt = {};
}

void Autosave::State::take(Spilled& event) {
  if (event.state < history.size() && history[event.state].place.layer != kNowhere)
    history[event.state].document.reset();
}

void Autosave::State::take(CameBack& event) {
  if (event.state < history.size()) history[event.state].document = std::move(event.document);
}

void Autosave::State::take(Saving& event) {
  savingTo = std::move(event.file);
  if (io::JournalWriter* sink = sound()) putSaving(*sink, savingTo);
}

void Autosave::State::take(Saved& event) {
  base = std::move(event.base);
  baseSeen = {};
  savingTo.clear();
  begin = true;
  retryAt = {};
}

// The saved file under the journal is another one by now, or gone: what the journal takes for kept there is not.
bool Autosave::State::baseLost() {
  if (!base || !savingTo.empty()) return false;  // a save of our own changes it
  struct stat now {};
  if (::stat(base->path.c_str(), &now) != 0) return true;
  if (now.st_ino == baseSeen.st_ino && now.st_dev == baseSeen.st_dev && now.st_size == baseSeen.st_size &&
      now.st_mtim.tv_sec == baseSeen.st_mtim.tv_sec && now.st_mtim.tv_nsec == baseSeen.st_mtim.tv_nsec) {
    return false;
  }
  try {
    if (!isStill(*base)) return true;
    baseSeen = now;
  } catch (const Error&) {
    // Somebody is writing to it: the next turn tells.
  }
  return false;
}

void Autosave::State::turn(std::vector<Event>& batch) {
  try {
    for (Event& event : batch) {
      try {
        std::visit([this](auto& each) { take(each); }, event);
      } catch (const Error&) {
        // The journal is broken; what it should have got is in the next one, as what is known here goes on.
        if (!journal || !journal->broken()) throw;
      }
    }
    if (!documentRecords || options.folder.empty()) return;
    requireSynced();
    if (baseLost()) {
      // The next journal builds on nothing: it holds all that is in memory, and what the old file, which is still open,
      // gives.
      base.reset();
      begin = true;
      retryAt = {};
    }
    if (journal && journal->bytes() - journalBegan > options.rollBytes) begin = true;
    bool fresh = false;
    if (begin || !sound()) {
      if (Clock::now() >= retryAt)
        fresh = beginJournal();
      else if (!sound())
        return;
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

void Autosave::State::askSync() {
  {
    const std::lock_guard lock(mutex);
    toSync = journal;
    toSyncLayer = layer;
  }
  syncWake.notify_one();
}

// What the disk's thread met is told here, where all else is.
void Autosave::State::requireSynced() {
  const std::lock_guard lock(mutex);
  if (!syncTrouble.empty()) throw Error(std::exchange(syncTrouble, {}), Error::Kind::work);
}

void Autosave::State::syncLoop() {
  (void)pthread_setname_np(pthread_self(), "argil-disk");
  std::unique_lock lock(mutex);
  for (;;) {
    syncWake.wait(lock, [this] { return stop || toSync; });
    if (!toSync) break;
    const auto behindUs = std::exchange(toSync, nullptr);
    const uint64_t behindLayer = toSyncLayer;
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
    if (behindLayer >= syncedLayer) {
      syncedLayer = behindLayer;
      syncedAt = behindUs->synced();
    }
    if (!trouble.empty()) {
      retired.insert(retired.end(), old.begin(), old.end());
      retiredFiles.insert(retiredFiles.end(), oldFiles.begin(), oldFiles.end());
      syncTrouble = std::move(trouble);
    }
    syncIdle.notify_all();
  }
}

void Autosave::State::run() {
  (void)pthread_setname_np(pthread_self(), "argil-autosave");
  std::vector<Event> batch;
  std::unique_lock lock(mutex);
  for (;;) {
    const auto hurry = [this] { return stop || flushWanted != flushed || turnWanted != turned; };
    const auto due = [&] { return hurry() || !events.empty(); };
    if (troubled || begin || behind) {
      wake.wait_for(lock, std::chrono::duration<double>(options.retryS), due);
    } else if (base) {
      wake.wait_for(lock, kLookEvery, due);
    } else {
      wake.wait(lock, due);
    }
    // What comes within a moment goes to the disk together.
    wake.wait_for(lock, std::chrono::duration<double>(options.syncS), hurry);
    if (stop) break;
    batch.swap(events);
    const uint64_t flushing = flushWanted, turning = turnWanted;
    if (flushing != flushed) retryAt = {};
    lock.unlock();
    turn(batch);
    batch.clear();
    lock.lock();
    turned = turning;
    if (flushing != flushed) {
      flushedOne.notify_all();
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
    counts.cpuS = 1e-9 * double(haptics::threadWorkNs());
  }
}

Autosave::Autosave(const AutosaveOptions& options, std::function<void(const std::string&)> tell)
    : state_(std::make_unique<State>(options, std::move(tell))) {
  state_->thread = std::thread([state = state_.get()] { state->run(); });
  try {
    state_->disk = std::thread([state = state_.get()] { state->syncLoop(); });
  } catch (...) {  // a system without threads: the first must not be left running
    {
      const std::lock_guard lock(state_->mutex);
      state_->stop = true;
    }
    state_->wake.notify_one();
    state_->thread.join();
    throw;
  }
}

Autosave::~Autosave() {
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
  for (const State::Event& event : state_->events) {
    if (const State::Begun* begun = std::get_if<State::Begun>(&event); begun && begun->continued)
      state_->retiredFiles.push_back(begun->continued->journal);
  }
  for (const auto& each : state_->retiredFiles) {
    std::error_code ignored;
    std::filesystem::remove(each, ignored);
  }
}

void Autosave::leave() {
  flush();
  const std::lock_guard lock(state_->mutex);
  state_->leaving = true;
}

std::shared_ptr<SavedHistory> Autosave::begin(std::vector<HistoryState> states, size_t done,
                                              std::shared_ptr<DocumentRecords> documentRecords,
                                              std::shared_ptr<const Base> base, const std::string& writer,
                                              std::optional<Continued> continued,
                                              const std::vector<std::shared_ptr<io::RecordSource>>& sources) {
  auto records = std::make_shared<SavedHistory>();
  SavedHistory::Layer first{0, sources, recordsOf(base, true)};
  if (continued && sources.empty()) first.journals = {continued->source};
  records->add(std::move(first));
  state_->queue(State::Begun{std::move(states), done, std::move(documentRecords), std::move(base), writer,
                             std::move(continued), records});
  return records;
}

void Autosave::saving(const std::filesystem::path& file) {
  state_->queue(State::Saving{file.empty() ? file : std::filesystem::absolute(file)});
}

void Autosave::saved(std::shared_ptr<const Base> base) {
  state_->queue(State::Saved{std::move(base)});
}

void Autosave::flush() {
  std::unique_lock lock(state_->mutex);
  const uint64_t wanted = ++state_->flushWanted;
  state_->wake.notify_one();
  state_->flushedOne.wait(lock, [&] { return state_->flushed >= wanted || state_->stop; });
}

void Autosave::catchUp() {
  std::unique_lock lock(state_->mutex);
  const uint64_t wanted = ++state_->turnWanted;
  state_->wake.notify_one();
  state_->flushedOne.wait_for(lock, kMostCatchingUp, [&] { return state_->turned >= wanted || state_->stop; });
}

uint64_t Autosave::kept(const DocumentPtr& document) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->known.find(document);
  if (found == state_->known.end()) return 0;
  const auto& [id, place] = found->second;
  return place.layer < state_->syncedLayer || (place.layer == state_->syncedLayer && place.at <= state_->syncedAt) ? id
                                                                                                                   : 0;
}

Autosave::Counts Autosave::counts() const {
  const std::lock_guard lock(state_->mutex);
  return state_->counts;
}

void Autosave::strokeBegan(const Tool& tool, const StrokeImages& images) {
  state_->queue(State::StrokeBegan{tool, images, now()});
}
void Autosave::strokePoint(const PathPoint& point) {
  state_->queue(JournalPoint{point, false});
}
void Autosave::toolLifted() {
  state_->queue(JournalPoint{{}, true});
}
void Autosave::strokeEnded() {
  state_->queue(State::StrokeEnded{});
}
void Autosave::stepped(const std::string& label, const DocumentPtr& after, bool merged) {
  state_->queue(State::Stepped{label, after, merged, now()});
}
void Autosave::went(size_t done) {
  state_->queue(State::Went{done, now()});
}
void Autosave::spilled(size_t state) {
  state_->queue(State::Spilled{state});
}
void Autosave::cameBack(size_t state, const DocumentPtr& document) {
  state_->queue(State::CameBack{state, document});
}

DocumentPtr readStep(Autosave& autosave, DocumentRecords& documentRecords, const std::shared_ptr<SavedHistory>& records,
                     uint64_t kept, const Document& near) {
  const auto known = [&] {
    const auto lock = documentRecords.lock();
    return documentRecords.knowsClay(near);
  };
  if (known()) {
    try {
      return readState(documentRecords, nullptr, {records}, kept, near);
    } catch (const Error&) {
      // What is known may be in a save that is not done, or was given up.
    }
  }
  autosave.catchUp();
  try {
    return readState(documentRecords, nullptr, {records}, kept, near);
  } catch (const Error&) {
    return readState(documentRecords, nullptr, {records}, kept, Document());
  }
}

}  // namespace argil::engine
