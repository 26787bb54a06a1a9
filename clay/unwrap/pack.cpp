#include "clay/unwrap/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/unwrap/compact.h"

namespace argil::clay {

namespace {

constexpr int kCells = 512;                     // of the square's side
constexpr int kTurns = 8;                       // of each shape
constexpr int kOrders = 8;                      // in which they are placed
constexpr double kFirst = 1.1, kLarger = 1.04;  // sides, of a square of their area
constexpr int kMore = 3;                        // sides after which orders that did not go in are left out
constexpr double kHopeless = 1e6;               // times the side of a square of their area

// Cells in rows of 64-bit words.
class Cells {
 public:
  Cells(int width, int height)
      : width_(width), height_(height), words_((width + 63) / 64), bits_(size_t(words_ * height)) {}
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  void set(int x, int y) { bits_[at(x, y)] |= uint64_t{1} << (x & 63); }
  [[nodiscard]] bool get(int x, int y) const { return bits_[at(x, y)] >> (x & 63) & 1; }

  // Does the other, moved, lie on something here? Then so far to the right it still does: at least 1. It must lie
  // inside.
  [[nodiscard]] int meets(const Cells& other, int x, int y) const {
    const int shift = x & 63, first = x >> 6;
    for (int row = 0; row < other.height_; ++row) {
      const uint64_t* here = &bits_[size_t((y + row) * words_)];
      const uint64_t* there = &other.bits_[size_t(row * other.words_)];
      for (int w = other.words_ - 1; w >= 0; --w) {
        uint64_t both = shift != 0 && first + w + 1 < words_ ? here[first + w + 1] & there[w] >> (64 - shift) : 0;
        int at = 64 * (w + 1) - shift;  // of the lowest bit, in the other
        if (both == 0) both = here[first + w] & there[w] << shift, at -= 64;
        if (both == 0) continue;
        // Its run of cells must pass the last cell that it meets.
        const int last = at + static_cast<int>(std::bit_width(both)) - 1;
        return last - other.begins_[size_t(row * other.width_ + last)] + 1;
      }
    }
    return 0;
  }
  // Of each cell the first of its run in the row: once all are set.
  void findRuns() {
    begins_.resize(size_t(width_ * height_));
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        begins_[size_t(y * width_ + x)] =
            static_cast<int16_t>(x > 0 && get(x - 1, y) && get(x, y) ? begins_[size_t(y * width_ + x - 1)] : x);
  }
  void add(const Cells& other, int x, int y) {
    for (int row = 0; row < other.height_; ++row)
      for (int column = 0; column < other.width_; ++column)
        if (other.get(column, row)) set(x + column, y + row);
  }

