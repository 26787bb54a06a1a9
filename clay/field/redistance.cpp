#include "clay/field/redistance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "clay/field/renewal.h"
#include "clay/field/scratch.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {

namespace {

constexpr int kLeastPasses = 6;
constexpr float kDiagonal = 1.7320508f;

struct Block {
  float u[2][kPaddedSize];  // |phi|: this pass and the next
  uint64_t frozen[8];
  Slot source;
  ChannelSlot mask;
};

// Copies a face layer of one brick's values into its neighbour's padding; `to` is the neighbour along +axis when
// `positive`.
void copyFace(const float* from, float* to, int axis, bool positive) {
  const int source = positive ? 8 : 1, target = positive ? 0 : 9;
  for (int i = 1; i <= 8; ++i) {
    if (axis == 0)
      std::memcpy(to + paddedOffset(target, i, 1), from + paddedOffset(source, i, 1), kBrickEdge * sizeof(float));
    else if (axis == 1)
      std::memcpy(to + paddedOffset(i, target, 1), from + paddedOffset(i, source, 1), kBrickEdge * sizeof(float));
    else
      for (int j = 1; j <= 8; ++j) to[paddedOffset(i, j, target)] = from[paddedOffset(i, j, source)];
  }
}

}  // namespace

int passesOf(float band) {
  return std::max(kLeastPasses, static_cast<int>(std::ceil(kDiagonal * band)));
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

std::vector<SettledBrick> solve(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew,
                                std::span<const uint8_t> wanted, int threads, float tolerance) {
  const bool masks = editor.has(Channel::mask);
  const float band = editor.grid().band;
  const auto count = coords.size();
  const std::span<Block> blocks = Scratch::of<Block>(count);
  const auto beside = besideEach(coords, kFaceSteps);
  for (size_t i = 0; i < count; ++i) {
    Block& b = blocks[i];
    b.source = editor.find(coords[i]);
    b.mask = masks ? editor.find(Channel::mask, coords[i]) : ChannelSlot();
  }
  const auto start = [&](size_t i, Sampler& field) {
    Block& b = blocks[i];
    float padded[kPaddedSize];
    std::fill(std::begin(padded), std::end(padded), band);
    gatherPadded(field, coords[i], padded);
    startDistance(padded, band, b.frozen, b.u[0]);
    const Renew how = renew.empty() ? Renew::none : renew[i];
    if (how != Renew::none) renewNearDistance(padded, b.frozen, how == Renew::impossible ? 1 : 0, b.u[0]);
    holdMasked(b.mask, padded, b.frozen, b.u[0]);
    std::memcpy(b.u[1], b.u[0], sizeof b.u[0]);
  };
  forBrickRanges(count, threads, [&](size_t begin, size_t end) {
    Sampler field(editor);
    for (size_t i = begin; i < end; ++i) start(i, field);
  });
  int now = 0;
  for (int pass = 0, passes = passesOf(band); pass < passes; ++pass, now ^= 1)
    forEachBrickOf(count, threads, [&](size_t i) {
      Block& b = blocks[i];
      // Between blocks the padding follows the neighbour; elsewhere it stays what the field says.
      for (size_t face = 0; face < 6; ++face)
        if (const ptrdiff_t other = beside[i][face]; other >= 0)
          copyFace(blocks[static_cast<size_t>(other)].u[now], b.u[now], int(face) / 2, face % 2 == 0);
      eikonalPass(b.u[now], b.frozen, band, b.u[now ^ 1]);
    });
  const float allowed[] = {tolerance, kSlopeTolerance, kSlopeTolerance};
  return settleBricks(editor, coords, wanted, threads, [&](size_t i, FloatBrick& brick) {
    BrickValues room;
    const float most = allowed[renew.empty() ? 0 : static_cast<size_t>(renew[i])];
    return settleDistance(blocks[i].source.values(room, band), blocks[i].u[now], band, most, brick);
  });
}

}  // namespace

std::vector<SettledBrick> solveDistances(Editor& editor, std::span<const Coord> coords, std::span<const uint8_t> wanted,
                                         int threads) {
  return solve(editor, coords, {}, wanted, threads, kRedistanceTolerance);
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

std::vector<Coord> redistance(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew, int threads,
                              float tolerance, size_t atOnce) {
  const bool all = std::any_of(renew.begin(), renew.end(), [](Renew how) { return how == Renew::all; });
  const auto solved = [&](std::span<const Coord> some, std::span<const Renew> how, std::span<const uint8_t> wanted) {
    return all ? renewDistances(editor, some, how, wanted, threads)
               : solve(editor, some, how, wanted, threads, tolerance);
  };
  if (coords.size() <= atOnce) return linkSettled(editor, solved(coords, renew, {}));
  // A pass takes what is known two voxels farther at most: what lies beyond so many bricks says nothing.
  const int rim = (2 * passesOf(editor.grid().band) + kBrickEdge - 1) / kBrickEdge;
  std::vector<CoordBox> parts;
  divide({coords.begin(), coords.end()}, atOnce, parts);
  std::vector<SettledBrick> settled;
  for (const CoordBox& part : parts) {
    std::vector<Coord> some;
    std::vector<Renew> how;
    std::vector<uint8_t> wanted;
    for (size_t i = 0; i < coords.size(); ++i) {
      if (!part.holds(coords[i], rim)) continue;
      some.push_back(coords[i]);
      if (!renew.empty()) how.push_back(renew[i]);
      wanted.push_back(part.holds(coords[i]));
    }
    const std::vector<SettledBrick> now = solved(some, how, wanted);
    settled.insert(settled.end(), now.begin(), now.end());
  }
  return linkSettled(editor, settled);
}

}  // namespace argil::clay
