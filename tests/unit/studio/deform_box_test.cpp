// The deform box: points in the hand, and the clay that follows them.

#include "ui3d/studio/view/deform_box.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/deform.h"
#include "tests/unit/studio/widget_rig.h"
#include "ui3d/studio/view/deforming.h"

namespace argil::studio {
namespace {

using test::Rig;

/// A document with a ball, its deform box, and what the workbench would do.
struct Scene {
  Scene() {
    rig.document = engine::Document::of(clay::makeSphere(clay::Store::make(), clay::Grid{1.0}, Vec3d::Zero(), 20));
    rig.state.deformBox = DeformBox::around(rig.document.pieces[0]);
  }
  bool update(bool held = false) {
    return deforming.update(
        rig.state.deformBox, rig.document, held,
        [this](const std::string& label, const std::function<void(engine::Document&)>& change,
               const std::string& merge) { rig.world().edit(label, change, merge); },
        [this] { rig.world().endMerge(); });
  }
  /// Until the clay has followed; generous, as the machine may be busy.
  bool settle() {
    for (int i = 0; i < 20000; ++i) {
      update();
      if (!deforming.busy()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  std::optional<DeformBox>& box() { return rig.state.deformBox; }
  const clay::Version& version() const { return rig.document.pieces[0].version; }

  Rig rig{render::View::named("iso", Rig::box(60), test::kWidth / test::kHeight)};
  Deforming deforming;
};

TEST(DeformBox, APointInTheHandTakesItsPlaceOfTheGridAlong) {
  Scene scene;
  const size_t index = scene.box()->lattice.index(3, 1, 3);
  const Vec3d from = scene.box()->lattice.restPoint(index);
  // In the plane of the picture.
  const Vec3d to = from + 8 * ScreenMap(scene.rig.view, test::kWidth, test::kHeight).axes().right;
  scene.rig.drag(scene.rig.at(from), scene.rig.at(to));
  Eigen::Matrix3d unused;
  EXPECT_LE((scene.box()->lattice.map(from, unused) - to).norm(), 0.2);
  EXPECT_EQ(scene.rig.edits, 0);  // The clay is changed by what follows the box, not by the widget.
  // Escape in mid-drag takes it back.
  Grip grip = scene.rig.at(to);
  scene.rig.hand(grip);
  grip.down = true;
  scene.rig.hand(grip);
  Grip far = scene.rig.at(to + Vec3d(10, 0, 0), true);
  scene.rig.hand(far);
  EXPECT_GT((scene.box()->lattice.map(from, unused) - to).norm(), 5);
  World world = scene.rig.world();
  scene.rig.widgets.escape(world);
  EXPECT_LE((scene.box()->lattice.map(from, unused) - to).norm(), 0.2);
}

TEST(DeformBox, TheClayFollowsWhenThePointIsLetGoAndIsOneStep) {
  Scene scene;
  const clay::Version base = scene.version();
  ASSERT_TRUE(scene.settle());
  EXPECT_EQ(scene.version(), base);
  for (int i = 0; i < 3; ++i) {
    scene.box()->lattice.drag({20, 0, 0}, {3, 0, 0});
    scene.update(true);
    EXPECT_FALSE(scene.deforming.busy());  // Not while it is held.
    ASSERT_TRUE(scene.settle());
    scene.update();
    EXPECT_FALSE(scene.update());  // At rest: nothing is drawn anew.
    EXPECT_EQ(scene.version().hash(), clay::deform(base, scene.box()->lattice, clay::Store::make()).hash());
  }
  EXPECT_EQ(scene.rig.labels, std::vector<std::string>{"Deform"});
  scene.box()->apply = true;
  ASSERT_TRUE(scene.settle());
  EXPECT_FALSE(scene.box());
  EXPECT_NE(scene.version(), base);
}

TEST(DeformBox, CancelBringsTheClayBack) {
  Scene scene;
  const clay::Version base = scene.version();
  scene.box()->kind = DeformBox::Kind::taper;
  scene.box()->taperPercent = 60;
  ASSERT_TRUE(scene.settle());
  EXPECT_NE(scene.version(), base);
  scene.box()->taperPercent = 50;
  scene.update();  // Cancelled while it is on its way.
  scene.box()->cancel = true;
  scene.update();
  EXPECT_FALSE(scene.box());
  EXPECT_EQ(scene.version(), base);
}

TEST(DeformBox, AFoldIsToldAndNothingIsDone) {
  Scene scene;
  const clay::Version base = scene.version();
  scene.box()->kind = DeformBox::Kind::bend;
  scene.box()->bendDegrees = 300;
  ASSERT_TRUE(scene.settle());
  EXPECT_NE(scene.box()->trouble.find("folds"), std::string::npos) << scene.box()->trouble;
  EXPECT_EQ(scene.version(), base);
  scene.box()->bendDegrees = 20;
  ASSERT_TRUE(scene.settle());
  EXPECT_TRUE(scene.box()->trouble.empty());
  EXPECT_NE(scene.version(), base);
}

TEST(DeformBox, GoesWhenSomebodyElseChangesTheClay) {
  Scene scene;
  scene.update();
  scene.rig.document.pieces[0].version = clay::makeSphere(clay::Store::make(), clay::Grid{1.0}, Vec3d::Zero(), 10);
  EXPECT_TRUE(scene.update());
  EXPECT_FALSE(scene.box());
  Scene other;
  other.update();
  other.rig.document.pieces.clear();
  other.update();
  EXPECT_FALSE(other.box());
}

TEST(DeformBox, ACornerTakesTheClayBelowItAlong) {
  const auto store = clay::Store::make();
  const clay::Version clays[] = {clay::makeBlock(store, clay::Grid{0.25}, Vec3d::Zero(), {40, 40, 40}, 0),
                                 clay::makeBlock(store, clay::Grid{0.25}, Vec3d::Zero(), {60, 30, 20}, 2),
                                 clay::makeSphere(store, clay::Grid{1.0}, Vec3d::Zero(), 20)};
  const Vec3d corners[] = {{19.5, 19.5, 19.5}, {29.2, 14.2, 9.2}, {11.5, 11.5, 11.5}};
  // Of the hand's way: a block's corner goes along, a ball has its surface at half of the way to the corner.
  const double least[] = {0.7, 0.5, 0.4};
  for (int i = 0; i < 3; ++i) {
    Scene scene;
    scene.rig.document = engine::Document::of(clays[i]);
    scene.rig.state.deformBox = DeformBox::around(scene.rig.document.pieces[0]);
    const size_t index = scene.box()->lattice.index(3, 3, 3);
    const Vec3d from = scene.box()->lattice.restPoint(index);
    const Vec3d by = 8 * ScreenMap(scene.rig.view, test::kWidth, test::kHeight).axes().right;
    scene.rig.drag(scene.rig.at(from), scene.rig.at(from + by));
    Eigen::Matrix3d unused;
    EXPECT_LE((scene.box()->lattice.map(from, unused) - (from + by)).norm(), 0.2) << "the point is in the hand";
    const Vec3d moved = scene.box()->lattice.map(corners[i], unused) - corners[i];
    EXPECT_GT(moved.dot(by) / by.squaredNorm(), least[i]) << i;
    EXPECT_LT(moved.dot(by) / by.squaredNorm(), 1.2) << i;
  }
}

TEST(DeformBox, ApplyTakesAllTabs) {
  Scene scene;
  const clay::Version base = scene.version();
  scene.box()->lattice.drag({20, 0, 0}, {4, 0, 0});
  scene.box()->twistDegrees = 60;
  scene.box()->taperPercent = 80;
  scene.box()->kind = DeformBox::Kind::bend;  // the tab that is shown, in which nothing is set
  ASSERT_TRUE(scene.settle());
  const auto warp = scene.box()->warp();
  ASSERT_TRUE(warp);
  clay::WarpAxis axis{.originMm = Vec3d::Zero(), .direction = Vec3d::UnitZ(), .fromMm = -20, .toMm = 20};
  axis.fromMm = scene.box()->bounds.low.z(), axis.toMm = scene.box()->bounds.high.z();
  const clay::Twist twist(axis, 60 * 0.017453292519943295);
  const clay::Taper taper(axis, 0.8);
  for (const Vec3d& p : {Vec3d(18, 0, 3), Vec3d(-7, 9, 12), Vec3d(0, -15, -10)}) {
    Eigen::Matrix3d slope, unused;
    const Vec3d wanted = twist.map(taper.map(scene.box()->lattice.map(p, unused), unused), unused);
    EXPECT_LT((warp->map(p, slope) - wanted).norm(), 1e-9);
    for (int k = 0; k < 3; ++k) {
      const Vec3d step = 1e-5 * Vec3d::Unit(k);
      EXPECT_LT(((warp->map(p + step, unused) - warp->map(p - step, unused)) / 2e-5 - slope.col(k)).norm(), 1e-5);
    }
  }
  EXPECT_EQ(scene.version().hash(), clay::deform(base, *warp, clay::Store::make()).hash());
  const uint64_t all = scene.version().hash();
  scene.box()->apply = true;
  ASSERT_TRUE(scene.settle());
  EXPECT_FALSE(scene.box());
  EXPECT_EQ(scene.version().hash(), all);
}

TEST(DeformBox, RestsAfterOtherCounts) {
  Scene scene;
  scene.box()->lattice.drag({20, 0, 0}, {3, 0, 0});
  EXPECT_TRUE(scene.box()->warp());
  scene.box()->setCounts({2, 3, 8});
  EXPECT_FALSE(scene.box()->warp());
  size_t dots = 0;
  World world = scene.rig.world();
  for (const Handle& handle : scene.rig.widgets.handles(world)) dots += handle.name == "lattice point";
  EXPECT_EQ(dots, 48u);
}

}  // namespace
}  // namespace argil::studio
