#pragma once
// A node of a version's tree as a record's body.

#include <array>
#include <bit>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "clay/base/vec.h"
#include "io/records/record.h"

namespace argil::io {

/// One bit for each of a node's 512 places (bit i % 64 of word i / 64).
using PlaceSet = std::array<uint64_t, 8>;

[[nodiscard]] inline bool holds(const PlaceSet& set, int place) {
  return (set[static_cast<size_t>(place >> 6)] >> (place & 63)) & 1u;
}
inline void add(PlaceSet& set, int place) {
  set[static_cast<size_t>(place >> 6)] |= uint64_t{1} << (place & 63);
}
template <class Visit>
void forEachPlace(const PlaceSet& set, const Visit& visit) {
  for (int word = 0; word < 8; ++word)
    for (uint64_t left = set[static_cast<size_t>(word)]; left != 0; left &= left - 1)
      visit(word * 64 + std::countr_zero(left));
}

/// What stands at each of 512 places: a record, else inside, else outside. Nodes of level 1 have bricks as records,
/// others nodes.
struct NodeBody {
  int level = 0;
  Coord first;                  ///< Its first brick coordinate.
  PlaceSet inside{}, record{};  ///< Never both.
  std::vector<RecordId> ids;    ///< Of the places in `record`, in their order.
};

/// Body: level (1 byte), first coordinate (3 × 4), both sets (64 each), ids as differences from one to the next in 7
/// bits a byte. It always fits in a record.
void packNode(const NodeBody& node, std::vector<std::byte>& body);

/// The node in a record; nothing when it is none: wrong kind or length, a level out of range, a set that contradicts
/// the other, an id that is 0 or not below the record's own (what a record refers to is older than it). Any bytes are
/// allowed.
[[nodiscard]] std::optional<NodeBody> parseNode(const RecordView& record);

}  // namespace argil::io
