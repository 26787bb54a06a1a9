#include "clay/whole/smooth_all.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "clay/base/parallel.h"
#include "clay/field/region_work.h"
#include "clay/field/renewal.h"
#include "clay/field/settle.h"
#include "clay/store/brick_margins.h"
#include "clay/store/brick_set.h"
#include "clay/store/channel_source.h"
#include "clay/store/store.h"

namespace argil::clay {

namespace {

// What one look at four voxels around a brick can do, and what a band of three leaves room for: beyond it values only
// say "farther", which bends the mean of what lies near by a part that grows with the square of curvature.
constexpr int kTogether = 4;
constexpr float kWideBand = 3;
constexpr int kTogetherNarrow = 2;
// Bricks along an axis of what is worked on at once. What lies around it is done twice: a quarter more than it here,
// more than half of it with eight.
constexpr int kEdge = 16;
constexpr int kEdgeBits = 4;
// A surface moves by two voxels at most in one look: nothing comes near where nothing is within the band two voxels
// off.
constexpr float kMostShift = 2;
constexpr int kLayers = 2;
// Where no mean is smaller than the band less this part of its spread, no distance is within the band: at its end the
// mean of a flat surface's field is smaller by 0.4 of it.
constexpr float kBeyond = 0.25f;
// Voxels; so little changes the band's end by less than redistancing lets stand.
constexpr float kSmallShift = 0.05f;
constexpr int kVolumeSteps = 6;
constexpr double kVolumeError = 1e-5;

// How far outwards the surface has that volume: by secants, the first with the area.
float shiftTo(double volume, const Version& version, int threads) {
  const double most = std::min(version.grid().band - 1, kMostShift), begin = volumeOf(version, 0, threads);
  double shift = 0, now = begin, gain = areaOf(version);
  for (int i = 0; i < kVolumeSteps && std::abs(volume - now) > kVolumeError * volume; ++i) {
    shift = std::clamp(shift + (volume - now) / gain, -most, most);
    now = volumeOf(version, static_cast<float>(shift), threads);
    if (shift != 0 && (now - begin) / shift > 0) gain = (now - begin) / shift;
  }
  return static_cast<float>(shift);
}

// The blocks of kEdge³ bricks that hold a brick or have one beside them.
std::vector<Coord> blocksOf(const Version& version) {
  BrickSet blocks;
  version.forEachBrick([&](const Brick& brick) {
    for (const Coord step : kAroundSteps) blocks.add((brick.coord + step) >> kEdgeBits);
  });
  return blocks.sorted();
}

// A block of bricks, with one more around it: their means, and then distances from them.
class Evened {
 public:
  explicit Evened(const Version& source) : field_(source), band_(source.grid().band) {}

  // Means of `passes` of a block, less `shift`.
  void average(Coord block, int passes, float shift);
  // Bricks of the block itself: tile(coord, inside), or what fresh(coord) gives is filled and goes to
  // linked(brick, inBand, number).
  template <class TileAt, class Fresh, class Linked>
  void distances(const TileAt& tile, const Fresh& fresh, const Linked& linked);
  // Once distances are there: the voxel beside the surface that is nearest to voxel `v` of a brick, by its number.
  void footsFrom(size_t number) { renewal_->around(number, around_.data()); }
  [[nodiscard]] Coord foot(Coord brick, int v) const;

 private:
  static constexpr int kRoom =
      kEdge + 4;  // two bricks around the block, so that each that is evened out has neighbours
  struct Mean {
    Coord brick;
    std::array<float, kBrickVoxels> phi;
  };
  [[nodiscard]] static size_t place(Coord c) { return static_cast<size_t>((c.x * kRoom + c.y) * kRoom + c.z); }
  [[nodiscard]] bool mine(Coord brick) const { return (brick >> kEdgeBits) * kEdge == first_; }

