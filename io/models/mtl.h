#pragma once
// The colours of a Wavefront material library, which OBJ files name. For this module's files.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "io/bytes/input.h"
#include "io/models/model_file.h"

namespace argil::io {

/// The picture of a material's colour (map_Kd).
struct MaterialMap {
  std::string file;  ///< As the library names it; empty: none.
  std::array<double, 2> scale{1, 1}, offset{0, 0};
  bool clamp = false;
};

struct Material {
  std::optional<Colour> colour;  ///< Kd, sRGB, as viewers take it.
  double opacity = 1;            ///< d, or what Tr leaves.
  MaterialMap map;
};

struct MaterialLibrary {
  std::map<std::string, Material> materials;
  uint64_t pictures = 0;  ///< Lines that name other pictures than of colours, which are not read.
};

/// Lines that are no colour are passed over: a material without a colour is less than a model that cannot be read.
[[nodiscard]] MaterialLibrary parseMtl(const Input& input);

}  // namespace argil::io
