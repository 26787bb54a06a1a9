#include "engine/models/model_colours.h"

#include <algorithm>
#include <optional>

#include "clay/surface/vertex_channels.h"
#include "io/models/colour_list.h"

namespace argil::engine {

namespace {

/// White, as formats have what has no colour beside what has one.
constexpr std::array<uint8_t, 3> kNoColour{255, 255, 255};

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

clay::Version withColours(clay::Version version, const clay::TriangleMesh& mesh, const io::ModelObject& object,
                          const clay::WorkPart& part) {
  if (!object.places.empty()) {
    const io::PictureColours pictures(object, mesh);
    const double voxel = version.grid().voxelMm;
    return clay::withMeshColours(version, mesh,
                                 {.at =
                                      [&](size_t triangle, const Vec3d& shares) {
                                        const io::Colour c = pictures.at(triangle, shares, voxel);
                                        return std::array{c.red, c.green, c.blue, c.alpha};
                                      }},
                                 part);
  }
  const std::span<const io::Colour> all =
      object.triangleColours.empty() ? object.vertexColours : object.triangleColours;
  if (std::none_of(all.begin(), all.end(), [&](const io::Colour& each) { return opaque(each) != opaque(all.front()); }))
    return version;
  const std::vector<clay::MeshColour> vertices = opaque(object.vertexColours),
                                      triangles = opaque(object.triangleColours);
  return clay::withMeshColours(version, mesh, {.vertices = vertices, .triangles = triangles}, part);
}

std::optional<std::array<float, 3>> pieceColourOf(const io::ModelObject& object,
                                                  const std::optional<io::Colour>& mean) {
  const bool seenThrough = !object.places.empty() && mean && mean->alpha < 255;
  return mean && !seenThrough ? std::optional(colourOf(*mean)) : std::nullopt;
}

std::vector<io::Colour> vertexColoursOf(const clay::Surface& surface, const Piece& piece) {
  const std::vector<clay::VertexPaint> paint = clay::meshPaint(surface);
  const std::vector<std::optional<std::array<uint8_t, 3>>> materials = materialColours(piece);
  const auto chosen = chosenColour(piece);
  const std::array<uint8_t, 3> own = chosen ? bytesOf(*chosen) : kNoColour;
  const auto materialOf = [&](const clay::VertexPaint& each) {
    return each.material > 0 && each.material <= materials.size() ? materials[each.material - 1u] : std::nullopt;
  };
  std::vector<io::Colour> colours;
  if (std::none_of(paint.begin(), paint.end(),
                   [&](const clay::VertexPaint& each) { return each.cover > 0 || materialOf(each); }))
    return colours;
  colours.reserve(paint.size());
  for (const clay::VertexPaint& each : paint) {
    const std::array<uint8_t, 3> ground = materialOf(each).value_or(own);
    const auto over = [&](uint8_t colour, uint8_t under) {
      return static_cast<uint8_t>((colour * each.cover + under * (255 - each.cover) + 127) / 255);
    };
    colours.push_back({over(each.red, ground[0]), over(each.green, ground[1]), over(each.blue, ground[2]), 255});
  }
  return colours;
}

std::array<float, 3> colourOf(const io::Colour& c) {
  return {float(c.red) / 255, float(c.green) / 255, float(c.blue) / 255};
}

io::Colour colourOf(const std::array<float, 3>& c) {
  const auto [red, green, blue] = bytesOf(c);
  return {red, green, blue, 255};
}

std::optional<std::array<float, 3>> chosenColour(const Piece& piece) {
  return piece.colour == Piece().colour ? std::nullopt : std::optional(piece.colour);
}

std::optional<io::Colour> fileColourOf(const Piece& piece) {
  const auto chosen = chosenColour(piece);
  return chosen ? std::optional(colourOf(*chosen)) : std::nullopt;
}

}  // namespace argil::engine
