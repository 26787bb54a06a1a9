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

#include "clay/field/region_work.h"
#include "clay/field/renewed_block.h"
#include "clay/field/settle.h"
#include "clay/field/unbent_plane.h"
#include "clay/field/work_rooms.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/kernels/smoothing_kernels.h"
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
// A surface moves by two voxels at most in one look: nothing comes near where nothing is within the band two voxels
// off.
constexpr float kMostShift = 2;
constexpr int kLayers = 2;
// Where no mean is smaller than the band less this part of its spread, no distance is within the band: at its end the
// mean of a flat surface's field is smaller by 0.4 of it.
constexpr float kBeyond = 0.25f;
// Means are distances once they are unbent, where their slopes are as near to 1.
constexpr float kSlopeOff = 0.03f;
// Every so many looks all is solved: what unbent planes leave out of thin plates adds up.
constexpr int kAllAnew = 3;
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

// The blocks that hold a brick or have one beside them.
std::vector<Coord> blocksOf(const Version& version) {
  BrickSet blocks;
  version.forEachBrick([&](const Brick& brick) {
    for (const Coord step : kAroundSteps) blocks.add((brick.coord + step) >> kBlockBits);
  });
  return blocks.sorted();
}

// For each brick around (kAroundSteps) whether something within the band lies no farther than kLayers from it.
uint32_t near(const BrickValues& values, float band) {
  uint64_t slices[kBrickEdge];
  bandBits(&values[0], band, slices);
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

// What the means of `passes` say of distances: by the normal distribution of the same spread.
UnbentPlane unbentPlane(int passes, float band) {
  const double spread = std::sqrt(passes / 2.0);
  // The mean of what is positive of a plane at the distance d.
  const auto ramp = [&](double d) {
    return d / 2 * std::erfc(-d / (spread * M_SQRT2)) +
           spread / std::sqrt(2 * M_PI) * std::exp(-d * d / (2 * spread * spread));
  };
  return {[&](double d) { return ramp(d + band) - ramp(d - band) - band; }, band};
}

// Means of `passes`, less `shift`, where the surface may come near. With `plane` they become distances, and those that
// are none are left to be solved; of bricks around the block, what these need.
void average(Sampler& field, Coord block, int passes, float shift, const UnbentPlane* plane, RenewedBlock& room) {
  constexpr int kRoom = kBlockEdge + 4;  // two bricks around the block: each that is evened out has neighbours
  const float band = field.band();
  room.begin(block, band);
  const Coord corner = room.first() - Coord{2, 2, 2};
  const auto place = [](Coord c) { return static_cast<size_t>((c.x * kRoom + c.y) * kRoom + c.z); };
  const auto forRoom = [](int rim, const auto& visit) {
    for (int x = rim; x < kRoom - rim; ++x)
      for (int y = rim; y < kRoom - rim; ++y)
        for (int z = rim; z < kRoom - rim; ++z) visit(Coord{x, y, z});
  };
  const auto within = [](int32_t at) { return at >= 0 && at < kRoom; };
  const auto onRim = [](Coord c) { return std::min({c.x, c.y, c.z}) == 0 || std::max({c.x, c.y, c.z}) == kRoom - 1; };
  std::array<bool, size_t{kRoom} * kRoom * kRoom> wanted{};
  forRoom(0, [&](Coord c) {
    const Slot slot = field.slot(corner + c);
    if (slot.isTile()) return;
    BrickValues values;
    const uint32_t around = near(slot.values(values, band), band);
    for (size_t i = 0; i < kBricksAround; ++i) {
      const Coord to = c + kAroundSteps[i];
      if ((around >> i & 1) && within(to.x) && within(to.y) && within(to.z)) wanted[place(to)] = true;
    }
    wanted[place(c)] = true;
  });
  const float least = band - kBeyond * std::sqrt(static_cast<float>(passes) / 2);
  float broad[kBroadSize] = {};
  // Whether it is to be solved.
  const auto add = [&](Coord c) {
    wanted[place(c)] = false;
    const Coord brick = corner + c;
    gatherBroad(field, brick, 4, broad);
    float* const mean = room.add(brick);
    if (broadMeans(broad, passes, shift, band, mean) < least) {
      if (!plane) return true;
      plane->distances(mean);
      if (!isSlopeOne(mean, band - 1, kSlopeOff)) return true;
      room.keepLast();
      return false;
    }
    if (room.holds(brick)) room.addTile(brick, mean[0] < 0);
    room.dropLast();
    return false;
  };
  std::vector<Coord> solved;
  forRoom(plane ? 2 : 1, [&](Coord c) {
    if (wanted[place(c)] && add(c) && plane) solved.push_back(c);
  });
  // What is kept is known all over: it comes through a brick beside the block.
  for (size_t i = 0; i < solved.size(); ++i)
    for (const Coord step : kAroundSteps)
      if (const Coord c = solved[i] + step; wanted[place(c)] && add(c) && !onRim(c)) solved.push_back(c);
}

// What is in the band of `old` stays, the rest has what its nearest place has.
ChannelBlock carried(ChannelSource& old, const FloatBrick& brick, const RenewedBlock::Feet& feet, float band) {
  ChannelBlock channels{ChannelPlace{}};
  ChannelBytes bytes;
  for (int v = 0; v < kBrickVoxels; ++v) {
    if (!(std::abs(brick.value[v]) < band)) continue;
    const Coord at = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
    const auto foot = [&] {
      const Vec3f way = feet.way(v);
      return at + Coord{static_cast<int>(std::lround(way.x())), static_cast<int>(std::lround(way.y())),
                        static_cast<int>(std::lround(way.z()))};
    };
    if (old.read(at, bytes) || old.nearest(foot(), bytes) != ChannelSource::kNone) channels.set(v, bytes);
  }
  return channels;
}

// One look at all of it, put into `store`; where more are to come, distances are solved only where a mean is none.
Version evenedOut(const Version& source, const std::shared_ptr<Store>& store, int passes, float shift, bool last,
                  int threads, const WorkPart& part) {
  const float band = source.grid().band;
  const bool channels = ChannelSource::any(source);
  std::optional<UnbentPlane> plane;
  if (!last && band >= kWideBand) plane = unbentPlane(passes, band);
  Editor editor(Version::empty(store, source.grid()));
  copyTiles(source, editor);
  std::mutex editing;
  const std::vector<Coord> blocks = blocksOf(source);
  forEachWithRoom<RenewedBlock>(blocks.size(), threads, part, [&](size_t i, RenewedBlock& room) {
    Sampler field(source);
    average(field, blocks[i], passes, shift, plane ? &*plane : nullptr, room);
    room.solve(Renew::all, field);
    ChannelSource old(source);
    const auto paint = [&](const FloatBrick& brick, size_t number) {
      return carried(old, brick, RenewedBlock::Feet(room, number, &field), band);
    };
    room.put(editor, editing, channels ? RenewedBlock::Paint(paint) : nullptr);
  });
  return editor.commit();
}

// Distances less a small shift: the band's end alone is not what it would be, by so much.
Version moved(const Version& source, float shift, int threads, const WorkPart& part) {
  const float band = source.grid().band;
  Editor editor(source);
  std::mutex editing;
  const std::vector<Coord> blocks = blocksOf(source);
  forEachWithRoom<RenewedBlock>(blocks.size(), threads, part, [&](size_t i, RenewedBlock& room) {
    room.begin(blocks[i], band);
    Sampler field(source);
    for (int b = 0; b < kBlockEdge * kBlockEdge * kBlockEdge; ++b) {
      const Coord brick = room.first() + Coord{b >> (2 * kBlockBits), (b >> kBlockBits) % kBlockEdge, b % kBlockEdge};
      const Slot slot = field.slot(brick);
      if (slot.isTile()) continue;
      BrickValues values;
      slot.read(values, band);
      float* const phi = room.add(brick);
      for (int v = 0; v < kBrickVoxels; ++v)
        phi[v] = std::abs(values[v]) < band ? std::clamp(values[v] - shift, -band, band) : values[v];
    }
    room.put(editor, editing);
  });
  if (ChannelSource::any(source))
    source.forEachBrick([&](const Brick& brick) { clearChannelsOutsideBand(editor, brick.coord); });
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
  const auto run = [&](int count, float shift, bool last) {
    now = evenedOut(now, store, count, shift, last || done % kAllAnew == kAllAnew - 1, threads,
                    all.part(done / looks, (done + 1) / looks));
    ++done;
    while (store->collect()) {  // The next look takes the room of the one before this.
    }
    if (now.stats().bricks == 0)
      throw Error("nothing is left after smoothing: the piece is thinner than that; give fewer passes",
                  Error::Kind::work);
  };
  for (int left = passes; left > 0; left -= together) run(std::min(left, together), 0, left <= together);
  if (keepVolume) {
    const float shift = shiftTo(volumeOf(version, 0, threads), now, threads);
    if (std::abs(shift) > kSmallShift)
      run(0, shift, true);
    else if (shift != 0)
      now = moved(now, shift, threads, all.part(done / looks, 1));
  }
  if (job) job->step(1);
  return now;
}

}  // namespace argil::clay
