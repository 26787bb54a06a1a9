// What a hand feels tick by tick, held against figures that were kept: each kind of contact, guide, device, material,
// texture and setting once by itself, in virtual time.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/scene/polyline.h"
#include "haptics/scene/texture.h"
#include "haptics/servo/servo.h"
#include "tests/figures/kept_figures.h"

namespace argil::haptics {
namespace {

// A block with its top at z = 0; half of it is of material 1 in its channel.
clay::Version block() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  grid.originMm = Vec3d(0.12, 0.07, -0.03);
  static const clay::Version made = [&] {
    const clay::Version bare = clay::makeBlock(clay::Store::make(), grid, {0, 0, -8}, {36, 30, 16}, 2);
    clay::Editor editor(bare);
    std::array<uint8_t, clay::kBrickVoxels> values;
    bare.forEachBrick([&](const clay::Brick& brick) {
      if (brick.coord.x < 0) return;
      for (size_t v = 0; v < values.size(); ++v) values[v] = std::abs(brick.phi(int(v))) < grid.band ? 1 : 0;
      editor.setChannel(clay::Channel::material, brick.coord, values);
    });
    return editor.commit();
  }();
  return made;
}

clay::TriangleMesh roof() {
  clay::TriangleMesh mesh;
  mesh.positions = {{-6, -8, 1}, {6, -8, 1}, {6, 8, 1}, {-6, 8, 1}, {0, -8, 4}, {0, 8, 4}};
  mesh.triangles = {{0, 4, 5}, {0, 5, 3}, {1, 2, 5}, {1, 5, 4}, {0, 1, 4}, {2, 3, 5}, {0, 3, 2}, {0, 2, 1}};
  return mesh;
}

// Down into the clay, along it with a bend, over its edge and up; a button from 0.15 s to 0.75 s.
HandPath path(double depthMm) {
  std::vector<HandPoint> points;
  const Vec3d places[] = {{-10, -5, 6},
                          {-10, -5, 2.5 - depthMm},
                          {-2, 3, 2.5 - depthMm},
                          {6, -4, 2.2 - depthMm},
                          {14, 2, 2.5 - depthMm},
                          {21, 3, -3},
                          {21, 3, 6}};
  const double times[] = {0, 0.15, 0.35, 0.55, 0.75, 0.9, 1};
  for (size_t i = 0; i < std::size(times); ++i) {
    HandPoint point;
    point.timeS = times[i];
    point.position = places[i];
    point.rotation = Eigen::AngleAxisd(0.3 * double(i), Vec3d::UnitX());
    point.buttons = i >= 1 && i < 4 ? 1 : 0;
    points.push_back(point);
  }
  return HandPath(std::move(points));
}

struct Felt {
  Scene scene;
  std::string device = "touchx", contact = "proxy";
  double rateHz = 1000, depthMm = 1, delayS = 0;
  bool prescribed = false;
};

TEST(Figures, EveryHandFeelsWhatItFelt) {
  tests::KeptFigures kept(std::string(ARGIL_SOURCE_DIR) + "/tests/figures/felt.txt");
  const auto run = [&](const std::string& name, const std::function<void(Felt&)>& change) {
    Felt setup;
    setup.scene.pieces.push_back({block(), Pose(), 0});
    setup.scene.tool.radiusMm = 2.5;
    change(setup);
    setup.scene.check();
    Published<Scene> published;
    published.publish(std::make_unique<const Scene>(setup.scene));
    SimulatedDevice::Options options;
    options.prescribed = setup.prescribed;
    options.delayS = setup.delayS;
    SimulatedDevice device(deviceSheet(setup.device), path(setup.depthMm), options);
    Servo servo(device, published, {.rateHz = setup.rateHz, .contact = setup.contact});
    Vec3d force = Vec3d::Zero(), moved = force, proxy = force, cut = force, motor = force;
    double depth = 0, planes = 0;
    const auto ticks = uint64_t(std::lround(1.1 * setup.rateHz));
    servo.runVirtual(ticks, [&](uint64_t i, double) {
      const StylusSample& sample = servo.tick().last();
      // Later ticks count more, so that the same force at another time is seen.
      const double weight = 1 + double(i) / double(ticks);
      force += weight * sample.forceN;
      moved += weight * sample.device.translation;
      proxy += weight * sample.proxy;
      cut += weight * sample.cutPoint;
      motor += weight * device.motorForce();
      depth += weight * sample.depthMm;
      planes += weight * sample.planes;
    });
    const ServoStatistics& all = servo.statistics();
    std::vector<double> figures{double(all.touching), double(all.cutting), double(all.leaving),    double(all.clamped),
                                double(all.slewed),   double(all.stopped), double(all.incomplete), all.peakForceN};
    for (const Vec3d& sum : {force, moved, proxy, cut, motor})
      for (int k = 0; k < 3; ++k) figures.push_back(sum[k] / double(ticks));
    figures.push_back(depth / double(ticks));
    figures.push_back(planes / double(ticks));
    figures.push_back(servo.heat());
    kept.expect(name, figures);
  };

  for (const std::string_view contact : contactNames()) {
    run("contact/" + std::string(contact), [&](Felt& s) { s.contact = contact; });
    run("contact-prescribed/" + std::string(contact), [&](Felt& s) {
      s.contact = contact;
      s.prescribed = true;
    });
  }
  for (const DeviceSheet& sheet : deviceSheets()) {
    run("device/" + sheet.name, [&](Felt& s) { s.device = sheet.name; });
    run("device-cuts/" + sheet.name, [&](Felt& s) {
      s.device = sheet.name;
      s.scene.tool.work = Work::cut;
    });
  }
  for (const double rate : {500.0, 4000.0}) run("rate/" + std::to_string(int(rate)), [&](Felt& s) { s.rateHz = rate; });
  run("delay", [](Felt& s) { s.delayS = 0.003; });
  run("deep", [](Felt& s) { s.depthMm = 6; });
  run("lay", [](Felt& s) { s.scene.tool.work = Work::lay; });
  run("rub", [](Felt& s) { s.scene.tool.work = Work::rub; });
  run("large-tool", [](Felt& s) { s.scene.tool.radiusMm = 6; });
  run("facets", [](Felt& s) { s.scene.quality.smoothNormals = false; });
  run("few-searches", [](Felt& s) {
    s.scene.quality.contactSearches = 6;
    s.scene.quality.contactSteps = 2;
  });
  run("no-clay", [](Felt& s) { s.scene.pieces.clear(); });

  const auto material = [&](const std::string& name, const std::function<void(Material&)>& change) {
    for (const bool cuts : {false, true})
      run((cuts ? "material-cut/" : "material/") + name, [&](Felt& s) {
        change(s.scene.materials[0]);
        if (cuts) s.scene.tool.work = Work::cut;
      });
  };
  material("soft", [](Material& m) { m.stiffnessNmm = 0.2; });
  material("hard", [](Material& m) { m.hardnessNmm2 = 0.5; });
  material("viscous", [](Material& m) { m.viscosityNsmm = 0.1; });
  material("drag", [](Material& m) { m.dragNsmm = 0.02; });
  material("rough", [](Material& m) {
    m.staticFriction = 0.9;
    m.dynamicFriction = 0.5;
  });
  material("sticky", [](Material& m) { m.viscousFrictionNsmm = 0.02; });
  run("two-materials", [](Felt& s) {
    s.scene.materials.resize(2);
    s.scene.materials[1].stiffnessNmm = 0.3;
    s.scene.materials[1].staticFriction = s.scene.materials[1].dynamicFriction = 0.6;
    auto rows = std::make_shared<MaterialRows>();
    rows->fill(0);
    (*rows)[1] = 1;
    s.scene.pieces[0].rows = rows;
  });
  const std::pair<const char*, Texture> textures[] = {{"ridges", Texture(Ridges{2, 0.1, Vec3d(1, 0.2, 0)})},
                                                      {"bumps", Texture(Bumps{2, 0.1})},
                                                      {"grain", Texture(Grain{2, 0.1, 3, 7})}};
  for (const auto& [name, shape] : textures)
    run(std::string("texture/") + name, [&](Felt& s) {
      s.scene.textures.push_back(std::make_shared<const Texture>(shape));
      s.scene.materials[0].texture = 0;
    });

  const auto part = std::make_shared<const PartMesh>(roof());
  run("part", [&](Felt& s) { s.scene.parts.push_back({part, Pose(), 0}); });
  run("part-alone", [&](Felt& s) {
    s.scene.pieces.clear();
    s.scene.parts.push_back({part, Pose(), 0});
    s.scene.materials[0].staticFriction = s.scene.materials[0].dynamicFriction = 0.4;
  });
  run("turned-piece", [](Felt& s) {
    s.scene.pieces[0].pose.rotation = Eigen::AngleAxisd(0.2, Vec3d(1, 0.5, 0.2).normalized());
    s.scene.pieces[0].pose.translation = Vec3d(1, 2, 0.5);
  });
  run("two-pieces", [](Felt& s) {
    clay::Grid grid;
    grid.voxelMm = 0.4;
    Pose pose;
    pose.translation = Vec3d(2, 0, 0);
    s.scene.pieces.push_back({clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 4), pose, 0});
    s.scene.workedOn = 1;
    s.scene.tool.work = Work::cut;
  });

