// Any bytes must give a script that can be written and read back, or an Error of one line.
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "clay/error.h"
#include "engine/script.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  if (size == 0) return 0;
  try {
    const engine::Script script = engine::parseScript({reinterpret_cast<const char*>(data + 1), size - 1}, "input.json");
    if (engine::parseScript(engine::formatScript(script), "again.json") != script) std::abort();
  } catch (const Error& error) {
    if (error.kind() != Error::Kind::input || std::strpbrk(error.what(), "\r\n") != nullptr) std::abort();
  }
  return 0;
}
