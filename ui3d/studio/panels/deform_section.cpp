// The deform box in numbers: points, bend, twist, taper; Apply and Cancel.

#include <array>
#include <cmath>

#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using Kind = DeformBox::Kind;
using std::string_view;

template <auto member>
constexpr engine::Parameter<DeformBox> plain(string_view id, string_view name, string_view help, string_view unit,
                                             double low, double high, double standard, bool logarithmic = false) {
  return {id,
          name,
          help,
          unit,
          low,
          high,
          standard,
          logarithmic,
          [](const DeformBox& b) { return b.*member; },
          [](DeformBox& b, double v) { b.*member = v; }};
}
template <int axis>
constexpr engine::Parameter<DeformBox> count(string_view id, string_view name) {
  return {id,
          name,
          "Points along this axis; moved ones go back to their places.",
          "",
          2,
          8,
          4,
          false,
          [](const DeformBox& b) { return double(b.lattice.counts()[axis]); },
          [](DeformBox& b, double v) {
            std::array<int, 3> counts = b.lattice.counts();
            const int wanted = static_cast<int>(std::lround(v));
            if (counts[axis] == wanted) return;
            counts[axis] = wanted;
            b.setCounts(counts);
          }};
}

constexpr std::array kCounts{count<0>("points-x", "Points x"), count<1>("points-y", "Points y"),
                             count<2>("points-z", "Points z")};
constexpr std::array kRange{
    plain<&DeformBox::fromPercent>("from", "From", "Where it begins along the axis; what lies before stays.", "%", 0,
                                   99, 0),
    plain<&DeformBox::toPercent>("to", "To", "Where it ends; what lies behind follows as it is.", "%", 1, 100, 100),
};
constexpr std::array kBend{
    plain<&DeformBox::bendDegrees>("bend", "Angle", "How far the end is turned.", "°", -350, 350, 0),
    plain<&DeformBox::bendTowards>("towards", "Towards", "Direction across the axis.", "°", 0, 360, 0),
};
constexpr std::array kTwist{
    plain<&DeformBox::twistDegrees>("twist", "Angle", "How far the end is turned.", "°", -1080, 1080, 0)};
constexpr std::array kTaper{plain<&DeformBox::taperPercent>(
    "taper", "Width", "At the end, of what it is at the beginning.", "%", 15, 700, 100, true)};

}  // namespace

void deformSection(Context& context) {
  DeformBox& box = *context.state.deformBox;
  ImGui::PushFont(fonts().strong);
  kit::text("Deform box");
  ImGui::PopFont();
  kit::wrapped("Points are pulled in the picture; bend, twist and taper are set here. Apply takes all of them.",
               colours().dim);
  if (const engine::Piece* piece = context.now.document->piece(box.piece)) kit::fact("Piece", piece->name);
  kit::gap(4);
  static constexpr std::array<string_view, 4> kKinds{"Points", "Bend", "Twist", "Taper"};
  int kind = static_cast<int>(box.kind);
  if (kit::segmented("deform kind", kKinds, kind)) box.kind = static_cast<Kind>(kind);
  if (box.kind == Kind::lattice) {
    drawRows(std::span<const engine::Parameter<DeformBox>>(kCounts), box);
  } else {
    static constexpr std::array<string_view, 3> kAxes{"x", "y", "z"};
    kit::segmented("deform axis", kAxes, box.axis);
    const std::span<const engine::Parameter<DeformBox>> rows =
        box.kind == Kind::bend    ? std::span<const engine::Parameter<DeformBox>>(kBend)
        : box.kind == Kind::twist ? std::span<const engine::Parameter<DeformBox>>(kTwist)
                                  : std::span<const engine::Parameter<DeformBox>>(kTaper);
    drawRows(rows, box);
    drawRows(std::span<const engine::Parameter<DeformBox>>(kRange), box);
  }
  box.held = ImGui::IsAnyItemActive();
  if (!box.trouble.empty()) kit::wrapped(kit::sentence(box.trouble), colours().warning);
  if (box.progress >= 0) {
    kit::gap(2);
    kit::bar(box.progress, ImGui::GetContentRegionAvail().x);
  }
  const float half = std::floor((ImGui::GetContentRegionAvail().x - kGap) / 2);
  if (kit::button("Cancel", kit::Weight::plain, half)) box.cancel = true;
  kit::tooltip("The clay as it was before the box.", "Esc");
  ImGui::SameLine();
  ImGui::BeginDisabled(!box.trouble.empty());
  if (kit::button("Apply", kit::Weight::chief, half)) box.apply = true;
  ImGui::EndDisabled();
  kit::tooltip("Keeps the clay as it is now, as one step of the history.", "Enter");
}

}  // namespace argil::studio