 private:
  [[nodiscard]] size_t at(int x, int y) const { return size_t(y * words_ + (x >> 6)); }
  int width_, height_, words_;
  std::vector<uint64_t> bits_;
  std::vector<int16_t> begins_;
};

Vec2d turned(const Vec2d& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

// A shape in one turn: its lowest corner, and the cells that it touches or is nearer to than `margin` cells.
struct Raster {
  Vec2d low;
  Cells cells{1, 1};
};

int cellsOf(double length) {
  return int(std::ceil(std::min(length, 4.0 * kCells))) + 1;
}

Raster rasterOf(const FlatShape& shape, double angle, double cellMm, double margin) {
  std::vector<Vec2d> places;
  places.reserve(shape.places->size());
  for (const Vec2d& each : *shape.places) places.push_back(turned(each, angle) / cellMm);
  Vec2d low = places.front(), high = low;
  for (const Vec2d& each : places) low = low.cwiseMin(each), high = high.cwiseMax(each);
  Raster out;
  // Half of the margin around each of two shapes.
  const double around = 0.5 * margin;
  low -= Vec2d::Constant(around);
  const int width = cellsOf(high.x() + around - low.x()), height = cellsOf(high.y() + around - low.y());
  out.low = low * cellMm;
  if (std::max(width, height) > kCells) {  // goes in nowhere, and may be of any length
    out.cells = Cells(kCells + 1, 1);
    return out;
  }
  out.cells = Cells(width, height);
  for (const auto& t : *shape.triangles) {
    const std::array<Vec2d, 3> c = {places[t[0]] - low, places[t[1]] - low, places[t[2]] - low};
    const Vec2d from = c[0].cwiseMin(c[1]).cwiseMin(c[2]), to = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
    const int y0 = std::max(0, int(from.y() - around)), y1 = std::min(height - 1, int(to.y() + around));
    for (int y = y0; y <= y1; ++y) {
      // A cell is free of a triangle that lies wholly behind one of its sides, moved out by the margin: in a row those
      // from one to another are not.
      double first = from.x() - around - 1, last = to.x() + around;
      for (size_t s = 0; s < 3; ++s) {
        const Vec2d side = c[(s + 1) % 3] - c[s];
        const Vec2d in = Vec2d(-side.y(), side.x()) / std::max(side.norm(), 1e-300);
        const double reach = 0.5 * (std::abs(in.x()) + std::abs(in.y())) + around;
        // in.x (x + 0.5) >= limit
        const double limit = in.dot(c[s]) - in.y() * (y + 0.5) - reach;
        if (in.x() > 1e-12) first = std::max(first, limit / in.x() - 0.5);
        if (in.x() < -1e-12) last = std::min(last, limit / in.x() - 0.5);
      }
      const int x0 = std::max(0, int(std::ceil(first))), x1 = std::min(width - 1, int(std::floor(last)));
      for (int x = x0; x <= x1; ++x) out.cells.set(x, y);
    }
  }
  out.cells.findRuns();
  return out;
}

double areaOf(const FlatShape& shape) {
  double sum = 0;
  for (const auto& t : *shape.triangles) {
    const Vec2d b = (*shape.places)[t[1]] - (*shape.places)[t[0]], c = (*shape.places)[t[2]] - (*shape.places)[t[0]];
    sum += 0.5 * (b.x() * c.y() - b.y() * c.x());
  }
  return sum;
}

// How a shape lies in the smallest rectangle.
double uprightOf(const FlatShape& shape) {
  double best = INFINITY, angle = 0;
  constexpr int kTried = 90;
  for (int i = 0; i < kTried; ++i) {
    const double a = 0.5 * std::numbers::pi * i / kTried;
    Vec2d low = Vec2d::Constant(INFINITY), high = -low;
    for (const Vec2d& p : *shape.places) {
      const Vec2d q = turned(p, a);
      low = low.cwiseMin(q), high = high.cwiseMax(q);
    }
    const double area = (high - low).prod();
    if (area < best * (1 - 1e-9)) best = area, angle = a;
  }
  return angle;
}

struct Shape {
  FlatShape shape;
  double area = 0, upright = 0;
};

// The shapes in all their turns, in cells of one size.
using Rasters = std::vector<std::array<Raster, kTurns>>;

// One after the other, each where it comes least far up, or least far from the corner; none when they do not all go in.
std::optional<std::vector<Packing::Placed>> placedIn(const std::vector<Shape>& shapes, const Rasters& rasters,
                                                     const std::vector<size_t>& order, bool upwards, double cellMm) {
  Cells taken(kCells, kCells);
  std::vector<Packing::Placed> out(shapes.size());
  for (const size_t i : order) {
    int least = INT32_MAX, bestX = 0, bestY = 0;
    const Raster* best = nullptr;
    for (int turn = 0; turn < kTurns; ++turn) {
      const Raster& raster = rasters[i][size_t(turn)];
      const int width = raster.cells.width(), height = raster.cells.height();
      for (int y = 0; y + height <= kCells; ++y) {
        const auto costAt = [&](int x) {
          return upwards ? kCells * (y + height) + x
                         : kCells * std::max(x + width, y + height) + std::min(x + width, y + height);
        };
        if (costAt(0) >= least) break;
        for (int x = 0, onwards = 0; x + width <= kCells; x += onwards) {
          if (costAt(x) >= least) break;
          onwards = taken.meets(raster.cells, x, y);
          if (onwards > 0) continue;
          least = costAt(x), bestX = x, bestY = y, best = &raster;
          out[i].turn = shapes[i].upright + 2 * std::numbers::pi * turn / kTurns;
          break;
        }
      }
    }
    if (best == nullptr) return std::nullopt;
    taken.add(best->cells, bestX, bestY);
    out[i].moveMm = cellMm * Vec2d(bestX, bestY) - best->low;
  }
  return out;
}

}  // namespace

Packing packed(const std::vector<FlatShape>& shapes, double margin, int threads, const WorkPart& part) {
  std::vector<Shape> all;
  double area = 0;
  for (const FlatShape& each : shapes) {
    Shape shape{each, areaOf(each), uprightOf(each)};
    area += shape.area;
    all.push_back(shape);
  }
  if (!(area > 0) || !std::isfinite(area)) throw Error("shapes without an area cannot be packed");
  const double cells = std::max(1.0, margin * kCells);
  std::vector<size_t> order(all.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return all[a].area > all[b].area; });
  // The largest first; in some more orders shapes of about one size change places.
  std::vector<std::vector<size_t>> orders(kOrders, order);
  std::mt19937 random(7);
  for (size_t k = 2; k < orders.size(); ++k)
    for (size_t i = 0; i + 1 < order.size(); ++i)
      std::swap(orders[k][i], orders[k][std::min(order.size() - 1, i + random() % 4)]);
  // A larger side until each of them has gone in, or the first had some more.
  std::vector<Packing> begun;
  std::vector<bool> done(orders.size());
  int more = 0;
  for (double side = kFirst * std::sqrt(area); begun.size() < orders.size() && more < kMore; side *= kLarger) {
    if (!(side < kHopeless * std::sqrt(area)))
      throw Error(fmt::format("{} charts do not go into one picture: give fewer quads", all.size()), Error::Kind::work);
    part.step(double(begun.size()) / double(2 * orders.size()));
    Rasters rasters(all.size());
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t turn = 0; turn < kTurns; ++turn)
        rasters[i][turn] =
            rasterOf(all[i].shape, all[i].upright + 2 * std::numbers::pi * double(turn) / kTurns, side / kCells, cells);
    std::vector<std::optional<std::vector<Packing::Placed>>> placed(orders.size());
    parallelBlocks(
        orders.size(), threads,
        [&](size_t begin, size_t end) {
          for (size_t k = begin; k < end; ++k)
            if (!done[k]) placed[k] = placedIn(all, rasters, orders[k], k % 2 == 0, side / kCells);
        },
        1);
    for (size_t k = 0; k < orders.size(); ++k) {
      if (!placed[k]) continue;
      begun.push_back({std::move(*placed[k]), side, area / (side * side)});
      done[k] = true;
    }
    if (!begun.empty()) ++more;
  }
  return compacted(shapes, std::move(begun), cells / kCells, threads, part.part(0.5, 1));
}

}  // namespace argil::clay
