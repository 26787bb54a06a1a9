// Bricks: any body is refused or gives one that is packed and unpacked as itself.
#include <cstring>

#include "io/records/brick_codec.h"
#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  static io::BrickCodec codec, again;
  constexpr float kBand = 3;
  tests::ByteInput input(data, size);
  io::RecordView record;
  record.header.kind = io::RecordKind::brick;
  record.header.codec = io::RecordCodec(input.byte());
  record.body = input.rest();
  record.header.bodyBytes = uint16_t(record.body.size());
  if (record.header.codec == io::RecordCodec::raw16 || record.header.codec == io::RecordCodec::predicted16) {
    clay::FixedBrick fixed, again16;
    fixed.step = again16.step = clay::stepOf(clay::Precision::fixed16, kBand);
    const auto place = codec.unpack(record, kBand, fixed);
    if (!place) return 0;
    fixed.coord = *place;
    for (const io::RecordCodec wanted : {io::RecordCodec::raw, io::RecordCodec::zstd}) {
      io::RecordView packed = record;
      packed.header.codec = wanted;
      packed.body = again.pack(fixed, kBand, packed.header.codec);
      tests::require(packed.body.size() <= io::kMostRecordBody && codec.unpack(packed, kBand, again16) == place);
      tests::require(std::memcmp(fixed.code, again16.code, sizeof fixed.code) == 0);
    }
    return 0;
  }
  clay::FloatBrick brick, back;
  const auto coord = codec.unpack(record, kBand, brick);
  if (!coord) return 0;
  brick.coord = *coord;
  for (const io::RecordCodec wanted : {io::RecordCodec::raw, io::RecordCodec::zstd}) {
    io::RecordView packed = record;
    packed.header.codec = wanted;
    packed.body = again.pack(brick, kBand, packed.header.codec);
    packed.header.bodyBytes = uint16_t(packed.body.size());
    tests::require(packed.body.size() <= io::kMostRecordBody && codec.unpack(packed, kBand, back) == coord);
    tests::require(std::memcmp(back.value, brick.value, sizeof brick.value) == 0);
  }
  return 0;
}
