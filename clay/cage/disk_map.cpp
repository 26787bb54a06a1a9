#include "clay/cage/disk_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

namespace argil::clay {

namespace {

// Sweeps over all vertices: of 20 rows each then lies within a hundredth of a row of its place.
constexpr int kSweeps = 80;
constexpr double kRelaxed = 1.6;  // of the way to the mean

using Flat = std::map<uint32_t, Eigen::Vector2d>;

// Vertices of the border at angles between 0 and 1, the others each in the mean of those beside it.
Flat flattened(const QuadDisk& disk, const std::map<uint32_t, double>& angles) {
  std::map<uint32_t, size_t> number;
  for (const auto& quad : disk.quads)
    for (const uint32_t v : quad) number.emplace(v, 0);
  std::vector<Eigen::Vector2d> place;
  std::vector<bool> fixed;
  for (auto& [v, n] : number) {
    n = place.size();
    const auto angle = angles.find(v);
    fixed.push_back(angle != angles.end());
    const double turn = fixed.back() ? 2 * std::numbers::pi * angle->second : 0;
    place.push_back(fixed.back() ? Eigen::Vector2d(std::cos(turn), std::sin(turn)) : Eigen::Vector2d(0, 0));
  }
  std::vector<std::vector<size_t>> beside(place.size());
  for (const auto& quad : disk.quads)
    for (size_t s = 0; s < 4; ++s) beside[number.at(quad[s])].push_back(number.at(quad[(s + 1) & 3]));
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (size_t v = 0; v < place.size(); ++v) {
      if (fixed[v]) continue;
      Eigen::Vector2d mean(0, 0);
      for (const size_t each : beside[v]) mean += place[each] / double(beside[v].size());
      place[v] += kRelaxed * (mean - place[v]);
    }
  Flat out;
  for (const auto& [v, n] : number) out.emplace(v, place[n]);
  return out;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<std::pair<uint32_t, Vec3d>> placesOn(const QuadDisk& was, const QuadDisk& is,
                                                 const std::function<Vec3d(uint32_t)>& at) {
  std::map<uint32_t, double> before, after;
  double length = 0;
  for (size_t i = 0; i < was.sides.size(); ++i) {
    const BorderSide &old = was.sides[i], &made = is.sides.at(i);
    const double first = length;
    for (size_t k = 0; k + 1 < old.size(); ++k) {
      before.emplace(old[k], length);
      length += (at(old[k + 1]) - at(old[k])).norm();
    }
    for (size_t k = 0; k + 1 < made.size(); ++k)
      after.emplace(made[k],
                    made == old ? before.at(made[k]) : first + (length - first) * double(k) / double(made.size() - 1));
  }
  for (auto* angles : {&before, &after})
    for (auto& [v, angle] : *angles) angle /= length;
  const Flat from = flattened(was, before), to = flattened(is, after);
  struct Corner {
    Eigen::Vector2d flat;
    Vec3d at;
  };
  std::vector<std::array<Corner, 3>> triangles;
  for (const auto& q : was.quads)
    for (const size_t k : {size_t{1}, size_t{2}}) {
      std::array<Corner, 3> triangle;
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t v = q[c == 0 ? 0 : k + c - 1];
        triangle[c] = {from.at(v), at(v)};
      }
      triangles.push_back(triangle);
    }
  std::vector<std::pair<uint32_t, Vec3d>> out;
  for (const auto& [v, p] : to) {
    if (after.contains(v)) continue;
    // In the triangle that it lies in, or the least outside.
    double most = -std::numeric_limits<double>::infinity();
    Vec3d place = Vec3d::Zero();
    for (const auto& [a, b, c] : triangles) {
      const Eigen::Vector2d u = b.flat - a.flat, w = c.flat - a.flat;
      const double area = cross(u, w);
      if (std::abs(area) < 1e-14) continue;
      const double y = cross(p - a.flat, w) / area, z = cross(u, p - a.flat) / area,
                   least = std::min({1 - y - z, y, z});
      if (least <= most) continue;
      most = least;
      place = (1 - y - z) * a.at + y * b.at + z * c.at;
    }
    out.emplace_back(v, place);
  }
  return out;
}

}  // namespace argil::clay
