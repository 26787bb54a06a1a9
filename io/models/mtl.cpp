#include "io/models/mtl.h"

#include <algorithm>
#include <cmath>

#include "io/bytes/text_cursor.h"

namespace argil::io {

MaterialLibrary parseMtl(const Input& input) {
  TextCursor cursor(input, {.hashComments = true, .backslashContinues = true});
  MaterialLibrary library;
  std::string material;
  for (; !cursor.atEnd(); cursor.skipLine()) {
    if (!cursor.wordOnLine()) continue;
    const std::string_view word = cursor.word();
    if (word == "newmtl") {
      material = cleanName(cursor.restOfLine());
    } else if (word == "Kd" && !material.empty()) {
      double part[3];
      size_t count = 0;
      while (count < 3 && cursor.wordOnLine() && parseNumber(cursor.word(), part[count]) && std::isfinite(part[count]))
        ++count;
      if (count == 0) continue;  // "spectral" and "xyz" are other ways to say it, which nobody writes
      const auto byte = [&](size_t k) {
        return uint8_t(std::lround(255 * std::clamp(part[k < count ? k : 0], 0.0, 1.0)));
      };
      library.colours[material] = {byte(0), byte(1), byte(2), 255};
    } else if (word.starts_with("map_")) {
      ++library.pictures;
    }
  }
  return library;
}

}  // namespace argil::io
