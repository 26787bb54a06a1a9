#include "io/reader/mesh_data.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "clay/base/error.h"

namespace argil::io::reader {

uint8_t plainByte(double value) {
  return uint8_t(std::clamp(value, 0.0, 1.0) * 255 + 0.5);
}

uint8_t srgbByte(double linear) {
  const double l = std::clamp(linear, 0.0, 1.0);
  return plainByte(l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
}

void sendMesh(const MeshData& mesh, std::string_view name, Sender& sender) {
  if (mesh.positions.size() > UINT32_MAX) throw Error("has more vertices than can be numbered; split it first");
  for (const auto& [x, y, z] : mesh.positions) {
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
      throw Error("has a vertex whose coordinates are not finite; export it again");
  }
  wire::Object object{.vertices = mesh.positions.size(),
                      .triangles = mesh.triangles.size(),
                      .colour = {},
                      .hasColour = mesh.colour.has_value(),
                      .hasColours = !mesh.colours.empty(),
                      .hasTriangleColours = !mesh.triangleColours.empty()};
  if (mesh.colour) std::copy(mesh.colour->begin(), mesh.colour->end(), object.colour);
  sender.named(wire::Kind::object, object, name);
  sender.array(wire::Kind::positions, std::span<const std::array<double, 3>>(mesh.positions));
  sender.array(wire::Kind::triangles, std::span<const std::array<uint32_t, 3>>(mesh.triangles));
  sender.array(wire::Kind::colours, std::span<const Bytes4>(mesh.colours));
  sender.array(wire::Kind::triangleColours, std::span<const Bytes4>(mesh.triangleColours));
  const auto finite = [](const wire::Face& face) {
    double sum = face.width + face.depth;
    for (int axis = 0; axis < 3; ++axis) sum += face.at[axis] + face.along[axis] + face.across[axis];
    return std::isfinite(sum);
  };
  std::vector<wire::Face> faces;
  std::copy_if(mesh.faces.begin(), mesh.faces.end(), std::back_inserter(faces), finite);
  faces.resize(std::min<size_t>(faces.size(), wire::kMostFaces));
  sender.array(wire::Kind::faces, std::span<const wire::Face>(faces));
}

}  // namespace argil::io::reader
