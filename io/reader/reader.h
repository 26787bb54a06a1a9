#pragma once
// What argil-reader can read. Each throws Error, a sentence without the file's name.

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/reader/sender.h"

namespace argil::io::reader {

/// A regular file that is not empty, whole; kInput names what the process was given as its standard input. `most`:
/// bytes.
inline constexpr const char* kInput = "-";
[[nodiscard]] std::vector<unsigned char> contentOf(const std::filesystem::path& file,
                                                   uint64_t most = uint64_t{1} << 31);

/// A scene of a .gltf or .glb file: an object for each node that shows a mesh, in metres, z up.
void readGltf(const std::filesystem::path& file, Sender& sender);
/// A .drc mesh as one object, in its own units and axes.
void readDraco(const std::filesystem::path& file, Sender& sender);
/// The level sets of a .vdb file, as bricks.
void readVdb(const std::filesystem::path& file, Sender& sender);
enum class PictureAs : uint8_t {
  grey,    ///< As wire::Kind::levels.
  colour,  ///< As wire::Kind::pixels.
};
struct DecodedPicture {
  uint32_t width = 0, height = 0;
  std::vector<std::array<uint8_t, 4>> pixels;  ///< sRGB and alpha, row by row from the top.
};
/// A picture in colour from the bytes of its file. Throws Error, which does not name it.
[[nodiscard]] DecodedPicture decodePicture(std::span<const unsigned char> bytes, int largest);
/// A picture of at most `largest` pixels along an edge.
void readPicture(const std::filesystem::path& file, PictureAs as, int largest, Sender& sender);
/// Tries what the sandbox forbids and sends a note for each thing that worked: for tests.
void tryForbidden(const std::filesystem::path& file, Sender& sender);

}  // namespace argil::io::reader
