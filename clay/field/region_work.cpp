#include "clay/field/region_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>
#include <thread>

#include "clay/base/parallel.h"
#include "clay/field/settle.h"
#include "clay/field/thin_parts.h"
#include "clay/field/work_rooms.h"
#include "clay/store/brick_set.h"
#include "clay/store/channel_source.h"
#include "clay/store/store.h"
#include "clay/store/tree_view.h"

namespace argil::clay {

int threadCount(int threads) {
  if (threads < 0 || threads > 64) throw Error(fmt::format("{} threads: give 1 to 64, or 0 for all cores", threads));
  return threads > 0 ? threads : static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 64u));
}

std::vector<Coord> regionsNear(const Version& version, int reach, const std::function<bool(const Brick&)>& wants) {
  BrickSet regions;
  version.forEachBrick([&](const Brick& brick) {
    if (wants && !wants(brick)) return;
    const Coord r{reach, reach, reach}, edge{kBrickEdge - 1, kBrickEdge - 1, kBrickEdge - 1};
    const Coord low = (brick.coord * kBrickEdge - r) >> 6, high = (brick.coord * kBrickEdge + edge + r) >> 6;
    for (int x = low.x; x <= high.x; ++x)
      for (int y = low.y; y <= high.y; ++y)
        for (int z = low.z; z <= high.z; ++z) regions.add({x, y, z});
  });
  return regions.sorted();
}

namespace {

void copyTilesOf(const TreePlace& place, Editor& target) {
  if (place.isTile()) {
    if (place.tile() == Tile::inside) target.setBlock(place.first(), place.level(), Tile::inside);
    return;
  }
  if (!place.isNode()) return;
  for (int i = 0; i < 512; ++i) copyTilesOf(place.child(i), target);
}

}  // namespace

void copyTiles(const Version& version, Editor& target) {
  copyTilesOf(TreePlace::root(version), target);
}

void copyAll(const Version& version, Editor& target, const WorkPart& part) {
  constexpr uint64_t kStepEvery = 4096;  // bricks between two looks at the job
  copyTiles(version, target);
  uint64_t done = 0;
  const auto all = static_cast<double>(version.stats().bricks + 1);
  version.forEachBrick([&](const Brick& brick) {
    if (done++ % kStepEvery == 0) part.step(0.9 * static_cast<double>(done) / all);
    BrickValues room;
    target.setVoxels(brick.coord, brick.values(room));
  });
  keepChannels(target, version);
  part.step(1);
}

namespace {

// Voxels of tiles that are inside; bricks are left for later.
double tilesInside(const TreePlace& place, std::vector<const Brick*>& bricks) {
  double sum = 0;
  if (place.isTile()) return place.tile() == Tile::inside ? kBrickVoxels * std::pow(512.0, place.level()) : 0;
  if (place.isNode()) {
    for (int i = 0; i < 512; ++i) sum += tilesInside(place.child(i), bricks);
    return sum;
  }
  bricks.push_back(place.brick());
  return 0;
}

}  // namespace

double volumeOf(const Version& version, float shift, int threads) {
  constexpr size_t kTogether = 1024;  // bricks of one sum
  std::vector<const Brick*> bricks;
  double all = tilesInside(TreePlace::root(version), bricks);
  std::vector<double> sums((bricks.size() + kTogether - 1) / kTogether);
  parallelBlocks(
      sums.size(), threads,
      [&](size_t begin, size_t end) {
        BrickValues room;
        for (size_t i = begin * kTogether; i < std::min(end * kTogether, bricks.size()); ++i) {
          // Of a brick sums of floats are as exact as its values.
          float sum = 0;
          for (const float phi : bricks[i]->values(room)) sum += std::clamp(0.5f + shift - phi, 0.0f, 1.0f);
          sums[i / kTogether] += double(sum);
        }
      },
      1);
  for (const double sum : sums) all += sum;
  return all;
}

double areaOf(const Version& version) {
  uint64_t edges = 0;
  constexpr uint64_t kNotLastZ = 0x7f7f7f7f7f7f7f7f;
  version.forEachBrick([&](const Brick& brick) {
    for (int x = 0; x < kBrickEdge; ++x) {
      const uint64_t inside = brick.inside[x];
      if (x + 1 < kBrickEdge) edges += static_cast<uint64_t>(std::popcount(inside ^ brick.inside[x + 1]));
      edges += static_cast<uint64_t>(std::popcount((inside ^ inside >> 8) & (~uint64_t{0} >> 8)));
      edges += static_cast<uint64_t>(std::popcount((inside ^ inside >> 1) & kNotLastZ));
    }
  });
  // Edges between bricks are left out: an eighth of all.
  return double(edges) / (7.0 / 8.0) / 1.5;
}

