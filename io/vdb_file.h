#pragma once
// Level sets from and to .vdb files.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "clay/job.h"
#include "clay/store.h"
#include "clay/version.h"
#include "io/mesh_writer.h"

namespace argil::io {

struct VdbObject {
  std::string name;                ///< The grid's.
  clay::Version version;           ///< Full band; φ as the file has it where its band is wide enough.
  std::vector<std::string> notes;  ///< What was done to make it clay: band rebuilt, several grids, ...
};

/// The level sets of a .vdb file (float or half; uniform scale and translation) as clay, each in a store of its own. The file's unit is `unitMm` mm. Fog volumes are refused by name with what to do. Parsed in a process of its own.
/// Throws Error; Cancelled.
[[nodiscard]] std::vector<VdbObject> readVdb(const std::filesystem::path& path, double unitMm = 1, Job* job = nullptr);

/// Writes versions as level sets in mm, whole or not at all: values are distances in mm, the transform says place and voxel size, as other programs expect. Throws Error, Cancelled.
struct VdbView {
  std::string name;
  clay::Version version;
};
WriteReport writeVdb(const std::filesystem::path& path, const std::vector<VdbView>& clays, Job* job = nullptr);

}  // namespace argil::io
