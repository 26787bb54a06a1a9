#include "clay/field/redistance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/field/jacobi_solver.h"
#include "clay/field/renewal.h"
#include "clay/field/settle.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {

namespace {

constexpr int kLeastPasses = 6;
constexpr float kDiagonal = 1.7320508f;

}  // namespace

int passesOf(float band) {
  return std::max(kLeastPasses, static_cast<int>(std::ceil(kDiagonal * band)));
}

int Redistancing::passesOf(float band) const {
  const int all = clay::passesOf(band);
  return passes > 0 ? std::min(passes, all) : all;
}

float Redistancing::toleranceOf(Renew renew) const {
  const float share = tolerance / kRedistanceTolerance;
  if (renew == Renew::none) return tolerance;
  return share * (renew == Renew::all ? kRenewTolerance : kSlopeTolerance);
}

void holdMasked(ChannelSlot mask, const float* padded, uint64_t (&frozen)[kBrickEdge], float* u) {
  if (mask == ChannelSlot()) return;
  for (int v = 0; v < kBrickVoxels; ++v) {
    if (mask.value(v) != 255) continue;
    const int at = paddedOffset((v >> 6) + 1, ((v >> 3) & 7) + 1, (v & 7) + 1);
    frozen[v >> 6] |= uint64_t{1} << (v & 63);
    u[at] = std::abs(padded[at]);
  }
}

std::vector<Coord> linkSettled(Editor& editor, std::span<const SettledBrick> settled) {
  std::vector<Coord> changed;
  for (const SettledBrick& each : settled) {
    changed.push_back(each.brick->coord);
    editor.link(each.brick, each.inBand);
  }
  return changed;
}

namespace {

// Voxels from the band's end up to which distances that nothing supports may stay.
constexpr float kAlone = 0.3f;
constexpr float kSame = 1e-6f;  // voxels between a distance and itself

std::vector<SettledBrick> solve(const Sampler& before, Editor& editor, std::span<const Coord> coords,
                                std::span<const Renew> renew, std::span<const uint8_t> wanted, int threads,
                                const Redistancing& options, const StandsTest* stands = nullptr) {
  const bool masks = editor.has(Channel::mask);
  const float band = editor.grid().band;
  std::vector<Slot> sources(coords.size());
  JacobiSolver<1> solver(coords, threads);
  forBrickRanges(coords.size(), threads, [&](size_t begin, size_t end) {
    Sampler field = before;
    float padded[kPaddedSize], far[kPaddedSize], u[kPaddedSize];
    std::fill(std::begin(far), std::end(far), band);
    std::fill(std::begin(padded), std::end(padded), band);
    for (size_t i = begin; i < end; ++i) {
      uint64_t frozen[kBrickEdge] = {};
      sources[i] = field.slot(coords[i]);
      if (isAmongTiles(field, coords[i], sources[i])) {
        solver.begin(i, far, frozen, 0);
        continue;
      }
      gatherPadded(field, coords[i], padded);
      startDistance(padded, band, frozen, u);
      const Renew how = renew.empty() ? Renew::none : renew[i];
      if (how != Renew::none) renewNearDistance(padded, frozen, how == Renew::impossible ? 1 : 0, u);
      if (masks) holdMasked(editor.find(Channel::mask, coords[i]), padded, frozen, u);
      solver.begin(i, u, frozen);
    }
  });
  solver.run(options.passesOf(band), [&](const float* around, const uint64_t* frozen, uint64_t rows, float* out) {
    return eikonalPass(around, frozen, rows, band, out);
  });
  return settleBricks(editor, coords, wanted, threads, [&](size_t i, FloatBrick& brick) {
    BrickValues room;
    const float most = options.toleranceOf(renew.empty() ? Renew::none : renew[i]);
    const BrickValues& old = sources[i].values(room, band);
    if (stands == nullptr) return settleDistance(old, solver.values(i), band, most, brick);
    float solved[kBrickVoxels];
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float size = std::abs(old[v]);
      const float now = solver.values(i)[v];
      bool stays = std::abs(now - size) < most;
      // Drops the tolerance where nothing is in reach.
      if (now - size >= most || (now >= band && size < band - kAlone))
        stays = (*stands)(coords[i] * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7}, old[v]);
      solved[v] = stays ? size : now;
    }
    return settleDistance(old, solved, band, kSame, brick);
  });
}

}  // namespace

std::vector<SettledBrick> solveDistances(Editor& editor, std::span<const Coord> coords, std::span<const uint8_t> wanted,
                                         int threads) {
  return solve(Sampler(editor), editor, coords, {}, wanted, threads, {});
}

