#pragma once
// What can still be read of a damaged file.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "clay/job.h"
#include "io/record.h"

namespace argil::io {

/// What can still be read of a damaged document or journal: every sound record found by scanning its bytes, whatever stands around it. Never throws for
/// content; throws Error when the file cannot be read at all.
class Salvage : public RecordSource {
 public:
  explicit Salvage(const std::filesystem::path& path, Job* job = nullptr);
  ~Salvage() override;
  /// Heads that were found (all chunks there), newest first.
  [[nodiscard]] const std::vector<RecordId>& heads() const;
  [[nodiscard]] uint64_t records() const;
  [[nodiscard]] RecordId highestId() const;
  bool get(RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const RecordId> ids, const std::function<void(size_t, std::span<const std::byte>)>& each) override;
  /// Ids of bricks of one clay at one place, newest first: what ClayRecords::read falls back to.
  [[nodiscard]] std::vector<RecordId> bricksAt(uint32_t owner, int32_t x, int32_t y, int32_t z) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::io
