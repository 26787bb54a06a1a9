// Colour and material go where the clay goes.

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <map>
#include <unordered_map>

#include "clay/brush/brush_channels.h"
#include "clay/store/channel_mean.h"

namespace argil::clay {

bool carriesChannels(const Editor& editor, const Brush& brush) {
  return brush.dye ||
         std::any_of(kAllChannels.begin(), kAllChannels.end(), [&](Channel channel) { return editor.has(channel); });
}

namespace {

// Moved clay is read between voxels in steps of 1/kSteps, with whole numbers: their sums do not depend on an order, and
// mirrored places are read alike.
constexpr int kSteps = 64;
// What is this many steps or more away counts as equally far: a count of 16 bits must not begin anew.
constexpr uint16_t kMostSteps = 65535;
constexpr uint16_t oneMore(uint16_t steps) {
  return steps < kMostSteps ? static_cast<uint16_t>(steps + 1) : kMostSteps;
}
// A voxel that a mask covers by as much keeps its own when clay moves.
constexpr uint8_t kHeld = 128;

// The clay at a place between voxels, in place of a voxel's own. False: no band there.
bool readMoved(ChannelReader<Version>& was, Coord voxel, const Vec3f& from, ChannelBytes& bytes) {
  int32_t first[3], part[3];
  const int32_t home[3] = {voxel.x, voxel.y, voxel.z};
  for (int i = 0; i < 3; ++i) {
    const auto steps = static_cast<int64_t>(std::lround((from[i] - static_cast<float>(home[i])) * kSteps));
    first[i] = home[i] + static_cast<int32_t>(steps >= 0 ? steps / kSteps : -((-steps + kSteps - 1) / kSteps));
    part[i] = static_cast<int32_t>(steps - int64_t{first[i] - home[i]} * kSteps);
  }
  ChannelMean mean;
  for (int corner = 0; corner < 8; ++corner) {
    const int step[3] = {corner >> 2, (corner >> 1) & 1, corner & 1};
    int64_t weight = 1;
    for (int i = 0; i < 3; ++i) weight *= step[i] ? part[i] : kSteps - part[i];
    if (weight == 0) continue;
    const Coord at{first[0] + step[0], first[1] + step[1], first[2] + step[2]};
    const ChannelPlace& place = was.at(at >> kBrickBits);
    const int offset = Brick::offset(at.x & 7, at.y & 7, at.z & 7);
    if (place.inBand(offset, was.band())) mean.add(place.bytes(offset), weight);
  }
  if (mean.empty()) return false;
  const uint8_t mask = bytes[indexOf(Channel::mask)];
  bytes = mean.value();
  bytes[indexOf(Channel::mask)] = mask;
  return true;
}

enum class State : uint8_t { none, known, wanted, queued };

struct Block {
  Block(Coord at, const ChannelPlace& place, bool isOwn) : coord(at), channels(place), own(isOwn) {}
  Coord coord;
  ChannelBlock channels;
  bool own;  // to be stored; the others are neighbours that are read
  std::array<State, kBrickVoxels> state;
  std::array<uint16_t, kBrickVoxels> steps;  // of what is known; of what is queued the least so far
  bool stepped = false;                      // some of them are above 0
};

class Carrier {
 public:
  Carrier(Editor& editor, const Version& was, const Brush& brush, CarriedFrom& stroke)
      : editor_(editor), was_(was), now_(editor), brush_(brush), stroke_(stroke) {}

