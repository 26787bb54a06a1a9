// Any records as clay: damaged, or (third byte of 128 and more) repaired into a version that can be written again.
#include "io/records/clay_records.h"

#include "clay/store/store.h"
#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  tests::ByteInput input(data, size);
  const io::RecordId root = input.two();
  const uint8_t choice = input.byte();
  const bool repair = choice >= 128;
  const uint32_t owner = choice % 128;
  tests::RecordList list = tests::recordsOf(input);
  try {
    io::RecordIds ids(list.highest() + 1);
    io::ClayRecords clay(ids);
    const io::ReadClay read =
        clay.read(list, root, clay::Grid{}, clay::Store::make(), nullptr, 1, repair ? &list : nullptr, owner);
    tests::require(repair || (read.bricksLost == 0 && read.blocksLost == 0));
    tests::RecordList again;
    io::RecordSet held;
    io::RecordIds newIds;
    io::ClayRecords fresh(newIds);
    (void)fresh.write(read.version, 1, held, again, io::RecordCodec::raw);
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  try {
    io::RecordSet live;
    io::markLive(list, root, live);
  } catch (const Error& error) {
    tests::requireSentence(error, Error::Kind::work);
  }
  return 0;
}
