#pragma once
// What every target for a mesh reader checks: any bytes give a model that keeps its promises, or an Error of one line.

#include <cstdint>
#include <span>
#include <string>

#include "io/models/model_file.h"
#include "tests/fuzz/require.h"

namespace argil::tests {

inline void requirePromises(const io::ModelFile& model) {
  require(!model.objects.empty());
  for (const io::ModelObject& object : model.objects) {
    require(!object.mesh.triangles.empty());
    for (const Vec3d& p : object.mesh.positions) require(p.allFinite());
    for (const auto& triangle : object.mesh.triangles) {
      for (const uint32_t corner : triangle) require(corner < object.mesh.positions.size());
    }
    require(object.vertexColours.empty() || object.vertexColours.size() == object.mesh.positions.size());
    require(object.triangleColours.empty() || object.triangleColours.size() == object.mesh.triangles.size());
    (void)io::meanColour(object);
  }
}

/// `name` decides which reader takes what no format recognizes.
inline int readAsModel(const uint8_t* data, size_t size, const std::string& name) {
  try {
    requirePromises(io::parseModel(std::as_bytes(std::span(data, size)), name));
  } catch (const Error& error) {
    requireSentence(error);
  }
  return 0;
}

}  // namespace argil::tests
