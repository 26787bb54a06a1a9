#pragma once
// glTF as tinygltf with Draco reads it: an independent look at what we write.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "clay/vec.h"

namespace argil::io {

struct PeerObject {
  std::string name;
  std::vector<Vec3d> positionsMm;  ///< The node's translation applied; turned to z up.
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<std::array<uint8_t, 4>> colours;  ///< sRGB.
  std::array<uint8_t, 4> baseColour = {255, 255, 255, 255};
};

/// One for each node, each of one primitive. Fails the test when tinygltf says no.
[[nodiscard]] std::vector<PeerObject> readByPeer(const std::filesystem::path& path);

}  // namespace argil::io
