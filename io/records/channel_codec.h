#pragma once
// Channels of clay as records' bodies. For this module's files alone.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "clay/kernels/channel.h"
#include "io/records/record.h"

namespace argil::io {

/// A version with channels. Body: id of the root of its distances (8 bytes), then for each channel that it has its
/// number (1 byte) and its root (8), numbers rising. Roots of channels are records of kind node, where `inside` means
/// 255.
struct ClayHead {
  RecordId distances = 0;
  std::array<RecordId, clay::kChannels> channels{};  ///< 0: the version has none.
};
void packClayHead(const ClayHead& head, std::vector<std::byte>& body);
/// Nothing when it is none: wrong kind or length, a channel unknown or out of order, an id that is 0 or not below the
/// record's own. Any bytes are allowed.
[[nodiscard]] std::optional<ClayHead> parseClayHead(const RecordView& record);

/// Body: brick coordinate (3 × 4 bytes), then the 512 bytes in Brick's order, as they are or by Zstandard. `codec`: raw
/// where time counts; what was used comes back.
void packChannelBrick(const clay::ChannelBrick& brick, RecordCodec& codec, std::vector<std::byte>& body);
/// The coordinate; nothing when the record is no such brick. Any bytes are allowed.
[[nodiscard]] std::optional<Coord> unpackChannelBrick(const RecordView& record,
                                                      std::span<uint8_t, clay::kBrickVoxels> values);

}  // namespace argil::io
