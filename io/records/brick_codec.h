#pragma once
// A brick of clay as a record's body, to the bit.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "clay/kernels/brick.h"
#include "io/records/record.h"

namespace argil::io {

/// Packs and unpacks bricks. Body: brick coordinate (3 × 4 bytes), then the 512 distances in Brick's order: raw (4
/// bytes each) or predicted (clay_records.md, "Bricks"); of a fixed brick its codes, raw (2 bytes each) or predicted.
/// One a thread.
class BrickCodec {
 public:
  BrickCodec();

  /// The body, valid until the next call. `codec`: raw where time counts (0.1 µs); anything else is packed, as
  /// predicted or, where that gains nothing, raw: what was used comes back, raw16 or predicted16 for a fixed brick. The
  /// brick is a version's: its distances are clamped to ±band.
  std::span<const std::byte> pack(const clay::Brick& brick, float band, RecordCodec& codec);

  /// The coordinate; distances and inside of `brick` are filled, its other members left alone: its step says which form
  /// it has. Nothing when the record is no brick of that form, or none that a version of this band can hold: wrong kind
  /// or length, NaN, |phi| > band, -0, no |phi| < band. Any bytes are allowed.
  [[nodiscard]] std::optional<Coord> unpack(const RecordView& record, float band, clay::Brick& brick);

 private:
  std::vector<std::byte> work_;
};

}  // namespace argil::io
