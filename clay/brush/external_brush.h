#pragma once
// A brush whose bricks are computed outside of this module, many at a time: a plugin's.

#include <cstdint>
#include <memory>
#include <span>

#include "clay/brush/brush.h"
#include "clay/field/redistance.h"
#include "clay/kernels/brick.h"

namespace argil::clay {

/// Computes the bricks of one stroke. One thread, but for place().
class BrickWorker {
 public:
  virtual ~BrickWorker() = default;

  /// Bricks that one batch may have.
  [[nodiscard]] virtual size_t most() const = 0;
  /// A batch of so many bricks begins; what it reads of them is written from then on. Throws Error: then the stroke
  /// does nothing any more; so do the calls below.
  virtual void begin(std::span<const Stamp> images, size_t count) = 0;
  /// Where what it reads of a brick of the batch is to be written. Any thread.
  struct Place {
    int32_t* coord;  ///< Three.
    float* phi;      ///< As brickLayout() has it.
    float* weight;   ///< 512.
  };
  [[nodiscard]] virtual Place place(size_t brick) = 0;
  /// So many bricks from the first on are written: it may compute them. From one thread at a time.
  virtual void written(size_t count) noexcept = 0;
  /// Returns when the batch is computed, all of which was written.
  virtual void finish() = 0;
  /// New distances of a brick of the batch that was computed, 512. Nothing of them is believed; they may change while
  /// they are read.
  [[nodiscard]] virtual const float* result(size_t brick) const = 0;
  /// A distance in them is not finite. Throws Error that says whose.
  [[noreturn]] virtual void failResult() = 0;
};

/// What a worker is begun with.
struct WorkerStroke {
  Grid grid;
  float amount = 1;  ///< Of the operation, −1 to 1.
  float perStamp = 1;
  std::span<const float> values;  ///< Brush::values.
  int threads = 1;                ///< That it may use.
};

/// The same for all strokes of such a brush. Any thread.
class ExternalBrush {
 public:
  virtual ~ExternalBrush() = default;
  /// Voxels around a brick that it reads: 0, 1, 2 or 4.
  [[nodiscard]] virtual int margin() const = 0;
  [[nodiscard]] virtual Renew leaves() const = 0;
  /// Throws Error where it cannot work.
  [[nodiscard]] virtual std::unique_ptr<BrickWorker> begin(const WorkerStroke& stroke) const = 0;
};

/// Where the voxels of a brick with a margin lie: voxel (x, y, z) at first + x · plane + y · row + z.
struct BrickLayout {
  int first = 0, row = 0, plane = 0;
  int floats = 0;  ///< Of a brick in all.
};
/// Of margin 0, 1, 2 or 4.
[[nodiscard]] BrickLayout brickLayout(int margin);

}  // namespace argil::clay