  // A brick whose distances changed or whose clay moved; `from`: where to, or null.
  void add(Coord coord, const Vec3f (*from)[kBrickVoxels]) {
    const ChannelPlace &now = now_.at(coord), &was = was_.at(coord);
    if (now.distance.isTile()) {
      if (!now.empty()) gone_.push_back(coord);
      return;
    }
    Block& block = blocks_.emplace_back(coord, now, true);
    takeSteps(block);
    index_[coord] = static_cast<int>(blocks_.size()) - 1;
    uint64_t nowBits[kBrickEdge], wasBits[kBrickEdge] = {};
    now.inBand(now_.band(), nowBits);
    if (!was.distance.isTile()) was.inBand(now_.band(), wasBits);
    // Most voxels keep what they have, or have nothing.
    block.state.fill(State::none);
    uint64_t both[kBrickEdge];
    for (int x = 0; x < kBrickEdge; ++x) both[x] = nowBits[x] & wasBits[x];
    block.channels.keepOnly(both);
    for (int x = 0; x < kBrickEdge; ++x) {
      forBits(both[x], x, [&](int i) { block.state[static_cast<size_t>(i)] = State::known; });
      forBits(nowBits[x] & ~wasBits[x], x, [&](int i) {
        block.state[static_cast<size_t>(i)] = State::wanted;
        block.steps[static_cast<size_t>(i)] = 0;
      });
      if (from) forBits(nowBits[x], x, [&](int i) { move(block, i, (*from)[i]); });
      forBits(nowBits[x] & ~wasBits[x], x, [&](int i) {
        if (block.state[static_cast<size_t>(i)] == State::wanted)
          wanted_.push_back({static_cast<int>(blocks_.size()) - 1, i});
      });
    }
  }

  // Along the band from what is known, the nearest first: all that are as many steps from the clay of the stroke's
  // beginning at once.
  void spread() {
    std::map<uint16_t, std::vector<Place>> queue;
    const auto reach = [&](const Place& place, uint16_t steps) {
      if (stateOf(place) == State::queued && stepsAt(place) <= steps) return;
      stateOf(place) = State::queued;
      stepsAt(place) = steps;
      queue[steps].push_back(place);
    };
    for (const Place& each : wanted_)
      forNeighbours(each, [&](const Place& near) {
        if (stateOf(near) == State::known) reach(each, oneMore(stepsAt(near)));
      });
    std::vector<std::pair<Place, ChannelBytes>> layer;
    while (!queue.empty()) {
      const uint16_t steps = queue.begin()->first;
      layer.clear();
      for (const Place& each : queue.begin()->second) {
        if (stateOf(each) != State::queued || stepsAt(each) != steps) continue;  // a nearer one was found
        ChannelMean mean;
        forNeighbours(each, [&](const Place& near) {
          if (stateOf(near) == State::known && oneMore(stepsAt(near)) == steps)
            mean.add(blockOf(near).channels.bytes(near.voxel), 1);
        });
        ChannelBytes bytes = mean.value();
        bytes[indexOf(Channel::mask)] = 0;
        layer.emplace_back(each, bytes);
      }
      queue.erase(queue.begin());
      for (const auto& [place, bytes] : layer) {
        Block& block = blockOf(place);
        block.channels.set(place.voxel, bytes);
        block.stepped = true;
        stateOf(place) = State::known;
      }
      for (const auto& each : layer)
        forNeighbours(each.first, [&](const Place& near) {
          if (stateOf(near) == State::wanted || stateOf(near) == State::queued) reach(near, oneMore(steps));
        });
    }
  }

  // Clay that was laid on: how far the surface came out at a voxel, in voxels, is how much of the brush's colour it
  // has.
  void dye() {
    for (Block& block : blocks_) {
      if (!block.own) continue;
      const ChannelPlace &now = now_.at(block.coord), &was = was_.at(block.coord);
      BrickValues nowRoom, wasRoom;
      const BrickValues &nowPhi = now.distance.values(nowRoom, now_.band()),
                        &wasPhi = was.distance.values(wasRoom, now_.band());
      uint64_t bits[kBrickEdge];
      now.inBand(now_.band(), bits);
      for (int x = 0; x < kBrickEdge; ++x)
        forBits(bits[x], x, [&](int i) {
          const float laid = std::min(wasPhi[i] - nowPhi[i], 1.0f);
          if (!(laid > 0)) return;
          ChannelBytes bytes = block.channels.bytes(i);
          layColour(bytes, brush_.colour, laid);
          if (laid > 0.5f && brush_.material != 0) bytes[indexOf(Channel::material)] = brush_.material;
          block.channels.set(i, bytes);
        });
    }
  }

  void store() {
    for (const Block& block : blocks_) {
      if (!block.own) continue;
      block.channels.storeChanged(editor_, block.coord);
      if (block.stepped) stroke_[block.coord] = block.steps;
    }
    for (const Coord coord : gone_)
      for (const Channel channel : kAllChannels) editor_.setChannelTile(channel, coord, false);
  }

