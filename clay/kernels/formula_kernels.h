#pragma once
// Steps of a formula on a brick's voxels; compiled once per SIMD target. Same rules as brush_kernels.h: equal bits on
// every target.

#include <cstdint>

namespace argil::clay {

enum class FormulaStep : uint8_t {
  add,
  subtract,
  multiply,
  divide,
  least,
  most,
  less,       ///< 1 where a < b, else 0.
  lessEqual,  ///< 1 where a ≤ b, else 0.
  choose,     ///< b where a is not 0, else c.
  absolute,
  root,  ///< Of what is below 0: 0.
  floor,
  sine,   ///< Of radians: within 1e-6 up to 50 000.
  noise,  ///< Of a place: smooth, −1 to 1, without a period, its hills about 2 apart; 0.4 RMS.
};
/// How many operands it takes.
[[nodiscard]] constexpr int operandsOf(FormulaStep step) {
  switch (step) {
    case FormulaStep::absolute:
    case FormulaStep::root:
    case FormulaStep::floor:
    case FormulaStep::sine:
      return 1;
    case FormulaStep::choose:
    case FormulaStep::noise:
      return 3;
    default:
      return 2;
  }
}

/// A value a voxel, or one for all.
struct FormulaOperand {
  const float* values = nullptr;
  bool one = false;
};

/// `out`: 512 values, or one where all operands are one; may be an operand's own.
void runFormulaStep(FormulaStep step, const FormulaOperand (&operands)[3], float* out) noexcept;

}  // namespace argil::clay
