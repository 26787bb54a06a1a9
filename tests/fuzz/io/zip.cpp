// ZIP archives: a table and parts that are as long as they say.
#include "io/bytes/zip_reader.h"

#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  const io::Input input{std::as_bytes(std::span(data, size)), "input.3mf"};
  try {
    io::ZipReader zip(input);
    for (const io::ZipReader::Part& part : zip.parts()) {
      tests::require(zip.find(part.name) != nullptr);
      try {
        tests::require(zip.read(part).size == part.size);
      } catch (const Error& error) {
        tests::requireSentence(error);
      }
    }
  } catch (const Error& error) {
    tests::requireSentence(error);
  }
  return 0;
}
