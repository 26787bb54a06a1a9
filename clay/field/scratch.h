#pragma once
// Room for what is solved brick by brick. This module's own.

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace argil::clay {

/// Rooms of a thread, kept from call to call: fresh pages would cost more than what is computed in them.
class Scratch {
 public:
  enum class Room { bricks, rims };
  /// `count` of T, with whatever was there. The next call for the room, for whatever type, takes it.
  template <class T>
  [[nodiscard]] static std::span<T> of(size_t count, Room room) {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_default_constructible_v<T> && alignof(T) <= 16);
    return {reinterpret_cast<T*>(mine(room).of(count * sizeof(T))), count};
  }
  /// Holds the rooms of a thread for one user. Throws std::logic_error while another has them: it would be written
  /// over.
  class Hold {
   public:
    Hold() {
      if (std::exchange(held(), true)) throw std::logic_error("two solvers at once on a thread");
    }
    ~Hold() { held() = false; }
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;
  };
  /// Bytes that this thread keeps.
  [[nodiscard]] static size_t kept() { return mine(Room::bricks).size + mine(Room::rims).size; }

 private:
  // Given back once so many calls in a row asked for a quarter of it at most: one large stroke is over.
  static constexpr int kCallsToShrink = 256;

  struct Kept {
    std::unique_ptr<std::byte[]> bytes;
    size_t size = 0;
    int smallCalls = 0;

    [[nodiscard]] std::byte* of(size_t wanted) {
      smallCalls = wanted <= size / 4 ? smallCalls + 1 : 0;
      if (wanted > size || smallCalls > kCallsToShrink) {
        bytes.reset();
        size = 0;                                 // Until there is some again: there may be no memory.
        const size_t next = wanted + wanted / 8;  // What grows with a stroke does not come anew with each stamp.
        bytes = std::make_unique_for_overwrite<std::byte[]>(next);
        size = next;
        smallCalls = 0;
      }
      return bytes.get();
    }
  };
  static bool& held() {
    static thread_local bool some = false;
    return some;
  }
  static Kept& mine(Room room) {
    static thread_local std::array<Kept, 2> rooms;
    return rooms[static_cast<size_t>(room)];
  }
};

}  // namespace argil::clay
