#pragma once
// An append-only file of records: what happened since the last save.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "clay/base/error.h"
#include "io/records/record.h"
#include "io/records/written_records.h"

namespace argil::io {

/// The writing side. The file is locked (flock) as long as this lives, so that others can tell a journal in work from
/// one that a crash left. One thread writes; sync() may be called by another one beside it.
class JournalWriter : public RecordSink {
 public:
  /// Makes the file, and its folder with access for the user alone. Does not wait for the disk.
  /// `unnamed`: nobody else finds the file, and it ends with this program. Throws Error (kind work).
  explicit JournalWriter(const std::filesystem::path& path, bool unnamed = false);
  ~JournalWriter() override;
  /// Into a buffer of ours; large buffers go to the file. Throws Error (kind work) when the file cannot take it: the
  /// journal is then as it was after the last sync().
  void put(const RecordHeader& header, std::span<const std::byte> body) override;
  /// What was put is the system's when it returns: the end of this program cannot lose it any more. Throws as put()
  /// does.
  void write();
  /// What was put is on the disk when it returns (fdatasync; the first time the file's name and the folders that were
  /// made for it too). Throws Error (kind work); what the disk has is then all up to an earlier sync(), and `broken()`.
  void sync();
  [[nodiscard]] bool broken() const;      ///< Something failed: begin another file.
  [[nodiscard]] uint64_t bytes() const;   ///< Put.
  [[nodiscard]] uint64_t synced() const;  ///< Of these on the disk: what a failure leaves.
  /// What write() or sync() gave to the file, to be read back; outlives this writer and the file's name. Any thread.
  [[nodiscard]] std::shared_ptr<WrittenRecords> records() const;
  [[nodiscard]] double syncSeconds() const;  ///< Spent waiting for the disk so far: told apart from work.
  /// Closes and removes the file: nothing of it is needed any more.
  void remove();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Another Argil has the journal, or had it and removed it.
class JournalTaken : public Error {
 public:
  explicit JournalTaken(const std::string& sentence) : Error(sentence, Kind::work) {}
};

/// The reading side, after a crash.
class JournalReader : public RecordSource {
 public:
  /// Reads what is there: whole and sound records in the order in which they were written, whatever stands between them
  /// (a damaged place is skipped and counted). `lock`: takes the lock, so that no second Argil recovers the same.
  /// Throws Error: cannot be read; JournalTaken.
  explicit JournalReader(const std::filesystem::path& path, bool lock);
  ~JournalReader() override;
  /// All records without an id, in order, with how many damaged places lie in front of each: where that number grows,
  /// events may be missing.
  void forEachEvent(const std::function<void(const RecordView&, uint64_t damaged)>& visit) const;
  [[nodiscard]] uint64_t records() const;
  [[nodiscard]] uint64_t damagedPlaces() const;
  [[nodiscard]] RecordId highestId() const;
  bool get(RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;
  /// Puts an event behind all else, on the disk when it returns. Only with the lock. forEachEvent() does not show it.
  /// Throws Error (kind work); it may be there all the same.
  void append(RecordKind kind, std::span<const std::byte> body);
  /// Removes the file.
  void remove();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Journals in a folder that no living Argil holds, by name, the last one first (names begin with the time at which the
/// journal was begun; clocks are set, so that proves nothing). Never throws: a folder that is not there has none.
[[nodiscard]] std::vector<std::filesystem::path> abandonedJournals(const std::filesystem::path& folder);

/// $XDG_STATE_HOME/argil/journal or ~/.local/state/argil/journal; ARGIL_STATE goes before both.
[[nodiscard]] std::filesystem::path journalFolder();

}  // namespace argil::io
