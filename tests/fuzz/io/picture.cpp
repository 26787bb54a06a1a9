// Pictures as height maps and in colour: what the reader process does with the file, and then the editor with what it
// sends. Both in this process.
#include "io/models/picture.h"

#include "io/models/reader_process.h"
#include "io/reader/reader.h"
#include "tests/fuzz/file_input.h"
#include "tests/fuzz/io/reader_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  if (size == 0) return 0;
  constexpr int kLargest = 256;  // Pixels along an edge: larger ones cost time and find nothing more.
  static tests::MemoryFile file;
  const auto path = file.holding(data, size);
  for (const auto as : {io::reader::PictureAs::grey, io::reader::PictureAs::colour}) {
    const auto spoken =
        tests::spokenBy([&](io::reader::Sender& sender) { io::reader::readPicture(path, as, kLargest, sender); });
    if (spoken.empty()) continue;
    // Whatever the file was: the reader keeps to the rules of the wire, so none of this throws.
    const io::SpokenReader reader(spoken);
    if (as == io::reader::PictureAs::grey) {
      const io::GreyImage image = io::readGreyImage(path, kLargest);
      tests::require(image.width > 0 && image.height > 0 && image.width <= kLargest && image.height <= kLargest);
      tests::require(image.grey.size() == size_t(image.width) * size_t(image.height));
      for (const float grey : image.grey) tests::require(grey >= 0 && grey <= 1);
    } else {
      const io::ColourImage image = io::unpackPicture({}, kLargest);
      tests::require(image.rgba.size() == 4 * size_t(image.width) * size_t(image.height));
    }
  }
  return 0;
}