namespace {

// What a new brick of these distances has in its channels.
ChannelBlock carried(const DistanceBox& box, ChannelSource& old, Coord low, std::span<const float, kBrickVoxels> phi,
                     float band) {
  ChannelBlock block{ChannelPlace{}};
  ChannelBytes bytes;
  for (int v = 0; v < kBrickVoxels; ++v) {
    if (!(std::abs(phi[static_cast<size_t>(v)]) < band)) continue;
    const Coord at = low + Coord{v >> 6, (v >> 3) & 7, v & 7};
    if (old.nearest(box.foot(at), bytes) != ChannelSource::kNone) block.set(v, bytes);
  }
  return block;
}

}  // namespace

Version rebuild(const Version& source, std::span<const Coord> regions, DistanceBox::Reach reach, int threads,
                const WorkPart& part, float shift, ThinParts* gone) {
  const float band = source.grid().band;
  // What is farther off than looked is outside of the band, and not a last digit within it: all of space would be.
  for (; reach.outside - shift < band; reach.outside = std::nextafter(reach.outside, HUGE_VALF)) {
  }
  for (; reach.inside + shift < band; reach.inside = std::nextafter(reach.inside, HUGE_VALF)) {
  }
  const bool channels = ChannelSource::any(source);
  reach.feet = channels;
  Editor editor(Version::empty(Store::make(source.store()->precision()), source.grid()));
  copyTiles(source, editor);
  std::mutex editing;
  std::vector<Coord> written;
  forEachWithRoom<DistanceBox>(regions.size(), threads, part.part(0, 0.98), [&](size_t i, DistanceBox& box) {
    const Coord first = regions[i] * kRegionBricks;
    if (!box.fill(source, first * kBrickEdge, Coord{1, 1, 1} * kRegionVoxels, reach)) return;
    std::vector<std::array<float, kBrickVoxels>> values;
    std::vector<Coord> bricks;
    std::vector<ChannelBlock> paint;
    ChannelSource old(source);
    const auto setTile = [&](Coord brick, bool inside) {
      const Tile tile = inside ? Tile::inside : Tile::outside;
      const std::lock_guard lock(editing);
      if (editor.find(brick) != Slot(tile)) editor.setTile(brick, tile);
    };
    for (int b = 0; b < 512; ++b) {
      const Coord brick = first + Coord{b >> 6, (b >> 3) & 7, b & 7};
      const Coord low = brick * kBrickEdge;
      values.emplace_back();
      using Row = Eigen::Array<float, kBrickEdge, 1>;
      float* out = values.back().data();
      Row least = Row::Constant(band);
      for (int row = 0; row < kBrickVoxels; row += kBrickEdge) {
        const Eigen::Map<const Row> from(box.row(low + Coord{row >> 6, (row >> 3) & 7, 0}));
        const Row phi = (from - shift).max(-band).min(band);
        Eigen::Map<Row>(out + row) = phi;
        least = least.min(phi.abs());
      }
      if (!(least < band).any()) {
        setTile(brick, out[0] < 0);
        values.pop_back();
        continue;
      }
      bricks.push_back(brick);
      if (channels) paint.push_back(carried(box, old, low, values.back(), band));
    }
    const std::lock_guard lock(editing);
    for (size_t k = 0; k < bricks.size(); ++k) {
      editor.setVoxels(bricks[k], values[k]);
      if (!channels) continue;
      paint[k].store(editor, bricks[k]);
      clearChannelsRoundedAway(editor, bricks[k]);
    }
    written.insert(written.end(), bricks.begin(), bricks.end());
  });
  // What vanished leaves values that are within the band of nothing.
  dropWithoutSurface(editor, written);
  std::vector<Coord> renewed;
  const ThinParts here = removeThin(editor, written, renewed);
  if (gone != nullptr) *gone += here;
  if (!renewed.empty()) dropWithoutSurface(editor, written);
  // Where an edge came up or two sides met.
  limitSlopes(editor, written, threads, part.part(0.98, 1));
  if (channels)
    for (const Coord brick : written)
      if (!editor.find(brick).brick()) clearChannels(editor, brick);
  return editor.commit();
}

}  // namespace argil::clay
