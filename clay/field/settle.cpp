#include "clay/field/settle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>
#include <vector>

#include "clay/base/parallel.h"
#include "clay/field/redistance.h"
#include "clay/kernels/shaping_kernels.h"
#include "clay/store/brick_margins.h"
#include "clay/store/brick_set.h"

namespace argil::clay {

namespace {

constexpr int kMostRounds = 12;             // a change travels a voxel a round, and the band is three wide
constexpr size_t kRedistanceAtOnce = 8192;  // bricks, 5 KB each
constexpr size_t kAtOnce = 16384;           // bricks between two looks at the job

// A brick once none of its values is too far from those around it.
struct Limited {
  Coord brick;
  std::array<float, kBrickVoxels> phi;
  // voxels that came into the band, and the voxel beside each that brought it there
  std::vector<std::pair<int, Coord>> fresh;
};

// False when all are near enough.
bool limit(Sampler& field, Coord brick, Limited& out) {
  constexpr int kStride[3] = {10 * kPaddedRow, kPaddedRow, 1};
  const float band = field.band();
  float padded[kPaddedSize];
  std::fill(std::begin(padded), std::end(padded), 0.0f);
  gatherPadded(field, brick, padded);
  if (!isSteep(padded, kSteepest)) return false;
  out.brick = brick;
  out.fresh.clear();
  bool any = false;
  for (int v = 0; v < kBrickVoxels; ++v) {
    const int at = paddedOffset((v >> 6) + 1, ((v >> 3) & 7) + 1, (v & 7) + 1);
    const float own = padded[at], size = std::abs(own);
    float most = size;
    Coord from;
    for (int axis = 0; axis < 3; ++axis)
      for (const int way : {-1, 1}) {
        const float other = padded[at + way * kStride[axis]], apart = std::abs(own - other);
        if (apart <= kSteepest) continue;
        const float bound = (own < 0) != (other < 0) ? size * (kSteepest / apart) : std::abs(other) + kSteepest;
        if (!(bound < most)) continue;
        most = bound;
        from = brick * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7} +
               Coord{axis == 0 ? way : 0, axis == 1 ? way : 0, axis == 2 ? way : 0};
      }
    any |= most < size;
    if (most < band && size >= band) out.fresh.emplace_back(v, from);
    out.phi[static_cast<size_t>(v)] = own < 0 ? -most : most;
  }
  return any;
}

// Voxels that came into the band have what brought them there.
void carryToFresh(Editor& editor, const Limited& limited) {
  for (const Channel channel : kAllChannels) {
    if (limited.fresh.empty() || !editor.has(channel)) continue;
    std::array<uint8_t, kBrickVoxels> values;
    const ChannelSlot own = editor.find(channel, limited.brick);
    for (int v = 0; v < kBrickVoxels; ++v) values[static_cast<size_t>(v)] = own.value(v);
    for (const auto& [v, from] : limited.fresh)
      values[static_cast<size_t>(v)] =
          editor.find(channel, from >> kBrickBits).value(Brick::offset(from.x & 7, from.y & 7, from.z & 7));
    editor.setChannel(channel, limited.brick, values);
  }
  clearChannelsRoundedAway(editor, limited.brick);
}

}  // namespace

void limitSlopes(Editor& editor, std::span<const Coord> bricks, int threads, const WorkPart& part) {
  std::vector<Coord> look(bricks.begin(), bricks.end());
  for (int round = 0; round < kMostRounds && !look.empty(); ++round) {
    std::vector<Limited> found;
    std::mutex mutex;
    for (size_t from = 0; from < look.size(); from += kAtOnce) {
      const size_t count = std::min(kAtOnce, look.size() - from);
      parallelBlocks(count, threads, [&](size_t begin, size_t end) {
        Sampler field(editor);
        Limited one;
        for (size_t i = from + begin; i < from + end; ++i) {
          if (!limit(field, look[i], one)) continue;
          const std::lock_guard lock(mutex);
          found.push_back(one);
        }
      });
      if (round == 0) part.step(double(from + count) / double(look.size()));
    }
    // All at once: each of them was found from what there was before.
    BrickSet next;
    for (const Limited& each : found) {
      editor.setVoxels(each.brick, each.phi);
      next.add(each.brick);
      for (int axis = 0; axis < 3; ++axis)
        for (const int way : {-1, 1})
          next.add(each.brick + Coord{axis == 0 ? way : 0, axis == 1 ? way : 0, axis == 2 ? way : 0});
    }
    for (const Limited& each : found) carryToFresh(editor, each);
    look = next.sorted();
  }
}

