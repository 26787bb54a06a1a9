#pragma once
// Widgets without a window: a document that takes its edits at once, clay that is a ball, and hands.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "engine/session/workbench.h"
#include "ui3d/studio/widgets/widget_set.h"

namespace argil::studio::test {

inline constexpr double kWidth = 1280, kHeight = 720;

class Rig {
 public:
  explicit Rig(const render::View& from = render::View::named("front", box(100), kWidth / kHeight)) : view(from) {}

  static render::Box box(double edge) {
    render::Box result;
    result.add(Vec3d::Constant(-0.5 * edge));
    result.add(Vec3d::Constant(0.5 * edge));
    return result;
  }

  World world() {
    World world(document, state, ScreenMap(view, kWidth, kHeight));
    world.timeS = timeS;
    world.bounds = box(100);
    world.toolRadiusMm = 3;
    if (state.showWorkspaceBox) world.reachMm = Vec3d::Constant(100);
    if (clayRadius > 0) {
      world.pick = [this](const Vec3d& origin, const Vec3d& direction) -> std::optional<render::Cursor::Footprint> {
        const double b = origin.dot(direction), c = origin.squaredNorm() - clayRadius * clayRadius, d = b * b - c;
        if (d < 0) return {};
        const double t = -b - std::sqrt(d) >= 0 ? -b - std::sqrt(d) : -b + std::sqrt(d);
        if (t < 0) return {};
        const Vec3d p = origin + t * direction;
        return render::Cursor::Footprint{p, p.normalized()};
      };
    }
    world.boundsOf = [this](engine::Id id) {
      render::Box result = box(40);
      if (const auto* piece = document.piece(id))
        result.min += piece->pose.translation, result.max += piece->pose.translation;
      return result;
    };
    world.edit = [this](const std::string& label, const std::function<void(engine::Document&)>& change,
                        const std::string& merge) {
      ++edits;
      if (bench) return bench->edit(label, change, merge);
      change(document);
      if (merge.empty() || merge != openMerge) labels.push_back(label);
      openMerge = merge;
    };
    world.endMerge = [this] {
      if (bench) return bench->endMerge();
      openMerge.clear();
    };
    world.setWorkspace = [this](const haptics::Workspace& w) { workspaces.push_back(w); };
    return world;
  }

  Grip mouse(double x, double y, bool down = false) const {
    const Ray ray = ScreenMap(view, kWidth, kHeight).ray(x, y);
    Grip grip;
    grip.origin = ray.origin;
    grip.direction = ray.direction;
    grip.down = down;
    return grip;
  }
  Grip at(const Vec3d& p, bool down = false) const {
    const Vec3d s = ScreenMap(view, kWidth, kHeight).project(p);
    return mouse(s.x(), s.y(), down);
  }
  static Grip tip(const Vec3d& p, bool down = false) {
    Grip grip;
    grip.origin = p;
    grip.stylus = true;
    grip.down = down;
    return grip;
  }

  bool hand(Grip grip) {
    grip.constrain = constrain;
    grip.snapOff = !snapping;
    if (bench) document = *bench->snapshot()->document;
    World w = world();
    timeS += 0.01;
    return widgets.handle(w, grip);
  }
  /// Hovers, presses, goes there in so many events, lets go.
  void drag(const Grip& from, const Grip& to, int events = 10) {
    Grip a = from, b = to;
    a.down = false;
    hand(a);
    a.down = true;
    hand(a);
    const ScreenMap screen(view, kWidth, kHeight);
    for (int i = 1; i <= events; ++i) {
      const double part = double(i) / events;
      if (a.stylus) {
        hand(tip(a.origin + part * (b.origin - a.origin), true));
      } else {
        const Vec3d p = screen.place({a.origin, a.direction}), q = screen.place({b.origin, b.direction});
        hand(mouse(p.x() + part * (q.x() - p.x()), p.y() + part * (q.y() - p.y()), true));
      }
    }
    b.down = false;
    hand(b);
  }
  void press(const Grip& grip) {
    Grip g = grip;
    hand(g);
    g.down = true;
    hand(g);
    g.down = false;
    hand(g);
  }

  Handle handle(std::string_view name, int index = 0) {
    World w = world();
    for (const Handle& each : widgets.handles(w))
      if (each.name == name && each.index == index) return each;
    ADD_FAILURE() << "no handle " << name << " " << index;
    return {};
  }
  bool has(std::string_view name) {
    World w = world();
    for (const Handle& each : widgets.handles(w))
      if (each.name == name) return true;
    return false;
  }
  /// In the picture, as parts of the window's height.
  Vec3d place(const Vec3d& p) const {
    const Vec3d s = ScreenMap(view, kWidth, kHeight).project(p);
    return {s.x() / kHeight, s.y() / kHeight, 0};
  }

  engine::Guide& add(engine::Guide guide) {
    const engine::Id id = document.add(std::move(guide));
    state.selected = id;
    return *document.guide(id);
  }
  engine::Guide& addPlane(const Vec3d& at = Vec3d::Zero(), const Vec3d& normal = Vec3d::UnitZ()) {
    engine::Guide guide;
    guide.kind = engine::Guide::Kind::plane;
    guide.pose.translation = at;
    guide.pose.rotation = haptics::rotationBetween(Vec3d::UnitZ(), normal);
    return add(guide);
  }
  engine::Guide& selected() { return *document.guide(state.selected); }

  engine::Document document;
  StudioState state;
  /// Else edits are done at once, and join the last step where both have the same key.
  engine::Workbench* bench = nullptr;
  render::View view;
  WidgetSet widgets;
  double clayRadius = 0;
  double timeS = 0;
  bool snapping = false, constrain = false;
  int edits = 0;
  std::vector<std::string> labels;  // Of undo steps.
  std::string openMerge;
  std::vector<haptics::Workspace> workspaces;
};

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) { testing::Test::RecordProperty("seed", int(seed)); }
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  Vec3d vector(double size = 1) { return size * Vec3d(between(-1, 1), between(-1, 1), between(-1, 1)); }
  Eigen::Quaterniond rotation() {
    return Eigen::Quaterniond(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
  }
  /// Looks at what is about zero.
  render::View view() {
    render::View view;
    view.projection = between(0, 1) < 0.5 ? render::Projection::perspective : render::Projection::orthographic;
    view.target = vector(10);
    Vec3d from;
    do from = vector();
    while (from.norm() < 0.3);
    view.position = view.target + 200 * from.normalized();
    view.openingDegrees = between(15, 60);
    return view;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace argil::studio::test
