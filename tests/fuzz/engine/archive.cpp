// Any records as a document at one moment: whole, or an Error that says what is damaged.
#include "engine/keeping/archive.h"

#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  tests::ByteInput input(data, size);
  const io::RecordId state = input.two();
  tests::RecordList list = tests::recordsOf(input);
  engine::Archive archive;
  const auto lock = archive.lock();
  try {
    const engine::Archive::Read read = archive.get(list, state, nullptr);
    tests::require(read.document != nullptr && read.notes.empty());
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  try {
    io::RecordSet live;
    archive.mark(list, state, live);
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
