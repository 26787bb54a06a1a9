#include "clay/cage/quad_fill.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace argil::clay {

namespace {

constexpr size_t kMostSides = 7;  // of a polygon or a part of it
constexpr double kUneven = 0.25;  // quads: what a difference of one between two spokes counts

// Of sides or of spokes.
struct Lengths {
  std::array<int, kMostSides> of{};
  size_t count = 0;
  void add(int length) { of[count++] = length; }
  int operator[](size_t i) const { return of[i]; }
};

// How many edges lead from the middle of each side to the one irregular vertex of a polygon of an odd number of sides;
// of four sides which are equal in pairs nothing. None: it has no such filling. `onLast`: that vertex may lie on the
// last side.
std::optional<Lengths> spokesOf(const Lengths& sides, bool onLast = false) {
  const size_t n = sides.count;
  if (n == 4) return sides[0] == sides[2] && sides[1] == sides[3] ? std::optional(Lengths()) : std::nullopt;
  if (n != 3 && n != 5) return std::nullopt;
  // Side i is as long as spokes i − 1 and i + 1 together. Along i + 1, i + 3, … each spoke comes twice but for spoke i.
  Lengths spokes;
  for (size_t i = 0; i < n; ++i) {
    int sum = 0;
    for (size_t k = 0; k < n; ++k) sum += (k % 2 == 0 ? 1 : -1) * sides[(i + 1 + 2 * k) % n];
    if (sum < (onLast && i + 1 == n ? 0 : 2) || sum % 2 != 0) return std::nullopt;
    spokes.add(sum / 2);
  }
  return spokes;
}

// Of a filling with spokes.
int quadsOf(const Lengths& spokes) {
  int sum = 0;
  for (size_t i = 0; i < spokes.count; ++i) sum += spokes[i] * spokes[(i + 1) % spokes.count];
  return sum;
}
double unevenIn(const Lengths& spokes) {
  double sum = 0;
  for (size_t k = 0; k < spokes.count; ++k) sum += kUneven * std::abs(spokes[k] - spokes[(k + 1) % spokes.count]);
  return sum;
}

// Two polygons: one is what lies between place `u` of side `i` and place `v` of side `j` > i, counter-clockwise, the
// other the rest; `w` edges part them.
struct Cut {
  size_t i = 0, j = 0;
  int u = 0, v = 0, w = 0;
};

std::array<Lengths, 2> lengthsOf(const Lengths& sides, const Cut& cut) {
  std::array<Lengths, 2> out;
  out[0].add(sides[cut.i] - cut.u);
  for (size_t k = cut.i + 1; k < cut.j; ++k) out[0].add(sides[k]);
  out[0].add(cut.v);
  out[0].add(cut.w);
  out[1].add(sides[cut.j] - cut.v);
  for (size_t k = cut.j + 1; k < cut.i + sides.count; ++k) out[1].add(sides[k % sides.count]);
  out[1].add(cut.u);
  out[1].add(cut.w);
  return out;
}

// A vertex of three quads may lie on the cut, one of them on its own side: it is one edge from one of five then.
bool liesOnCut(const std::array<Lengths, 2>& parts, size_t k) {
  return parts[k].count == 3 && (k == 0 || parts[0].count != 3);
}

std::optional<Cut> bestCut(const Lengths& sides, size_t about) {
  const size_t n = sides.count;
  std::optional<Cut> best;
  double least = HUGE_VAL;
  int all = 0;
  for (size_t i = 0; i < n; ++i) all += sides[i];
  if (n % 2 != 0 || all % 2 != 0) return best;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; ++j) {
      // Into three and five sides, or two of three, or two of five.
      if (n == 2 ? j - i != 1 : n == 4 ? j - i == 2 : j - i != 3) continue;
      for (int u = 1; u < sides[i]; ++u)
        for (int v = 1; v < sides[j]; ++v) {
          // Each is as long in all as an even number of edges, and no side is longer than the others together.
          Cut cut{i, j, u, v, 0};
          std::array<int, 2> around{};
          for (size_t k = 0; k < 2; ++k) {
            const Lengths part = lengthsOf(sides, cut)[k];
            for (size_t s = 0; s < part.count; ++s) around[k] += part[s];
          }
          for (cut.w = 2 - around[0] % 2; cut.w <= std::min(around[0], around[1]); cut.w += 2) {
            const std::array<Lengths, 2> parts = lengthsOf(sides, cut);
            const auto first = spokesOf(parts[0], liesOnCut(parts, 0));
            if (!first) continue;
            const auto second = spokesOf(parts[1], liesOnCut(parts, 1));
            if (!second) continue;
            const double cost =
                std::abs(quadsOf(*first) + quadsOf(*second) - double(about)) + unevenIn(*first) + unevenIn(*second);
            if (cost < least) least = cost, best = cut;
          }
        }
    }
  return best;
}

Lengths lengthsOf(const std::vector<BorderSide>& sides) {
  Lengths lengths;
  for (const BorderSide& side : sides) lengths.add(int(side.size()) - 1);
  return lengths;
}

class Filler {
 public:
  Filler(QuadFill& out, const std::function<Vec3d(uint32_t)>& at) : out_(out), at_(at) {}

