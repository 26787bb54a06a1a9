// The bed of the printer on the ground, and the room above it.

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ui3d/studio/widgets/box_frame.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr render::Colour kFits{0.45f, 0.78f, 0.55f, 1}, kTooSmall{0.96f, 0.42f, 0.40f, 1};

}  // namespace

Vec3d printBedMiddle(const render::Box& clay, const Vec3d& bedMm) {
  if (clay.empty()) return Vec3d::Zero();
  Vec3d middle = clay.centre();
  // What was nested begins at the corner of the first bed.
  for (int axis = 0; axis < 2; ++axis)
    if (clay.size()[axis] > bedMm[axis]) middle[axis] = clay.min[axis] + 0.5 * bedMm[axis];
  middle.z() = clay.min.z();
  return middle;
}

void buildPrintBed(Build& build) {
  Vec3d bed = build.world.state.print.bedMm;
  const render::Box& clay = build.world.bounds;
  // As the check looks at it: turned by a quarter, where it fits so alone.
  const auto holds = [&] { return clay.empty() || (bed - clay.size()).minCoeff() >= 0; };
  if (!holds()) {
    std::swap(bed.x(), bed.y());
    if (!holds()) std::swap(bed.x(), bed.y());
  }
  const Vec3d middle = printBedMiddle(clay, bed);
  const render::Colour colour = holds() ? kFits : kTooSmall;
  BoxFrame box;
  box.pose.translation = middle + Vec3d(0, 0, 0.5 * bed.z());
  box.half = 0.5 * bed;
  for (const auto& edge : box.edges()) {
    const bool onGround = std::max(edge[0].z(), edge[1].z()) < middle.z() + 0.25 * bed.z();
    build.line({edge[0], edge[1]}, faded(colour, onGround ? 0.9f : 0.25f), onGround ? 2.2f : 1.2f);
  }
  const Vec3d a = box.at(-1, -1, -1), b = box.at(1, -1, -1), c = box.at(1, 1, -1), d = box.at(-1, 1, -1);
  build.fill({a, b, c, a, c, d}, faded(colour, 0.08f));
  build.text(a, fmt::format("bed {:g} × {:g} × {:g} mm", bed.x(), bed.y(), bed.z()), colour);
}

}  // namespace argil::studio
