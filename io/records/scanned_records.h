#pragma once
// The sound records in the bytes of a file, whatever stands between them: for journals and for recovery.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "io/records/record.h"

namespace argil::io {

/// Where in its file each record lies. The file is read in blocks and stays open; it is never mapped, as a file that
/// somebody shortens would end the program. 16 bytes of memory a record, whatever the file's length. One thread.
class ScannedRecords : public RecordSource {
 public:
  /// Where a record stands, for read().
  struct Place {
    uint64_t offset : 48;
    uint64_t bytes : 16;
  };
  using Visit = std::function<void(const RecordView&, Place)>;

  /// Reads the whole file; `visit` sees each sound record in the order of the file. Throws Error when the file cannot
  /// be opened or read, Cancelled.
  ScannedRecords(const std::filesystem::path& path, Job* job, const Visit& visit);
  /// The same for a descriptor, which is closed at the end.
  ScannedRecords(int fd, const std::filesystem::path& path, Job* job, const Visit& visit);
  ~ScannedRecords() override;
  ScannedRecords(const ScannedRecords&) = delete;
  ScannedRecords& operator=(const ScannedRecords&) = delete;

  [[nodiscard]] uint64_t records() const { return records_; }
  /// Stretches of other bytes in front of a record. What follows the last record does not count.
  [[nodiscard]] uint64_t gaps() const { return gaps_; }
  [[nodiscard]] RecordId highestId() const { return ids_.empty() ? 0 : ids_.back().id; }

  /// False when it can no longer be read there.
  bool read(Place place, std::vector<std::byte>& record) const;
  /// Of several with one id: the one that stands last.
  bool get(RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;

 private:
  struct Entry {
    RecordId id;
    Place place;
  };
  void scan(const std::string& name, Job* job, const Visit& visit);

  int fd_;
  uint64_t records_ = 0, gaps_ = 0;
  std::vector<Entry> ids_;  ///< Rising, each once.
};

/// A regular file for reading (`writable`: for writing too, as some file systems want for a lock). Throws Error for
/// what is missing or something else.
[[nodiscard]] int openForScan(const std::filesystem::path& path, bool writable);

}  // namespace argil::io
