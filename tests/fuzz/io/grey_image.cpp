// Pictures as height maps; stb_image takes them apart in this process.
#include "io/grey_image.h"

#include "tests/fuzz/file_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  constexpr int kLargest = 256;  // Pixels along an edge: larger ones cost time and find nothing more.
  static tests::MemoryFile file;
  try {
    const io::GreyImage image = io::readGreyImage(file.holding(data, size), kLargest);
    tests::require(image.width > 0 && image.height > 0 && image.width <= kLargest && image.height <= kLargest);
    tests::require(image.grey.size() == size_t(image.width) * size_t(image.height));
    for (const float grey : image.grey) tests::require(grey >= 0 && grey <= 1);
  } catch (const Error& error) {
    tests::requireSentence(error);
  }
  return 0;
}
