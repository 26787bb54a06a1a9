#pragma once
// What is near the hand, as somebody beside the servo says it: a few planes and springs, renewed as often as they can.

#include <array>
#include <cstdint>

#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// World millimetres.
struct LocalModel {
  static constexpr int kMost = 8;
  struct Element {
    enum class Kind : uint8_t {
      plane,   ///< Pushes out along `normal` where the hand is behind the plane through `place`.
      spring,  ///< Draws to `place`, within `rangeMm` of it.
    };
    Kind kind = Kind::plane;
    Vec3d place = Vec3d::Zero(), normal = Vec3d::UnitZ();
    double stiffnessNmm = 0.1;
    double rangeMm = 5;
  };
  std::array<Element, kMost> elements{};
  int count = 0;
  Vec3d middle = Vec3d::Zero();  ///< It holds within `radiusMm` of here; elsewhere nothing is felt.
  double radiusMm = 0;
};

/// Where such models come from. The servo asks in each tick, and nobody else.
class LocalModelSource {
 public:
  virtual ~LocalModelSource() = default;
  /// The newest model, checked: finite, normals of unit length, ranges above 0. False when there is none newer than the
  /// last; then `model` stays as it was. Never waits.
  virtual bool newest(LocalModel& model) ARGIL_REALTIME = 0;
  /// Where the hand is.
  virtual void tell(const Vec3d& hand, const Vec3d& velocity, uint32_t buttons) ARGIL_REALTIME = 0;
};

/// Without a newer model for so long a model fades, and is gone after so long again.
inline constexpr double kModelHoldsS = 0.02, kModelFadesS = 0.05;

}  // namespace argil::haptics
