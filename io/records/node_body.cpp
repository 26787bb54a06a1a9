#include "io/records/node_body.h"

#include <cstring>

#include "clay/store/version.h"

namespace argil::io {

namespace {

constexpr size_t kFixedBytes = 1 + 12 + 2 * sizeof(PlaceSet);
static_assert(kFixedBytes + 512 * 10 <= kMostRecordBody);

void appendBytes(std::vector<std::byte>& to, const void* data, size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  to.insert(to.end(), bytes, bytes + size);
}

}  // namespace

void packNode(const NodeBody& node, std::vector<std::byte>& body) {
  body.clear();
  body.push_back(static_cast<std::byte>(node.level));
  const int32_t first[3] = {node.first.x, node.first.y, node.first.z};
  appendBytes(body, first, sizeof first);
  appendBytes(body, node.inside.data(), sizeof(PlaceSet));
  appendBytes(body, node.record.data(), sizeof(PlaceSet));
  RecordId before = 0;
  for (const RecordId id : node.ids) {
    const auto step = static_cast<int64_t>(id - before);
    before = id;
    // small for steps of both signs
    auto left = (static_cast<uint64_t>(step) << 1) ^ static_cast<uint64_t>(step >> 63);
    for (; left >= 128; left >>= 7) body.push_back(static_cast<std::byte>(left | 128));
    body.push_back(static_cast<std::byte>(left));
  }
}

std::optional<NodeBody> parseNode(const RecordView& record) {
  const std::span<const std::byte> body = record.body;
  if (record.header.kind != RecordKind::node || record.header.codec != RecordCodec::raw || body.size() < kFixedBytes)
    return std::nullopt;
  NodeBody node;
  node.level = static_cast<int>(body[0]);
  if (node.level < 1 || node.level > clay::kTreeLevels) return std::nullopt;
  int32_t first[3];
  std::memcpy(first, &body[1], sizeof first);
  node.first = {first[0], first[1], first[2]};
  std::memcpy(node.inside.data(), &body[13], sizeof(PlaceSet));
  std::memcpy(node.record.data(), &body[13 + sizeof(PlaceSet)], sizeof(PlaceSet));
  size_t count = 0;
  for (size_t word = 0; word < 8; ++word) {
    if (node.inside[word] & node.record[word]) return std::nullopt;
    count += static_cast<size_t>(std::popcount(node.record[word]));
  }
  if (body.size() - kFixedBytes < count) return std::nullopt;
  node.ids.resize(count);
  size_t at = kFixedBytes;
  RecordId before = 0;
  for (RecordId& id : node.ids) {
    uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      if (at == body.size() || shift > 63) return std::nullopt;
      const auto byte = static_cast<uint64_t>(body[at++]);
      value |= (byte & 127) << shift;
      if (byte < 128) break;
    }
    id = before + ((value >> 1) ^ (~(value & 1) + 1));
    if (id == 0 || id >= record.header.id) return std::nullopt;
    before = id;
  }
  if (at != body.size()) return std::nullopt;
  return node;
}

}  // namespace argil::io
