#pragma once
// Any bytes as records with right checksums: what a fuzzer could never guess. A list of orders, a byte each with what
// belongs to it:
//   0 a record: kind, codec, owner, id (2 bytes), length (2), body      1 a blob: its kind, length (2), bytes
//   2 a brick: codec, owner, id (2), coordinate (3), pattern (2)        3 a node: owner, id (2), level, coordinate (3),
//   count, (place (2), id (2))... 4 a brick of a channel: codec, owner, id (2), coordinate (3), pattern  5 a version
//   with channels: owner, id (2), id of its distances (2), count, (channel, id (2))...
// Numbers are little endian, the order is the byte modulo 6; what is cut off ends the list.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "clay/kernels/brick.h"
#include "io/records/blob.h"
#include "io/records/brick_codec.h"
#include "io/records/channel_codec.h"
#include "io/records/node_body.h"
#include "io/records/record.h"

namespace argil::tests {

class ByteInput {
 public:
  ByteInput(const uint8_t* data, size_t size) : bytes_(data, size) {}
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  uint8_t byte() {
    if (bytes_.empty()) return 0;
    const uint8_t first = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return first;
  }
  uint16_t two() {
    const uint8_t low = byte();
    return static_cast<uint16_t>(low | byte() << 8);
  }
  std::span<const std::byte> some(size_t count) {
    const auto taken = std::as_bytes(bytes_.first(std::min(count, bytes_.size())));
    bytes_ = bytes_.subspan(taken.size());
    return taken;
  }
  std::span<const std::byte> rest() { return some(bytes_.size()); }

 private:
  std::span<const uint8_t> bytes_;
};

/// A file of records in memory; of several with one id the last counts.
class RecordList : public io::RecordSink, public io::RecordSource, public io::OlderBricks {
 public:
  void put(const io::RecordHeader& header, std::span<const std::byte> body) override {
    std::vector<std::byte>& record = records_[header.id];
    record.clear();
    io::appendRecord(record, header, body.first(std::min(body.size(), io::kMostRecordBody)));
    all_.insert(all_.end(), record.begin(), record.end());
  }
  bool get(io::RecordId id, std::vector<std::byte>& record) override {
    const auto found = records_.find(id);
    if (found == records_.end()) return false;
    record = found->second;
    return true;
  }
  void getMany(std::span<const io::RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override {
    for (size_t i = 0; i < ids.size(); ++i) {
      const auto found = records_.find(ids[i]);
      if (found != records_.end()) each(i, found->second);
    }
  }
  void bricksIn(uint32_t owner, Coord first, int32_t edge,
                const std::function<void(Coord, io::RecordId)>& each) const override {
    const auto in = [edge](int32_t at, int32_t from) { return at >= from && int64_t{at} < int64_t{from} + edge; };
    for (const auto& [id, bytes] : records_) {
      const auto record = io::parseRecord(bytes);
      if (!record || record->header.kind != io::RecordKind::brick || record->header.owner != owner ||
          record->body.size() < 12)
        continue;
      int32_t at[3];
      std::memcpy(at, record->body.data(), sizeof at);
      if (in(at[0], first.x) && in(at[1], first.y) && in(at[2], first.z)) each({at[0], at[1], at[2]}, id);
    }
  }

  /// In the order in which they were put, one after another: what a journal is.
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return all_; }
  [[nodiscard]] const std::map<io::RecordId, std::vector<std::byte>>& records() const { return records_; }
  [[nodiscard]] io::RecordId highest() const { return records_.empty() ? 0 : records_.rbegin()->first; }

