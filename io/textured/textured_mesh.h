#pragma once
// Meshes of quads with pictures on them, to OBJ and glTF.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/cage/quad_mesh.h"
#include "clay/unwrap/bake.h"
#include "clay/unwrap/unwrap.h"
#include "io/models/model_file.h"

namespace argil::io {

struct TexturedObject {
  std::string name;
  std::optional<Colour> colour;                      ///< Of the whole, where there is no picture of it; or none.
  clay::QuadMesh mesh;                               ///< mm.
  clay::UvMap map;                                   ///< Of the mesh.
  clay::UvFrames frames;                             ///< Of the map, turned as the mesh is.
  std::vector<std::byte> colours, normals, heights;  ///< PNG, or empty: as clay::BakedPictures has them.
  double heightMm = 0;                               ///< Of `heights`.
};

/// Whether a file of this ending can hold them: .obj, .glb.
[[nodiscard]] bool holdsTextures(const std::filesystem::path& file);

/// Names of the files that may come beside an OBJ of so many objects.
[[nodiscard]] std::vector<std::string> texturedNames(const std::filesystem::path& file, size_t objects);

/// OBJ: quads, with NAME.mtl and the pictures beside it (NAME_colour.png, NAME_normal.png, NAME_displacement.png; from
/// the second object on with its number). GLB: triangles, pictures inside, without the heights, which glTF has no word
/// for. All files or none, but for a power cut between them. Gives the names of the files. Throws Error, Cancelled.
std::vector<std::string> writeTextured(const std::filesystem::path& file, std::span<const TexturedObject> objects,
                                       Job* job = nullptr);

}  // namespace argil::io
