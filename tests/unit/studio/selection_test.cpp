// Several things are selected at once: by Ctrl and a click in the list and in the picture. Commands and gizmos take all
// of them.

#include <algorithm>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "panels_rig.h"
#include "widget_rig.h"

namespace argil::studio {
namespace {

using engine::Id;
using Ids = std::vector<Id>;

TEST(Selection, IsAddedToTakenFromAndReplaced) {
  StudioState state;
  EXPECT_TRUE(state.selection().empty());
  state.toggleSelected(0);
  EXPECT_TRUE(state.selection().empty()) << "nothing is no thing";
  state.toggleSelected(3);
  state.toggleSelected(5);
  state.toggleSelected(4);
  EXPECT_EQ(state.selection(), (Ids{3, 5, 4}));
  EXPECT_EQ(state.selected, 3u) << "the first stays the first";
  EXPECT_TRUE(state.isSelected(4));
  EXPECT_FALSE(state.isSelected(6));
  EXPECT_FALSE(state.isSelected(0));
  state.toggleSelected(3);
  EXPECT_EQ(state.selection(), (Ids{5, 4}));
  state.selected = 9;  // As everything does that selects one thing.
  EXPECT_EQ(state.selection(), (Ids{9}));
  state.toggleSelected(9);
  EXPECT_TRUE(state.selection().empty());
}

class SeveralThings : public testing::Test {
 protected:
  SeveralThings() { fill(rig); }
  const engine::Document& document() {
    now = rig.bench.snapshot()->document;
    return *now;
  }
  ImVec2 row(Id id) {
    ImGuiWindow* list = PanelsRig::child("Upper", "things");
    for (ImGuiWindow* window : GImGui->Windows)
      if (window->ParentWindow == list && std::string(window->Name).find("/list_") != std::string::npos) list = window;
    const int number = int(id);
    return rig.findId(list, ImHashStr("row", 0, ImHashData(&number, sizeof number, list->ID)));
  }
  void click(Id id, bool adds) {
    const ImVec2 at = row(id);
    ASSERT_FALSE(std::isnan(at.x)) << id;
    ImGui::GetIO().KeyCtrl = adds;
    rig.click(at);
    ImGui::GetIO().KeyCtrl = false;
    rig.until([&] { return rig.bench.idle(); }, "idle");
    rig.frames(2);
  }