 private:
  std::map<io::RecordId, std::vector<std::byte>> records_;
  std::vector<std::byte> all_;
};

namespace record_input {

inline Coord coordOf(ByteInput& input) {
  const auto part = [&input] { return int32_t{static_cast<int8_t>(input.byte())}; };
  const int32_t x = part(), y = part(), z = part();
  return {x, y, z};
}

inline void putBrick(ByteInput& input, io::RecordSink& sink) {
  auto codec = io::RecordCodec(input.byte() % 2);
  const uint32_t owner = input.byte();
  const io::RecordId id = input.two();
  clay::FloatBrick brick;
  brick.coord = coordOf(input);
  const uint16_t pattern = input.two();
  // A plane through the brick, or noise within the band.
  for (size_t i = 0; i < clay::kBrickVoxels; ++i) {
    const auto along = double(pattern & 1 ? i / 64 : pattern & 2 ? i / 8 % 8 : i % 8);
    const double noise = pattern & 4 ? double((i * 2654435761u >> 7) % 100) / 50 : 0;
    brick.value[i] = static_cast<float>(std::clamp(along - double(pattern >> 3 & 7) + noise, -3.0, 3.0));
  }
  static io::BrickCodec packer;
  const auto body = packer.pack(brick, 3.0f, codec);
  sink.put({io::RecordKind::brick, codec, 0, owner, id}, body);
}

inline void putNode(ByteInput& input, io::RecordSink& sink) {
  const uint32_t owner = input.byte();
  const io::RecordId id = input.two();
  io::NodeBody node;
  node.level = input.byte() % 8;
  const Coord first = coordOf(input);
  // Where nodes of a tree may be: a coordinate of 0 is the one that holds brick 0.
  int32_t edge = 1, from = 0;
  for (int level = 0; level < node.level; ++level) {
    if (level > 0) from -= 4 * edge;
    edge *= 8;
  }
  node.first = {from + first.x * edge, from + first.y * edge, from + first.z * edge};
  std::map<int, io::RecordId> children;
  for (int count = input.byte(); count > 0 && !input.empty(); --count) {
    const uint16_t place = input.two();
    const io::RecordId child = input.two();
    if (child == 0)
      io::add(node.inside, place % 512);
    else
      children[place % 512] = child;
  }
  for (const auto& [place, child] : children) {
    node.inside[size_t(place) / 64] &= ~(uint64_t{1} << (place % 64));
    io::add(node.record, place);
    node.ids.push_back(child);
  }
  std::vector<std::byte> body;
  io::packNode(node, body);
  sink.put({io::RecordKind::node, io::RecordCodec::raw, 0, owner, id}, body);
}

inline void putChannelBrick(ByteInput& input, io::RecordSink& sink) {
  auto codec = io::RecordCodec(input.byte() % 2);
  const uint32_t owner = input.byte();
  const io::RecordId id = input.two();
  clay::ChannelBrick brick;
  brick.coord = coordOf(input);
  const uint8_t pattern = input.byte();
  for (size_t i = 0; i < clay::kBrickVoxels; ++i)
    brick.value[i] = pattern & 1 ? static_cast<uint8_t>(i * pattern >> 3) : pattern;
  std::vector<std::byte> body;
  io::packChannelBrick(brick, codec, body);
  sink.put({io::RecordKind::channelBrick, codec, 0, owner, id}, body);
}

inline void putClayHead(ByteInput& input, io::RecordSink& sink) {
  const uint32_t owner = input.byte();
  const io::RecordId id = input.two();
  io::ClayHead head;
  head.distances = input.two();
  for (int count = input.byte() % 16; count > 0 && !input.empty(); --count) {
    io::RecordId& channel = head.channels[input.byte() % head.channels.size()];
    channel = input.two();
  }
  std::vector<std::byte> body;
  io::packClayHead(head, body);
  sink.put({io::RecordKind::clay, io::RecordCodec::raw, 0, owner, id}, body);
}

}  // namespace record_input

inline RecordList recordsOf(ByteInput& input) {
  RecordList list;
  while (!input.empty()) {
    switch (input.byte() % 6) {
      case 0: {
        io::RecordHeader header;
        header.kind = io::RecordKind(input.byte());
        header.codec = io::RecordCodec(input.byte());
        header.owner = input.byte();
        header.id = input.two();
        list.put(header, input.some(input.two()));
        break;
      }
      case 1: {
        const auto kind = io::BlobKind(input.byte());
        io::RecordIds ids(list.highest() + 1);
        io::RecordSet held;
        const size_t length = input.two();
        io::putBlob(kind, input.some(length), ids, held, list);
        break;
      }
      case 2:
        record_input::putBrick(input, list);
        break;
      case 4:
        record_input::putChannelBrick(input, list);
        break;
      case 5:
        record_input::putClayHead(input, list);
        break;
      default:
        record_input::putNode(input, list);
    }
  }
  return list;
}

}  // namespace argil::tests
