#include "engine/text/texture_text.h"

#include <charconv>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "io/bytes/input.h"
#include "io/models/picture.h"

namespace argil::engine {
namespace {

constexpr int kLargestImage = 4096;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == at)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

[[noreturn]] void refuse(const std::string& text) {
  throw Error(
      fmt::format("--texture {}: give ridges:WAVELENGTH:AMPLITUDE[:X,Y,Z], bumps:WAVELENGTH:AMPLITUDE, "
                  "grain:WAVELENGTH:AMPLITUDE[:OCTAVES] or image:FILE:MM_PER_PIXEL:AMPLITUDE, in mm",
                  io::shown(text)));
}

}  // namespace

std::vector<double> parseNumbers(const std::string& text, size_t count, const std::string& what) {
  std::vector<double> numbers;
  for (const std::string& part : split(text, ',')) {
    double value = 0;
    const auto [end, code] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (code != std::errc() || end != part.data() + part.size() || !std::isfinite(value))
      throw Error(fmt::format("{} {}: '{}' is not a finite number", what, io::shown(text), io::shown(part)));
    numbers.push_back(value);
  }
  if (numbers.size() != count)
    throw Error(fmt::format("{} {}: {} {} wanted, separated by commas", what, io::shown(text), count,
                            count == 1 ? "number is" : "numbers are"));
  return numbers;
}

std::shared_ptr<const haptics::Texture> parseTexture(const std::string& text) {
  const std::vector<std::string> parts = split(text, ':');
  const std::string what = "--texture " + parts[0] + ":";
  const auto number = [&](size_t i) { return parseNumbers(parts[i], 1, what)[0]; };
  const size_t n = parts.size();
  try {
    if (parts[0] == "ridges" && (n == 3 || n == 4)) {
      haptics::Ridges ridges{number(1), number(2)};
      if (n == 4) ridges.across = Vec3d(parseNumbers(parts[3], 3, what).data());
      return std::make_shared<const haptics::Texture>(ridges);
    }
    if (parts[0] == "bumps" && n == 3)
      return std::make_shared<const haptics::Texture>(haptics::Bumps{number(1), number(2)});
    if (parts[0] == "grain" && (n == 3 || n == 4)) {
      haptics::Grain grain{number(1), number(2)};
      if (n == 4) {
        const double octaves = number(3);
        if (octaves != std::floor(octaves) || std::abs(octaves) > 100)
          throw Error("texture: octaves are a whole number");
        grain.octaves = static_cast<int>(octaves);
      }
      return std::make_shared<const haptics::Texture>(grain);
    }
    if (parts[0] == "image" && n >= 4) {
      // A file's name may hold colons.
      std::string file = parts[1];
      for (size_t i = 2; i + 2 < n; ++i) file += ":" + parts[i];
      haptics::HeightMap map;
      map.mmPerPixel = number(n - 2);
      map.amplitudeMm = number(n - 1);
      io::GreyImage image = io::readGreyImage(file, kLargestImage);
      map.width = image.width;
      map.height = image.height;
      map.grey = std::move(image.grey);
      return std::make_shared<const haptics::Texture>(map);
    }
  } catch (const Error& e) {
    const std::string sentence = e.what();
    if (!sentence.starts_with("texture: ")) throw;
    throw Error(fmt::format("--texture {}: {}", io::shown(text), sentence.substr(9)));
  }
  refuse(text);
}

}  // namespace argil::engine
