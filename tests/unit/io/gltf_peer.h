#pragma once
// glTF as tinygltf with Draco reads it: an independent look at what we write.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "clay/base/vec.h"

namespace argil::io {

struct PeerObject {
  std::string name;
  std::vector<Vec3d> positionsMm;  ///< The node's translation applied; turned to z up.
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<std::array<uint8_t, 4>> colours;  ///< sRGB.
  std::vector<Vec3d> normals;                   ///< One a position, or empty; turned to z up.
  std::array<uint8_t, 4> baseColour = {255, 255, 255, 255};
  double metallic = 1, roughness = 1;
  bool material = false;
};

/// One for each node, each of one primitive. Fails the test when tinygltf says no.
[[nodiscard]] std::vector<PeerObject> readByPeer(const std::filesystem::path& path);
/// What a program must know to open the file.
[[nodiscard]] std::vector<std::string> requiredByPeer(const std::filesystem::path& path);

}  // namespace argil::io
