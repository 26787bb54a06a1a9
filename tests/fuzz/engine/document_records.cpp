// Any records as a document at one moment: whole, or an Error that says what is damaged.
#include "engine/saving/document_records.h"

#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  tests::ByteInput input(data, size);
  const io::RecordId state = input.two();
  tests::RecordList list = tests::recordsOf(input);
  engine::DocumentRecords documentRecords;
  const auto lock = documentRecords.lock();
  try {
    const engine::DocumentRecords::Read read = documentRecords.get(list, state, nullptr);
    tests::require(read.document != nullptr && read.notes.empty());
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  try {
    io::RecordSet live;
    documentRecords.mark(list, state, live);
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
