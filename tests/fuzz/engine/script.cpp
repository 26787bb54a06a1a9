// Any bytes must give a script that can be written and read back, or an Error of one line.
#include <cstdint>

#include "engine/text/script.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  try {
    const engine::Script script = engine::parseScript({reinterpret_cast<const char*>(data), size}, "input.json");
    tests::require(engine::parseScript(engine::formatScript(script), "again.json") == script);
  } catch (const Error& error) {
    tests::requireSentence(error);
  }
  return 0;
}
