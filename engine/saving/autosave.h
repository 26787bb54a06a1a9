#pragma once
// Keeps what is being made: the journal beside the person, and what it takes to save and to recover.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/saving/saved_document.h"
#include "engine/saving/saved_history.h"
#include "engine/saving/session.h"

namespace argil::engine {

/// How the journal keeps up. What a stroke's samples were is on the disk `syncS` after they came, plus what the disk
/// itself takes.
struct AutosaveOptions {
  std::filesystem::path folder;  ///< Of journals; empty: none is written.
  double syncS = 0.25;
  /// A journal that grew by this since its begin is begun anew with what is still needed.
  uint64_t rollBytes = uint64_t{512} << 20;
  bool unnamed = false;  ///< Journals that nobody finds after a crash: there for steps that leave memory alone.
  /// After a failure the journal is begun anew after this time, then after twice as long each time, until it works.
  double retryS = 0.25, mostRetryS = 10;
};

/// Writes a journal of a session, on a thread of its own: samples of the stroke in work, bricks and documents of
/// finished steps, durable within a second, never in the saved file. As a SessionWatch it only queues. Members but
/// those of SessionWatch may be called from any thread but the servo's. Destroyed: the journal is removed, as whoever
/// ends it has decided about what is unsaved; a crash leaves it.
class Autosave : public SessionWatch {
 public:
  /// `tell` gets a sentence when journalling fails, and an empty one when it works again; from the autosave's thread.
  Autosave(const AutosaveOptions& options, std::function<void(const std::string&)> tell);
  ~Autosave() override;

  /// A journal that a crash left, taken over to go on with.
  struct Continued {
    std::filesystem::path journal;
    std::shared_ptr<io::RecordSource> source;  ///< Holds its lock until the autosave has a journal of its own.
    uint64_t sequence = 0;                     ///< Its JournalBegin::sequence.
  };
  /// Another document is in work from now on: as the session begins with it. The journal of the one before is removed,
  /// and that of `continued` once there is a new one. `sources`: where states without a document are read, besides the
  /// base. What comes back is where they all can be read as long as this document is in work, those too that leave
  /// memory later.
  std::shared_ptr<SavedHistory> begin(std::vector<HistoryState> states, size_t done,
                                      std::shared_ptr<DocumentRecords> documentRecords,
                                      std::shared_ptr<const Base> base, const std::string& writer,
                                      std::optional<Continued> continued = {},
                                      const std::vector<std::shared_ptr<io::RecordSource>>& sources = {});
  /// A save to this file begins: a crash may find it done before saved() was called. Empty: it was given up, so that
  /// the journal goes on looking after the file under it.
  void saving(const std::filesystem::path& file);
  /// All that happened up to here is in this file: the journal begins anew.
  void saved(std::shared_ptr<const Base> base);
  /// When it is destroyed the journal stays.
  void leave();
  /// Until all that was queued is on the disk, or has failed. For tests and before risky work.
  void flush();
  /// Until what was queued has been looked at and, unless it failed, written. Does not wait for the disk; for a journal
  /// that is just being begun anew it does, two seconds at most.
  void catchUp();

  /// The id under which a document of the history can be read again whatever becomes of the program's journal; 0 while
  /// it is not on the disk. Cheap.
  [[nodiscard]] uint64_t kept(const DocumentPtr& document) const;

  struct Counts {
    uint64_t generations = 0;  ///< Journals begun.
    uint64_t bytes = 0;        ///< Written, all of them.
    uint64_t steps = 0;        ///< Whose documents are in the journal.
    double cpuS = 0;           ///< Of the thread.
    double syncS = 0;          ///< Waited for the disk.
  };
  [[nodiscard]] Counts counts() const;

  void strokeBegan(const Tool& tool, const StrokeImages& images) override;
  void strokePoint(const PathPoint& point) override;
  void toolLifted() override;
  void strokeEnded() override;
  void stepped(const std::string& label, const DocumentPtr& after, bool merged) override;
  void went(size_t done) override;
  void spilled(size_t state) override;
  void cameBack(size_t state, const DocumentPtr& document) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A state of the document in work, whose places are `records` (of Autosave::begin), read near a document in memory: it
/// shares with that one even when that was made a moment ago; only what no file could take is shared with nothing, and
/// the whole is read. Throws Error when it cannot be read. The editing thread.
[[nodiscard]] DocumentPtr readStep(Autosave& autosave, DocumentRecords& documentRecords,
                                   const std::shared_ptr<SavedHistory>& records, uint64_t kept, const Document& near);

}  // namespace argil::engine
