// The plane along which a piece is about to be cut or mirrored: a sheet with an arrow and two arcs, the line on the
// clay and a tint over what goes.

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr double kMargin = 1.1;
constexpr render::Colour kGoes{0.86f, 0.20f, 0.16f, 0.62f}, kIsReplaced{0.30f, 0.45f, 0.70f, 0.55f};
constexpr render::Colour kSheet{0.98f, 0.68f, 0.30f, 1};

}  // namespace

void buildPlaneCut(Build& build) {
  const auto& cut = build.world.state.planeCut;
  if (!cut || !(cut->arguments.plane.normal.norm() > 0)) return;
  const Vec3d n = cut->arguments.plane.normal.normalized();
  const Vec3d x = (std::abs(n.z()) < 0.9 ? n.cross(Vec3d::UnitZ()) : n.cross(Vec3d::UnitX())).normalized(),
              y = n.cross(x);
  const Vec3d centre = cut->middleMm + (cut->arguments.plane.pointMm - cut->middleMm).dot(n) * n;
  const double half = kMargin * cut->halfMm;
  const Sheet sheet{centre, x, y, half, half};
  build.fill(sheet.triangles(), faded(kSheet, 0.10f));
  build.closedLine(sheet.corners(), kSheet, 1.6f);
  sheetHandles(build, sheet, {Target::Kind::cut, cut->arguments.pieces.front()}, centre, kSheet, true);

  render::PlaneMark mark;
  mark.pointMm = centre;
  mark.normal = cut->kept() < 0 ? n : Vec3d(-n);
  mark.line = kSheet;
  mark.widthPixels = 2.5f;
  mark.dimmedToo = false;  // The other pieces stay as they are.
  if (!cut->choosesSide())
    mark.beyond = kIsReplaced;
  else if (cut->kept() != 0)
    mark.beyond = kGoes;
  build.planes.push_back(mark);
}

}  // namespace argil::studio
