// Records are found among any bytes, once each, and what is found is written again as the same bytes.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "io/records/record.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  using tests::require;
  const auto bytes = std::as_bytes(std::span(data, size));
  size_t before = 0;
  for (size_t at = io::findRecord(bytes, 0); at < bytes.size(); at = io::findRecord(bytes, before)) {
    require(at >= before);
    const auto record = io::parseRecord(bytes.subspan(at));
    require(record && record->whole.size() == io::kRecordHeaderBytes + record->body.size());
    std::vector<std::byte> again;
    io::appendRecord(again, record->header, record->body);
    // The reserved bytes alone may differ, and with them the checksum.
    require(again.size() == record->whole.size() && io::parseRecord(again));
    before = at + record->whole.size();
  }
  // The same bytes as the body of a record come back whole, and no other record is seen in them.
  const auto body = bytes.first(std::min(bytes.size(), io::kMostRecordBody));
  std::vector<std::byte> packed;
  io::appendRecord(packed, {io::RecordKind::chunk, io::RecordCodec::raw, 0, 7, 9}, body);
  const auto back = io::parseRecord(packed);
  require(back && back->header.owner == 7 && back->header.id == 9 &&
          std::equal(back->body.begin(), back->body.end(), body.begin(), body.end()));
  // Damaged anywhere, it is none.
  const size_t hit = size == 0 ? 0 : (size_t(data[0]) * 31 + data[size - 1]) % packed.size();
  packed[hit] ^= std::byte(1 + (size == 0 ? 0 : data[size / 2] % 255));
  require(!io::parseRecord(packed));
  return 0;
}
