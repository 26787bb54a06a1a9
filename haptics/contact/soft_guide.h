#pragma once
// Wells and ambient forces: what one guide pulls at a place.

#include "haptics/scene/guide.h"
#include "haptics/scene/local_model.h"
#include "haptics/scene/polyline.h"
#include "haptics/scene/touchable.h"

namespace argil::haptics {

/// Catches at this part of a well's range.
inline constexpr double kCatchFraction = 0.7;

/// What the device allows, in the world: the shares that soft guides may take of it.
struct SoftLimits {
  double forceN = 1;  ///< Of one guide.
  double stiffnessNmm = 1;
  double dragNsmm = 0;
  double periodS = 0.001;  ///< Since the last tick.
};

struct Pull {
  Vec3d force = Vec3d::Zero();  ///< N.
  double mostN = 0;             ///< The guide's largest force, within the limits.
  /// The force changes by no more in a millimetre of smooth way; infinite where it does not follow the place.
  double stiffnessNmm = 0;
  bool within = true;  ///< In a well's range,
  bool caught = true;  ///< and in that where it catches.
};

/// The well's law for a vector to its centre: −grad of −D (1 − (|d|/R)²)³, D = 0.582 · force · range. Linear in the
/// middle, smooth at the rim; steepest in the middle: 3.49 force / range.
[[nodiscard]] Pull wellPull(const Vec3d& toCentre, const WellShape& shape, const SoftLimits& limits) ARGIL_REALTIME;
/// Energy in the middle of a well as wide as `shape` and of `forceN`, N·mm: all that it can give out.
[[nodiscard]] double wellDepthNmm(const WellShape& shape, double forceN) noexcept;

/// What a guide remembers from tick to tick to answer sooner.
struct SoftMemory {
  Polyline::Place place;
  uint64_t curve = 0;  ///< The curve that `place` belongs to; 0: none.
  Vec3d near = Vec3d::Zero();
  bool nearKnown = false;
  LocalModel model;      ///< The newest one,
  double modelAgeS = 0;  ///< and for how long nothing newer came.
};

/// The pull of a well or an ambient guide on the tool's centre `at`; none for guides of another kind. Elements of a
/// model are limited one by one, and all of it together. `clay` searches a piece for it, null for guides that name
/// none.
[[nodiscard]] Pull softPull(const Guide& guide, const Scene& scene, TouchableClay* clay, const Vec3d& at,
                            const Vec3d& velocity, uint32_t buttons, const SoftLimits& limits,
                            SoftMemory& memory) ARGIL_REALTIME;

}  // namespace argil::haptics
