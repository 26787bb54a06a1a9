#pragma once
// What can still be read of a damaged file.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "clay/base/job.h"
#include "io/records/clay_records.h"
#include "io/records/record.h"

namespace argil::io {

/// What can still be read of a damaged document or journal: every sound record found by scanning its bytes, whatever
/// stands around it. Never throws for content; throws Error when the file cannot be read at all.
class RecoveredRecords : public RecordSource, public OlderBricks {
 public:
  explicit RecoveredRecords(const std::filesystem::path& path, Job* job = nullptr);
  ~RecoveredRecords() override;
  /// Heads that were found (all chunks there), newest first.
  [[nodiscard]] const std::vector<RecordId>& heads() const;
  /// The same of BlobKind::state, for files whose head is gone.
  [[nodiscard]] const std::vector<RecordId>& states() const;
  [[nodiscard]] uint64_t records() const;
  [[nodiscard]] RecordId highestId() const;
  bool get(RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;
  void bricksIn(uint32_t owner, Coord first, int32_t edge,
                const std::function<void(Coord, RecordId)>& each) const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::io
