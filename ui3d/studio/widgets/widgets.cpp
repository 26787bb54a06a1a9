#include "ui3d/studio/widgets/widgets.h"

#include "haptics/scene/part_mesh.h"
#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/widgets/widget_set.h"

namespace argil::studio {
namespace {

// Clay by the operation, whose result is shown before it is there; a part at once, with its mesh.
void scaleThing(const Context& context, engine::Id id, const Vec3d& factors, const Vec3d& aboutMm) {
  const engine::Document& document = *context.now.document;
  if (const engine::Piece* piece = document.piece(id)) {
    engine::PieceArguments arguments;
    arguments.pieces = {id};
    auto& values = arguments.change<engine::ScaleValues>();
    int axis = 0;
    (factors - Vec3d::Ones()).cwiseAbs().maxCoeff(&axis);
    values.percent = 100 * factors[axis];
    const bool alike = factors == Vec3d::Constant(factors[axis]);
    if (alike)
      values.aboutMm = aboutMm;
    else
      arguments.plane = {aboutMm, Vec3d::Unit(axis)};
    context.state.growing = GrownPiece{.piece = id, .factors = factors, .aboutMm = aboutMm, .before = piece->version};
    context.state.grown = context.state.growing;
    context.bench.operate(alike ? "scale" : "stretch", arguments);
  } else if (const engine::Part* part = document.part(id)) {
    context.bench.edit("Scale " + part->name, [id, factors, aboutMm](engine::Document& d) {
      engine::Part* each = d.part(id);
      if (!each || !each->mesh) return;
      auto mesh = std::make_shared<clay::TriangleMesh>(*each->mesh);
      const Eigen::Quaterniond& turn = each->pose.rotation;
      for (Vec3d& position : mesh->positions)
        position = turn.conjugate() * factors.cwiseProduct(Vec3d(turn * position));
      each->felt = std::make_shared<const haptics::PartMesh>(*mesh);
      each->mesh = std::move(mesh);
      each->pose.translation = aboutMm + factors.cwiseProduct(each->pose.translation - aboutMm);
    });
  }
}

World worldOf(const Context& context) {
  World world(*context.now.document, context.state, ScreenMap(context.camera.view(), context.width, context.height));
  world.timeS = context.timeS;
  world.toolRadiusMm = context.now.tool.radiusMm;
  world.bounds = context.renderer.bounds();
  const render::Renderer& renderer = context.renderer;
  const StudioState& state = context.state;
  engine::Workbench& bench = context.bench;
  // A mouse has no reach.
  if (state.showWorkspaceBox && !bench.usesPointer()) world.reachMm = bench.touch(false).sheet.workspaceMm;
  world.pick = [&renderer, &state](const Vec3d& origin,
                                   const Vec3d& direction) -> std::optional<render::Cursor::Footprint> {
    const auto hit = renderer.pick(origin, direction, state.look.section);
    if (!hit) return {};
    return render::Cursor::Footprint{origin + hit->distanceMm * direction.normalized(), hit->normal};
  };
  world.pickThing = [&renderer, &state](const Ray& ray) -> engine::Id {
    const auto hit = renderer.pick(ray.origin, ray.direction, state.look.section);
    return hit ? hit->piece : 0;
  };
  world.boundsOf = [&renderer](engine::Id id) { return renderer.bounds(id); };
  world.edit = [&bench](std::string label, std::function<void(engine::Document&)> change, std::string merge) {
    bench.edit(std::move(label), std::move(change), std::move(merge));
  };
  world.endMerge = [&bench] { bench.endMerge(); };
  world.scale = [&context](engine::Id id, const Vec3d& factors, const Vec3d& aboutMm) {
    scaleThing(context, id, factors, aboutMm);
  };
  world.setWorkspace = [&bench](const haptics::Workspace& workspace) { bench.setWorkspace(workspace); };
  return world;
}

}  // namespace

struct Widgets::State {
  WidgetSet set;
};

Widgets::Widgets() : state_(std::make_unique<State>()) {}
Widgets::~Widgets() = default;

bool Widgets::handle(Context& context, const Grip& grip) {
  World world = worldOf(context);
  return state_->set.handle(world, grip);
}

void Widgets::escape(Context& context) {
  World world = worldOf(context);
  state_->set.escape(world);
}

bool Widgets::finish(Context& context) {
  World world = worldOf(context);
  return state_->set.finish(world);
}

bool Widgets::removePoint(Context& context) {
  World world = worldOf(context);
  return state_->set.removePoint(world);
}

bool Widgets::held() const {
  return state_->set.held();
}

bool Widgets::click(Context& context, const Grip& grip) {
  World world = worldOf(context);
  return state_->set.click(world, grip);
}

void Widgets::place(Context& context, const std::string& kind) {
  World world = worldOf(context);
  state_->set.place(world, kind);
}

bool Widgets::placing() const {
  return state_->set.placing();
}
std::string Widgets::hint() const {
  return state_->set.hint();
}

void Widgets::draw(const Context& context, render::Overlays& overlays) const {
  state_->set.draw(worldOf(context), overlays);
}

std::vector<Widgets::Label> Widgets::labels(const Context& context) const {
  return state_->set.labels(worldOf(context));
}

}  // namespace argil::studio
