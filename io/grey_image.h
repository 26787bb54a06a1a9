#pragma once
// A picture file as grey levels: height maps for textures.

#include <filesystem>
#include <vector>

namespace argil::io {

struct GreyImage {
  int width = 0, height = 0;
  std::vector<float> grey;  ///< 0 black to 1 white, row by row from the top.
};

/// Reads PNG, JPEG, BMP, TGA or PGM, 8 or 16 bits, colours as their brightness. Throws Error for a file that is missing, is none
/// of these, has more than `largest` pixels along an edge, or is damaged where its format tells (a PGM that ends early does not).
[[nodiscard]] GreyImage readGreyImage(const std::filesystem::path& file, int largest);

}  // namespace argil::io
