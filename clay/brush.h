#pragma once
// Stamps on clay: what a stroke does to a version.

#include <cstdint>
#include <memory>

#include "clay/editor.h"

namespace argil::clay {

enum class Operation : uint8_t { carve, add, smooth };

/// A ball swept from a to b. Equal stamps on equal versions give equal bits on every CPU, whatever was published between.
struct Stamp {
  Vec3d a = Vec3d::Zero();  ///< Voxel coordinates.
  Vec3d b = Vec3d::Zero();  ///< Voxel coordinates; equal to a for a single dab.
  double radius = 1;        ///< Voxels, 0.5 to 4096.
  Operation operation = Operation::carve;
  float strength = 1;       ///< Smooth only: 0 to 1.
};

/// The stamps of one stroke, applied to a version one after the other, with redistancing that trails the tool by a fixed
/// count of stamps: the result depends on the sequence of stamps alone. One thread.
class BrushStroke {
 public:
  explicit BrushStroke(Version base);
  ~BrushStroke();

  /// Applies one stamp. Throws Error for a stamp that is not finite or out of range; then nothing changed.
  void apply(const Stamp& stamp);
  /// A version of all that was applied so far. Cheap: path copies only.
  [[nodiscard]] Version publish();
  /// Redistances what still trails; the version that the stroke leaves. The stroke is over.
  [[nodiscard]] Version finish();

  /// Bricks and nodes made so far.
  [[nodiscard]] Editor::Counts counts() const;
  /// Bricks that stamps computed or turned into tiles so far, changed or not: what an edit's cost follows.
  [[nodiscard]] uint64_t touched() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::clay
