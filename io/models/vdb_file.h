#pragma once
// Level sets from and to .vdb files.

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/base/vec.h"
#include "clay/store/store.h"
#include "clay/store/version.h"
#include "io/models/mesh_writer.h"
#include "io/models/model_file.h"

namespace argil::io {

struct VdbObject {
  std::string name;       ///< The grid's.
  clay::Version version;  ///< Full band; φ as the file has it where its band is wide enough; with its colours.
  /// Of the clay about zero, to where the file has it.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  std::optional<Colour> colour;    ///< Of the whole, where the file says so.
  std::vector<std::string> notes;  ///< What was done to make it clay: band rebuilt, several grids, ...
};

/// The level sets of a .vdb file (float, half or double) as clay, each in a store of its own; where a transform is more
/// than a uniform scale, a rotation and a translation, distances are made anew. A grid of three numbers (linear light)
/// that the level set names in `colours`, or that is called Cd or color, with the level set's name and a dot before it
/// or alone, gives its colours, at the nearest sample. The file's unit is `unitMm` mm. Fog volumes are refused by name
/// with what to do. Parsed in a process of its own. Throws Error; Cancelled.
[[nodiscard]] std::vector<VdbObject> readVdb(const std::filesystem::path& path, double unitMm = 1, Job* job = nullptr);

struct VdbView {
  std::string name;
  clay::Version version;
  Vec3d positionMm = Vec3d::Zero();  ///< World = rotation · clay + this.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  std::optional<Colour> colour = {};  ///< The piece's own.
  /// sRGB of material 1, 2, ..., where it has one.
  std::vector<std::optional<std::array<uint8_t, 3>>> materials = {};
};
/// Writes versions as level sets in mm, whole or not at all: values are distances in mm, the transform says place and
/// voxel size, as other programs expect. What is painted, or of a material with a colour, is a grid `NAME.Cd` beside it
/// (`Cd` where the level set is the only one): linear light, half floats, active where the colour is not the piece's
/// own. Throws Error, Cancelled.
WriteReport writeVdb(const std::filesystem::path& path, const std::vector<VdbView>& clays, Job* job = nullptr);

}  // namespace argil::io
