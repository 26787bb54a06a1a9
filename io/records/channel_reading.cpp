#include "io/records/channel_reading.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "io/records/clay_reading.h"

namespace argil::io {

namespace {

size_t rankOf(const PlaceSet& set, int place) {
  size_t rank = 0;
  forEachPlace(set, [&](int each) { rank += each < place; });
  return rank;
}

}  // namespace

void ChannelReading::lose(const char* what) {
  if (!repairing_)
    throw Error(fmt::format("damaged: {} of the clay's colours, materials or masks is missing or damaged", what),
                Error::Kind::work);
  ++lost_;
  exact_ = false;
}

std::optional<NodeBody> ChannelReading::load(RecordId id, int level, Coord first) {
  std::vector<std::byte> bytes;
  if (!source_.get(id, bytes)) return std::nullopt;
  const auto record = parseRecord(bytes);
  if (!record || record->header.id != id || record->header.owner != owner_) return std::nullopt;
  auto node = parseNode(*record);
  if (!node || node->level != level || node->first != first) return std::nullopt;
  return node;
}

// A block that is 0 or 255 everywhere: only where there are bricks, which bounds the work whatever a file says.
void ChannelReading::fill(clay::Channel channel, const clay::Version& bricksOf, int level, Coord first, bool full) {
  uint8_t values[clay::kBrickVoxels];
  std::fill(std::begin(values), std::end(values), full ? uint8_t{255} : uint8_t{0});
  const auto walk = [&](const auto& self, const clay::TreePlace& place) -> void {
    const Coord end = place.first() + Coord{1, 1, 1} * (1 << (3 * place.level())),
                blockEnd = first + Coord{1, 1, 1} * (1 << (3 * level));
    const bool apart = place.first().x >= blockEnd.x || place.first().y >= blockEnd.y ||
                       place.first().z >= blockEnd.z || end.x <= first.x || end.y <= first.y || end.z <= first.z;
    if (apart || place.isTile()) return;
    if (place.level() == 0)
      exact_ = set(channel, place.first(), values) && exact_;
    else
      for (int i = 0; i < 512; ++i) self(self, place.child(i));
  };
  walk(walk, clay::TreePlace::root(bricksOf));
}

bool ChannelReading::set(clay::Channel channel, Coord coord, std::span<const uint8_t, clay::kBrickVoxels> values) {
  const clay::Brick* brick = version_.find(coord).brick();
  if (!brick) {
    if (editor_.find(channel, coord) != clay::ChannelSlot()) editor_.setChannelTile(channel, coord, false);
    return std::all_of(values.begin(), values.end(), [](uint8_t value) { return value == 0; });
  }
  uint8_t inBand[clay::kBrickVoxels];
  bool whole = true;
  for (size_t i = 0; i < clay::kBrickVoxels; ++i) {
    inBand[i] = std::abs(brick->phi(i)) < version_.grid().band ? values[i] : uint8_t{0};
    whole = whole && inBand[i] == values[i];
  }
  editor_.setChannel(channel, coord, inBand);
  return whole;
}

void ChannelReading::visit(clay::Channel channel, State now, State near, int level, Coord first) {
  if (now == near) return;
  if (level == 0) {
    if (now.id != 0)
      wanted_.push_back({now.id, first});
    else
      fill(channel, now.full ? version_ : near_, 0, first, now.full);
    return;
  }
  if (now.id == 0 && near.id == 0) {
    fill(channel, now.full ? version_ : near_, level, first, now.full);
    return;
  }
  std::optional<NodeBody> nowNode, nearNode;
  if (now.id != 0) {
    nowNode = load(now.id, level, first);
    if (!nowNode) {
      lose("a node");
      now = {};
    } else {
      nodes_.emplace(now.id, *nowNode);
    }
  }
  if (near.id != 0 && !(nearNode = load(near.id, level, first)))
    throw Error("damaged: a node of the version beside it is missing or damaged", Error::Kind::work);
  size_t nowNext = 0, nearNext = 0;
  const auto childOf = [](const std::optional<NodeBody>& node, State whole, int place, size_t& next) {
    if (!node) return State{0, whole.full};
    if (holds(node->record, place)) return State{node->ids[next++], false};
    return State{0, holds(node->inside, place)};
  };
  for (int place = 0; place < 512; ++place) {
    const State a = childOf(nowNode, now, place, nowNext), b = childOf(nearNode, near, place, nearNext);
    visit(channel, a, b, level - 1, clay::childFirst(first, level, place));
  }
}

void ChannelReading::loadBricks(clay::Channel channel) {
  // What lies where no clay is would not be set: it need not be read.
  std::vector<RecordId> ids;
  for (const Wanted& each : wanted_) ids.push_back(each.id);
  std::vector<bool> there(wanted_.size());
  size_t done = 0;
  fetchRecords(source_, ids, [&](size_t index, const RecordView& record) {
    Wanted& want = wanted_[index];
    uint8_t values[clay::kBrickVoxels];
    if (record.header.owner != owner_ || unpackChannelBrick(record, values) != want.coord) return;
    there[index] = true;
    const bool whole = set(channel, want.coord, values);
    exact_ = exact_ && whole;
    const clay::ChannelBrick* brick = editor_.find(channel, want.coord).brick();
    if (whole && brick) serials_[want.id] = brick->serial;
    if (job_ && ++done % 1024 == 0) job_->step(static_cast<double>(done) / static_cast<double>(ids.size()));
  });
  for (size_t i = 0; i < wanted_.size(); ++i) {
    if (there[i]) continue;
    lose("a brick");
    if (editor_.find(channel, wanted_[i].coord) != clay::ChannelSlot())
      editor_.setChannelTile(channel, wanted_[i].coord, false);
  }
  wanted_.clear();
}

// As ClayReading::teach: true when what stands there is what the record says.
bool ChannelReading::teach(clay::Channel channel, RecordId id, const clay::TreePlace& place) {
  const auto key = ClayRecords::keyOf(place, owner_);
  if (!place.isNode()) return false;
  const auto loaded = nodes_.find(id);
  if (loaded == nodes_.end()) return memo_.nodes_.find(key) == id;  // the same as near's
  const NodeBody& node = loaded->second;
  bool same = true;
  for (int i = 0; i < 512; ++i) {
    const clay::TreePlace child = place.child(i);
    if (!holds(node.record, i)) {
      same = same && child.isTile() && (child.tile() == clay::Tile::inside) == holds(node.inside, i);
      continue;
    }
    const RecordId childId = node.ids[rankOf(node.record, i)];
    if (node.level > 1) {
      same = teach(channel, childId, child) && same;
    } else if (const clay::ChannelBrick* brick = child.channelBrick()) {
      const auto serial = serials_.find(childId);
      if (serial != serials_.end() && serial->second == brick->serial) memo_.bricks_.set({brick->serial}, childId);
      same = same && memo_.bricks_.find({brick->serial}) == childId;
    } else {
      same = false;
    }
  }
  if (same) memo_.nodes_.set(key, id);
  return same;
}

clay::Version ChannelReading::run(const ClayHead& head, const ClayHead& nearHead, ReadClay& read) {
  const auto stateOf = [](RecordId id) { return State{id, false}; };
  for (const clay::Channel channel : clay::kAllChannels) {
    const auto index = static_cast<size_t>(channel);
    visit(channel, stateOf(head.channels[index]), stateOf(nearHead.channels[index]), clay::kTreeLevels,
          clay::treeFirst());
    loadBricks(channel);
  }
  clay::Version version = editor_.commit();
  for (const clay::Channel channel : clay::kAllChannels) {
    const RecordId id = head.channels[static_cast<size_t>(channel)];
    if (id != 0) exact_ = teach(channel, id, clay::TreePlace::root(version, channel)) && exact_;
  }
  if (lost_ > 0)
    read.notes.push_back(fmt::format("{} places of colour, material or mask were damaged: they are unset", lost_));
  return version;
}

}  // namespace argil::io
