// A curve over the picture, and what stays and what goes where it cuts.

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr render::Colour kCurve{1.00f, 0.82f, 0.22f, 1}, kGoes{0.86f, 0.16f, 0.12f, 0.42f},
    kStays{0.25f, 0.62f, 0.95f, 0.16f}, kOther{0.95f, 0.55f, 0.15f, 0.30f};
constexpr render::Colour kPlain{0.95f, 0.95f, 0.95f, 1};
constexpr float kWire = 0.22f;  // Of the wall that the curve sweeps.

}  // namespace

void buildDrawnCurve(Build& build) {
  const auto& curve = build.world.state.drawnCurve;
  if (!curve || curve->pointsMm.empty()) return;
  std::vector<Vec3d> line = curve->pointsMm;
  if (line.size() > 1 && (curve->closed || (curve->held && curve->atOnce))) line.push_back(line.front());
  if (line.size() > 1) build.line(line, kCurve, 3, render::Depth::onTop);
  if (!curve->drawn() || !curve->cuts()) return;

  // The wall that it sweeps, through the piece: seen when the view is turned.
  const double reach = 1.1 * (curve->box.high - curve->box.low).norm();
  std::vector<Vec3d> wall;
  for (size_t i = 1; i < line.size(); ++i) {
    const Vec3d a = line[i - 1], b = line[i], c = a + reach * curve->directionMm, d = b + reach * curve->directionMm;
    wall.insert(wall.end(), {a, b, c, b, d, c});
  }
  build.fill(std::move(wall), faded(kCurve, kWire));
  for (size_t i = 0; i < 2; ++i) {
    const CurveSides::Side& side = curve->sides.sides[i];
    if (side.trianglesMm.empty()) continue;
    const bool both = curve->kept() == 0, stays = both || (curve->kept() > 0) == (i == 0);
    build.fill(side.trianglesMm, !stays ? kGoes : both && i == 1 ? kOther : kStays, render::Depth::xray);
    build.text(side.middleMm, both ? (i == 0 ? "stays" : "a piece of its own") : stays ? "stays" : "goes", kPlain);
  }
}

}  // namespace argil::studio
