#pragma once
// The colours of a Wavefront material library, which OBJ files name. For this module's files.

#include <cstdint>
#include <map>
#include <string>

#include "io/bytes/input.h"
#include "io/models/model_file.h"

namespace argil::io {

struct MaterialLibrary {
  std::map<std::string, Colour> colours;  ///< Kd of each material that has one: sRGB, as viewers take it.
  uint64_t pictures = 0;                  ///< map_ lines: textures, which are not read.
};

/// Lines that are no colour are passed over: a material without a colour is less than a model that cannot be read.
[[nodiscard]] MaterialLibrary parseMtl(const Input& input);

}  // namespace argil::io
