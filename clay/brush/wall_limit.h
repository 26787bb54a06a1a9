#pragma once
// Keeps a tip that cuts away from walls that would become too thin. This module's own.

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "clay/brush/brush.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// A ball that follows the stamps of a stroke but stays so far from the far side of what it cuts into that a wall of
/// `wall` voxels is left: like a ball on a string that rolls on a sheet at that depth. Far is a place of the surface
/// that leads away from the ball (its normal within 25° of the way there), with clay before it, when what bounds that
/// clay towards the ball faces the other way: so edges, corners and wedges are no walls. Walls that are thinner already
/// are not touched. A tip that grows is pushed off them too, and stays as large as it was without room. One thread.
/// Method: NOTES.md, "A limit for walls".
class WallLimit {
 public:
  /// `wall` in voxels, above 0; `around`: radii of the ball around the tip, of the stamp's.
  WallLimit(double wall, double around) : wall_(wall), around_(around) {}

  /// The stamps of an image of one application as they may be applied: the stamp itself where nothing is in the way.
  /// Empty: nothing may be cut. The images of a stroke keep their order.
  [[nodiscard]] std::vector<Stamp> allowed(const Editor& clay, const Stamp& stamp, size_t image);

  /// The walls around the balls, where the last stamps left them (BrushStroke::wallsAhead).
  [[nodiscard]] const std::vector<WallAhead>& ahead(const Editor& clay);

 private:
  struct Follower {
    Vec3d ball;     // where it is
    Vec3d target;   // where the stamps are
    double radius;  // of the ball
  };
  void gather(const Editor& clay, const Vec3d& centre, double radius);
  void gatherAhead(const Editor& clay, const Vec3d& ball, double radius);
  [[nodiscard]] bool isFar(Sampler& clay, const Vec3d& place, const Vec3d& ball, double radius) const;
  [[nodiscard]] std::optional<Vec3d> freed(Sampler& clay, Vec3d ball, double radius);
  [[nodiscard]] std::optional<Vec3d> outsideOf(Sampler& clay, const Vec3d& place, double radius) const;
  void grow(const Editor& clay, Follower& follower, double radius, std::vector<Vec3d>& way);
  Vec3d follow(const Editor& clay, Vec3d ball, const Vec3d& target, double radius, std::vector<Vec3d>* way);

  double wall_, around_;
  std::vector<std::optional<Follower>> followers_;
  std::vector<Vec3d> places_;  // where the surface crosses edges of voxels, around gathered_
  Vec3d gathered_ = Vec3d::Zero();
  double gatheredRadius_ = 0;
  Vec3d barrier_ = Vec3d::Zero();  // where to the wall lies that was in the way last
  bool hindered_ = false;          // the ball of this application went another way than its stamp
  std::vector<std::pair<double, uint32_t>> near_;
  std::vector<WallAhead> ahead_;
  bool aheadKnown_ = false;  // since the last stamp
};

}  // namespace argil::clay
