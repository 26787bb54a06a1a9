#pragma once
// From what is in memory to the record that holds it: a hash table for hundreds of thousands of entries.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/records/record.h"

namespace argil::io {

/// Open addressing in one array. Key: comparable, with `hash()` (64 good bits). Entries are never removed one by one.
template <class Key>
class IdTable {
 public:
  /// The id of a key; 0 when it is not there.
  [[nodiscard]] RecordId find(const Key& key) const {
    if (slots_.empty()) return 0;
    for (size_t at = key.hash() & mask();; at = (at + 1) & mask()) {
      const Slot& slot = slots_[at];
      if (slot.id == 0 || slot.key == key) return slot.id;
    }
  }
  /// Adds or replaces; `id` is not 0.
  void set(const Key& key, RecordId id) {
    if ((size_ + 1) * 8 > slots_.size() * 5) grow();
    size_t at = key.hash() & mask();
    while (slots_[at].id != 0 && !(slots_[at].key == key)) at = (at + 1) & mask();
    size_ += slots_[at].id == 0;
    slots_[at] = {key, id};
  }
  [[nodiscard]] size_t size() const { return size_; }
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (const Slot& slot : slots_)
      if (slot.id != 0) visit(slot.key, slot.id);
  }

 private:
  struct Slot {
    Key key{};
    RecordId id = 0;
  };
  [[nodiscard]] size_t mask() const { return slots_.size() - 1; }
  void grow() {
    std::vector<Slot> old(slots_.empty() ? 1024 : slots_.size() * 2);
    old.swap(slots_);
    size_ = 0;
    for (const Slot& slot : old)
      if (slot.id != 0) set(slot.key, slot.id);
  }

  std::vector<Slot> slots_;  // a power of two of them
  size_t size_ = 0;
};

inline uint64_t mixed(uint64_t word) {
  word *= 0x9e3779b97f4a7c15ull;
  return word ^ (word >> 32);
}

}  // namespace argil::io