  const auto workspace = [&](const std::string& name, const std::function<void(Workspace&)>& change) {
    run("workspace/" + name, [&](Felt& s) { change(s.scene.workspace); });
  };
  workspace("scaled", [](Workspace& w) { w.scale = 0.7; });
  workspace("turned", [](Workspace& w) { w.pose.rotation = Eigen::AngleAxisd(0.3, Vec3d::UnitZ()); });
  workspace("left", [](Workspace& w) { w.frame = Handedness::left; });
  workspace("depth", [](Workspace& w) { w.depthMm = -1; });
  workspace("clutch", [](Workspace& w) { w.clutchButtons = 1; });
  workspace("walls", [](Workspace& w) {
    w.walls.on = true;
    w.walls.share = 0.15;
  });

  const auto curve =
      std::make_shared<const Polyline>(std::vector<Vec3d>{{-12, -4, 2}, {-4, 3, 3}, {5, -3, 2}, {14, 3, 2.5}});
  const WellShape well{4, 1};
  const auto guide = [&](const std::string& name, auto shape, uint32_t whileButtons = 0) {
    run("guide/" + name, [&](Felt& s) { s.scene.guides.push_back({1, shape, whileButtons}); });
    run("guide-cuts/" + name, [&](Felt& s) {
      s.scene.guides.push_back({1, shape, whileButtons});
      s.scene.tool.work = Work::cut;
    });
  };
  guide("point", LockToPoint{{-3, 0, 2}});
  guide("line", LockToLine{{0, 0, 2}, {1, 0.1, 0}});
  guide("plane", LockToPlane{{0, 0, 2.2}, {0.1, 0, 1}});
  guide("curve", LockToCurve{curve});
  guide("normal", LockToNormal{}, 1);
  guide("box", KeepOutBox{Pose(), Vec3d(4, 4, 5), false});
  guide("ball", KeepOutBall{{2, 0, 0}, 5, false});
  guide("in-ball", KeepOutBall{{0, 0, 2}, 13, true});
  guide("wall", KeepOutPlane{{0, 0, 1}, {0, 0.1, 1}});
  guide("well-points", WellAtPoints{{{-2, 3, 2}, {8, -2, 2}}, well});
  guide("well-curve", WellAtCurve{curve, well});
  guide("well-plane", WellAtPlane{{0, 0, 3}, {0, 0.1, 1}, well});
  guide("well-piece", WellAtPiece{0, well});
  guide("gravity", Gravity{{0.1, 0, -0.4}});
  guide("buoyancy", Buoyancy{{0, 0, 4}, {0, 0, 1}, 0.5, 4});
  guide("viscosity", Viscosity{0.001});
  guide("ambient", AmbientPlane{{0, 0, 3}, {0, 0.1, 1}, 0.2, 1});
  guide("by-button", AmbientPlane{{0, 0, 3}, {0, 0.1, 1}, 0.2, 1}, 1);
  run("two-guides", [&](Felt& s) {
    s.scene.guides.push_back({1, LockToPlane{{0, 0, 2.2}, {0, 0, 1}}, 0});
    s.scene.guides.push_back({2, LockToPlane{{0, 1, 0}, {0, 1, 0.1}}, 1});
    s.scene.guides.push_back({3, WellAtPoints{{{3, 1, 2.2}}, well}, 0});
  });
}

}  // namespace
}  // namespace argil::haptics
