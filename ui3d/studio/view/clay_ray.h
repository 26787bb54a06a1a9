#pragma once
// Where a line of sight meets clay as it was at one moment.

#include <optional>
#include <vector>

#include "clay/store/version.h"
#include "engine/document/document.h"
#include "haptics/base/pose.h"
#include "render/view/view.h"

namespace argil::studio {

/// Pinned versions of the clay that is seen: a stroke's own cuts do not change what its line of sight meets. One
/// thread.
class PinnedClay {
 public:
  /// The visible pieces; `bounds` of each by render::Renderer::bounds(id), in world mm, at that moment.
  template <class Bounds>
  PinnedClay(const engine::Document& document, const Bounds& bounds) {
    for (const engine::Piece& piece : document.pieces)
      if (piece.visible && piece.version)
        pieces_.push_back({piece.version, piece.pose, bounds(piece.id), piece.hideMasked});
  }
  PinnedClay() = default;

  /// Distance along the direction (length one) to the first surface that is seen at or after `fromMm`, or nothing: a
  /// line goes on through masked clay that is hidden. 0.01 mm or a thousandth of a voxel. Cost: a field read each voxel
  /// or so on the way through the boxes.
  [[nodiscard]] std::optional<double> distance(const Vec3d& origin, const Vec3d& direction, double fromMm = 0) const;
  [[nodiscard]] bool empty() const { return pieces_.empty(); }

 private:
  struct Pinned {
    clay::Version version;
    haptics::Pose pose;
    render::Box bounds;
    bool hideMasked = false;
  };
  std::vector<Pinned> pieces_;
};

}  // namespace argil::studio
