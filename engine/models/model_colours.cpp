#include "engine/models/model_colours.h"

#include <algorithm>
#include <vector>

#include "engine/document/document.h"

namespace argil::engine {

namespace {

clay::MeshColour opaque(const io::Colour& colour) {
  return {colour.red, colour.green, colour.blue};
}

std::vector<clay::MeshColour> opaque(std::span<const io::Colour> colours) {
  std::vector<clay::MeshColour> all;
  all.reserve(colours.size());
  for (const io::Colour& each : colours) all.push_back(opaque(each));
  return all;
}

}  // namespace

bool FileColours::several() const {
  const std::span<const io::Colour> all = triangles.empty() ? vertices : triangles;
  return std::any_of(all.begin(), all.end(),
                     [&](const io::Colour& each) { return opaque(each) != opaque(all.front()); });
}

clay::Version withColours(clay::Version version, const clay::TriangleMesh& mesh, const FileColours& colours,
                          const clay::WorkPart& part) {
  if (!colours.several()) return version;
  const std::vector<clay::MeshColour> vertices = opaque(colours.vertices), triangles = opaque(colours.triangles);
  return clay::withMeshColours(version, mesh, {vertices, triangles}, part);
}

std::array<float, 3> colourOf(const io::Colour& c) {
  return {float(c.red) / 255, float(c.green) / 255, float(c.blue) / 255};
}

io::Colour colourOf(const std::array<float, 3>& c) {
  const auto [red, green, blue] = bytesOf(c);
  return {red, green, blue, 255};
}

}  // namespace argil::engine
