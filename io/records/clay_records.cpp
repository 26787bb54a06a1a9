#include "io/records/clay_records.h"

#include <algorithm>

#include "clay/base/hash.h"
#include "io/records/brick_codec.h"
#include "io/records/channel_codec.h"
#include "io/records/node_body.h"

namespace argil::io {

struct ClayWriting {
  ClayRecords& memo;
  uint32_t owner;
  RecordSet& held;
  RecordSink& sink;
  RecordCodec codec;
  Job* job;
  double bricksInAll;
  float band;
  BrickCodec packer;
  std::vector<std::byte> bytes;
  uint64_t written = 0;

  RecordId brick(const clay::Brick& brick) {
    RecordId id = memo.bricks_.find({brick.serial});
    if (id != 0 && held.contains(id)) return id;
    if (id == 0) memo.bricks_.set({brick.serial}, id = memo.ids_.take());
    RecordCodec used = codec;
    const std::span<const std::byte> body = packer.pack(brick, band, used);
    sink.put({RecordKind::brick, used, static_cast<uint16_t>(body.size()), owner, id}, body);
    held.add(id);
    if (job && ++written % 256 == 0) job->step(static_cast<double>(written) / bricksInAll);
    return id;
  }

  RecordId brick(const clay::ChannelBrick& brick) {
    RecordId id = memo.bricks_.find({brick.serial});
    if (id != 0 && held.contains(id)) return id;
    if (id == 0) memo.bricks_.set({brick.serial}, id = memo.ids_.take());
    RecordCodec used = codec == RecordCodec::raw ? RecordCodec::raw : RecordCodec::zstd;
    packChannelBrick(brick, used, bytes);
    sink.put({RecordKind::channelBrick, used, static_cast<uint16_t>(bytes.size()), owner, id}, bytes);
    held.add(id);
    if (job && ++written % 256 == 0) job->step(static_cast<double>(written) / bricksInAll);
    return id;
  }

  RecordId version(const clay::Version& version) {
    ClayHead head;
    head.distances = node(clay::TreePlace::root(version), false);
    bool any = false;
    for (const clay::Channel channel : clay::kAllChannels) {
      if (!version.has(channel)) continue;
      head.channels[static_cast<size_t>(channel)] = node(clay::TreePlace::root(version, channel), true);
      any = true;
    }
    if (!any) return head.distances;
    const auto key = ClayRecords::keyOf(version, owner);
    RecordId id = memo.nodes_.find(key);
    if (id != 0 && held.contains(id)) return id;
    if (id == 0) memo.nodes_.set(key, id = memo.ids_.take());
    packClayHead(head, bytes);
    sink.put({RecordKind::clay, RecordCodec::raw, static_cast<uint16_t>(bytes.size()), owner, id}, bytes);
    held.add(id);
    return id;
  }

  RecordId node(const clay::TreePlace& place, bool channel) {
    const auto key = ClayRecords::keyOf(place, owner);
    RecordId id = memo.nodes_.find(key);
    if (id != 0 && held.contains(id)) return id;
    NodeBody body;
    body.level = place.level();
    body.first = place.first();
    for (int i = 0; i < 512; ++i) {
      const clay::TreePlace child = place.child(i);
      if (child.isTile()) {
        if (child.tile() == clay::Tile::inside) add(body.inside, i);
        continue;
      }
      add(body.record, i);
      body.ids.push_back(child.isNode() ? node(child, channel)
                         : channel      ? brick(*child.channelBrick())
                                        : brick(*child.brick()));
    }
    // A sink may let another writer in meanwhile, who may have come to this node first.
    if (id == 0) id = memo.nodes_.find(key);
    if (id == 0) memo.nodes_.set(key, id = memo.ids_.take());
    packNode(body, bytes);
    sink.put({RecordKind::node, RecordCodec::raw, static_cast<uint16_t>(bytes.size()), owner, id}, bytes);
    held.add(id);
    return id;
  }
};

RecordId ClayRecords::write(const clay::Version& version, uint32_t owner, RecordSet& held, RecordSink& sink,
                            RecordCodec codec, Job* job) {
  ClayWriting writing{*this,
                      owner,
                      held,
                      sink,
                      codec,
                      job,
                      static_cast<double>(version.stats().bricks + version.stats().channelBricks),
                      version.grid().band,
                      {},
                      {}};
  return writing.version(version);
}

ClayRecords::NodeKey ClayRecords::keyOf(const clay::Version& version, uint32_t owner) {
  const NodeKey distances = keyOf(clay::TreePlace::root(version), owner);
  if (std::none_of(clay::kAllChannels.begin(), clay::kAllChannels.end(),
                   [&](clay::Channel channel) { return version.has(channel); }))
    return distances;
  clay::Hasher first, second;
  const auto add = [&](const NodeKey& key) {
    first.add(key.node.address);
    first.add(key.node.birth);
    second.add(key.node.birth);
    second.add(~key.node.address);
  };
  add(distances);
  for (const clay::Channel channel : clay::kAllChannels) add(keyOf(clay::TreePlace::root(version, channel), owner));
  return {{first.value() | 3, second.value()}};
}

void ClayRecords::learn(const ClayRecords& other) {
  other.nodes_.forEach([&](const NodeKey& key, RecordId id) { nodes_.set(key, id); });
  other.bricks_.forEach([&](const BrickKey& key, RecordId id) { bricks_.set(key, id); });
}

void ClayRecords::forgetUnused(std::span<const clay::Version> inUse) {
  IdTable<NodeKey> nodes;
  IdTable<BrickKey> bricks;
  const auto keep = [&](const auto& self, const clay::TreePlace& place, bool channel) -> void {
    const NodeKey key = keyOf(place, 0);
    if (nodes.find(key) != 0) return;  // what several versions share is walked once
    if (const RecordId id = nodes_.find(key)) nodes.set(key, id);
    for (int i = 0; i < 512; ++i) {
      const clay::TreePlace child = place.child(i);
      if (child.isNode()) {
        self(self, child, channel);
      } else if (!child.isTile()) {
        const uint64_t serial = channel ? child.channelBrick()->serial : child.brick()->serial;
        if (const RecordId id = bricks_.find({serial})) bricks.set({serial}, id);
      }
    }
  };
  for (const clay::Version& version : inUse) {
    const clay::TreePlace root = clay::TreePlace::root(version);
    if (root.isNode()) keep(keep, root, false);
    for (const clay::Channel channel : clay::kAllChannels)
      if (version.has(channel)) keep(keep, clay::TreePlace::root(version, channel), true);
    // the owner counts for versions of one tile alone, which have no channels
    const NodeKey whole = keyOf(version, 0);
    if (const RecordId id = nodes_.find(whole)) nodes.set(whole, id);
  }
  nodes_.forEach([&](const NodeKey& key, RecordId id) {
    if (key.node.address <= 1) nodes.set(key, id);  // versions of one tile: few, and of no address
  });
  nodes_ = std::move(nodes);
  bricks_ = std::move(bricks);
}

}  // namespace argil::io
