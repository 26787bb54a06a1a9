// Paths of a hand as CSV, ours and others': read, they can be asked for any moment.
#include "haptics/devices/hand_path.h"

#include <cmath>
#include <cstdint>

#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  haptics::HandPathLayout other;
  other.units = "m";
  for (const bool ours : {true, false}) {
    try {
      const haptics::HandPath path =
          ours ? haptics::HandPath::fromCsv(text, "hand.csv") : haptics::HandPath::fromCsv(text, "hand.csv", other);
      tests::require(!path.empty() && std::isfinite(path.durationS()));
    } catch (const Error& error) {
      tests::requireSentence(error);
    }
  }
  return 0;
}
