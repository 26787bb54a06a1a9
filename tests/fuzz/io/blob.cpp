// Any records as a blob: what getBlob() gives is not longer than was asked for; the bytes themselves come back as a
// blob.
#include "io/records/blob.h"

#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  constexpr size_t kMost = 1 << 16;
  tests::ByteInput input(data, size);
  const auto kind = io::BlobKind(input.byte());
  const io::RecordId id = input.two();
  tests::RecordList list = tests::recordsOf(input);
  try {
    tests::require(io::getBlob(kind, id, list, kMost).size() <= kMost);
  } catch (const Error& error) {
    tests::requireSentence(error, Error::Kind::work);
  }
  try {
    io::RecordSet live;
    io::markBlob(list, id, live);
  } catch (const Error& error) {
    tests::requireSentence(error, Error::Kind::work);
  }
  tests::RecordList own;
  io::RecordIds ids;
  io::RecordSet held;
  const auto bytes = std::as_bytes(std::span(data, size));
  const io::RecordId put = io::putBlob(io::BlobKind::mesh, bytes, ids, held, own);
  const std::vector<std::byte> back = io::getBlob(io::BlobKind::mesh, put, own, size);
  tests::require(std::equal(back.begin(), back.end(), bytes.begin(), bytes.end()));
  return 0;
}
