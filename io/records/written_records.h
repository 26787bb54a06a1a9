#pragma once
// Records of a file that is still being written, to be read back by the program that writes it.

#include <cstdint>
#include <mutex>
#include <vector>

#include "io/records/record.h"

namespace argil::io {

/// Remembers where its writer put each record: 16 bytes of memory a record. What has not reached the file yet, or what
/// the file lost, is not there. Stays readable when the writer is gone and the file has no name any more. Any thread,
/// several at once.
class WrittenRecords : public RecordSource {
 public:
  /// Takes over a descriptor for reading.
  explicit WrittenRecords(int fd) : fd_(fd) {}
  ~WrittenRecords() override;
  WrittenRecords(const WrittenRecords&) = delete;
  WrittenRecords& operator=(const WrittenRecords&) = delete;

  /// The writer's: this record is to stand there. Of several with one id the last one counts.
  void add(RecordId id, uint64_t offset, size_t bytes);

  bool get(RecordId id, std::vector<std::byte>& record) override;
  /// Records that lie together are read together.
  void getMany(std::span<const RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;

 private:
  struct Entry {
    RecordId id;
    uint64_t offset : 48;
    uint64_t bytes : 16;
  };
  /// With the mutex held. Null when there is none.
  [[nodiscard]] const Entry* find(RecordId id);

  int fd_;
  std::mutex mutex_;  // guards these
  std::vector<Entry> entries_;
  bool sorted_ = true;  // by id
};

}  // namespace argil::io
