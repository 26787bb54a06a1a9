// glTF, text and binary: what the reader process does with the file, and then the editor with what it sends. Both in
// this process. Draco's own streams are left out: its library is others', and dies in the reader alone.
#include <string_view>

#include "io/models/model_file.h"
#include "io/models/reader_process.h"
#include "io/reader/reader.h"
#include "tests/fuzz/file_input.h"
#include "tests/fuzz/io/reader_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text.find("draco") != std::string_view::npos) return 0;
  static tests::MemoryFile file;
  const auto path = file.holding(data, size);
  const auto spoken = tests::spokenBy([&](io::reader::Sender& sender) { io::reader::readGltf(path, sender); });
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (spoken.empty() || (!text.starts_with("glTF") && (first == std::string_view::npos || text[first] != '{')))
    return 0;
  // Whatever the file was: the reader keeps to the rules of the wire, so none of this throws.
  const io::SpokenReader reader(spoken);
  const io::ModelFile model = io::readModel(path);
  tests::require(!model.objects.empty() && model.unitMm == 1000);
  for (const io::ModelObject& object : model.objects) {
    tests::require(!object.mesh.triangles.empty());
    for (const Vec3d& p : object.mesh.positions) tests::require(p.allFinite());
    for (const auto& triangle : object.mesh.triangles)
      for (const uint32_t corner : triangle) tests::require(corner < object.mesh.positions.size());
    tests::require(object.vertexColours.empty() || object.vertexColours.size() == object.mesh.positions.size());
    tests::require(object.triangleColours.empty() || object.triangleColours.size() == object.mesh.triangles.size());
  }
  return 0;
}
