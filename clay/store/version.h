#pragma once
// A clay model at one moment: an immutable sparse narrow-band signed distance field.

#include <cstdint>
#include <functional>
#include <memory>

#include "clay/kernels/brick.h"
#include "clay/kernels/channel.h"
#include "clay/kernels/grid.h"

namespace argil::clay {

class Store;
struct Node;
struct VersionRecord;

/// Nodes of 8×8×8 children between a version and its bricks, whatever its size.
inline constexpr int kTreeLevels = 5;
/// Brick coordinates lie in [-kBrickReach, kBrickReach): 112 000 voxels on each side of the grid's origin.
inline constexpr int kBrickReach = 14000;

struct VersionStats {
  uint64_t bricks = 0;
  uint64_t nodes = 0;
  uint64_t channelBricks = 0;
  Precision precision = Precision::float32;
  /// Bricks of all kinds and nodes; what versions share is counted in each of them.
  [[nodiscard]] uint64_t bytes() const;
};

/// Handle to a version: copying it pins the version, dropping the last handle hands what only that version used to
/// Store::collect. Invariants (see NOTES.md): canonical (a brick exists exactly where some |phi| < band, equal content
/// has equal bits); an inside tile never touches an outside one, as distances to a surface cannot jump; never changes.
/// Handles may be copied and dropped on any thread but the servo's; reading through a handle that somebody else holds
/// is allowed everywhere, wait-free.
class Version {
 public:
  Version() = default;
  /// All outside. Throws Error for a bad grid.
  static Version empty(std::shared_ptr<Store> store, const Grid& grid);

  explicit operator bool() const { return record_ != nullptr; }
  friend bool operator==(const Version&, const Version&) = default;

  [[nodiscard]] const Grid& grid() const;
  [[nodiscard]] uint64_t id() const;  ///< Unique in the process, increasing from a version to those made from it.
  [[nodiscard]] const std::shared_ptr<Store>& store() const;
  [[nodiscard]] VersionStats stats() const;  ///< O(1).

  /// What stands at a brick coordinate; outside of the reach: Tile::outside. Five dependent loads, noexcept,
  /// servo-safe.
  [[nodiscard]] Slot find(Coord brick) const noexcept;

  /// The same of a channel; where nothing was ever set, 0.
  [[nodiscard]] ChannelSlot find(Channel channel, Coord brick) const noexcept;
  /// Whether something was set in it anywhere.
  [[nodiscard]] bool has(Channel channel) const noexcept;

  /// Calls back with every brick, in order of the tree (deterministic). O(model).
  void forEachBrick(const std::function<void(const Brick&)>& visit) const;

  /// Calls back with each brick coordinate where the two versions differ in a brick: (coordinate, what a has, what b
  /// has), at least one of them a brick. Cost follows the difference, not the model. Both must be of one store.
  static void forEachDifference(const Version& a, const Version& b,
                                const std::function<void(Coord, Slot, Slot)>& visit);

  void forEachBrick(Channel channel, const std::function<void(const ChannelBrick&)>& visit) const;
  static void forEachDifference(Channel channel, const Version& a, const Version& b,
                                const std::function<void(Coord, ChannelSlot, ChannelSlot)>& visit);

  /// 64-bit hash of grid, coordinates, voxels and channels: equal for equal content, whatever path led there. O(model).
  [[nodiscard]] uint64_t hash() const;

  /// Count of voxels with |phi| < band. O(model).
  [[nodiscard]] uint64_t activeVoxels() const;

  [[nodiscard]] const VersionRecord* record() const noexcept { return record_.get(); }
  explicit Version(std::shared_ptr<const VersionRecord> record) : record_(std::move(record)) {}

 private:
  std::shared_ptr<const VersionRecord> record_;
};

}  // namespace argil::clay
