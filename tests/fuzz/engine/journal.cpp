// Recovery from a journal of any records: a document and strokes to do again, or an Error.
#include "engine/recovery.h"

#include "tests/fuzz/file_input.h"
#include "tests/fuzz/record_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  static tests::MemoryFile file;
  tests::ByteInput input(data, size);
  const std::vector<std::byte> bytes = tests::recordsOf(input).bytes();
  const auto path = file.holding(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  try {
    (void)engine::examine(path);
    const engine::Recovered recovered = engine::recover(path);
    const engine::OpenedDocument& opened = recovered.document;
    tests::require(opened.done < opened.states.size() && opened.states[opened.done].document != nullptr);
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
