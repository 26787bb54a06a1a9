#include "io/models/mtl.h"

#include <algorithm>
#include <cmath>

#include "io/bytes/text_cursor.h"

namespace argil::io {

namespace {

/// Options of a map take so many words at most; those that are numbers alone may be fewer.
struct MapOption {
  std::string_view name;
  size_t words;
};
constexpr MapOption kOptions[] = {{"-blendu", 1}, {"-blendv", 1},  {"-bm", 1},  {"-boost", 1}, {"-cc", 1},
                                  {"-clamp", 1},  {"-imfchan", 1}, {"-mm", 2},  {"-o", 3},     {"-s", 3},
                                  {"-t", 3},      {"-texres", 1},  {"-type", 1}};

/// Reads what follows "map_Kd": options, then the name of a file, which may have blanks in it.
MaterialMap readMap(TextCursor& cursor) {
  MaterialMap map;
  while (cursor.wordOnLine()) {
    TextCursor ahead = cursor;
    const std::string_view word = ahead.word();
    const auto option = std::find_if(std::begin(kOptions), std::end(kOptions),
                                     [&](const MapOption& each) { return each.name == word; });
    if (option == std::end(kOptions)) break;
    cursor.word();
    double number[3] = {};
    size_t numbers = 0;
    if (option->name == "-clamp") {
      map.clamp = cursor.word() == "on";
    } else if (option->words == 1) {
      cursor.word();
    } else {
      for (; numbers < option->words && cursor.wordOnLine(); ++numbers) {
        TextCursor next = cursor;
        if (!parseNumber(next.word(), number[numbers]) || !std::isfinite(number[numbers])) break;
        cursor.word();
      }
    }
    if (option->name == "-s")
      for (size_t k = 0; k < std::min<size_t>(numbers, 2); ++k) map.scale[k] = number[k];
    if (option->name == "-o")
      for (size_t k = 0; k < std::min<size_t>(numbers, 2); ++k) map.offset[k] = number[k];
  }
  std::string_view rest = cursor.restOfLine();
  while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\t')) rest.remove_suffix(1);
  map.file = rest;
  return map;
}

}  // namespace

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
      library.materials[material].colour = Colour{byte(0), byte(1), byte(2), 255};
    } else if ((word == "d" || word == "Tr") && !material.empty()) {
      double amount = 1;
      if (!cursor.wordOnLine() || !parseNumber(cursor.word(), amount) || !std::isfinite(amount)) continue;
      library.materials[material].opacity = std::clamp(word == "d" ? amount : 1 - amount, 0.0, 1.0);
    } else if (word == "map_Kd" && !material.empty()) {
      library.materials[material].map = readMap(cursor);
    } else if (word.starts_with("map_")) {
      ++library.pictures;
    }
  }
  return library;
}

}  // namespace argil::io
