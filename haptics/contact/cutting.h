#pragma once
// How clay yields to a ball that cuts: predicted in the servo, ahead of the edit.

#include <array>
#include <cstdint>
#include <span>

#include "haptics/base/realtime.h"
#include "haptics/scene/scene.h"
#include "haptics/scene/touchable.h"

namespace argil::haptics {

/// Projected area of a ball's cap of height h, mm²: 2πrh − πh², at most that of a half buried ball.
[[nodiscard]] double engagedArea(double radiusMm, double heightMm) noexcept;
/// The height at which hardness · area balances a force: where a constant force rests. At most the radius.
[[nodiscard]] double restingDepth(double radiusMm, double hardnessNmm2, double forceN) noexcept;

/// Visco-plastic yielding of the clay that a ball touches. The ball's centre follows the hand so that
///   viscosity · velocity = spring force − hardness · (area of the touched clay that the velocity presses on),
/// which for a straight push is ḣ = max(0, f − σ A(h)) / η. Which clay is touched is measured just
/// beyond the ball, in the published version less what this stroke has cut since: the answer is the same before and
/// after an edit arrives. Model, trap and tolerances: cutting.md. One thread.
class CutLaw {
 public:
  struct Result {
    Vec3d centre = Vec3d::Zero();  ///< Of the cutting ball, world mm.
    double depthMm = 0;            ///< Engaged depth h.
    double areaMm2 = 0;            ///< Engaged projected area.
    bool engaged = false;
  };
  struct Input {
    Vec3d centre, hand;       ///< World mm.
    double stiffnessNmm = 1;  ///< Of the spring between them.
    double radiusMm = 1;
    double periodS = 1e-3;
    bool frozen = false;  ///< The tool no longer cuts: clay that it touches does not yield at all.
  };

  void reset() noexcept;
  /// Where the ball is a period later.
  Result advance(std::span<TouchableClay> pieces, const Scene& scene, const Input& input) ARGIL_REALTIME;

  /// The sample `index` cuts with a ball at `centre`.
  void remember(const Vec3d& centre, double radiusMm, uint64_t index) ARGIL_REALTIME;
  /// Samples below `applied` are in the published clay.
  void forget(uint64_t applied) ARGIL_REALTIME;
  /// Cuts that are not in the published clay yet.
  [[nodiscard]] bool pending() const noexcept { return count_ > 0; }

 private:
  static constexpr int kZones = 24;  // Parts of that half in which loads are summed.
  static constexpr int kHistory = 24;

  struct Cut {
    Vec3d centre;
    double radius;
    uint64_t first, last;  // Samples whose balls it stands for.
  };
  struct Patch {  // Touched clay: unit directions from the centre and the force that each can bear, N.
    std::array<double, kZones> x, y, z, load;
    int count = 0;
    double areaMm2 = 0, depthMm = 0, viscosity = 0, drag = 0;
  };
  struct Feel {  // Of the clay that is cut, where its materials differ: means over what is touched of its band.
    double hardness = 0, viscosity = 0, drag = 0;
    double weight = 0;  // Zero: not known.
  };

  void measure(std::span<TouchableClay> pieces, const Scene& scene, const Vec3d& centre, double radiusMm,
               const Vec3d& axis, bool frozen) ARGIL_REALTIME;
  Vec3d yield(const Vec3d& force, double resistance, const Vec3d& guess) const ARGIL_REALTIME;

  Patch patch_;
  std::array<Vec3d, kZones> loads_;
  std::array<Cut, kHistory> cuts_;
  // The last that was known: deep in the clay, ahead of the edit, no voxel has a material.
  std::array<Feel, kMaxPieces> feel_{};
  int first_ = 0, count_ = 0;
  Vec3d axis_ = -Vec3d::UnitZ();
  Vec3d velocity_ = Vec3d::Zero();  // Of the last yielding: where the next search begins.
};

}  // namespace argil::haptics
