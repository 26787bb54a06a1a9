#pragma once
// Triangles packed with Draco, for .drc and glTF. For this room's files.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "io/model_file.h"

namespace draco {
class EncoderBuffer;
}

namespace argil::io {

/// Points of a mesh whose colours may jump from triangle to triangle: a vertex of several colours becomes several
/// points.
struct ColouredPoints {
  std::vector<uint32_t> vertex;                    ///< Of each point; empty: points are the vertices.
  std::vector<Colour> colours;                     ///< One a point, or empty.
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Of points; empty with `vertex`.
};
[[nodiscard]] ColouredPoints pointsOf(const ModelObject& object);

/// A position in numbers and axes of the file.
using FilePoint = std::array<float, 3>;

/// How mm become the numbers of a file, and the way back.
struct Placement {
  std::function<FilePoint(const Vec3d&)> toFile;
  std::function<Vec3d(const FilePoint&)> toMm;
};

struct DracoStream {
  std::shared_ptr<draco::EncoderBuffer> buffer;
  uint64_t points = 0, triangles = 0;       ///< As the stream has them: triangles that repeat a corner go.
  int position = 0, colour = -1;            ///< Unique ids of its attributes; −1: none.
  FilePoint low{}, high{};                  ///< Box of the positions as they will be decoded.
  double coordinateMm = 0, distanceMm = 0;  ///< The most that a coordinate, a vertex moved.
  [[nodiscard]] std::span<const std::byte> bytes() const;
};

/// `errorMm` as WriteOptions::quantization. Colours are written as 16-bit linear light where `linear`, else as sRGB
/// bytes. Objects become one mesh. Memory: about 130 bytes a triangle. Throws Error (kind work), Cancelled between its
/// steps.
[[nodiscard]] DracoStream packDraco(std::span<const ModelObject> objects, const Placement& placement, double errorMm,
                                    bool linear, Job* job);

/// A byte of sRGB as 16 bits of linear light (IEC 61966-2-1); there and back every byte is kept.
[[nodiscard]] uint16_t linearOf(uint8_t srgb);

}  // namespace argil::io
