#include "ui3d/studio/widgets/widget_set.h"

#include <fmt/format.h>

#include <algorithm>

namespace argil::studio {
namespace {

using engine::Document;
using engine::Guide;

constexpr double kSettleS = 0.5;   // An edit that has not come back by then was refused.
constexpr double kMarkUnits = 9;   // Of a snapped place.
constexpr float kLabelAside = 14;  // Interface units from what it names.

bool isGizmo(const Handle& handle) {
  return handle.name == "move axis" || handle.name == "move plane" || handle.name == "move" ||
         handle.name == "turn axis" || handle.name == "turn view" || handle.name == "scale axis" ||
         handle.name == "scale";
}

void overlay(Document& document, const Target& target, const Subject& subject) {
  if (target.kind == Target::Kind::symmetry) {
    if (const auto* symmetry = std::get_if<engine::Symmetry>(&subject)) document.symmetry.pose = symmetry->pose;
  } else if (target.kind == Target::Kind::thing) {
    if (const auto* guide = std::get_if<Guide>(&subject)) {
      if (Guide* there = document.guide(target.id)) {
        there->pose = guide->pose;
        there->sizeMm = guide->sizeMm;
        there->pointsMm = guide->pointsMm;
        there->closed = guide->closed;
      }
    } else if (const auto* pose = std::get_if<haptics::Pose>(&subject)) {
      if (auto* piece = document.piece(target.id)) piece->pose = *pose;
      if (auto* part = document.part(target.id)) part->pose = *pose;
    }
  }
}

// Whether a drag is a stroke of the tool, or turns the view: then guides are moved by their handles alone. Where the
// handles of Move, Rotate and Scale are shown a guide can be grabbed anywhere.
bool brushInHand(const World& world) {
  return world.state.gizmo == GizmoMode::none && !world.state.deformBox && world.document.workedOn() != nullptr;
}

void mark(Build& build, const Snap& snap) {
  if (snap.highlight.size() > 1) build.line(snap.highlight, widget_colours::kSnap, 3.5f, render::Depth::xray);
  const auto& axes = build.world.screen.axes();
  const double r = kMarkUnits * build.unit(snap.at);
  build.closedLine({snap.at + r * axes.right, snap.at + r * axes.up, snap.at - r * axes.right, snap.at - r * axes.up},
                   widget_colours::kSnap, 2.5f, render::Depth::onTop);
}

}  // namespace

Document WidgetSet::shown(const World& world) const {
  Document document = world.document;
  if (settling_) overlay(document, settling_->target, settling_->subject);
  if (drag_) overlay(document, drag_->handle().target, drag_->now());
  return document;
}

Build WidgetSet::build(const World& world, const Document& document) const {
  std::optional<Vec3d> pivot;
  if (settling_ && settling_->pivot && settling_->target.id == world.state.selected) pivot = settling_->pivot;
  if (drag_ && isGizmo(drag_->handle())) pivot = drag_->anchor();
  return buildAll(world, document, pivot);
}

std::vector<Handle> WidgetSet::handles(const World& world) const {
  return build(world, shown(world)).handles;
}

void WidgetSet::selectNew(World& world) {
  if (expected_ == 0) return;
  const bool there = world.document.guide(expected_) != nullptr;
  if (there) world.state.selected = expected_;
  if (there || world.timeS > expectedUntilS_) expected_ = 0;
}

bool WidgetSet::handle(World& world, const Grip& grip) {
  const size_t hand = grip.stylus ? 1 : 0;
  const bool pressed = grip.down && !wasDown_[hand];
  wasDown_[hand] = grip.down;
  selectNew(world);
  if (settling_ &&
      (world.timeS > settling_->untilS || sameSubject(readSubject(world, settling_->target), settling_->subject)))
    settling_.reset();
  if (!grip.down) ignored_[hand] = false;
  if (ignored_[hand]) return true;

  if (placing_) {
    hover_[hand].reset();
    if (pressed) placedByPress_ = true;
    if (placing_->follow(world, grip)) complete(world);
    return true;
  }
  if (drag_ && drag_->stylus() == grip.stylus) {
    // An undo took it away.
    if (std::holds_alternative<std::monostate>(readSubject(world, drag_->handle().target))) {
      drag_.reset();
      ignored_[hand] = grip.down;
      return true;
    }
    const Document document = shown(world);
    if (drag_->follow(world, document, grip)) {
      writeSubject(world, drag_->handle().target, drag_->now(), drag_->label(document), drag_->merge());
      for (const auto& [target, start] : others_) {
        Subject next = start;
        drag_->handle().apply(next, drag_->handle(), drag_->change());
        writeSubject(world, target, next, drag_->label(document), drag_->merge());
      }
    }
    if (!grip.down) letGo(world);
    return true;
  }
  if (grip.down && !pressed) return false;  // Pressed elsewhere: on clay, or on a panel.

  const Document document = shown(world);
  Build all = build(world, document);
  if (!grip.stylus && brushInHand(world))
    std::erase_if(all.handles,
                  [&](const Handle& each) { return each.body && document.guide(each.target.id) != nullptr; });
  const auto picked = pickHandle(all.handles, grip, world.screen, world.toolRadiusMm, [&] {
    if (grip.stylus) return true;  // What is not selected is not in the way of a stylus that cuts.
    return world.pick && world.pick(grip.origin, grip.direction).has_value();
  });
  if (!picked) {
    hover_[hand].reset();
    return false;
  }
  hover_[hand] = all.handles[picked->index];
  if (pressed && !drag_) press(world, *hover_[hand], picked->point, grip);
  return true;
}

// What is moved and turned along by a gizmo: the rest of the selection, as it is now.
std::vector<std::pair<Target, Subject>> WidgetSet::othersThan(const World& world, const Handle& handle) {
  std::vector<std::pair<Target, Subject>> others;
  if (!isGizmo(handle) || handle.apply != applyRigid) return others;
  for (const engine::Id id : world.state.selection()) {
    const engine::Thing* thing = world.document.thing(id);
    if (!thing || thing->locked || id == handle.target.id) continue;
    const Target target{Target::Kind::thing, id};
    others.emplace_back(target, readSubject(world, target));
  }
  return others;
}

void WidgetSet::press(World& world, const Handle& handle, const Vec3d& at, const Grip& grip) {
  Subject start =
      settling_ && settling_->target == handle.target ? settling_->subject : readSubject(world, handle.target);
  settling_.reset();
  point_.reset();
  others_.clear();
  if (handle.target.kind == Target::Kind::thing) {
    if (grip.adds && !world.state.isSelected(handle.target.id))
      world.state.toggleSelected(handle.target.id);
    else if (!world.state.isSelected(handle.target.id))
      world.state.selected = handle.target.id;
    others_ = othersThan(world, handle);
    if (handle.name == "point") point_ = {handle.target.id, size_t(handle.index)};
    if (handle.name == "insert") point_ = {handle.target.id, size_t(handle.index) + 1};
  }
  drag_.emplace(handle, at, std::move(start), grip, world.screen, fmt::format("widget {}", ++drags_));
}

void WidgetSet::letGo(World& world) {
  if (const auto* held = std::get_if<HeldScale>(&drag_->now())) {
    world.state.scaled.reset();
    if (held->factors != Vec3d::Ones() && world.scale)
      world.scale(drag_->handle().target.id, held->factors, held->aboutMm);
  } else if (drag_->changed()) {
    // All moves of a deform box are one step; a plane to cut along is no step.
    const Target::Kind kind = drag_->handle().target.kind;
    if (kind != Target::Kind::lattice && kind != Target::Kind::cut) world.endMerge();
    std::optional<Vec3d> pivot;
    if (isGizmo(drag_->handle())) pivot = drag_->anchor();
    settling_ = Settling{drag_->handle().target, drag_->now(), pivot, world.timeS + kSettleS};
  } else if (drag_->handle().name == "insert") {
    point_.reset();
  }
  drag_.reset();
}

void WidgetSet::escape(World& world) {
  if (drag_) {
    const size_t hand = drag_->stylus() ? 1 : 0;
    if (drag_->changed()) {
      writeSubject(world, drag_->handle().target, drag_->start(), drag_->label(world.document), drag_->merge());
      for (const auto& [target, start] : others_)
        writeSubject(world, target, start, drag_->label(world.document), drag_->merge());
      world.endMerge();
      if (drag_->handle().target.kind != Target::Kind::scale)
        settling_ = Settling{drag_->handle().target, drag_->start(), {}, world.timeS + kSettleS};
    }
    drag_.reset();
    hover_[hand].reset();
    point_.reset();
    ignored_[hand] = wasDown_[hand];
  } else if (placing_) {
    placing_.reset();
    ignored_ = wasDown_;
  } else {
    world.state.selected = 0;
    world.state.gizmo = GizmoMode::none;
    point_.reset();
  }
}

bool WidgetSet::finish(World& world) {
  if (!placing_ || !placing_->finish(world)) return false;
  complete(world);
  return true;
}

bool WidgetSet::removePoint(World& world) {
  if (placing_) return placing_->stepBack();
  if (drag_ || !point_) return false;
  const auto [id, index] = *point_;
  const Guide* guide = world.document.guide(id);
  point_.reset();
  if (!guide || guide->locked || guide->kind != Guide::Kind::curve || index >= guide->pointsMm.size() ||
      guide->pointsMm.size() <= (guide->closed ? 3u : 2u))
    return false;
  world.edit(fmt::format("Delete a point of {}", guide->name),
             [id, index](Document& document) {
               Guide* there = document.guide(id);
               if (there && index < there->pointsMm.size())
                 there->pointsMm.erase(there->pointsMm.begin() + ptrdiff_t(index));
             },
             {});
  settling_.reset();
  return true;
}

void WidgetSet::place(World& world, const std::string& kind) {
  if (!Placing::knows(kind)) return;
  if (drag_) letGo(world);
  world.state.selected = 0;
  hover_ = {};
  placing_.emplace(kind);
  placedByPress_ = false;
}

void WidgetSet::complete(World& world) {
  const auto guide = placing_->result(world);
  placing_.reset();
  ignored_ = wasDown_;  // The press that ended it grabs nothing.
  if (!guide) return;
  expected_ = world.document.nextId;
  expectedUntilS_ = world.timeS + kSettleS;
  static constexpr std::array<const char*, 7> names{"plane", "line", "point", "curve", "box", "ruler", "angle"};
  const std::string_view name = names[size_t(guide->kind)];
  world.edit(fmt::format("Add {} {}", name.starts_with('a') ? "an" : "a", name),
             [guide = *guide](Document& document) { document.add(guide); }, {});
}

bool WidgetSet::click(World& world, const Grip& grip) {
  if (placedByPress_) {
    placedByPress_ = false;
    return true;
  }
  if (placing_) {
    if (placing_->click(world, grip)) complete(world);
    return true;
  }
  // Guides stand in front of what they guide.
  const Document document = shown(world);
  Build all = build(world, document);
  for (Handle& handle : all.handles) handle.besideClay = false;
  engine::Id id = 0;
  if (const auto picked = pickHandle(all.handles, grip, world.screen, world.toolRadiusMm, nullptr)) {
    if (all.handles[picked->index].target.kind == Target::Kind::thing) id = all.handles[picked->index].target.id;
  }
  if (id == 0 && !grip.stylus && world.pickThing) id = world.pickThing({grip.origin, grip.direction});
  if (grip.adds) {
    world.state.toggleSelected(id);
    return true;
  }
  const bool was = world.state.selected != 0;
  world.state.selected = id;
  return id != 0 || was;
}

void WidgetSet::draw(const World& world, render::Overlays& overlays) const {
  const Document document = shown(world);
  Build all = build(world, document);
  std::vector<const Handle*> hot;
  if (drag_) {
    hot.push_back(&drag_->handle());
  } else {
    for (const auto& hover : hover_)
      if (hover) hot.push_back(&*hover);
  }
  if (placing_) {
    all.handles.clear();
    if (const auto guide = placing_->preview(world)) {
      Stance stance;
      stance.selected = true;
      stance.grabbed = false;
      buildGuide(all, *guide, stance);
    }
    for (const Vec3d& p : placing_->points()) {
      Handle dot;
      dot.name = "placed";
      dot.points = {p};
      dot.colour = widget_colours::kHot;
      all.handles.push_back(dot);
    }
    if (placing_->spot()) {
      Handle dot;
      dot.name = "next";
      dot.points = {*placing_->spot()};
      dot.colour = widget_colours::kHandle;
      all.handles.push_back(dot);
    }
    if (placing_->snap()) mark(all, *placing_->snap());
  }
  if (drag_) {
    const Handle& handle = drag_->handle();
    if (drag_->changed() && (handle.way == Way::along || handle.way == Way::about)) {
      // The way that it goes: a thin line through all.
      const double far = 4 * all.extentMm();
      all.line({drag_->anchor() - far * handle.axis, drag_->anchor() + far * handle.axis},
               faded(widget_colours::kHot, 0.35f), 1.2f);
    }
    if (drag_->snap()) mark(all, *drag_->snap());
  }
  drawHandles(all, hot);
  overlays.fills.insert(overlays.fills.end(), std::make_move_iterator(all.fills.begin()),
                        std::make_move_iterator(all.fills.end()));
  overlays.polylines.insert(overlays.polylines.end(), std::make_move_iterator(all.lines.begin()),
                            std::make_move_iterator(all.lines.end()));
  overlays.planes.insert(overlays.planes.end(), all.planes.begin(), all.planes.end());
}

std::vector<Widgets::Label> WidgetSet::labels(const World& world) const {
  const Document document = shown(world);
  Build all = build(world, document);
  if (placing_) {
    if (const auto guide = placing_->preview(world)) buildGuide(all, *guide, {.selected = true, .grabbed = false});
  }
  std::vector<Widgets::Label> labels;
  const auto add = [&](const Vec3d& at, const std::string& text, const render::Colour& colour, float below) {
    if (!world.screen.seen(at)) return;
    const Vec3d p = world.screen.project(at);
    labels.push_back({float(p.x()) + kLabelAside, float(p.y()) + below, text, colour});
  };
  for (const Build::Text& text : all.texts) add(text.at, text.text, text.colour, -kLabelAside);
  if (drag_ && drag_->changed()) {
    std::string text = drag_->text();
    if (const auto* held = std::get_if<HeldScale>(&drag_->now()); held && world.boundsOf) {
      const Vec3d size = world.boundsOf(drag_->handle().target.id).size();
      text += "  ·  " + lengthText(size.x()) + " × " + lengthText(size.y()) + " × " + lengthText(size.z());
    }
    if (drag_->snap()) text += "  ·  " + drag_->snap()->text;
    add(drag_->anchor(), text, widget_colours::kHot, kLabelAside);
  } else if (!drag_) {
    for (const auto& hover : hover_) {
      if (!hover || hover->target.kind != Target::Kind::thing || !hover->body ||
          hover->target.id == world.state.selected)
        continue;
      if (const engine::Thing* thing = document.thing(hover->target.id))
        add(hover->points.front(), thing->name, widget_colours::kHot, kLabelAside);
    }
  }
  if (placing_ && placing_->snap() && placing_->spot())
    add(*placing_->spot(), placing_->snap()->text, widget_colours::kSnap, kLabelAside);
  return labels;
}

}  // namespace argil::studio
