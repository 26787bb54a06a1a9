// What can be set of a plane that is moved in the picture before a piece is cut or mirrored along it.

#include <algorithm>
#include <array>
#include <cmath>

#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using std::string_view;

bool same(const engine::MirrorPlane& a, const engine::MirrorPlane& b) {
  constexpr double kSame = 1e-9;
  return (a.normal - b.normal).norm() < kSame && std::abs((a.pointMm - b.pointMm).dot(b.normal)) < kSame;
}

// A list of planes that are there; the first entry while it lies elsewhere.
void choosePlane(const Context& context, PlaneCut& cut) {
  const std::vector<NamedPlane> planes = planesOf(*context.now.document, context.state.selected, cut.middleMm);
  std::vector<string_view> names{"As it lies"};
  int chosen = 0;
  for (size_t i = 0; i < planes.size(); ++i) {
    names.push_back(planes[i].name);
    if (chosen == 0 && same(planes[i].plane, cut.arguments.plane)) chosen = int(i) + 1;
  }
  if (kit::choice("Plane", names, chosen, "Puts it there; then it can be moved on.") && chosen > 0)
    cut.arguments.plane = planes[size_t(chosen - 1)].plane;
}

}  // namespace

void planeCutSection(Context& context) {
  PlaneCut& cut = *context.state.planeCut;
  ImGui::PushFont(fonts().strong);
  kit::text(cut.job->name);
  ImGui::PopFont();
  kit::wrapped(cut.job->help, colours().dim);
  if (const engine::Piece* piece = context.now.document->piece(cut.arguments.pieces.front()))
    kit::fact("Piece", piece->name);
  kit::gap(4);
  choosePlane(context, cut);
  double offset = cut.offsetMm();
  if (kit::number({"offset", "Offset", "Of the plane from the middle of the piece, along its arrow.", "mm", -cut.halfMm,
                   cut.halfMm, 0},
                  offset)
          .changed)
    cut.setOffset(offset);
  if (cut.choosesSide()) {
    static constexpr std::array<string_view, 3> kKeeps{"Arrow's side", "Both", "Other side"};
    kit::dimText("What stays");
    kit::tooltip("What goes is red in the picture. Both: the piece becomes two.");
    int chosen = 1 - cut.kept();
    if (kit::segmented("keep", kKeeps, chosen)) cut.arguments.change<engine::CutValues>().keep = 1 - chosen;
  } else {
    kit::wrapped("The blue half is replaced by the mirror image of the other.", colours().dim);
  }
  if (kit::button("Turn the plane round", kit::Weight::plain, ImGui::GetContentRegionAvail().x))
    cut.arguments.plane.normal *= -1;
  kit::gap(4);
  const float half = std::floor((ImGui::GetContentRegionAvail().x - kGap) / 2);
  if (kit::button("Cancel", kit::Weight::plain, half)) cut.cancel = true;
  kit::tooltip("The clay stays as it is.", "Esc");
  ImGui::SameLine();
  if (kit::button("Apply", kit::Weight::chief, half)) cut.apply = true;
  kit::tooltip("Does it, as one step of the history.", "Enter");
}

}  // namespace argil::studio