  Sampler field_;
  float band_;
  Coord first_;
  std::vector<uint8_t> wanted_;
  std::vector<Mean> means_;
  std::vector<std::pair<Coord, bool>> tiles_;  // of the block: flat now, and whether inside
  std::optional<Renewal> renewal_;
  std::array<float, kWideSize> around_;
};

// For each brick around (kAroundSteps) whether something within the band lies no farther than kLayers from it.
uint32_t near(const BrickValues& values, float band) {
  uint64_t slices[kBrickEdge];
  for (int x = 0; x < kBrickEdge; ++x) {
    slices[x] = 0;
    for (int i = 0; i < 64; ++i) slices[x] |= uint64_t{std::abs(values[x * 64 + i]) < band} << i;
  }
  constexpr uint64_t kAll = ~uint64_t{0}, kFirstZ = 0x0101010101010101u * ((1u << kLayers) - 1),
                     kFirstY = (uint64_t{1} << (8 * kLayers)) - 1;
  constexpr uint64_t kY[3] = {kFirstY, kAll, kFirstY << (64 - 8 * kLayers)},
                     kZ[3] = {kFirstZ, kAll, kFirstZ << (kBrickEdge - kLayers)};
  uint64_t below = 0, all = 0, above = 0;
  for (int x = 0; x < kBrickEdge; ++x) {
    all |= slices[x];
    if (x < kLayers) below |= slices[x];
    if (x >= kBrickEdge - kLayers) above |= slices[x];
  }
  const uint64_t sides[3] = {below, all, above};
  uint32_t found = 0;
  for (size_t i = 0; i < kBricksAround; ++i) found |= uint32_t{(sides[i / 9] & kY[i / 3 % 3] & kZ[i % 3]) != 0} << i;
  return found;
}

void Evened::average(Coord block, int passes, float shift) {
  first_ = block * kEdge;
  means_.clear();
  tiles_.clear();
  wanted_.assign(size_t{kRoom} * kRoom * kRoom, 0);
  const Coord corner = first_ - Coord{2, 2, 2};
  const auto forRoom = [](int rim, const auto& visit) {
    for (int x = rim; x < kRoom - rim; ++x)
      for (int y = rim; y < kRoom - rim; ++y)
        for (int z = rim; z < kRoom - rim; ++z) visit(Coord{x, y, z});
  };
  const auto within = [](int32_t at) { return at >= 0 && at < kRoom; };
  forRoom(0, [&](Coord c) {
    const Slot slot = field_.slot(corner + c);
    if (slot.isTile()) return;
    BrickValues room;
    const uint32_t around = near(slot.values(room, band_), band_);
    for (size_t i = 0; i < kBricksAround; ++i) {
      const Coord to = c + kAroundSteps[i];
      if ((around >> i & 1) && within(to.x) && within(to.y) && within(to.z)) wanted_[place(to)] = 1;
    }
    wanted_[place(c)] = 1;
  });
  const float least = band_ - kBeyond * std::sqrt(static_cast<float>(passes) / 2);
  float broad[kBroadSize] = {};
  forRoom(1, [&](Coord c) {
    if (!wanted_[place(c)]) return;
    const Coord brick = corner + c;
    gatherBroad(field_, brick, 4, broad);
    means_.emplace_back();
    Mean& mean = means_.back();
    mean.brick = brick;
    if (broadMeans(broad, passes, shift, band_, mean.phi.data()) < least) return;
    if (mine(brick)) tiles_.emplace_back(brick, mean.phi[0] < 0);
    means_.pop_back();
  });
}

template <class TileAt, class Fresh, class Linked>
void Evened::distances(const TileAt& tile, const Fresh& fresh, const Linked& linked) {
  for (const auto& [brick, inside] : tiles_) tile(brick, inside);
  if (means_.empty()) return;
  std::vector<Coord> coords;
  for (const Mean& mean : means_) coords.push_back(mean.brick);
  const auto beside = besideEach(coords, kAroundSteps);
  renewal_.emplace(coords, band_, 1);
  float broad[kBroadSize] = {};
  for (size_t i = 0; i < means_.size(); ++i) {
    std::array<const float*, kBricksAround> around{};
    for (size_t k = 0; k < kBricksAround; ++k)
      if (const ptrdiff_t at = beside[i][k]; at >= 0) around[k] = means_[static_cast<size_t>(at)].phi.data();
    gatherBroad(field_, coords[i], 4, broad, around.data());
    renewal_->begin(i, broad, Renew::all);
  }
  renewal_->run();
  for (size_t i = 0; i < means_.size(); ++i) {
    if (!mine(coords[i])) continue;
    FloatBrick* const brick = fresh(coords[i]);
    BrickValues sizes;
    renewal_->sizes(i, sizes);
    linked(brick, settleDistance(means_[i].phi.data(), sizes, band_, 0, *brick).inBand, i);
  }
}

Coord Evened::foot(Coord brick, int v) const {
  const int voxel[3] = {v >> 6, (v >> 3) & 7, v & 7};
  const float* at = around_.data() + wideOffset(voxel[0] + 2, voxel[1] + 2, voxel[2] + 2);
  constexpr int kSteps[3] = {12 * kWideRow, kWideRow, 1};
  const float own = std::abs(*at);
  Vec3f way = Vec3f::Zero();
  for (int k = 0; k < 3; ++k) {
    const float below = std::abs(at[-kSteps[k]]), above = std::abs(at[kSteps[k]]);
    if (const float nearer = std::min(below, above); nearer < own) way[k] = below < above ? nearer - own : own - nearer;
  }
  const float length = way.norm();
  if (length > 0) way *= own / length;
  return brick * kBrickEdge + Coord{voxel[0] + static_cast<int>(std::lround(way.x())),
                                    voxel[1] + static_cast<int>(std::lround(way.y())),
                                    voxel[2] + static_cast<int>(std::lround(way.z()))};
}

// Work rooms, one for each thread that is at work: fresh pages for each block would cost more than what is in them.
class Rooms {
 public:
  explicit Rooms(const Version& source) : source_(source) {}
  template <class Work>
  void with(const Work& work) {
    std::unique_ptr<Evened> room;
    {
      const std::lock_guard lock(mutex_);
      if (!spare_.empty()) {
        room = std::move(spare_.back());
        spare_.pop_back();
      }
    }
    if (!room) room = std::make_unique<Evened>(source_);
    work(*room);
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(room));
  }

