#pragma once
// A file of records in memory, whose records tests damage and lose.

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "io/records/clay_records.h"
#include "io/records/record.h"

namespace argil::io::testing {

class RecordMemory : public RecordSink, public RecordSource, public OlderBricks {
 public:
  void put(const RecordHeader& header, std::span<const std::byte> body) override {
    if (failAfter == 0) throw Error("no space left", Error::Kind::work);
    --failAfter;
    std::vector<std::byte> bytes;
    appendRecord(bytes, header, body);
    order.push_back(header.id);
    ++puts[header.kind];
    bytesPut += bytes.size();
    if (!records.emplace(header.id, std::move(bytes)).second) throw std::logic_error("an id twice");
  }
  bool get(RecordId id, std::vector<std::byte>& record) override {
    const auto at = records.find(id);
    if (at == records.end()) return false;
    record = at->second;
    return true;
  }
  void getMany(std::span<const RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override {
    for (size_t i = 0; i < ids.size(); ++i) {
      if (i > 0 && ids[i] <= ids[i - 1]) throw std::logic_error("ids do not rise");
      const auto at = records.find(ids[i]);
      if (at != records.end()) each(i, at->second);
    }
  }
  void bricksIn(uint32_t owner, Coord first, int32_t edge,
                const std::function<void(Coord, RecordId)>& each) const override {
    if (!bricks_) {
      bricks_.emplace();
      for (const auto& [id, bytes] : records) {
        const auto record = parseRecord(bytes);
        if (!record || record->header.kind != RecordKind::brick || record->body.size() < 12) continue;
        int32_t c[3];
        std::memcpy(c, record->body.data(), sizeof c);
        bricks_->push_back({record->header.owner, {c[0], c[1], c[2]}, id});
      }
    }
    for (const BrickRecord& brick : *bricks_) {
      const Coord d = brick.coord - first;
      if (brick.owner == owner && std::min({d.x, d.y, d.z}) >= 0 && std::max({d.x, d.y, d.z}) < edge)
        each(brick.coord, brick.id);
    }
  }
  /// Puts another record in the place of one, with a right checksum.
  void replace(RecordHeader header, std::span<const std::byte> body) {
    auto& bytes = records[header.id];
    bytes.clear();
    appendRecord(bytes, header, body);
  }
  [[nodiscard]] RecordView at(RecordId id) const { return *parseRecord(records.at(id)); }

  std::map<RecordId, std::vector<std::byte>> records;
  std::vector<RecordId> order;  ///< As they were put.
  std::map<RecordKind, uint64_t> puts;
  uint64_t bytesPut = 0;
  uint64_t failAfter = UINT64_MAX;  ///< So many more puts succeed.

 private:
  struct BrickRecord {
    uint32_t owner;
    Coord coord;
    RecordId id;
  };
  mutable std::optional<std::vector<BrickRecord>> bricks_;  // made by the first bricksIn()
};

}  // namespace argil::io::testing