  // Whether a brick or one beside it has anything to take along.
  [[nodiscard]] bool concerned(Coord coord) {
    return std::any_of(kAroundSteps.begin(), kAroundSteps.end(),
                       [&](Coord step) { return !now_.at(coord + step).empty(); });
  }

 private:
  struct Place {
    int block, voxel;
  };
  template <class Visit>
  static void forBits(uint64_t bits, int x, const Visit& visit) {
    for (; bits != 0; bits &= bits - 1) visit(x << 6 | std::countr_zero(bits));
  }
  // Clay that came from somewhere, unless a mask held what is there.
  void move(Block& block, int i, const Vec3f& from) {
    ChannelBytes bytes = block.channels.bytes(i);
    const Coord voxel = block.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
    if (bytes[indexOf(Channel::mask)] >= kHeld || !readMoved(was_, voxel, from, bytes)) return;
    block.channels.set(i, bytes);
    block.state[static_cast<size_t>(i)] = State::known;
    block.steps[static_cast<size_t>(i)] = 0;
  }
  Block& blockOf(const Place& place) { return blocks_[static_cast<size_t>(place.block)]; }
  uint16_t& stepsAt(const Place& place) { return blockOf(place).steps[static_cast<size_t>(place.voxel)]; }
  void takeSteps(Block& block) const {
    const auto found = stroke_.find(block.coord);
    block.stepped = found != stroke_.end();
    if (block.stepped)
      block.steps = found->second;
    else
      block.steps.fill(0);
  }
  State& stateOf(const Place& place) { return blockOf(place).state[static_cast<size_t>(place.voxel)]; }

  template <class Visit>
  void forNeighbours(const Place& place, const Visit& visit) {
    const int at[3] = {place.voxel >> 6, (place.voxel >> 3) & 7, place.voxel & 7};
    const Coord home = blockOf(place).coord;
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        int to[3] = {at[0], at[1], at[2]};
        to[axis] += step;
        Place near{place.block, Brick::offset(to[0] & 7, to[1] & 7, to[2] & 7)};
        if ((to[axis] & ~7) != 0)
          near.block = indexOfBrick(home + Coord{axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0});
        visit(near);
      }
  }
  // A brick that did not change is known as it is.
  int indexOfBrick(Coord coord) {
    const auto [entry, fresh] = index_.try_emplace(coord, static_cast<int>(blocks_.size()));
    if (fresh) {
      const ChannelPlace& place = now_.at(coord);
      Block& block = blocks_.emplace_back(coord, place, false);
      takeSteps(block);
      for (int i = 0; i < kBrickVoxels; ++i)
        block.state[static_cast<size_t>(i)] = place.inBand(i, now_.band()) ? State::known : State::none;
    }
    return entry->second;
  }

  Editor& editor_;
  ChannelReader<Version> was_;
  ChannelReader<Editor> now_;
  const Brush& brush_;
  CarriedFrom& stroke_;
  std::deque<Block> blocks_;  // places stay while it grows
  std::unordered_map<Coord, int, CoordHash> index_;
  std::vector<Place> wanted_;
  std::vector<Coord> gone_;  // no band there any more
};

}  // namespace

void carryChannels(Editor& editor, const Version& was, const Brush& brush, const DistanceMethod* method,
                   std::span<const Stamp> images, CarriedFrom& stroke) {
  std::vector<Coord> changed;
  Version::forEachDifference(was, editor.base(), [&](Coord coord, Slot, Slot) { changed.push_back(coord); });
  if (method && !images.empty()) {
    // Moved clay may look as before.
    const std::vector<Coord> near = surfaceBricks(editor, images, [&](const Stamp& s) { return method->reach(s); });
    changed.insert(changed.end(), near.begin(), near.end());
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  }
  Carrier carrier(editor, was, brush, stroke);
  if (!brush.dye && std::none_of(changed.begin(), changed.end(), [&](Coord coord) { return carrier.concerned(coord); }))
    return;
  Vec3f from[kBrickVoxels];
  for (const Coord coord : changed) {
    const bool moved = method && method->origins(images, coord, from);
    carrier.add(coord, moved ? &from : nullptr);
  }
  carrier.spread();
  if (brush.dye) carrier.dye();
  carrier.store();
}

}  // namespace argil::clay
