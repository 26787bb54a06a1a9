// What a Falcon sends: packets in a stream of any bytes.
#include <cstdint>

#include "haptics/devices/falcon_protocol.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  haptics::FalconDecoder decoder;
  haptics::FalconReply reply;
  uint64_t packets = 0;
  for (size_t i = 0; i < size; ++i) packets += decoder.feed(data[i], reply);
  tests::require(packets * sizeof(haptics::FalconPacket) + decoder.dropped() <= size);
  return 0;
}
