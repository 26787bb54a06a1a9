#pragma once
// IGES files for tests.

#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "clay/base/vec.h"

namespace argil::samples {

/// IGES of four-sided plane faces: rational B-spline surfaces of degree one, without anything around them. `colours`:
/// of each, a number that the standard names (2 red, 3 green, 4 blue), or none at all.
inline std::string igesOf(const std::vector<std::array<Vec3d, 4>>& faces, const std::vector<int>& colours = {}) {
  std::string text, parameters, directory;
  const auto line = [](const std::string& content, char section, size_t number) {
    return fmt::format("{:<72}{}{:7}\n", content, section, number);
  };
  text += line("", 'S', 1);
  text += line(",,4Htest,4Htest,4Htest,4Htest,32,38,6,308,15,4Htest,1.,2,2HMM,1,0.01,", 'G', 1);
  text += line("15H20260101.000000,0.001,1000.,4Htest,4Htest,11,0,15H20260101.000000;", 'G', 2);
  size_t number = 1, entry = 1;
  for (const auto& face : faces) {
    std::vector<std::string> rows{"128,1,1,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,"};
    for (const size_t i : {0, 1, 3, 2})
      rows.push_back(fmt::format("{:.6f},{:.6f},{:.6f},", face[i].x(), face[i].y(), face[i].z()));
    rows.emplace_back("0.,1.,0.,1.;");
    directory +=
        line(fmt::format("{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:08}", 128, number, 0, 0, 0, 0, 0, 0, 0), 'D', entry);
    const int colour = colours.empty() ? 0 : colours.at((entry - 1) / 2);
    directory +=
        line(fmt::format("{:8}{:8}{:8}{:8}{:8}{:>24}{:>8}", 128, 0, colour, rows.size(), 0, "", 0), 'D', entry + 1);
    for (const std::string& row : rows) parameters += fmt::format("{:<64}{:8}P{:7}\n", row, entry, number++);
    entry += 2;
  }
  text += directory + parameters;
  return text + line(fmt::format("S{:7}G{:7}D{:7}P{:7}", 1, 2, entry - 1, number - 1), 'T', 1);
}
/// Of a box with a corner at zero, each counter-clockwise from outside.
inline std::vector<std::array<Vec3d, 4>> boxFaces(const Vec3d& size) {
  const auto corner = [&](int i) { return Vec3d((i & 1) * size.x(), (i >> 1 & 1) * size.y(), (i >> 2) * size.z()); };
  std::vector<std::array<Vec3d, 4>> faces;
  for (const auto& f : std::vector<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    faces.push_back({corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3])});
  return faces;
}

}  // namespace argil::samples
