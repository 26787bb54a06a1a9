// What can be set of the selected thing.

#include <algorithm>
#include <cmath>

#include "engine/document/guide_table.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"

namespace argil::studio {
namespace {

using engine::Document;
using engine::Guide;

std::string mergeKey(std::string_view what, engine::Id id) {
  return std::string(what) + "." + std::to_string(id);
}

template <class Body>
void bodyOf(Context& context, const Body& body, Body* (Document::*find)(engine::Id)) {
  std::array<float, 3> colour = body.colour;
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::AlignTextToFramePadding();
  kit::text("Colour");
  ImGui::SameLine(ImGui::GetCursorStartPos().x + width - ImGui::GetFrameHeight());
  if (ImGui::ColorEdit3("##colour", colour.data(),
                        ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel | ImGuiColorEditFlags_NoTooltip)) {
    context.bench.edit(
        "Colour of " + body.name,
        [id = body.id, colour, find](Document& d) {
          if (Body* each = (d.*find)(id)) each->colour = colour;
        },
        mergeKey("colour", body.id));
  }
  if (ImGui::IsItemDeactivatedAfterEdit()) context.bench.endMerge();

  kit::heading("Feel");
  haptics::Material material = body.material;
  const auto touched = drawRows(materialRows(), material);
  if (touched.changed) {
    context.bench.edit(
        std::string(touched.name) + " of " + body.name,
        [id = body.id, set = touched.set, find](Document& d) {
          if (Body* each = (d.*find)(id)) set(each->material);
        },
        mergeKey(touched.id, body.id));
  }
  if (touched.ended) context.bench.endMerge();
}

void guide(Context& context, const Guide& guide) {
  static constexpr std::array<std::string_view, 4> kFeels{"Seen", "Lock", "Well", "Block"};
  if (const std::span feels = engine::rowOf(guide.kind).feels; !feels.empty()) {
    kit::dimText("To the hand");
    std::vector<std::string_view> names;
    for (const Guide::Feel feel : feels) names.push_back(kFeels[size_t(feel)]);
    int chosen = int(std::find(feels.begin(), feels.end(), guide.feel) - feels.begin());
    if (kit::segmented("feel", names, chosen)) {
      context.bench.edit("Feel of " + guide.name, [id = guide.id, feel = feels[size_t(chosen)]](Document& d) {
        if (Guide* each = d.guide(id)) each->feel = feel;
      });
    }
    static constexpr std::array<std::string_view, 4> kSays{"Not felt.", "Holds the tool on it.",
                                                           "Draws the tool to it.", "The tool may not pass."};
    kit::wrapped(kSays[size_t(guide.feel)], colours().dim);
  }
  Guide copy = guide;
  auto touched = drawRows(sizeRows(guide.kind), copy);
  if (guide.feel == Guide::Feel::well) {
    if (const auto t = drawRows(wellRows(), copy); t.changed || t.ended) touched = t;
  }
  if (guide.kind == Guide::Kind::curve && kit::toggle("Closed", copy.closed, "The end meets the beginning."))
    touched = {true, true, "closed", "Closing", [closed = copy.closed](Guide& each) { each.closed = closed; }};
  if (touched.changed) {
    context.bench.edit(
        std::string(touched.name) + " of " + guide.name,
        [id = guide.id, set = touched.set](Document& d) {
          if (Guide* each = d.guide(id)) set(*each);
        },
        mergeKey(touched.id, guide.id));
  }
  if (touched.ended) context.bench.endMerge();
  if (guide.kind == Guide::Kind::curve || guide.kind == Guide::Kind::line) {
    const Action* stroke = findAction("guides.stroke");
    ImGui::BeginDisabled(!stroke->enabled(context));
    if (kit::button(stroke->name, kit::Weight::plain, -1)) runAction(context, stroke->id);
    ImGui::EndDisabled();
    kit::tooltip(stroke->help);
  }
  if (guide.kind == Guide::Kind::ruler && guide.pointsMm.size() >= 2) {
    kit::fact("Length", kit::written((guide.pointsMm[1] - guide.pointsMm[0]).norm()) + " mm");
  }
  if (guide.kind == Guide::Kind::angle && guide.pointsMm.size() >= 3) {
    const Vec3d a = guide.pointsMm[0] - guide.pointsMm[1], b = guide.pointsMm[2] - guide.pointsMm[1];
    kit::fact("Angle", kit::written(std::atan2(a.cross(b).norm(), a.dot(b)) * 57.29577951308232) + "°");
  }
}

void pose(const haptics::Pose& pose) {
  const Vec3d& p = pose.translation;
  kit::fact("Place", kit::written(p.x()) + ", " + kit::written(p.y()) + ", " + kit::written(p.z()) + " mm");
}

}  // namespace

void inspector(Context& context, Memory& memory) {
  const Document& document = *context.now.document;
  const engine::Thing* thing = document.thing(context.state.selected);
  if (!thing) return;
  kit::heading(thing->name);
  ImGui::PushID(int(thing->id));
  ImGui::BeginDisabled(thing->locked);
  if (const engine::Piece* piece = document.piece(thing->id)) {
    if (piece->version) kit::fact("Voxel", kit::written(piece->version.grid().voxelMm) + " mm");
    pose(piece->pose);
    bodyOf(context, *piece, &Document::piece);
    if (!laysMaterial(context)) materialsSection(context, memory, *piece);
  } else if (const engine::Part* part = document.part(thing->id)) {
    pose(part->pose);
    bodyOf(context, *part, &Document::part);
  } else if (const Guide* g = document.guide(thing->id)) {
    if (g->pointsMm.empty()) pose(g->pose);
    guide(context, *g);
  }
  ImGui::EndDisabled();
  if (thing->locked) kit::wrapped("Locked: unlock it to change it.", colours().dim);
  ImGui::PopID();
}

}  // namespace argil::studio
