#include "ui3d/studio/widgets/guide_places.h"

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {

std::vector<Vec3d> placesAlong(const engine::Guide& guide) {
  if (guide.kind == engine::Guide::Kind::curve && guide.pointsMm.size() >= 2)
    return sampleCurve(guide.pointsMm, guide.closed);
  if (guide.kind != engine::Guide::Kind::line) return {};
  const Vec3d half = 0.5 * guide.sizeMm.z() * guide.axis();
  return {guide.pose.translation - half, guide.pose.translation + half};
}

}  // namespace argil::studio
