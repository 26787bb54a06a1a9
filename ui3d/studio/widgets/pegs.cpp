// Pegs of a cut that is asked about, as they would stand.

#include <cmath>
#include <numbers>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr render::Colour kPeg{0.98f, 0.68f, 0.30f, 1};
constexpr int kSteps = 32, kSides = 8;

}  // namespace

void buildPegs(Build& build) {
  const auto& shown = build.world.state.pegs;
  if (!shown) return;
  const Vec3d n = shown->normal, u = n.unitOrthogonal(), v = n.cross(u);
  for (const clay::Peg& peg : shown->pegs) {
    const double radius = 0.5 * peg.diameterMm;
    const Vec3d end = peg.atMm + peg.depthMm * n, begin = shown->loose ? Vec3d(peg.atMm - peg.depthMm * n) : peg.atMm;
    for (const Vec3d& at : {begin, peg.atMm, end})
      build.line(arc(at, u, v, radius, 0, 2 * std::numbers::pi, kSteps), kPeg, at == peg.atMm ? 2.6f : 1.8f);
    for (int i = 0; i < kSides; ++i) {
      const double a = 2 * std::numbers::pi * i / kSides;
      const Vec3d out = radius * (std::cos(a) * u + std::sin(a) * v);
      build.line({begin + out, end + out}, faded(kPeg, 0.7f), 1.4f);
    }
  }
}

}  // namespace argil::studio
