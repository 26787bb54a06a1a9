// Channels: any body is refused or gives bytes that are packed and unpacked as themselves; the same for the head of a
// version with channels.
#include <algorithm>
#include <array>

#include "io/records/channel_codec.h"
#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  tests::ByteInput input(data, size);
  io::RecordView record;
  record.header.kind = input.byte() % 2 ? io::RecordKind::clay : io::RecordKind::channelBrick;
  record.header.codec = io::RecordCodec(input.byte());
  record.header.id = input.two();
  record.body = input.rest();
  record.header.bodyBytes = uint16_t(record.body.size());
  std::vector<std::byte> body;
  if (const auto head = io::parseClayHead(record)) {
    io::packClayHead(*head, body);
    tests::require(std::equal(body.begin(), body.end(), record.body.begin(), record.body.end()));
  }
  clay::ChannelBrick brick;
  std::array<uint8_t, clay::kBrickVoxels> back;
  const auto coord = io::unpackChannelBrick(record, brick.value);
  if (!coord) return 0;
  brick.coord = *coord;
  for (const io::RecordCodec wanted : {io::RecordCodec::raw, io::RecordCodec::zstd}) {
    io::RecordView packed = record;
    packed.header.codec = wanted;
    io::packChannelBrick(brick, packed.header.codec, body);
    packed.body = body;
    packed.header.bodyBytes = uint16_t(body.size());
    tests::require(body.size() <= io::kMostRecordBody && io::unpackChannelBrick(packed, back) == coord &&
                   std::equal(back.begin(), back.end(), brick.value));
  }
  return 0;
}
