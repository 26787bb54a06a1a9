// The readers of OBJ and of the material libraries that it names.
#include "io/models/mtl.h"
#include "tests/fuzz/io/mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static_cast<void>(argil::io::parseMtl({std::as_bytes(std::span(data, size)), "input.mtl"}));
  return argil::tests::readAsModel(data, size, "input.obj");
}
