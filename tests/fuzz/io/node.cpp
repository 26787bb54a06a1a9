// Nodes of a version's tree: any body is refused or gives a node that is packed as itself.
#include "io/records/node_body.h"

#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  tests::ByteInput input(data, size);
  io::RecordView record;
  record.header.kind = io::RecordKind::node;
  record.header.id = uint64_t(input.two()) * input.two();
  record.body = input.rest();
  record.header.bodyBytes = uint16_t(record.body.size());
  const auto node = io::parseNode(record);
  if (!node) return 0;
  std::vector<std::byte> body;
  io::packNode(*node, body);
  io::RecordView again = record;
  again.body = body;
  again.header.bodyBytes = uint16_t(body.size());
  const auto back = io::parseNode(again);
  tests::require(back && back->ids == node->ids && back->record == node->record && back->inside == node->inside &&
                 back->level == node->level);
  return 0;
}
