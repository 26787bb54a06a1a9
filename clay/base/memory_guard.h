#pragma once
// Refuses memory before the system has none left: Linux grants what it does not have, and then kills who uses it.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

namespace argil {

/// What the system says of memory, in bytes; nothing where it does not say.
struct MemoryRoom {
  std::optional<uint64_t> total, available;
};

/// Of the machine ("MemTotal", "MemAvailable"), and of the control groups that this process is in where they allow less
/// (memory.max less memory.current, of which files that can be read again do not count). Swap does not count: a hand
/// cannot wait for it. `root`: "/" but for tests.
[[nodiscard]] MemoryRoom memoryRoom(const std::filesystem::path& root = "/");

/// Counts what is taken in large pieces. Any thread; an atomic a call, a look at the system (about 50 µs) each 64 MiB.
class MemoryGuard {
 public:
  using Source = std::function<MemoryRoom()>;
  explicit MemoryGuard(Source source) : source_(std::move(source)) {}

  /// Throws std::bad_alloc where this would leave the system less than its reserve, a 32nd of its memory and 256 MiB at
  /// least: enough to save what there is.
  void claim(size_t bytes);
  /// Bytes that could be claimed now; nothing where the system does not say.
  [[nodiscard]] std::optional<uint64_t> free() const;
  static constexpr uint64_t kLeastReserve = uint64_t{256} << 20;

 private:
  Source source_;
  std::atomic<int64_t> credit_{0};  // that may be taken before the next look
};

/// The process's. Slabs of clay and surfaces claim what they take, and so does what needs much at once.
void claimMemory(size_t bytes);

/// Of what is about to need so much: throws Error that says so, where claiming it would be refused. Claims
/// nothing. `what`: "a ball of 40 mm at voxels of 0.01 mm"; `instead`: "use a larger voxel".
void requireMemory(double bytes, std::string_view what, std::string_view instead);

/// While it stands the process's guard believes `source`. Tests.
class PretendedMemory {
 public:
  explicit PretendedMemory(MemoryGuard::Source source);
  ~PretendedMemory();
  PretendedMemory(const PretendedMemory&) = delete;
  PretendedMemory& operator=(const PretendedMemory&) = delete;

 private:
  MemoryGuard guard_;
};

}  // namespace argil