  // Edges between two vertices, along a straight line.
  BorderSide line(uint32_t from, uint32_t to, int edges) {
    BorderSide side{from};
    const Vec3d a = at(from), b = at(to);
    for (int k = 1; k < edges; ++k) side.push_back(add(a + (b - a) * (double(k) / edges)));
    side.push_back(to);
    return side;
  }

  void fill(const std::vector<BorderSide>& sides, const Lengths& spokes) {
    if (spokes.count == 0) return grid(sides);
    const size_t n = sides.size();
    if (spokes[n - 1] == 0) {
      ++out_.irregular;
      const BorderSide& cut = sides[2];
      const std::ptrdiff_t first = spokes[1];
      return grid({sides[0], sides[1], BorderSide(cut.begin(), cut.begin() + first + 1),
                   BorderSide(cut.begin() + first, cut.end())});
    }
    Vec3d middle = Vec3d::Zero();
    std::vector<uint32_t> ends(n);
    for (size_t i = 0; i < n; ++i) {
      ends[i] = sides[i][size_t(spokes[(i + n - 1) % n])];
      middle += at(ends[i]) / double(n);
    }
    const uint32_t centre = add(middle);
    ++out_.irregular;
    std::vector<BorderSide> ways;
    for (size_t i = 0; i < n; ++i) ways.push_back(line(ends[i], centre, spokes[i]));
    for (size_t i = 0; i < n; ++i) {
      const size_t before = (i + n - 1) % n;
      const BorderSide &side = sides[i], &last = sides[before];
      const std::ptrdiff_t on = spokes[before], off = spokes[i];
      grid({BorderSide(side.begin(), side.begin() + on + 1), ways[i],
            BorderSide(ways[before].rbegin(), ways[before].rend()), BorderSide(last.end() - off - 1, last.end())});
    }
  }

 private:
  [[nodiscard]] Vec3d at(uint32_t v) const { return v < QuadFill::kAdded ? at_(v) : out_.added[v - QuadFill::kAdded]; }
  uint32_t add(const Vec3d& p) {
    out_.added.push_back(p);
    return QuadFill::kAdded + static_cast<uint32_t>(out_.added.size() - 1);
  }

  // Vertices within as a Coons patch has them.
  void grid(const std::vector<BorderSide>& sides) {
    const size_t n = sides[0].size() - 1, m = sides[1].size() - 1;
    std::vector<uint32_t> all((n + 1) * (m + 1));
    const auto vertex = [&](size_t i, size_t j) -> uint32_t& { return all[i + j * (n + 1)]; };
    for (size_t i = 0; i <= n; ++i) vertex(i, 0) = sides[0][i], vertex(i, m) = sides[2][n - i];
    for (size_t j = 0; j <= m; ++j) vertex(0, j) = sides[3][m - j], vertex(n, j) = sides[1][j];
    for (size_t j = 1; j < m; ++j)
      for (size_t i = 1; i < n; ++i) {
        const double x = double(i) / double(n), y = double(j) / double(m);
        vertex(i, j) =
            add((1 - y) * at(vertex(i, 0)) + y * at(vertex(i, m)) + (1 - x) * at(vertex(0, j)) + x * at(vertex(n, j)) -
                ((1 - x) * (1 - y) * at(vertex(0, 0)) + x * (1 - y) * at(vertex(n, 0)) + x * y * at(vertex(n, m)) +
                 (1 - x) * y * at(vertex(0, m))));
      }
    for (size_t j = 0; j < m; ++j)
      for (size_t i = 0; i < n; ++i)
        out_.quads.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
  }

  QuadFill& out_;
  const std::function<Vec3d(uint32_t)>& at_;
};

}  // namespace

int leastIrregular(const std::vector<int>& lengths) {
  Lengths sides;
  for (const int each : lengths) sides.add(each);
  const auto spokes = spokesOf(sides);
  return !spokes ? 2 : spokes->count == 0 ? 0 : 1;
}

QuadFill filled(const std::vector<BorderSide>& sides, size_t about, const std::function<Vec3d(uint32_t)>& at) {
  QuadFill out;
  Filler filler(out, at);
  const Lengths lengths = lengthsOf(sides);
  if (const auto spokes = spokesOf(lengths)) {
    filler.fill(sides, *spokes);
    return out;
  }
  const auto cut = bestCut(lengths, about);
  if (!cut) return out;
  const BorderSide &first = sides[cut->i], &second = sides[cut->j];
  const BorderSide line = filler.line(second[size_t(cut->v)], first[size_t(cut->u)], cut->w);
  std::array<std::vector<BorderSide>, 2> parts;
  parts[0].emplace_back(first.begin() + cut->u, first.end());
  for (size_t k = cut->i + 1; k < cut->j; ++k) parts[0].push_back(sides[k]);
  parts[0].emplace_back(second.begin(), second.begin() + cut->v + 1);
  parts[0].push_back(line);
  parts[1].emplace_back(second.begin() + cut->v, second.end());
  for (size_t k = cut->j + 1; k < cut->i + sides.size(); ++k) parts[1].push_back(sides[k % sides.size()]);
  parts[1].emplace_back(first.begin(), first.begin() + cut->u + 1);
  parts[1].emplace_back(line.rbegin(), line.rend());
  const std::array<Lengths, 2> of = lengthsOf(lengths, *cut);
  for (size_t k = 0; k < 2; ++k) filler.fill(parts[k], *spokesOf(of[k], liesOnCut(of, k)));
  return out;
}

}  // namespace argil::clay
