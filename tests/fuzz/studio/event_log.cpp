// Recordings of a session: lines of events that can be written and read again, or an Error.
#include "ui3d/studio/input/event_log.h"

#include "tests/fuzz/file_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  static tests::MemoryFile file;
  try {
    for (const studio::Event& event : studio::readEvents(file.holding(data, size))) {
      const std::string line = studio::toLine(event);
      tests::require(studio::toLine(studio::fromLine(line)) == line);
    }
  } catch (const Error& error) {
    tests::requireSentence(error);
  }
  return 0;
}
