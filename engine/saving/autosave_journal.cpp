// What a journal begins with, and the documents that it gets.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <utility>

#include "clay/base/error.h"
#include "engine/saving/autosave_state.h"

namespace argil::engine {
namespace {

constexpr std::chrono::milliseconds kMostWait{100};
constexpr size_t kHistoryKept = 100;  // steps that a new journal takes over, besides those that can be redone

// Names sort by time; a program can begin several in a second.
std::filesystem::path journalName(const std::filesystem::path& folder, WallTime now) {
  static std::atomic<unsigned> count{0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
  return folder / fmt::format("{:015}-{}-{}.journal", ms, getpid(), count++);
}

}  // namespace

// False when the records are not to be had and there is a journal that can go on.
bool Autosave::State::beginJournal() {
  begin = true;  // until it is there
  DocumentRecords::Lock lock = sound() ? documentRecords->tryLock(kMostWait) : documentRecords->lock();
  if (!lock) return false;
  const WallTime now = std::chrono::system_clock::now();
  auto fresh = std::make_shared<io::JournalWriter>(journalName(options.folder, now), options.unnamed);
  try {
    io::RecordSet freshHeld;
    if (base) freshHeld = base->held;
    JournalBegin head;
    head.writer = writer;
    head.sequence = ++sequence;
    if (base) {
      head.file = std::filesystem::absolute(base->path);
      head.stamp = base->stamp;
      head.savedState = base->state;
    }
    head.at = now;
    std::vector<bool> here(history.size());
    {
      DocumentRecords::Giving sink(*fresh, *documentRecords, lock);
      const size_t first = done > kHistoryKept ? done - kHistoryKept : 0;
      head.done = done;
      for (size_t i = 0; i < history.size(); ++i) {
        Entry& entry = history[i];
        here[i] = entry.kept != 0 && freshHeld.contains(entry.kept);
        if (!here[i] && i >= first) {
          try {
            if (entry.document) {
              entry.kept = documentRecords->put(entry.document, freshHeld, sink, io::RecordCodec::raw);
              here[i] = true;
            } else if (entry.kept != 0) {
              documentRecords->copy(*records, entry.kept, freshHeld, sink);
              here[i] = true;
            }
          } catch (const Error&) {
            if (entry.document || fresh->broken()) throw;
          }
        }
        // 0: its place in the history stays, but this journal has it not
        head.states.emplace_back(entry.label, here[i] ? entry.kept : 0);
      }
      putBegin(*fresh, head, documentRecords->ids(), freshHeld);
      if (!savingTo.empty()) putSaving(*fresh, savingTo);
      if (stroke) {
        putStrokeBegin(*fresh, stroke->tool, stroke->images, head.at);
        putStrokePoints(*fresh, stroke->points);
      }
      fresh->write();
      // From here on nothing fails, and whatever the records know can be read.
      if (stroke) strokeWritten = stroke->points.size();
      const uint64_t before = std::exchange(layer, ++layers);
      const uint64_t synced = journal ? journal->synced() : 0;
      std::set<uint64_t> needed{layer};
      for (size_t i = 0; i < history.size(); ++i) {
        Entry& entry = history[i];
        if (entry.copy.layer == before && entry.copy.at <= synced) entry.place = entry.copy;
        if (entry.place.layer == before && entry.place.at > synced) entry.place = {};
        entry.copy = here[i] ? Place{layer, fresh->bytes()} : Place{};
        if (entry.place.layer == kNowhere) entry.place = std::exchange(entry.copy, {});
        entry.stated = entry.place.layer != kNowhere || !entry.document;
        entry.number = 0;
        needed.insert({entry.place.layer, entry.copy.layer});
      }
      records->add({layer, {fresh->records()}, recordsOf(base, true)});
      records->keepOnly(needed);
      std::vector<DocumentPtr> inUse;
      for (const Entry& entry : history) inUse.push_back(entry.document);
      documentRecords->tidy(inUse);
    }
    lock.unlock();
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
  tellKept();
  askSync();
  journalBegan = journal->bytes();
  number = 0;
  begin = false;
  fits = true;
  const std::lock_guard guard(mutex);
  ++counts.generations;
  return true;
}

void Autosave::State::putStates() {
  if (std::none_of(history.begin(), history.end(), [](const Entry& e) { return !e.stated; })) return;
  // What happened is with the system already; documents come when nobody keeps the records waiting.
  journal->write();
  DocumentRecords::Lock lock = documentRecords->tryLock(kMostWait);
  behind = !lock.owns_lock();
  if (behind) return;
  uint64_t put = 0;
  for (Entry& entry : history) {
    if (entry.stated || !entry.document) continue;
    entry.kept = documentRecords->put(entry.document, held, *journal, io::RecordCodec::raw);
    if (entry.number != 0) putState(*journal, entry.number, entry.kept);
    entry.stated = true;
    entry.place = {layer, journal->bytes()};
    ++put;
  }
  // Before others get the records: what they know can be read.
  journal->write();
  lock.unlock();
  tellKept();
  const std::lock_guard guard(mutex);
  counts.steps += put;
}

// For kept().
void Autosave::State::tellKept() {
  const std::lock_guard guard(mutex);
  std::erase_if(known, [](const auto& each) { return each.first.expired(); });
  for (const Entry& entry : history) {
    if (!entry.document) continue;
    if (entry.place.layer == kNowhere)
      known.erase(entry.document);
    else
      known[entry.document] = {entry.kept, entry.place};
  }
}

}  // namespace argil::engine
