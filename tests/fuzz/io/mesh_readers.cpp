// libFuzzer entry over every mesh reader: any bytes must give a mesh that keeps its promises, or an Error of one line.
// The first byte chooses the ending of the name, so that content that no format recognizes reaches every reader.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "clay/mesh_topology.h"
#include "io/mesh_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  if (size == 0) return 0;
  constexpr const char* kNames[] = {"input.stl", "input.obj", "input.ply", "input.off", "input"};
  const char* name = kNames[data[0] % std::size(kNames)];
  try {
    const io::MeshFile file = io::parseMesh({reinterpret_cast<const std::byte*>(data + 1), size - 1}, name);
    if (file.mesh.triangles.empty()) std::abort();
    for (const Vec3d& p : file.mesh.positions) {
      if (!p.allFinite()) std::abort();
    }
    (void)clay::checkTopology(file.mesh);  // Throws when an index is out of range.
  } catch (const Error& error) {
    if (error.kind() != Error::Kind::input || std::strpbrk(error.what(), "\r\n") != nullptr) std::abort();
  }
  return 0;
}
