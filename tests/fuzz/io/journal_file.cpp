// Journals: any bytes, or any records one after another, are read in order; what is no record is passed over.
#include "io/records/journal_file.h"

#include "tests/fuzz/file_input.h"
#include "tests/fuzz/record_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  static tests::MemoryFile file;
  tests::ByteInput input(data, size);
  const bool asRecords = input.byte() % 2 == 1;
  std::vector<std::byte> bytes;
  if (asRecords)
    bytes = tests::recordsOf(input).bytes();
  else if (const auto rest = input.rest(); true)
    bytes.assign(rest.begin(), rest.end());
  try {
    io::JournalReader journal(file.holding(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()), true);
    uint64_t events = 0;
    uint64_t before = 0;
    journal.forEachEvent([&](const io::RecordView& record, uint64_t damaged) {
      tests::require(damaged >= before && damaged <= journal.damagedPlaces());
      before = damaged;
      tests::require(record.header.id == 0 && record.whole.size() == io::kRecordHeaderBytes + record.body.size());
      ++events;
    });
    tests::require(events <= journal.records());
    if (asRecords) tests::require(journal.damagedPlaces() == 0);
    std::vector<io::RecordId> ids;
    std::vector<std::byte> record;
    for (io::RecordId id = 1; id <= std::min<io::RecordId>(journal.highestId(), 64); ++id) {
      ids.push_back(id);
      if (journal.get(id, record)) tests::require(io::parseRecord(record)->header.id == id);
    }
    journal.getMany(ids, [&](size_t i, std::span<const std::byte> found) {
      tests::require(io::parseRecord(found)->header.id == ids[i]);
    });
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
