#include "io/records/channel_codec.h"

#include <cstring>

#include <zstd.h>

namespace argil::io {

namespace {

constexpr size_t kCoordBytes = 12, kIdBytes = sizeof(RecordId);
constexpr int kZstdLevel = 1;

template <class T>
void append(std::vector<std::byte>& to, const T& value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  to.insert(to.end(), bytes, bytes + sizeof value);
}

RecordId idAt(std::span<const std::byte> body, size_t at) {
  RecordId id;
  std::memcpy(&id, &body[at], kIdBytes);
  return id;
}

}  // namespace

void packClayHead(const ClayHead& head, std::vector<std::byte>& body) {
  body.clear();
  append(body, head.distances);
  for (size_t i = 0; i < head.channels.size(); ++i) {
    if (head.channels[i] == 0) continue;
    body.push_back(static_cast<std::byte>(i));
    append(body, head.channels[i]);
  }
}

std::optional<ClayHead> parseClayHead(const RecordView& record) {
  const std::span<const std::byte> body = record.body;
  if (record.header.kind != RecordKind::clay || record.header.codec != RecordCodec::raw || body.size() < kIdBytes ||
      (body.size() - kIdBytes) % (1 + kIdBytes) != 0)
    return std::nullopt;
  const auto known = [&](RecordId id) { return id != 0 && id < record.header.id; };
  ClayHead head;
  head.distances = idAt(body, 0);
  if (!known(head.distances)) return std::nullopt;
  size_t next = 0;
  for (size_t at = kIdBytes; at < body.size(); at += 1 + kIdBytes) {
    const auto channel = static_cast<size_t>(body[at]);
    const RecordId id = idAt(body, at + 1);
    if (channel < next || channel >= head.channels.size() || !known(id)) return std::nullopt;
    head.channels[channel] = id;
    next = channel + 1;
  }
  return head;
}

void packChannelBrick(const clay::ChannelBrick& brick, RecordCodec& codec, std::vector<std::byte>& body) {
  body.clear();
  const int32_t coord[3] = {brick.coord.x, brick.coord.y, brick.coord.z};
  append(body, coord);
  if (codec != RecordCodec::raw) {
    std::byte packed[clay::kBrickVoxels];
    const size_t size = ZSTD_compress(packed, sizeof packed, brick.value, sizeof brick.value, kZstdLevel);
    if (ZSTD_isError(size) == 0) {
      codec = RecordCodec::zstd;
      body.insert(body.end(), packed, packed + size);
      return;
    }
    codec = RecordCodec::raw;  // it does not get smaller
  }
  append(body, brick.value);
}

std::optional<Coord> unpackChannelBrick(const RecordView& record, std::span<uint8_t, clay::kBrickVoxels> values) {
  const std::span<const std::byte> body = record.body;
  if (record.header.kind != RecordKind::channelBrick || body.size() <= kCoordBytes) return std::nullopt;
  const std::span<const std::byte> rest = body.subspan(kCoordBytes);
  if (record.header.codec == RecordCodec::raw) {
    if (rest.size() != values.size()) return std::nullopt;
    std::memcpy(values.data(), rest.data(), values.size());
  } else if (record.header.codec != RecordCodec::zstd ||
             ZSTD_decompress(values.data(), values.size(), rest.data(), rest.size()) != values.size()) {
    return std::nullopt;
  }
  int32_t coord[3];
  std::memcpy(coord, body.data(), sizeof coord);
  return Coord{coord[0], coord[1], coord[2]};
}

}  // namespace argil::io