namespace {

struct CoordBox {
  Coord low, high;  // both of them in it
  [[nodiscard]] bool holds(Coord c, int rim = 0) const {
    return c.x >= low.x - rim && c.x <= high.x + rim && c.y >= low.y - rim && c.y <= high.y + rim &&
           c.z >= low.z - rim && c.z <= high.z + rim;
  }
};

// Boxes that hold each of `coords` once and at most `most` of them each: halved along the longest edge.
void divide(std::vector<Coord> coords, size_t most, std::vector<CoordBox>& boxes) {
  const auto bounds = [&](int32_t Coord::*axis) {
    const auto [low, high] = std::minmax_element(coords.begin(), coords.end(),
                                                 [=](const Coord& a, const Coord& b) { return a.*axis < b.*axis; });
    return std::pair((*low).*axis, (*high).*axis);
  };
  const auto x = bounds(&Coord::x), y = bounds(&Coord::y), z = bounds(&Coord::z);
  const int edges[3] = {x.second - x.first, y.second - y.first, z.second - z.first};
  const auto longest = std::max_element(edges, edges + 3) - edges;
  if (coords.size() <= most || edges[longest] == 0) {
    boxes.push_back({{x.first, y.first, z.first}, {x.second, y.second, z.second}});
    return;
  }
  constexpr int32_t Coord::*kAxes[3] = {&Coord::x, &Coord::y, &Coord::z};
  const auto axis = kAxes[longest];
  const int32_t from[3] = {x.first, y.first, z.first}, middle = from[longest] + (edges[longest] + 1) / 2;
  const auto second = std::partition(coords.begin(), coords.end(), [=](const Coord& c) { return c.*axis < middle; });
  divide({second, coords.end()}, most, boxes);
  coords.erase(second, coords.end());
  divide(std::move(coords), most, boxes);
}

}  // namespace

std::vector<RedistancePart> redistanceParts(std::vector<Coord> coords, std::vector<Renew> renew, float band,
                                            const Redistancing& how) {
  const bool all = std::count(renew.begin(), renew.end(), Renew::all) > 0;
  std::vector<RedistancePart> parts;
  if (coords.size() <= how.atOnce) {
    parts.push_back({std::move(coords), std::move(renew), {}, all});
    return parts;
  }
  // A pass takes what is known two voxels farther at most: what lies beyond so many bricks says nothing.
  const int rim = (2 * passesOf(band) + kBrickEdge - 1) / kBrickEdge;
  std::vector<CoordBox> boxes;
  divide(coords, how.atOnce, boxes);
  for (const CoordBox& box : boxes) {
    RedistancePart& part = parts.emplace_back();
    part.all = all;
    for (size_t i = 0; i < coords.size(); ++i) {
      if (!box.holds(coords[i], rim)) continue;
      part.bricks.push_back(coords[i]);
      if (!renew.empty()) part.renew.push_back(renew[i]);
      part.wanted.push_back(box.holds(coords[i]));
    }
  }
  return parts;
}

std::vector<SettledBrick> redistancePart(const Sampler& field, Editor& editor, const RedistancePart& part, int threads,
                                         const Redistancing& how) {
  return part.all ? renewDistances(field, editor, part.bricks, part.renew, part.wanted, threads, how)
                  : solve(field, editor, part.bricks, part.renew, part.wanted, threads, how);
}

std::vector<Coord> redistance(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew, int threads,
                              const Redistancing& how) {
  std::vector<SettledBrick> settled;
  for (const RedistancePart& part :
       redistanceParts({coords.begin(), coords.end()}, {renew.begin(), renew.end()}, editor.grid().band, how)) {
    const std::vector<SettledBrick> now = redistancePart(Sampler(editor), editor, part, threads, how);
    settled.insert(settled.end(), now.begin(), now.end());
  }
  return linkSettled(editor, settled);
}

std::vector<Coord> redistanceUnless(Editor& editor, std::span<const Coord> coords, float tolerance,
                                    const StandsTest& stands) {
  std::vector<SettledBrick> settled;
  const Redistancing how{.tolerance = tolerance};
  for (const RedistancePart& part : redistanceParts({coords.begin(), coords.end()}, {}, editor.grid().band, how)) {
    const auto now = solve(Sampler(editor), editor, part.bricks, {}, part.wanted, 1, how, &stands);
    settled.insert(settled.end(), now.begin(), now.end());
  }
  return linkSettled(editor, settled);
}

}  // namespace argil::clay
