#pragma once
// Triangles on their way from a library to the wire.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "io/reader/sender.h"

namespace argil::io::reader {

using Bytes4 = std::array<uint8_t, 4>;

struct MeshData {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<Bytes4> colours;                      ///< sRGB, one a vertex, or empty.
  std::vector<Bytes4> triangleColours;              ///< sRGB, one a triangle, or empty.
  std::optional<Bytes4> colour;                     ///< Of all, sRGB.
  std::vector<std::array<float, 2>> texturePlaces;  ///< One a vertex, or empty.
  std::vector<wire::Face> faces;
};

/// 0 to 1, linear light, as a byte of sRGB (IEC 61966-2-1); a byte without the curve.
[[nodiscard]] uint8_t srgbByte(double linear);
[[nodiscard]] uint8_t plainByte(double value);

/// The triangles of a Draco stream. Attributes are named by their unique id; none: the stream's own first POSITION and
/// COLOR. `linearFactor`: its colours are linear light to be multiplied by that, as glTF's are; none: sRGB. Throws
/// Error.
[[nodiscard]] MeshData decodeDraco(std::span<const unsigned char> bytes, std::optional<uint64_t> positionId = {},
                                   std::optional<uint64_t> colourId = {},
                                   const std::optional<std::array<double, 4>>& linearFactor = {},
                                   std::optional<uint64_t> placesId = {});

/// Sends it as one object. Throws Error for what is not finite or out of range: the last look at what libraries gave.
void sendMesh(const MeshData& mesh, std::string_view name, Sender& sender);

}  // namespace argil::io::reader