void redistanceByRegion(Editor& editor, std::span<const Coord> bricks, Job* job, double jobFrom) {
  std::vector<Coord> sorted(bricks.begin(), bricks.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<Coord> byRegion = sorted;
  std::stable_sort(byRegion.begin(), byRegion.end(), [](Coord a, Coord b) { return a >> 3 < b >> 3; });
  // A pass takes what is known a voxel farther, and there are fewer of them than a brick has voxels along an axis: with
  // the bricks around it a region comes out as if all had been solved together.
  struct Unlinked {
    Editor& editor;
    std::vector<SettledBrick> bricks;
    ~Unlinked() {
      for (const SettledBrick& each : bricks) editor.recycle(each.brick);
    }
  } settled{editor, {}};
  std::vector<uint8_t> wanted;
  for (size_t begin = 0; begin < byRegion.size();) {
    size_t end = begin;
    while (end < byRegion.size() && byRegion[end] >> 3 == byRegion[begin] >> 3) ++end;
    BrickSet set;
    for (size_t i = begin; i < end; ++i)
      for (const Coord step : kAroundSteps)
        if (const Coord near = byRegion[i] + step; std::binary_search(sorted.begin(), sorted.end(), near))
          set.add(near);
    std::vector<Coord> all = set.sorted();
    std::sort(all.begin(), all.end());
    wanted.clear();
    for (const Coord c : all) wanted.push_back(c >> 3 == byRegion[begin] >> 3);
    const auto now = solveDistances(editor, all, wanted, 1);
    settled.bricks.insert(settled.bricks.end(), now.begin(), now.end());
    begin = end;
    if (job) job->step(jobFrom + (1 - jobFrom) * double(end) / double(byRegion.size()));
  }
  (void)linkSettled(editor, std::exchange(settled.bricks, {}));
}

void clearChannelsRoundedAway(Editor& editor, Coord brick) {
  if (editor.step() != 0) clearChannelsOutsideBand(editor, brick);
}

void clearChannelsOutsideBand(Editor& editor, Coord coord) {
  const float band = editor.grid().band;
  const Slot distance = editor.find(coord);
  for (const Channel channel : kAllChannels) {
    const ChannelSlot slot = editor.has(channel) ? editor.find(channel, coord) : ChannelSlot();
    if (slot == ChannelSlot()) continue;
    if (distance.isTile()) {
      editor.setChannelTile(channel, coord, false);
      continue;
    }
    std::array<uint8_t, kBrickVoxels> values;
    for (int i = 0; i < kBrickVoxels; ++i)
      values[static_cast<size_t>(i)] = std::abs(distance.phi(i, band)) < band ? slot.value(i) : 0;
    editor.setChannel(channel, coord, values);
  }
}

void keepChannels(Editor& editor, const Version& from) {
  const float band = editor.grid().band;
  for (const Channel channel : kAllChannels) {
    if (!from.has(channel)) continue;
    from.forEachBrick([&](const Brick& was) {
      const Slot is = editor.find(was.coord);
      const ChannelSlot slot = from.find(channel, was.coord);
      if (slot == ChannelSlot()) return;
      if (is.isTile()) {
        editor.setChannelTile(channel, was.coord, false);
        return;
      }
      std::array<uint8_t, kBrickVoxels> values;
      for (int i = 0; i < kBrickVoxels; ++i) {
        const bool both = std::abs(is.phi(i, band)) < band && std::abs(was.phi(i)) < band;
        values[static_cast<size_t>(i)] = both ? slot.value(i) : 0;
      }
      editor.setChannel(channel, was.coord, values);
    });
  }
}

std::vector<Coord> bricksAround(const Editor& editor, const std::vector<Coord>& coords) {
  BrickSet around;
  for (const Coord c : coords)
    for (const Coord step : kAroundSteps)
      if (editor.find(c + step).brick()) around.add(c + step);
  return around.sorted();
}

void dropWithoutSurface(Editor& editor, const std::vector<Coord>& coords) {
  std::vector<Coord> drop;
  for (const Coord c : coords) {
    bool inside = false, outside = false;
    for (const Coord step : kAroundSteps) {
      if (inside && outside) break;
      const Slot slot = editor.find(c + step);
      inside |= slot.brick() ? slot.brick()->anyInside != 0 : slot.tile() == Tile::inside;
      outside |= slot.brick() ? slot.brick()->anyOutside != 0 : slot.tile() == Tile::outside;
    }
    if (!(inside && outside)) drop.push_back(c);
  }
  for (const Coord c : drop)
    if (const Brick* brick = editor.find(c).brick()) editor.setTile(c, brick->anyInside ? Tile::inside : Tile::outside);
}

void redistanceAll(Editor& editor, std::vector<Coord> coords, const WorkPart& part, float tolerance,
                   const StandsTest& stands) {
  std::sort(coords.begin(), coords.end());
  dropWithoutSurface(editor, coords);
  std::erase_if(coords, [&](Coord c) { return !editor.find(c).brick(); });
  // A call meets values of the next one's that were only bounds.
  const int rounds = coords.size() > kRedistanceAtOnce ? 2 : 1;
  const double all = static_cast<double>(std::max<size_t>(coords.size(), 1)) * rounds;
  for (int round = 0; round < rounds; ++round)
    for (size_t from = 0; from < coords.size(); from += kRedistanceAtOnce) {
      part.step((static_cast<double>(from) + static_cast<double>(coords.size()) * round) / all);
      const auto some = std::span(coords).subspan(from, std::min(kRedistanceAtOnce, coords.size() - from));
      if (stands)
        redistanceUnless(editor, some, tolerance, stands);
      else
        redistance(editor, some, {}, 1, {.tolerance = tolerance});
    }
}

}  // namespace argil::clay
