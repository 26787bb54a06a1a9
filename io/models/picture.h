#pragma once
// Pictures from others: height maps from files, previews out of documents. All are parsed in the reader process
// (reader_process.h): a picture that crashes its library takes nothing else with it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "clay/base/job.h"

namespace argil::io {

struct GreyImage {
  int width = 0, height = 0;
  std::vector<float> grey;  ///< 0 black to 1 white, row by row from the top.
};

struct ColourImage {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;  ///< Four bytes a pixel, sRGB and alpha, row by row from the top.
};

/// Reads PNG, JPEG, BMP, TGA or PGM, 8 or 16 bits, colours as their brightness. Throws Error for a file that is
/// missing, is none of these, has more than `largest` pixels along an edge, or is damaged where its format tells (a PGM
/// that ends early does not); Cancelled. Starts a process: some 40 ms beside the work. Any thread but the servo's.
[[nodiscard]] GreyImage readGreyImage(const std::filesystem::path& file, int largest, Job* job = nullptr);

/// The same formats from a file, in colour.
[[nodiscard]] ColourImage readColourImage(const std::filesystem::path& file, int largest, Job* job = nullptr);

/// The same formats from memory, in colour: a preview may come from anybody's document. Errors name it "the picture".
[[nodiscard]] ColourImage unpackPicture(std::span<const std::byte> bytes, int largest, Job* job = nullptr);

}  // namespace argil::io
