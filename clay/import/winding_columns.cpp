#include "clay/import/winding_columns.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace argil::clay {

namespace {

struct Point2 {
  double y, z;
};

/// Where an edge meets the plane of an x. Always computed from the vertex of lower index, so that both faces at the
/// edge get the same bits.
Point2 edgeAt(const TriangleMesh& mesh, uint32_t from, uint32_t to, double x) {
  const Vec3d& a = mesh.positions[std::min(from, to)];
  const Vec3d& b = mesh.positions[std::max(from, to)];
  const double t = (x - a.x()) / (b.x() - a.x());
  return {a.y() + t * (b.y() - a.y()), a.z() + t * (b.z() - a.z())};
}

}  // namespace

WindingColumns::WindingColumns(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return;
  double low = INFINITY, high = -INFINITY;
  for (const auto& t : mesh.triangles) {
    for (const uint32_t v : t) {
      low = std::min(low, mesh.positions[v].x());
      high = std::max(high, mesh.positions[v].x());
    }
  }
  firstX_ = int32_t(std::ceil(low));
  rows_.resize(size_t(std::max(0.0, std::floor(high) - firstX_ + 1)));

  for (const auto& t : mesh.triangles) {
    const double x[3] = {mesh.positions[t[0]].x(), mesh.positions[t[1]].x(), mesh.positions[t[2]].x()};
    const auto [xLow, xHigh] = std::minmax({x[0], x[1], x[2]});
    for (auto column = int32_t(std::ceil(xLow)); column < xHigh; ++column) {
      // One edge of the triangle passes the plane towards +x and one towards −x; between the two lies its section.
      Point2 up{}, down{};
      for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        if (x[k] <= column && column < x[next]) up = edgeAt(mesh, t[k], t[next], column);
        if (x[next] <= column && column < x[k]) down = edgeAt(mesh, t[k], t[next], column);
      }
      // A counter-clockwise face, which a ray towards +z leaves by, has the edge towards +x at the lower y.
      const int sign = up.y < down.y ? 1 : -1;
      const auto end = int32_t(std::ceil(std::max(up.y, down.y)));
      const double slope = (down.z - up.z) / (down.y - up.y);
      for (auto y = int32_t(std::ceil(std::min(up.y, down.y))); y < end; ++y) {
        rows_[size_t(column - firstX_)].push_back({y, sign, up.z + (y - up.y) * slope});
      }
    }
  }

  tbb::parallel_for(size_t{0}, rows_.size(), [&](size_t r) {
    auto& row = rows_[r];
    std::sort(row.begin(), row.end(), [](const Crossing& a, const Crossing& b) {
      if (a.y != b.y) return a.y < b.y;
      if (a.z != b.z) return a.z < b.z;
      return a.above < b.above;
    });
    for (size_t i = row.size(); i-- > 1;) {
      if (row[i - 1].y == row[i].y) row[i - 1].above += row[i].above;
    }
  });
}

std::span<const WindingColumns::Crossing> WindingColumns::column(int32_t x, int32_t y) const noexcept {
  if (x < firstX_ || size_t(int64_t(x) - firstX_) >= rows_.size()) return {};
  const auto& row = rows_[size_t(x - firstX_)];
  const auto begin = std::lower_bound(row.begin(), row.end(), y, [](const Crossing& c, int32_t v) { return c.y < v; });
  auto end = begin;
  while (end != row.end() && end->y == y) ++end;
  return {begin, end};
}

int WindingColumns::at(std::span<const Crossing> column, double z) noexcept {
  for (const Crossing& crossing : column) {
    if (crossing.z > z) return crossing.above;
  }
  return 0;
}

}  // namespace argil::clay
