#pragma once
// Arithmetic that a user wrote, run on a brick's voxels: what a formula brush does to distances.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clay/kernels/brick.h"
#include "clay/kernels/formula_kernels.h"

namespace argil::clay {

/// What a formula may read of a voxel, and of the stamp. Lengths in mm.
enum class FormulaInput : uint8_t {
  phi,     ///< Distance from the surface, below zero inside.
  mean,    ///< Of phi over the 27 voxels around, near ones more.
  weight,  ///< Of the tip: 1 in its middle at full strength, 0 at its rim.
  x,
  y,
  z,  ///< Of the piece.
  u,
  v,
  w,  ///< From the nearest place of the tip's path along its axes, in radii.
  r,  ///< From the tip's path, in radii.
  nx,
  ny,
  nz,      ///< Outward normal of the surface.
  radius,  ///< One for all from here on.
  strength,
  voxel,
};
inline constexpr size_t kFormulaInputs = 16;
struct FormulaName {
  std::string_view name, help;
};
/// In the order of FormulaInput.
[[nodiscard]] std::span<const FormulaName, kFormulaInputs> formulaInputs();
[[nodiscard]] std::span<const FormulaName> formulaFunctions();

/// A text such as "phi - height * weight * (sin(x * 6.28 / pitch) + 1) / 2", compiled: numbers, + − * /, comparisons (1
/// or 0), "a ? b : c", functions, names given before ("a = …; b = …; …"), inputs, parameters. The last of its
/// statements is what it gives. It cannot loop, read or write anything else. Equal bits on every CPU. Immutable.
class Formula {
 public:
  /// Throws Error that names the place: a text that is too long or deep, a name that is not known, or hides one that
  /// is.
  Formula(std::string text, std::span<const std::string> parameters);

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool reads(FormulaInput input) const { return ((reads_ >> static_cast<int>(input)) & 1) != 0; }
  /// How many parameters it was compiled with.
  [[nodiscard]] size_t parameters() const { return parameters_; }
  /// Steps that are run for each block of voxels.
  [[nodiscard]] size_t steps() const { return steps_.size(); }

  /// 512 values, by what is in `inputs` (those that it reads) and the parameters' values. Any thread; about 30 ns a
  /// step (AVX2).
  void run(std::span<const FormulaOperand, kFormulaInputs> inputs, std::span<const float> parameters,
           float (&out)[kBrickVoxels]) const;

  static constexpr size_t kMostText = 4000, kMostSteps = 256, kMostDepth = 64, kMostParameters = 8;

 private:
  friend class FormulaCompiler;
  // Places: inputs, then parameters, then constants, then registers.
  struct Step {
    FormulaStep step;
    std::array<uint16_t, 3> from;
    uint16_t to;
  };

  std::string text_;
  size_t parameters_ = 0;
  uint32_t reads_ = 0;
  std::vector<float> constants_;
  std::vector<Step> steps_;
  uint16_t result_ = 0;     // its place
  uint16_t registers_ = 0;  // how many
};

}  // namespace argil::clay
