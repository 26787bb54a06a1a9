#include "engine/print/nest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "clay/base/error.h"

namespace argil::engine {

namespace {

constexpr int kMostCells = 2000;  // along a bed

// Cells, a bit each.
struct Bits {
  int width = 0, height = 0, words = 0;
  std::vector<uint64_t> rows;
  Bits(int w, int h) : width(w), height(h), words((w + 63) / 64), rows(size_t(words) * size_t(h), 0) {}
  void set(int x, int y) { rows[size_t(y) * size_t(words) + size_t(x / 64)] |= uint64_t{1} << (x % 64); }
  [[nodiscard]] bool at(int x, int y) const {
    return (rows[size_t(y) * size_t(words) + size_t(x / 64)] >> (x % 64) & 1) != 0;
  }
  // Visits the words of `other` that lie over words of this with its corner at (x, y), as they lie there, until one
  // says false. What is beyond this is nothing.
  template <class Visit>
  bool over(const Bits& other, int x, int y, const Visit& visit) const {
    const int shift = ((x % 64) + 64) % 64, first = (x - shift) / 64;
    for (int r = std::max(0, -y); r < std::min(other.height, height - y); ++r) {
      const uint64_t* from = &other.rows[size_t(r) * size_t(other.words)];
      uint64_t carry = 0;
      for (int w = 0; w <= other.words; ++w) {
        const uint64_t word = w < other.words ? from[w] : 0;
        const uint64_t here = word << shift | carry;
        carry = shift > 0 ? word >> (64 - shift) : 0;
        const int to = first + w;
        if (here != 0 && to >= 0 && to < words && !visit(size_t(y + r) * size_t(words) + size_t(to), here))
          return false;
      }
    }
    return true;
  }
};

// A footprint turned: its cells, and those with the gap around them, whose corner is `margin` cells lower.
struct Shape {
  double turn = 0;
  Vec2d low = Vec2d::Zero();
  Bits own, wide;
};

Shape shapeOf(const std::vector<Vec2d>& footprint, double turn, double cell, int margin) {
  const Eigen::Rotation2Dd rotation(turn);
  std::vector<Vec2d> places;
  places.reserve(footprint.size());
  Vec2d low = Vec2d::Constant(INFINITY), high = -low;
  for (const Vec2d& each : footprint) {
    places.push_back(rotation * each);
    low = low.cwiseMin(places.back()), high = high.cwiseMax(places.back());
  }
  const int width = static_cast<int>((high.x() - low.x()) / cell) + 1,
            height = static_cast<int>((high.y() - low.y()) / cell) + 1;
  Shape shape{turn, low, Bits(width, height), Bits(width + 2 * margin, height + 2 * margin)};
  for (const Vec2d& each : places)
    shape.own.set(static_cast<int>((each.x() - low.x()) / cell), static_cast<int>((each.y() - low.y()) / cell));
  // A disk of the gap around each cell, row by row.
  for (int dy = -margin; dy <= margin; ++dy) {
    const int half = static_cast<int>(std::sqrt(double(margin) * margin - double(dy) * dy));
    Bits spread(width + 2 * half, height);
    for (int dx = 0; dx <= 2 * half; ++dx)
      spread.over(shape.own, dx, 0, [&](size_t at, uint64_t bits) {
        spread.rows[at] |= bits;
        return true;
      });
    shape.wide.over(spread, margin - half, margin + dy, [&](size_t at, uint64_t bits) {
      shape.wide.rows[at] |= bits;
      return true;
    });
  }
  return shape;
}

}  // namespace

std::vector<Nested> nest(std::span<const std::vector<Vec2d>> footprints, const NestOptions& options,
                         const clay::WorkPart& part) {
  if (!(options.bedMm.minCoeff() >= 1 && options.bedMm.maxCoeff() <= 1e5))
    throw Error(fmt::format("a bed of {:g} × {:g} mm: give 1 to 100000 mm", options.bedMm.x(), options.bedMm.y()));
  if (!(options.gapMm >= 0 && options.gapMm <= 1000))
    throw Error(fmt::format("a gap of {:g} mm: give 0 to 1000 mm", options.gapMm));
  if (options.turns < 1 || options.turns > 64) throw Error(fmt::format("{} turns: give 1 to 64", options.turns));
  const double cell = std::max(options.cellMm, options.bedMm.maxCoeff() / kMostCells);
  const int margin = static_cast<int>(std::ceil(options.gapMm / cell)),
            width = static_cast<int>(options.bedMm.x() / cell), height = static_cast<int>(options.bedMm.y() / cell);

  std::vector<size_t> order(footprints.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::vector<double> sizes;
  for (const std::vector<Vec2d>& each : footprints) {
    Vec2d low = Vec2d::Constant(INFINITY), high = -low;
    for (const Vec2d& p : each) low = low.cwiseMin(p), high = high.cwiseMax(p);
    sizes.push_back(each.empty() ? 0 : (high - low).prod());
  }
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return sizes[a] > sizes[b]; });

  std::vector<Bits> beds;
  std::vector<Nested> result(footprints.size());
  for (size_t done = 0; done < order.size(); ++done) {
    const size_t i = order[done];
    if (footprints[i].empty()) continue;
    std::vector<Shape> shapes;
    for (int turn = 0; turn < options.turns; ++turn) {
      part.step((double(done) + double(turn) / options.turns) / double(order.size()));
      Shape shape = shapeOf(footprints[i], 2 * std::numbers::pi * turn / options.turns, cell, margin);
      if (shape.own.width <= width && shape.own.height <= height) shapes.push_back(std::move(shape));
    }
    if (shapes.empty()) throw LargerThanBed(i);
    for (size_t bed = 0;; ++bed) {
      if (bed == beds.size()) beds.emplace_back(width, height);
      const Bits& taken = beds[bed];
      const Shape* best = nullptr;
      int bestX = 0, bestY = 0, bestTop = height + 1;
      for (const Shape& shape : shapes) {
        part.step(double(done) / double(order.size()));
        bool found = false;
        for (int y = 0; !found && y + shape.own.height <= height && y + shape.own.height < bestTop + 1; ++y)
          for (int x = 0; !found && x + shape.own.width <= width; ++x) {
            const int top = y + shape.own.height;
            if (best && (top > bestTop || (top == bestTop && x >= bestX))) break;
            found = taken.over(shape.wide, x - margin, y - margin,
                               [&](size_t at, uint64_t bits) { return (taken.rows[at] & bits) == 0; });
            if (found) best = &shape, bestX = x, bestY = y, bestTop = top;
          }
      }
      if (!best) continue;
      Bits& now = beds[bed];
      now.over(best->own, bestX, bestY, [&](size_t at, uint64_t bits) {
        now.rows[at] |= bits;
        return true;
      });
      result[i] = {best->turn, Vec2d(bestX * cell, bestY * cell) - best->low, static_cast<int>(bed)};
      break;
    }
  }
  return result;
}

}  // namespace argil::engine
