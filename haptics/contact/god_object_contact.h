#pragma once
// Contact by a god-object, to compare with: a point that stays on the surface.

#include <array>
#include <span>

#include "haptics/contact/active_set.h"
#include "haptics/contact/contact.h"
#include "haptics/scene/touchable.h"

namespace argil::haptics {

/// Zilles & Salisbury's god-object on an implicit surface (Salisbury & Tarr): a point without radius follows the hand
/// through free space in short steps, stops at the zero surface, and then moves in at most three tangent planes towards
/// the hand, taken back to the surface after each step. It does not pop through walls thicker than half a voxel, but
/// falls into any gap, feels each facet of the field, and is lost when more clay than the band grows over it: then no
/// force until the hand is near the surface again. Only clay is felt, friction, guides and the tool's operation are
/// not; the tool's radius means nothing. One thread, the servo's.
class GodObjectContact final : public Contact {
 public:
  void reset() noexcept override { begun_ = false; }
  Output tick(const Scene& scene, const Input& input) ARGIL_REALTIME override;

 private:
  struct Value {
    double mm = 0;  // Trilinear value of the union, mm as the field counts them.
    size_t piece = 0;
  };
  Value value(const Vec3d& world) ARGIL_REALTIME;
  Vec3d gradient(size_t piece, const Vec3d& world) ARGIL_REALTIME;
  bool project(Vec3d& at, Vec3d& normal) ARGIL_REALTIME;
  bool march(const Vec3d& goal, int& steps) ARGIL_REALTIME;
  void follow(const Vec3d& hand, Output& out) ARGIL_REALTIME;

  std::array<TouchableClay, kMaxPieces> pieces_;
  std::span<TouchableClay> used_;
  double voxel_ = 1;  // Of the finest piece, mm.
  Vec3d place_ = Vec3d::Zero();
  bool begun_ = false;
};

}  // namespace argil::haptics
