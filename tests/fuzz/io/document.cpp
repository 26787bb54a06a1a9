// Saved documents of any bytes: opened, read through and added to, or refused; scanned in any case.
#include "io/records/document_file.h"

#include "io/records/recovered_records.h"
#include "tests/fuzz/patched_file.h"

namespace {

using namespace argil;

constexpr io::RecordId kRecords = 12;

void putRecords(io::RecordSink& sink, io::RecordId first) {
  for (io::RecordId id = first; id < first + kRecords; ++id) {
    const std::vector<std::byte> body(size_t(id * 331 % 2500), std::byte(id));
    sink.put({id % 2 ? io::RecordKind::brick : io::RecordKind::node, io::RecordCodec::raw, 0, 1, id}, body);
  }
}

const std::string& wholeDocument(const tests::MemoryFolder& folder) {
  static const std::string kWhole = [&] {
    const auto path = folder / "whole.argil";
    for (io::RecordId first = 1; first <= 1 + kRecords; first += kRecords) {
      const auto file = first == 1 ? io::DocumentFile::create(path) : io::DocumentFile::open(path, true);
      const auto transaction = file->begin();
      putRecords(*transaction, first);
      transaction->commit(first, first + kRecords);
    }
    return tests::contentOf(path);
  }();
  return kWhole;
}

void readAll(io::RecordSource& source, io::RecordId highest) {
  std::vector<std::byte> record;
  std::vector<io::RecordId> ids;
  for (io::RecordId id = 1; id <= std::min<io::RecordId>(highest, 64); ++id) {
    ids.push_back(id);
    (void)source.get(id, record);
  }
  source.getMany(ids, [](size_t, std::span<const std::byte> bytes) { (void)io::parseRecord(bytes); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static tests::MemoryFolder folder;
  const std::string& whole = wholeDocument(folder);
  const auto path = folder / "input.argil";
  folder.clear();
  tests::ByteInput input(data, size);
  const bool toWrite = input.byte() % 2 == 1;
  tests::write(path, tests::patched(input, whole));
  (void)io::isDocument(path);
  try {
    const auto file = io::DocumentFile::open(path, toWrite);
    const io::RecordSet held = file->held();
    readAll(*file, file->nextId());
    if (toWrite) {
      const io::RecordId next = file->nextId();
      const auto transaction = file->begin();
      putRecords(*transaction, next);
      transaction->commit(next, next + kRecords);
      const auto again = io::DocumentFile::open(path, false);
      std::vector<std::byte> record;
      tests::require(again->head() == next && again->get(next, record) && io::parseRecord(record));
    }
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  try {
    io::RecoveredRecords found(path);
    readAll(found, found.highestId());
    for (const io::RecordId head : found.heads()) tests::require(head != 0);
    found.bricksIn(1, {-8, -8, -8}, 16, [&](Coord, io::RecordId id) {
      std::vector<std::byte> record;
      tests::require(found.get(id, record));
    });
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
