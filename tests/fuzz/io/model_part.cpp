// libFuzzer entry over the XML of 3MF: behind the checksums of an archive few mutations would reach it. The first byte
// is passed over.
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "io/models/three_mf_part.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  if (size == 0) return 0;
  const io::Input input{{reinterpret_cast<const std::byte*>(data + 1), size - 1}, "input.3mf"};
  try {
    io::three_mf::Losses losses;
    const io::three_mf::Part part = io::three_mf::readPart(input, "3D/3dmodel.model", losses);
    for (const auto& [id, object] : part.objects) {
      const io::ModelObject& content = object.content;
      for (const Vec3d& p : content.mesh.positions) {
        if (!p.allFinite()) std::abort();
      }
      for (const auto& triangle : content.mesh.triangles) {
        for (const uint32_t corner : triangle) {
          if (corner >= content.mesh.positions.size()) std::abort();
        }
      }
      if (!content.triangleColours.empty() && content.triangleColours.size() != content.mesh.triangles.size())
        std::abort();
      if (!content.vertexColours.empty() && content.vertexColours.size() != content.mesh.positions.size()) std::abort();
    }
  } catch (const Error& error) {
    if (error.kind() != Error::Kind::input || std::strpbrk(error.what(), "\r\n") != nullptr) std::abort();
  }
  return 0;
}
