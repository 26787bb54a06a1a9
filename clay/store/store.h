#pragma once
// Memory of versions: slabs, and what happens when a version is dropped.

#include <cstdint>
#include <memory>

#include "clay/store/version.h"

namespace argil::clay {

/// Bricks of a voxel² of surface, mean over its directions.
inline constexpr double kBricksOfArea = 0.0325;
/// About what clay with a surface of `area` voxels² in a band of `band` takes together with the surface that shows it.
/// `slant`: mean over the area of |x| + |y| + |z| of its normal, 1 along the axes, 1.5 all around.
[[nodiscard]] double bytesOfClay(double area, Precision precision, double band = 3, double slant = 1.5);

/// Owns the bricks and nodes of any number of versions. Create with make(); versions keep it alive.
class Store : public std::enable_shared_from_this<Store> {
 public:
  static std::shared_ptr<Store> make(Precision precision = Precision::float32);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  /// Frees what dropped versions alone used, about `maxObjects` bricks and nodes at most, and keeps touched memory in
  /// stock (an eighth of what the store has) for a model that is edited, so that no editor waits for the system's
  /// pages; true when more waits. Any thread but the servo's, beside the editor: a session calls it in the background.
  /// Never a stall: cost follows maxObjects.
  bool collect(size_t maxObjects = 4096);
  /// Something was dropped, or stock runs low, since collect() last looked: a call would find work. Any thread; one
  /// load.
  [[nodiscard]] bool wantsCollecting() const noexcept;

  [[nodiscard]] Precision precision() const;  ///< Of all its bricks.

  struct Usage {
    uint64_t bricks = 0, nodes = 0, channelBricks = 0;  ///< Live or waiting to be collected.
    uint64_t slabBytes = 0;                             ///< Taken from the system,
    uint64_t heapBytes = 0;                             ///< so much of it from the heap: small stores.
    uint64_t versions = 0;                              ///< Pinned or waiting.
    Precision precision = Precision::float32;
    [[nodiscard]] uint64_t bytes() const;
  };
  [[nodiscard]] Usage usage() const;  ///< What editors at work have in stock is counted too. Any thread.

  struct State;
  [[nodiscard]] State& state() const { return *state_; }  ///< For this module's files (clay/store/tree.h).

 private:
  explicit Store(Precision precision);
  std::unique_ptr<State> state_;
};

}  // namespace argil::clay
