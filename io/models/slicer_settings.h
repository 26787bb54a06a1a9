#pragma once
// What slicers write into a 3MF package beside the standard: which volumes are cut away, and which are no clay at all.
// For this module's files.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/bytes/input.h"
#include "io/bytes/zip_reader.h"

namespace argil::io {

enum class VolumeKind : uint8_t {
  solid,
  negative,  ///< Cut away from the solid ones of its object.
  modifier,  ///< Other settings hold in it.
  support,   ///< Supports are wanted or unwanted in it.
};

/// A run of triangles of an object's one mesh (PrusaSlicer, SuperSlicer).
struct SlicerVolume {
  uint64_t first = 0, last = 0;  ///< Both belong to it.
  VolumeKind kind = VolumeKind::solid;
  std::string name;
};

/// A component of an object (Bambu Studio, OrcaSlicer).
struct SlicerPart {
  VolumeKind kind = VolumeKind::solid;
  std::string name;
};

/// By ids of objects of the package's first model part.
struct SlicerSettings {
  std::map<uint32_t, std::string> names;
  std::map<uint32_t, std::vector<SlicerVolume>> volumes;
  std::map<std::pair<uint32_t, uint32_t>, SlicerPart>
      parts;            ///< Of an object, and the object that its component names.
  std::string trouble;  ///< A sentence when they are there and cannot be read; then all else is empty.
};

/// Slic3r_PE_model.config and model_settings.config. Never refuses a package for what slicers alone understand.
[[nodiscard]] SlicerSettings readSlicerSettings(ZipReader& zip, const Input& input);

}  // namespace argil::io
