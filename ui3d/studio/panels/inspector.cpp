// What can be set of the selected thing.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/whole/deform.h"
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
void bodyOf(Context& context, Memory& memory, const Body& body, Body* (Document::*find)(engine::Id)) {
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

  if (!feelHeading(context, memory)) return;
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

// The middle of a piece or a part in its own axes, measured once for its clay or mesh.
Vec3d middleOf(Memory& memory, const engine::Piece& piece) {
  if (std::exchange(memory.middleOf, piece.version.record()) != piece.version.record()) {
    memory.middleMm.setZero();
    if (piece.version && piece.version.stats().bricks > 0) {
      const clay::BoxMm box = clay::boundsOf(piece.version);
      memory.middleMm = (box.low + box.high) / 2;
    }
  }
  return memory.middleMm;
}
Vec3d middleOf(Memory& memory, const engine::Part& part) {
  if (std::exchange(memory.middleOf, part.mesh.get()) != part.mesh.get()) {
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : part.mesh->positions) box.extend(p);
    memory.middleMm = box.isEmpty() ? Vec3d(Vec3d::Zero()) : Vec3d(box.center());
  }
  return memory.middleMm;
}

Vec3d middleOf(const Guide& guide) {
  if (guide.pointsMm.empty()) return guide.pose.translation;
  Vec3d sum = Vec3d::Zero();
  for (const Vec3d& p : guide.pointsMm) sum += p;
  return sum / double(guide.pointsMm.size());
}

void moveThing(Document& document, engine::Id id, const Vec3d& by) {
  if (engine::Piece* piece = document.piece(id)) piece->pose.translation += by;
  if (engine::Part* part = document.part(id)) part->pose.translation += by;
  if (Guide* guide = document.guide(id)) {
    guide->pose.translation += by;
    for (Vec3d& p : guide->pointsMm) p += by;
  }
}

// Shows where a thing is, to be read, dragged and typed. Whatever else is selected goes along, as by the handles.
void place(Context& context, const engine::Thing& thing, const Vec3d& atMm) {
  constexpr double kReachMm = 250;  // Of a drag over the bar, either way; typed places may be anywhere.
  static constexpr std::array<std::string_view, 3> kNames{"X", "Y", "Z"}, kIds{"place x", "place y", "place z"};
  std::vector<engine::Id> moved;
  for (const engine::Id id : context.state.selection())
    if (const engine::Thing* each = context.now.document->thing(id); each && !each->locked) moved.push_back(id);
  const size_t along = moved.size() > 1 ? moved.size() - 1 : 0;
  kit::dimText(along == 0 ? "Place of its middle" : "Place of its middle; the others move along");
  for (int axis = 0; axis < 3; ++axis) {
    double value = atMm[axis];
    const kit::Change change = kit::number({.id = kIds[size_t(axis)],
                                            .name = kNames[size_t(axis)],
                                            .help = "Drag, or double-click to type.",
                                            .unit = "mm",
                                            .low = -kReachMm,
                                            .high = kReachMm,
                                            .open = true},
                                           value);
    if (change.changed) {
      const Vec3d by = (value - atMm[axis]) * Vec3d::Unit(axis);
      context.bench.edit(
          "Move " + thing.name + (along == 0 ? "" : " and " + std::to_string(along) + " more"),
          [moved, by](Document& d) {
            for (const engine::Id id : moved) moveThing(d, id, by);
          },
          mergeKey("place", thing.id));
    }
    if (change.ended) context.bench.endMerge();
  }
}

}  // namespace

bool feelHeading(const Context& context, Memory& memory) {
  if (context.bench.usesPointer())
    return kit::fold("Feel", memory.feelOpen, "How the clay feels to a force device. There is none in use.");
  kit::heading("Feel");
  return true;
}

void inspector(Context& context, Memory& memory) {
  const Document& document = *context.now.document;
  const engine::Thing* thing = document.thing(context.state.selected);
  if (!thing) return;
  kit::heading(thing->name);
  if (const size_t selected = context.state.selection().size(); selected > 1)
    kit::dimText("and " + std::to_string(selected - 1) + " more selected");
  ImGui::PushID(int(thing->id));
  ImGui::BeginDisabled(thing->locked);
  if (const engine::Piece* piece = document.piece(thing->id)) {
    if (piece->version) kit::fact("Voxel", kit::written(piece->version.grid().voxelMm) + " mm");
    place(context, *piece, piece->pose.apply(middleOf(memory, *piece)));
    bodyOf(context, memory, *piece, &Document::piece);
    if (!laysMaterial(context)) materialsSection(context, memory, *piece);
  } else if (const engine::Part* part = document.part(thing->id)) {
    place(context, *part, part->pose.apply(middleOf(memory, *part)));
    bodyOf(context, memory, *part, &Document::part);
  } else if (const Guide* g = document.guide(thing->id)) {
    place(context, *g, middleOf(*g));
    guide(context, *g);
  }
  ImGui::EndDisabled();
  if (thing->locked) kit::wrapped("Locked: unlock it to change it.", colours().dim);
  ImGui::PopID();
}

}  // namespace argil::studio
