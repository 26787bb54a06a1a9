#include "io/records/record.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstring>

namespace argil::io {

namespace {

static_assert(std::endian::native == std::endian::little, "swap the header's bytes here for a big-endian machine");

// As in other formats that must survive being scanned: not text, and not what zeros, floats or packed data look like.
constexpr std::array<unsigned char, 8> kMagic{0x8a, 'A', 'r', 'g', 'R', 0x0d, 0x1a, 0xe3};

struct Packed {
  unsigned char magic[8];
  uint8_t kind, codec;
  uint16_t bodyBytes;
  uint32_t owner;
  uint64_t id;
  uint64_t reserved;
  uint64_t checksum;
};
static_assert(sizeof(Packed) == kRecordHeaderBytes);

uint64_t checksumOf(const Packed& header, std::span<const std::byte> body) {
  const uint64_t head = XXH3_64bits(&header, offsetof(Packed, checksum));
  return XXH3_64bits_withSeed(body.data(), body.size(), head);
}

}  // namespace

void appendRecord(std::vector<std::byte>& to, const RecordHeader& header, std::span<const std::byte> body) {
  assert(body.size() <= kMostRecordBody);
  Packed packed{};
  std::memcpy(packed.magic, kMagic.data(), sizeof packed.magic);
  packed.kind = static_cast<uint8_t>(header.kind);
  packed.codec = static_cast<uint8_t>(header.codec);
  packed.bodyBytes = static_cast<uint16_t>(body.size());
  packed.owner = header.owner;
  packed.id = header.id;
  packed.checksum = checksumOf(packed, body);
  const auto* bytes = reinterpret_cast<const std::byte*>(&packed);
  to.insert(to.end(), bytes, bytes + sizeof packed);
  to.insert(to.end(), body.begin(), body.end());
}

std::optional<RecordView> parseRecord(std::span<const std::byte> bytes) {
  if (bytes.size() < kRecordHeaderBytes || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return std::nullopt;
  Packed packed;
  std::memcpy(&packed, bytes.data(), sizeof packed);
  if (packed.bodyBytes > kMostRecordBody || packed.bodyBytes > bytes.size() - kRecordHeaderBytes) return std::nullopt;
  const auto body = bytes.subspan(kRecordHeaderBytes, packed.bodyBytes);
  if (checksumOf(packed, body) != packed.checksum) return std::nullopt;
  RecordView view;
  view.header = {static_cast<RecordKind>(packed.kind), static_cast<RecordCodec>(packed.codec), packed.bodyBytes,
                 packed.owner, packed.id};
  view.body = body;
  view.whole = bytes.first(kRecordHeaderBytes + packed.bodyBytes);
  return view;
}

size_t findRecord(std::span<const std::byte> bytes, size_t from) {
  while (from + kRecordHeaderBytes <= bytes.size()) {
    const void* at = memmem(bytes.data() + from, bytes.size() - from, kMagic.data(), kMagic.size());
    if (at == nullptr) break;
    from = static_cast<size_t>(static_cast<const std::byte*>(at) - bytes.data());
    if (parseRecord(bytes.subspan(from))) return from;
    ++from;
  }
  return bytes.size();
}

}  // namespace argil::io
