#pragma once
// Contact by penalty, to compare with: force from how deep the hand is.

#include <array>

#include "haptics/contact/contact.h"
#include "haptics/scene/touchable.h"

namespace argil::haptics {

/// Force of a piece = stiffness × depth along the field's gradient at the hand, by central differences one voxel apart,
/// as the volume methods of the course do (Avila & Sobierajski); pieces add up. Nothing is remembered of where the ball
/// came in, so it pops through thin walls, and a field that jumps within a voxel or two multiplies the stiffness by its
/// slope and buzzes. Only clay is felt, friction, guides and the tool's operation are not. The field is known within
/// its band alone: the ball is felt as one of at most (band − 1) voxels, and deeper than the band the last direction is
/// kept. One thread, the servo's.
class PenaltyContact final : public Contact {
 public:
  void reset() noexcept override;
  Output tick(const Scene& scene, const Input& input) ARGIL_REALTIME override;

 private:
  std::array<TouchableClay, kMaxPieces> pieces_;
  std::array<Vec3d, kMaxPieces> normal_{};  // Outward, world; zero before the first contact with that piece.
};

}  // namespace argil::haptics
