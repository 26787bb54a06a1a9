#pragma once
// A brick of clay as a record's body, to the bit.

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "clay/brick.h"
#include "io/record.h"

namespace argil::io {

/// Packs and unpacks bricks. Body: brick coordinate (3 × 4 bytes), then the 512 distances in Brick's order, raw (4 bytes each) or packed (NOTES.md, "Bricks").
/// Holds what packing needs again and again: one a thread.
class BrickCodec {
 public:
  BrickCodec();
  ~BrickCodec();
  BrickCodec(const BrickCodec&) = delete;
  BrickCodec& operator=(const BrickCodec&) = delete;

  /// The body, valid until the next call. `codec` may come back as raw where packing gains nothing. The distances are a version's: clamped to ±band.
  std::span<const std::byte> pack(const clay::Brick& brick, RecordCodec& codec);

  /// The coordinate; phi and inside are filled. Nothing when the record is no brick or not one that a version of this band can hold: wrong kind or length, NaN, |phi| > band, -0, no |phi| < band.
  /// Any bytes are allowed. serial, birth, coord and the two flags of `brick` are left alone.
  [[nodiscard]] std::optional<Coord> unpack(const RecordView& record, float band, clay::Brick& brick);

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::vector<std::byte> body_;
};

}  // namespace argil::io
