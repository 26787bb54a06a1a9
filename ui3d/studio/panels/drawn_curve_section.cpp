// What can be set of a curve that is drawn over the picture.

#include <array>
#include <cmath>

#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using std::string_view;

// Which side stays: the values of the parameter, +1, 0, −1.
bool drawKeep(DrawnCurve& curve) {
  static constexpr std::array<string_view, 3> kOpen{"Left", "Both", "Right"}, kClosed{"Inside", "Both", "Outside"};
  kit::dimText("What stays");
  kit::tooltip("Both: the piece becomes two.");
  int chosen = 1 - curve.kept();
  if (!kit::segmented("keep", curve.closed ? kClosed : kOpen, chosen)) return false;
  curve.arguments.change<engine::CutValues>().keep = 1 - chosen;
  return true;
}

bool hasCurveGuide(const engine::Document& document) {
  for (const engine::Guide& guide : document.guides)
    if (guide.kind == engine::Guide::Kind::curve && guide.pointsMm.size() >= 2) return true;
  return false;
}

}  // namespace

void drawnCurveSection(Context& context) {
  DrawnCurve& curve = *context.state.drawnCurve;
  ImGui::PushFont(fonts().strong);
  kit::text(curve.job->name);
  ImGui::PopFont();
  kit::wrapped(curve.job->help, colours().dim);
  if (const engine::Piece* piece = context.now.document->piece(curve.arguments.pieces.front()))
    kit::fact("Piece", piece->name);
  kit::gap(4);
  bool changed = false;
  for (const auto& parameter : curve.job->parameters)
    changed |= parameter.id == "keep" ? drawKeep(curve) : drawRow(parameter, curve.arguments).changed;
  if (curve.cuts() && curve.drawn() && curve.pointsMm.size() >= 3)
    changed |= kit::toggle("Closed", curve.closed, "The end meets the beginning; else both ends go straight on.");
  if (changed && curve.cuts()) curve.findSides();
  kit::gap(4);
  if (!curve.cuts()) {
    maskButtons(context);
    kit::gap(4);
    if (kit::button("Done", kit::Weight::chief, ImGui::GetContentRegionAvail().x)) curve.cancel = true;
    kit::tooltip("Back to the tool in hand.", "Esc");
    return;
  }
  const float half = std::floor((ImGui::GetContentRegionAvail().x - kGap) / 2);
  if (kit::button("Cancel", kit::Weight::plain, half)) curve.cancel = true;
  kit::tooltip("The clay stays whole.", "Esc");
  ImGui::SameLine();
  ImGui::BeginDisabled(!curve.drawn());
  if (kit::button("Apply", kit::Weight::chief, half)) curve.apply = true;
  ImGui::EndDisabled();
  kit::tooltip("Cuts, as one step of the history.", "Enter");
  if (hasCurveGuide(*context.now.document)) {
    if (kit::button("Along a curve guide…", kit::Weight::plain, ImGui::GetContentRegionAvail().x)) {
      context.state.wishes.dialog = "piece." + std::string(curve.job->id);
      curve.cancel = true;
    }
    kit::tooltip("Instead of a drawn one.");
  }
}

}  // namespace argil::studio
