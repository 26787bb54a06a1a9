// Documents as text: any text is refused or gives a document that is written and read as itself.
#include "engine/text/document_text.h"

#include <string_view>

#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  try {
    const engine::DocumentText read = engine::readDocumentText({reinterpret_cast<const char*>(data), size}, "input");
    tests::require(read.clay.size() == read.grids.size());
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