 private:
  const Version& source_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Evened>> spare_;
};

// One look at all of it, put into `store`.
Version evenedOut(const Version& source, const std::shared_ptr<Store>& store, int passes, float shift, int threads,
                  const WorkPart& part) {
  const float band = source.grid().band;
  const bool channels = ChannelSource::any(source);
  const std::vector<Coord> blocks = blocksOf(source);
  Editor editor(Version::empty(store, source.grid()));
  copyTiles(source, editor);
  Rooms rooms(source);
  std::mutex editing;
  size_t done = 0;
  const auto evenOut = [&](Coord block, Evened& room) {
    ChannelSource old(source);
    room.average(block, passes, shift);
    room.distances(
        [&](Coord brick, bool inside) {
          const Tile tile = inside ? Tile::inside : Tile::outside;
          const std::lock_guard lock(editing);
          if (editor.find(brick) != Slot(tile)) editor.setTile(brick, tile);
        },
        [&](Coord brick) {
          const std::lock_guard lock(editing);
          return editor.newBrick(brick);
        },
        [&](FloatBrick* brick, bool inBand, size_t number) {
          const Coord coord = brick->coord;
          ChannelBlock paint{ChannelPlace{}};
          if (channels && inBand) {
            room.footsFrom(number);
            ChannelBytes bytes;
            for (int v = 0; v < kBrickVoxels; ++v) {
              if (!(std::abs(brick->value[v]) < band)) continue;
              const Coord at = coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
              if (old.read(at, bytes) || old.nearest(room.foot(coord, v), bytes) != ChannelSource::kNone)
                paint.set(v, bytes);
            }
          }
          const std::lock_guard lock(editing);
          editor.link(brick, inBand);
          if (!channels || !inBand) return;
          paint.store(editor, coord);
          clearChannelsRoundedAway(editor, coord);
        });
  };
  parallelBlocks(
      blocks.size(), threads,
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          rooms.with([&](Evened& room) { evenOut(blocks[i], room); });
          const std::lock_guard lock(editing);
          part.step(static_cast<double>(++done) / static_cast<double>(blocks.size()));
        }
      },
      1);
  return editor.commit();
}

// Distances less a small shift: the band's end alone is not what it would be, by so much.
Version moved(const Version& source, float shift) {
  const float band = source.grid().band;
  Editor editor(source);
  source.forEachBrick([&](const Brick& brick) {
    BrickValues room;
    const BrickValues& was = brick.values(room);
    std::array<float, kBrickVoxels> phi;
    for (size_t v = 0; v < kBrickVoxels; ++v)
      phi[v] = std::abs(was[v]) < band ? std::clamp(was[v] - shift, -band, band) : was[v];
    editor.setVoxels(brick.coord, phi);
    clearChannelsOutsideBand(editor, brick.coord);
  });
  return editor.commit();
}

}  // namespace

Version smoothAll(const Version& version, int passes, bool keepVolume, int threads, Job* job) {
  if (passes < 1 || passes > 200) throw Error(fmt::format("smoothing in {} passes: give 1 to 200", passes));
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is nothing to smooth");
  threads = threadCount(threads);
  const WorkPart all(job);
  const int together = version.grid().band >= kWideBand ? kTogether : kTogetherNarrow;
  const double looks = (passes + together - 1) / together + (keepVolume ? 1 : 0);
  const auto store = Store::make(version.store()->precision());
  Version now = version;
  int done = 0;
  const auto run = [&](int count, float shift) {
    now = evenedOut(now, store, count, shift, threads, all.part(done / looks, (done + 1) / looks));
    ++done;
    while (store->collect()) {  // The next look takes the room of the one before this.
    }
    if (now.stats().bricks == 0)
      throw Error("nothing is left after smoothing: the piece is thinner than that; give fewer passes",
                  Error::Kind::work);
  };
  for (int left = passes; left > 0; left -= together) run(std::min(left, together), 0);
  if (keepVolume) {
    const float shift = shiftTo(volumeOf(version, 0, threads), now, threads);
    if (std::abs(shift) > kSmallShift)
      run(0, shift);
    else if (shift != 0)
      now = moved(now, shift);
  }
  if (job) job->step(1);
  return now;
}

}  // namespace argil::clay
