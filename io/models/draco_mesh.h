#pragma once
// Triangles packed with Draco, for .drc and glTF. For this module's files.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "io/models/surface_points.h"

namespace draco {
class EncoderBuffer;
}

namespace argil::io {

/// A position in numbers and axes of the file.
using FilePoint = std::array<float, 3>;

/// How mm become the numbers of a file, and the way back.
struct Placement {
  std::function<FilePoint(const Vec3d&)> toFile;
  std::function<Vec3d(const FilePoint&)> toMm;
  std::function<FilePoint(const FilePoint&)> directionToFile;  ///< Turned alone.
};

struct DracoStream {
  std::shared_ptr<draco::EncoderBuffer> buffer;
  uint64_t points = 0, triangles = 0;          ///< As the stream has them: triangles that repeat a corner go.
  int position = 0, colour = -1, normal = -1;  ///< Unique ids of its attributes; −1: none.
  FilePoint low{}, high{};                     ///< Box of the positions as they will be decoded.
  double coordinateMm = 0, distanceMm = 0;     ///< The most that a coordinate, a vertex moved.
  [[nodiscard]] std::span<const std::byte> bytes() const;
};

/// What glTF wants otherwise than .drc files have it.
enum class DracoFor : uint8_t {
  drc,   ///< Colours as sRGB bytes, no normals.
  gltf,  ///< Colours as 16-bit linear light, normals in axes of the file.
};

/// `errorMm` as WriteOptions::quantization; normals go into glTF alone. Objects become one mesh. Memory: about 130
/// bytes a triangle. Throws Error (kind work), Cancelled between its steps.
[[nodiscard]] DracoStream packDraco(std::span<const ModelObject> objects, const Placement& placement, double errorMm,
                                    DracoFor what, Normals normals, Job* job);

/// A byte of sRGB as 16 bits of linear light (IEC 61966-2-1); there and back every byte is kept.
[[nodiscard]] uint16_t linearOf(uint8_t srgb);

}  // namespace argil::io
