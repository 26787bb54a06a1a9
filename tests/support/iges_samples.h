#pragma once
// IGES files for tests.

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clay/base/vec.h"

namespace argil::samples {

/// A B-spline surface: points row by row along u, with their weights; knots as often as they count.
struct IgesSurface {
  int degreeU = 1, degreeV = 1;
  std::vector<double> knotsU{0, 0, 1, 1}, knotsV{0, 0, 1, 1};
  std::vector<Vec3d> points;
  std::vector<double> weights;
};

/// IGES of such faces, without anything around them. `colours`: of each, a number that the standard names (2 red, 3
/// green, 4 blue), or none at all.
inline std::string igesOfSurfaces(const std::vector<IgesSurface>& faces, const std::vector<int>& colours = {}) {
  std::string text, parameters, directory;
  const auto line = [](const std::string& content, char section, size_t number) {
    return fmt::format("{:<72}{}{:7}\n", content, section, number);
  };
  text += line("", 'S', 1);
  text += line(",,4Htest,4Htest,4Htest,4Htest,32,38,6,308,15,4Htest,1.,2,2HMM,1,0.01,", 'G', 1);
  text += line("15H20260101.000000,0.001,1000.,4Htest,4Htest,11,0,15H20260101.000000;", 'G', 2);
  size_t number = 1, entry = 1;
  for (const IgesSurface& face : faces) {
    const size_t u = face.knotsU.size() - size_t(face.degreeU) - 2, v = face.knotsV.size() - size_t(face.degreeV) - 2;
    std::vector<std::string> rows{fmt::format("128,{},{},{},{},0,0,0,0,0,", u, v, face.degreeU, face.degreeV)};
    const auto numbers = [&](const std::vector<double>& list) {
      for (const double each : list) rows.push_back(fmt::format("{:.12f},", each));
    };
    numbers(face.knotsU), numbers(face.knotsV), numbers(face.weights);
    for (const Vec3d& p : face.points) rows.push_back(fmt::format("{:.12f},{:.12f},{:.12f},", p.x(), p.y(), p.z()));
    rows.push_back(fmt::format("{:.6f},{:.6f},{:.6f},{:.6f};", face.knotsU.front(), face.knotsU.back(),
                               face.knotsV.front(), face.knotsV.back()));
    const int colour = colours.empty() ? 0 : colours.at((entry - 1) / 2);
    directory +=
        line(fmt::format("{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:08}", 128, number, 0, 0, 0, 0, 0, 0, 0), 'D', entry);
    directory +=
        line(fmt::format("{:8}{:8}{:8}{:8}{:8}{:>24}{:>8}", 128, 0, colour, rows.size(), 0, "", 0), 'D', entry + 1);
    for (const std::string& row : rows) parameters += fmt::format("{:<64}{:8}P{:7}\n", row, entry, number++);
    entry += 2;
  }
  text += directory + parameters;
  return text + line(fmt::format("S{:7}G{:7}D{:7}P{:7}", 1, 2, entry - 1, number - 1), 'T', 1);
}

/// The same of four-sided plane faces.
inline std::string igesOf(const std::vector<std::array<Vec3d, 4>>& faces, const std::vector<int>& colours = {}) {
  std::vector<IgesSurface> surfaces;
  for (const auto& face : faces) {
    IgesSurface surface;
    surface.points = {face[0], face[1], face[3], face[2]};
    surface.weights = {1, 1, 1, 1};
    surfaces.push_back(std::move(surface));
  }
  return igesOfSurfaces(surfaces, colours);
}

/// A curve, in the plane of x and z, that is turned half around z: two rational quarters.
inline IgesSurface halfTurned(int degree, const std::vector<double>& knots, const std::vector<Vec3d>& curve,
                              const std::vector<double>& weights) {
  IgesSurface made{.degreeU = 2,
                   .degreeV = degree,
                   .knotsU = {0, 0, 0, 1, 1, 2, 2, 2},
                   .knotsV = knots,
                   .points = {},
                   .weights = {}};
  const double half = std::sqrt(0.5);
  // Points of half a circle of radius one, those between standing outside; u runs fastest.
  const std::array<std::array<double, 3>, 5> circle{{{1, 0, 1}, {1, 1, half}, {0, 1, 1}, {-1, 1, half}, {-1, 0, 1}}};
  for (size_t i = 0; i < curve.size(); ++i)
    for (const auto& [x, y, weight] : circle) {
      made.points.emplace_back(curve[i].x() * x, curve[i].x() * y, curve[i].z());
      made.weights.push_back(weight * weights[i]);
    }
  return made;
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