  engine::DocumentPtr now;
  PanelsRig rig{1280, 900};
};

TEST_F(SeveralThings, AreSelectedInTheListByControlAndAClick) {
  const Id head = document().pieces[0].id, ball = document().pieces[1].id, part = document().parts[0].id;
  click(head, false);
  EXPECT_EQ(document().active, head);
  click(ball, true);
  click(part, true);
  EXPECT_EQ(rig.state.selection(), (Ids{head, ball, part}));
  EXPECT_EQ(document().active, head) << "what is added is not worked on";
  click(ball, true);
  EXPECT_EQ(rig.state.selection(), (Ids{head, part}));
  click(ball, false);
  EXPECT_EQ(rig.state.selection(), (Ids{ball}));
  EXPECT_EQ(document().active, ball);
}

TEST_F(SeveralThings, AreHiddenCopiedIsolatedAndDeletedAsOneStep) {
  const Id head = document().pieces[0].id, part = document().parts[0].id;
  const size_t pieces = document().pieces.size(), parts = document().parts.size(), guides = document().guides.size();
  const auto does = [&](const char* id) {
    const size_t before = rig.bench.snapshot()->done;
    rig.state.selected = head;
    rig.state.alsoSelected = {head, {part}};
    rig.run(id);
    rig.until([&] { return rig.bench.idle() && rig.bench.snapshot()->done == before + 1; }, id);
    rig.frame();  // It selects copies.
  };
  does("edit.hide");
  EXPECT_FALSE(document().piece(head)->visible);
  EXPECT_FALSE(document().part(part)->visible);
  does("edit.hide");
  does("edit.lock");
  EXPECT_TRUE(document().piece(head)->locked);
  EXPECT_TRUE(document().part(part)->locked);
  does("edit.lock");
  does("edit.isolate");
  EXPECT_TRUE(document().piece(head)->visible);
  EXPECT_TRUE(document().part(part)->visible);
  EXPECT_FALSE(document().pieces[1].visible);
  EXPECT_TRUE(
      std::none_of(document().guides.begin(), document().guides.end(), [](const auto& g) { return g.visible; }));
  does("edit.showAll");
  does("edit.duplicate");
  EXPECT_EQ(document().pieces.size(), pieces + 1);
  EXPECT_EQ(document().parts.size(), parts + 1);
  does("edit.delete");
  EXPECT_EQ(document().piece(head), nullptr);
  EXPECT_EQ(document().part(part), nullptr);
  EXPECT_EQ(document().guides.size(), guides);
  EXPECT_TRUE(rig.state.selection().empty());
}

TEST_F(SeveralThings, AreThePiecesOfACombination) {
  const Id head = document().pieces[0].id, ball = document().pieces[1].id;
  rig.state.selected = ball;
  rig.state.alsoSelected = {ball, {document().guides[0].id, head}};
  rig.run("piece.cut");
  const ImVec2 at = rig.find("Operation", {"Cut away", "button"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return rig.bench.idle() && !document().piece(head); }, "cut");
  EXPECT_NE(document().piece(ball), nullptr) << "the one that was selected first is cut, the other cuts";
}

engine::Piece ball() {
  engine::Piece piece;
  piece.version = clay::makeSphere(clay::Store::make(), clay::Grid{1.0}, Vec3d::Zero(), 3);
  return piece;
}

TEST(WidgetsOfSeveral, AMoveAndATurnOfOneTakeTheOthersAlong) {
  test::Rig rig;
  engine::Piece piece = ball();
  piece.pose.translation = Vec3d(0, 0, 0);
  const Id first = rig.document.add(piece);
  piece.pose.translation = Vec3d(20, 0, 0);
  const Id second = rig.document.add(piece);
  piece.pose.translation = Vec3d(0, 0, -25);
  piece.locked = true;
  const Id locked = rig.document.add(piece);
  rig.state.selected = first;
  rig.state.alsoSelected = {first, {second, locked}};
  rig.state.gizmo = GizmoMode::move;
  const Handle up = rig.handle("move axis", 2);
  rig.drag(rig.at(up.points.back()), rig.at(up.points.back() + Vec3d(0, 0, 9)));
  EXPECT_NEAR(rig.document.piece(first)->pose.translation.z(), 9, 0.2);
  EXPECT_NEAR(rig.document.piece(second)->pose.translation.z(), 9, 0.2);
  EXPECT_NEAR(rig.document.piece(second)->pose.translation.x(), 20, 1e-9);
  EXPECT_EQ(rig.document.piece(locked)->pose.translation.z(), -25) << "locked";
  EXPECT_EQ(rig.labels.size(), 1u) << "one step";
  EXPECT_EQ(rig.state.selection(), (Ids{first, second, locked}));

  // About the middle of the first: a quarter turn in the picture brings the second below or above it.
  rig.timeS += 2;
  rig.state.gizmo = GizmoMode::rotate;
  const Vec3d pivot = rig.document.piece(first)->pose.translation;
  const Handle ring = rig.handle("turn axis", 1);
  const Vec3d from = ring.points[ring.points.size() * 5 / 8], out = from - pivot;
  const Vec3d to = pivot + Eigen::AngleAxisd(std::acos(-1.0) / 2, ring.axis) * out;
  rig.constrain = true;  // To whole steps of 15°.
  rig.drag(rig.at(from), rig.at(to), 40);
  const Vec3d now = rig.document.piece(second)->pose.translation - pivot;
  EXPECT_NEAR(now.norm(), 20, 0.1);
  EXPECT_NEAR(std::abs(now.z()), 20, 0.1);
  EXPECT_EQ(rig.labels.size(), 2u);
}

TEST(WidgetsOfSeveral, EscapeBringsAllBack) {
  test::Rig rig;
  engine::Piece piece = ball();
  const Id first = rig.document.add(piece);
  piece.pose.translation = Vec3d(20, 0, 0);
  const Id second = rig.document.add(piece);
  rig.state.selected = first;
  rig.state.alsoSelected = {first, {second}};
  rig.state.gizmo = GizmoMode::move;
  const Handle up = rig.handle("move axis", 2);
  rig.hand(rig.at(up.points.back()));
  rig.hand(rig.at(up.points.back(), true));
  rig.hand(rig.at(up.points.back() + Vec3d(0, 0, 9), true));
  EXPECT_GT(rig.document.piece(second)->pose.translation.z(), 5);
  World world = rig.world();
  rig.widgets.escape(world);
  EXPECT_NEAR(rig.document.piece(first)->pose.translation.z(), 0, 1e-9);
  EXPECT_NEAR(rig.document.piece(second)->pose.translation.z(), 0, 1e-9);
}

TEST(WidgetsOfSeveral, AClickWithControlAddsAndTakesAway) {
  test::Rig rig;
  const Id first = rig.document.add(ball());
  const Id second = rig.document.add(ball());
  Id under = first;
  const auto click = [&](bool adds) {
    World world = rig.world();
    world.pickThing = [&](const Ray&) { return under; };
    Grip grip = rig.mouse(300, 300);
    grip.adds = adds;
    return rig.widgets.click(world, grip);
  };
  EXPECT_TRUE(click(false));
  under = second;
  EXPECT_TRUE(click(true));
  EXPECT_EQ(rig.state.selection(), (Ids{first, second}));
  under = 0;
  EXPECT_TRUE(click(true));
  EXPECT_EQ(rig.state.selection(), (Ids{first, second})) << "beside everything nothing is lost";
  under = first;
  click(true);
  EXPECT_EQ(rig.state.selection(), (Ids{second}));
  under = 0;
  click(false);
  EXPECT_TRUE(rig.state.selection().empty());
}

// T: four squares and a ring around the middle of a piece; what is let go is done once, about that middle.
TEST(WidgetsOfScale, APieceGrowsAboutItsMiddleByAnyOfItsHandles) {
  for (int i = -1; i < 4; ++i) {
    SCOPED_TRACE(i);
    test::Rig rig;
    engine::Piece piece = ball();
    piece.pose.translation = Vec3d(5, 0, -7);
    const Id id = rig.document.add(piece);
    rig.state.selected = id;
    rig.state.gizmo = GizmoMode::scale;
    std::vector<std::tuple<Id, Vec3d, Vec3d>> done;
    const Handle handle = rig.handle("scale", i);
    const Vec3d middle = piece.pose.translation;
    const Vec3d grab = handle.points[handle.points.size() / 3];
    const auto hand = [&](const Vec3d& at, bool down) {
      World world = rig.world();
      world.scale = [&](Id which, const Vec3d& factors, const Vec3d& about) {
        done.emplace_back(which, factors, about);
      };
      rig.timeS += 0.01;
      Grip grip = rig.at(at, down);
      rig.widgets.handle(world, grip);
    };
    hand(grab, false);
    hand(grab, true);
    hand(middle + 1.25 * (grab - middle), true);
    ASSERT_TRUE(rig.state.scaled) << "seen while it is dragged";
    hand(middle + 1.5 * (grab - middle), true);
    EXPECT_EQ(rig.state.scaled->piece, id);
    EXPECT_LT((rig.state.scaled->factors - Vec3d::Constant(1.5)).cwiseAbs().maxCoeff(), 0.02);
    EXPECT_TRUE(done.empty()) << "not before it is let go";
    hand(middle + 1.5 * (grab - middle), false);
    ASSERT_EQ(done.size(), 1u);
    EXPECT_EQ(std::get<0>(done[0]), id);
    EXPECT_LT((std::get<1>(done[0]) - Vec3d::Constant(1.5)).cwiseAbs().maxCoeff(), 0.02);
    EXPECT_LT((std::get<2>(done[0]) - middle).norm(), 1e-6);
    EXPECT_FALSE(rig.state.scaled);
    EXPECT_EQ(rig.edits, 0) << "the operation does it";
    // A press that moves nothing, and one that is given up.
    hand(grab, true);
    hand(grab, false);
    hand(grab, true);
    hand(middle + 2 * (grab - middle), true);
    World world = rig.world();
    rig.widgets.escape(world);
    EXPECT_FALSE(rig.state.scaled);
    hand(grab, false);
    EXPECT_EQ(done.size(), 1u);
  }
}

// The box of T, 40 mm each way: a side takes its axis, a corner all three; what lies opposite stays, with Ctrl the
// middle.
TEST(WidgetsOfScale, ASideOfTheBoxScalesOneAxisAndACornerAll) {
  struct Case {
    const char* name;
    int index;
    Vec3d outwards;  // From the middle, of 20 mm.
  };
  for (const Case& each : {Case{"scale side", 0, -Vec3d::UnitX()}, Case{"scale side", 1, Vec3d::UnitX()},
                           Case{"scale side", 4, -Vec3d::UnitZ()}, Case{"scale side", 5, Vec3d::UnitZ()},
                           Case{"scale side", 3, Vec3d::UnitY()}, Case{"scale corner", 7, Vec3d(1, 1, 1)},
                           Case{"scale corner", 1, Vec3d(1, -1, -1)}})
    for (const bool ctrl : {false, true}) {
      SCOPED_TRACE(testing::Message() << each.name << " " << each.index << (ctrl ? " with Ctrl" : ""));
      test::Rig rig(render::View::named("iso", test::Rig::box(100), test::kWidth / test::kHeight));
      engine::Piece piece = ball();
      piece.pose.translation = Vec3d(5, 0, -7);
      const Id id = rig.document.add(piece);
      rig.state.selected = id;
      rig.state.gizmo = GizmoMode::scale;
      std::vector<std::pair<Vec3d, Vec3d>> done;
      const Vec3d middle = piece.pose.translation, grab = middle + 20 * each.outwards;
      EXPECT_LT((rig.handle(each.name, each.index).points[0] - grab).norm(), 1e-9);
      const auto hand = [&](const Vec3d& at, bool down) {
        World world = rig.world();
        world.scale = [&](Id, const Vec3d& factors, const Vec3d& about) { done.emplace_back(factors, about); };
        rig.timeS += 0.01;
        Grip grip = rig.at(at, down);
        grip.snapOff = ctrl;
        rig.widgets.handle(world, grip);
      };
      // From 20 mm beside what stays to 30, or from 40 to 60.
      const Vec3d to = grab + (ctrl ? 10 : 20) * each.outwards;
      hand(grab, false);
      hand(grab, true);
      hand((grab + to) / 2, true);
      hand(to, true);
      ASSERT_TRUE(rig.state.scaled);
      Vec3d expected = Vec3d::Ones();
      for (int i = 0; i < 3; ++i)
        if (each.outwards[i] != 0) expected[i] = 1.5;
      EXPECT_LT((rig.state.scaled->factors - expected).cwiseAbs().maxCoeff(), 1e-3);
      World world = rig.world();
      bool told = false;
      for (const Widgets::Label& label : rig.widgets.labels(world))
        told |= label.text.find("× 1.50") != std::string::npos;
      EXPECT_TRUE(told);
      hand(to, false);
      ASSERT_EQ(done.size(), 1u);
      EXPECT_LT((done[0].first - expected).cwiseAbs().maxCoeff(), 1e-3);
      EXPECT_LT((done[0].second - (ctrl ? middle : Vec3d(middle - 20 * each.outwards))).norm(), 1e-6);
      EXPECT_EQ(rig.edits, 0);
    }
}

}  // namespace
}  // namespace argil::studio
