// What the editor makes of the bytes of a reader that a file has taken over: a model, clay or a picture that keeps what
// it promises, or one sentence. The first byte says what is read, the others are what the reader sends behind its
// magic.
#include "io/reader/wire.h"

#include <cmath>

#include "io/models/model_file.h"
#include "io/models/picture.h"
#include "io/models/reader_process.h"
#include "io/models/vdb_file.h"
#include "tests/fuzz/file_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  if (size == 0) return 0;
  constexpr int kLargest = 256;
  constexpr uint8_t kGlb[] = {'g', 'l', 'T', 'F'};
  static tests::MemoryFile file;
  static const auto path = file.holding(kGlb, sizeof kGlb);  // Its content is not looked at beyond that.
  const io::SpokenReader reader(std::as_bytes(std::span(data + 1, size - 1)));
  try {
    switch (data[0] % 4) {
      case 0: {
        const io::ModelFile model = io::readModel(path);
        tests::require(!model.objects.empty());
        for (const io::ModelObject& object : model.objects) {
          tests::require(!object.mesh.triangles.empty());
          for (const Vec3d& p : object.mesh.positions) tests::require(p.allFinite());
          for (const io::ModelFace& face : object.faces)
            tests::require(face.at.allFinite() && std::abs(face.along.norm() - 1) < 1e-3 && face.width >= 0 &&
                           face.depth >= 0);
          for (const auto& triangle : object.mesh.triangles)
            for (const uint32_t corner : triangle) tests::require(corner < object.mesh.positions.size());
          tests::require(object.vertexColours.empty() || object.vertexColours.size() == object.mesh.positions.size());
          tests::require(object.triangleColours.empty() ||
                         object.triangleColours.size() == object.mesh.triangles.size());
        }
        break;
      }
      case 1:
        for (const io::VdbObject& object : io::readVdb(path)) tests::require(object.version.stats().bricks > 0);
        break;
      case 2: {
        const io::GreyImage image = io::readGreyImage(path, kLargest);
        tests::require(image.grey.size() == size_t(image.width) * size_t(image.height));
        for (const float grey : image.grey) tests::require(grey >= 0 && grey <= 1);
        break;
      }
      default: {
        const io::ColourImage image = io::unpackPicture({}, kLargest);
        tests::require(image.rgba.size() == 4 * size_t(image.width) * size_t(image.height));
      }
    }
  } catch (const Error& error) {
    tests::requireSentence(error);
  }
  return 0;
}
