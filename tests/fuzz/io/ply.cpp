// The reader of PLY.
#include "tests/fuzz/io/mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return argil::tests::readAsModel(data, size, "input.ply");
}
