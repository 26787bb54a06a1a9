#include "clay/mould/parting_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace argil::clay {

namespace {

constexpr int kCoarsest = 8;      // places along the shorter side
constexpr int kFirst = 400;       // sweeps on the coarsest
constexpr int kSweeps = 60;       // and on the others
constexpr double kRelaxed = 1.7;  // more than the whole step: converges in as many times fewer

// Heights and their bounds; without bounds they are infinite.
struct Level {
  int width = 0, height = 0;
  std::vector<float> low, high, at;
  void resize(int w, int h) {
    width = w, height = h;
    const size_t count = size_t(w) * size_t(h);
    low.assign(count, -std::numeric_limits<float>::infinity());
    high.assign(count, std::numeric_limits<float>::infinity());
    at.assign(count, 0);
  }
  [[nodiscard]] size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
  // Between places, and beyond the last ones as at them.
  [[nodiscard]] float between(double x, double y) const {
    x = std::clamp(x, 0.0, width - 1.0), y = std::clamp(y, 0.0, height - 1.0);
    const int i = std::min(static_cast<int>(x), std::max(0, width - 2)),
              j = std::min(static_cast<int>(y), std::max(0, height - 2));
    const int right = std::min(i + 1, width - 1), above = std::min(j + 1, height - 1);
    const double s = x - i, r = y - j;
    return static_cast<float>((1 - r) * ((1 - s) * double(at[index(i, j)]) + s * double(at[index(right, j)])) +
                              r * ((1 - s) * double(at[index(i, above)]) + s * double(at[index(right, above)])));
  }
};

Level coarser(const Level& fine) {
  Level out;
  out.resize((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      double low = 0, high = 0;
      int count = 0;
      for (int j = 2 * y; j < std::min(2 * y + 2, fine.height); ++j)
        for (int i = 2 * x; i < std::min(2 * x + 2, fine.width); ++i) {
          const size_t k = fine.index(i, j);
          if (!std::isfinite(fine.low[k])) continue;
          low += double(fine.low[k]), high += double(fine.high[k]), ++count;
        }
      if (count == 0) continue;
      out.low[out.index(x, y)] = static_cast<float>(low / count);
      out.high[out.index(x, y)] = static_cast<float>(high / count);
    }
  return out;
}

void relax(Level& level, int sweeps, const WorkPart& part) {
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    part.step(double(sweep) / sweeps);
    // Forth and back, so that no direction is preferred.
    const bool back = sweep % 2 == 1;
    for (int row = 0; row < level.height; ++row) {
      const int y = back ? level.height - 1 - row : row;
      for (int column = 0; column < level.width; ++column) {
        const int x = back ? level.width - 1 - column : column;
        double sum = 0;
        int count = 0;
        if (x > 0) sum += double(level.at[level.index(x - 1, y)]), ++count;
        if (x + 1 < level.width) sum += double(level.at[level.index(x + 1, y)]), ++count;
        if (y > 0) sum += double(level.at[level.index(x, y - 1)]), ++count;
        if (y + 1 < level.height) sum += double(level.at[level.index(x, y + 1)]), ++count;
        if (count == 0) continue;
        const size_t k = level.index(x, y);
        const double now = double(level.at[k]);
        level.at[k] = std::clamp(static_cast<float>(now + kRelaxed * (sum / count - now)), level.low[k], level.high[k]);
      }
    }
  }
}

}  // namespace

std::vector<float> partingHeights(const MouldColumns& columns, const WorkPart& part) {
  const int stride = (std::max(columns.width, columns.height) + kMostPlaces - 1) / kMostPlaces;
  std::vector<Level> levels(1);
  levels[0].resize((columns.width + stride - 1) / stride, (columns.height + stride - 1) / stride);
  double middle = 0;
  size_t covered = 0;
  for (int y = 0; y < levels[0].height; ++y)
    for (int x = 0; x < levels[0].width; ++x) {
      const size_t from = columns.index(x * stride, y * stride), to = levels[0].index(x, y);
      if (!columns.covered(from)) continue;
      levels[0].low[to] = columns.bottom[from], levels[0].high[to] = columns.top[from];
      middle += 0.5 * double(columns.bottom[from] + columns.top[from]), ++covered;
    }
  if (covered > 0) middle /= double(covered);
  while (std::min(levels.back().width, levels.back().height) > kCoarsest) levels.push_back(coarser(levels.back()));
  // Half of the work is on the finest, a quarter of the rest on the next.
  double done = 0;
  for (size_t l = levels.size(); l-- > 0;) {
    Level& level = levels[l];
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        const size_t k = level.index(x, y);
        // The middles of coarse places lie between fine ones.
        const float start =
            l + 1 == levels.size() ? static_cast<float>(middle) : levels[l + 1].between((x - 0.5) / 2, (y - 0.5) / 2);
        level.at[k] = std::clamp(start, level.low[k], level.high[k]);
      }
    const double share = std::pow(0.25, double(l)) * 0.75;
    relax(level, l + 1 == levels.size() ? kFirst : kSweeps, part.part(done, std::min(1.0, done + share)));
    done = std::min(1.0, done + share);
  }
  if (stride == 1) return std::move(levels[0].at);
  std::vector<float> all(size_t(columns.width) * size_t(columns.height));
  for (int y = 0; y < columns.height; ++y)
    for (int x = 0; x < columns.width; ++x)
      all[columns.index(x, y)] = levels[0].between(double(x) / stride, double(y) / stride);
  return all;
}

}  // namespace argil::clay
