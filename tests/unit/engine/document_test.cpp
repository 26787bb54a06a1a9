#include "engine/document/document.h"

#include <gtest/gtest.h>

#include <set>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "engine/document/guide_table.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {
namespace {

clay::Version ball(double radiusMm = 10) {
  return clay::makeSphere(clay::Store::make(), {.voxelMm = 0.5}, Vec3d::Zero(), radiusMm);
}

Piece pieceOf(const clay::Version& version) {
  Piece piece;
  piece.version = version;
  return piece;
}

TEST(Document, NamesAndNumbersAreNeverUsedTwice) {
  Document document;
  const Id first = document.add(pieceOf(ball()));
  const Id second = document.add(pieceOf(ball()));
  EXPECT_EQ(document.active, first);
  EXPECT_EQ(document.piece(second)->name, "Clay 2");
  EXPECT_TRUE(document.remove(second));
  EXPECT_FALSE(document.remove(second));
  const Id third = document.add(pieceOf(ball()));
  EXPECT_GT(third, second);
  EXPECT_EQ(document.piece(third)->name, "Clay 2");
  EXPECT_TRUE(document.remove(first));
  EXPECT_EQ(document.active, third);
  EXPECT_EQ(document.thing(first), nullptr);
  EXPECT_THROW(document.add(Piece()), Error);
}

TEST(Document, ThingsAreReorderedWithinTheirList) {
  Document document;
  const Id a = document.add(Guide()), b = document.add(Guide());
  EXPECT_EQ(document.guides[0].name, "Plane");
  EXPECT_FALSE(document.reorder(a, -1));
  EXPECT_TRUE(document.reorder(a, 1));
  EXPECT_EQ(document.guides[0].id, b);
  EXPECT_FALSE(document.reorder(77, 1));
}

TEST(Document, TheSceneHoldsWhatIsVisibleWithTheWorkedOnPieceFirst) {
  Document document;
  const Id other = document.add(pieceOf(ball(5)));
  const Id worked = document.add(pieceOf(ball()));
  document.active = worked;
  document.piece(worked)->material.hardnessNmm2 = 0.5;
  Guide lock;
  lock.feel = Guide::Feel::lock;
  const Id plane = document.add(lock);
  document.add(Guide());  // only seen
  haptics::Scene base;
  base.guides.push_back({});
  base.guides[0].id = 3;
  base.guides[0].shape = haptics::Gravity{};
  base.tool.work = haptics::Work::cut;
  haptics::Scene scene = sceneOf(document, base);
  scene.check();
  ASSERT_EQ(scene.pieces.size(), 2u);
  EXPECT_EQ(scene.workedOn, 1u);
  EXPECT_EQ(scene.pieces[0].version, document.piece(worked)->version);
  EXPECT_EQ(scene.materials[scene.pieces[0].material].hardnessNmm2, 0.5);
  ASSERT_EQ(scene.guides.size(), 2u);
  const uint32_t id = scene.guides[1].id;
  EXPECT_TRUE(scene.tool.work.has_value());

  // A guide keeps its id whatever is hidden before it.
  document.guide(plane)->visible = true;
  document.piece(other)->visible = false;
  document.piece(worked)->locked = true;
  scene = sceneOf(document, base);
  scene.check();
  EXPECT_EQ(scene.pieces.size(), 1u);
  EXPECT_EQ(scene.workedOn, 0u);
  EXPECT_FALSE(scene.tool.work.has_value());
  EXPECT_EQ(scene.guides[1].id, id);
}

TEST(Document, RowsOfMaterialsAreTheScenes) {
  Document document;
  const Id id = document.add(pieceOf(ball()));
  document.add(pieceOf(ball(5)));
  Piece& piece = *document.piece(id);
  piece.material.hardnessNmm2 = 0.5;
  haptics::Material wax;
  wax.hardnessNmm2 = 0.01;
  piece.materials = {{"wax", wax, {}}, {"own again", piece.material, {}}, {"wax again", wax, {}}};
  EXPECT_EQ(sceneOf(document, {}).pieces[0].rows, nullptr) << "no voxel asks for one";
  clay::Editor editor(piece.version);
  piece.version.forEachBrick([&](const clay::Brick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> values;
    values.fill(1);
    editor.setChannel(clay::Channel::material, brick.coord, values);
  });
  piece.version = editor.commit();
  const haptics::Scene scene = sceneOf(document, {});
  scene.check();
  ASSERT_NE(scene.pieces[0].rows, nullptr);
  EXPECT_EQ(scene.pieces[1].rows, nullptr);
  const auto hardness = [&](size_t row) { return scene.materials[(*scene.pieces[0].rows)[row]].hardnessNmm2; };
  EXPECT_EQ(hardness(1), 0.01);
  EXPECT_EQ(hardness(3), 0.01);
  for (const size_t own : {0u, 2u, 4u, 255u}) EXPECT_EQ(hardness(own), 0.5) << own;
  EXPECT_EQ(scene.materials.size(), 3u) << "each once";
  haptics::Scene wrong = scene;
  haptics::MaterialRows rows{};
  rows[200] = 3;
  wrong.pieces[0].rows = std::make_shared<const haptics::MaterialRows>(rows);
  EXPECT_THROW(wrong.check(), Error);
}

TEST(Document, WhatTheTableOffersForAGuideIsFeltEachInItsOwnWay) {
  for (const GuideRow& row : guideTable()) {
    SCOPED_TRACE(row.id);
    Guide guide;
    guide.kind = row.kind;
    for (size_t i = 0; i < row.points; ++i) guide.pointsMm.emplace_back(10.0 * double(i), double(i * i), 0);
    std::set<size_t> shapes;
    for (const Guide::Feel feel : row.feels) {
      guide.feel = feel;
      const auto made = felt(guide, 1);
      ASSERT_EQ(made.has_value(), feel != Guide::Feel::seen);
      if (made) {
        EXPECT_TRUE(shapes.insert(made->shape.index()).second) << "two are felt alike";
      }
    }
  }
}

TEST(Document, EveryKindOfGuideIsFeltAsItSays) {
  using Kind = Guide::Kind;
  using Feel = Guide::Feel;
  for (const GuideRow& row : guideTable()) {
    const Kind kind = row.kind;
    for (const Feel feel : {Feel::seen, Feel::lock, Feel::well, Feel::keepOut}) {
      Guide guide;
      guide.kind = kind;
      guide.feel = feel;
      guide.pointsMm = {{0, 0, 0}, {10, 0, 0}, {10, 5, 0}};
      const auto made = felt(guide, 9);
      EXPECT_EQ(made.has_value(), feel != Feel::seen && kind != Kind::ruler && kind != Kind::angle);
      if (!made) continue;
      EXPECT_EQ(made->id, 9u);
      const bool well = feel == Feel::well;
      const auto is = [&]<class Shape>() { return std::holds_alternative<Shape>(made->shape); };
      switch (kind) {
        case Kind::plane:
          EXPECT_EQ(is.operator()<haptics::WellAtPlane>(), well);
          EXPECT_EQ(is.operator()<haptics::LockToPlane>(), feel == Feel::lock);
          EXPECT_EQ(is.operator()<haptics::KeepOutPlane>(), feel == Feel::keepOut);
          break;
        case Kind::line:
          EXPECT_TRUE(well ? is.operator()<haptics::WellAtCurve>() : is.operator()<haptics::LockToLine>());
          break;
        case Kind::point:
          EXPECT_TRUE(well ? is.operator()<haptics::WellAtPoints>() : is.operator()<haptics::LockToPoint>());
          break;
        case Kind::curve:
          EXPECT_TRUE(well ? is.operator()<haptics::WellAtCurve>() : is.operator()<haptics::LockToCurve>());
          break;
        default:
          EXPECT_TRUE(is.operator()<haptics::KeepOutBox>());
      }
    }
  }
  Guide bad;
  bad.kind = Kind::curve;
  bad.feel = Feel::lock;
  EXPECT_THROW((void)felt(bad, 1), Error);
  Guide well;
  well.feel = Guide::Feel::well;
  EXPECT_NO_THROW((void)felt(well, 1));
  for (const double none : {-1.0, double(NAN), 1e9}) {
    Guide wide = well, strong = well;
    wide.rangeMm = strong.forceN = none;
    EXPECT_THROW((void)felt(wide, 1), Error) << none;
    EXPECT_THROW((void)felt(strong, 1), Error) << none;
  }
  EXPECT_THROW(Document().add(bad), Error);
}

const Tool kCarve{"carve", 2};

TEST(SessionOfADocument, ChangesAreStepsAndMergeByKey) {
  Session session(ball());
  const DocumentPtr first = session.document();
  const auto move = [](double x) { return [x](Document& document) { document.pieces[0].pose.translation.x() = x; }; };
  session.change("Move", move(1), "drag");
  session.change("Move", move(2), "drag");
  EXPECT_EQ(session.undoSteps(), 1u);
  session.endMerge();
  session.change("Move", move(3), "drag");
  session.change("Rename", [](Document& document) { document.pieces[0].name = "Head"; });
  EXPECT_EQ(session.history(), (std::vector<std::string>{"Move", "Move", "Rename"}));
  session.goTo(1);
  EXPECT_EQ(session.document()->pieces[0].pose.translation.x(), 2);
  EXPECT_EQ(session.history().size(), 3u);
  session.goTo(0);
  EXPECT_EQ(session.document(), first);
  session.goTo(3);
  EXPECT_EQ(session.document()->pieces[0].name, "Head");
  EXPECT_THROW(session.goTo(4), Error);
  // What throws changes nothing.
  EXPECT_THROW(session.change("Bad",
                              [](Document& document) {
                                document.pieces[0].name = "x";
                                throw Error("no");
                              }),
               Error);
  EXPECT_EQ(session.document()->pieces[0].name, "Head");
  EXPECT_EQ(session.undoSteps(), 3u);
}

TEST(SessionOfADocument, LaterStepsStayWhereOneGoesBackInTheHistoryAndWorksOn) {
  const auto name = [](Session& session, const char* to) {
    session.change(to, [to](Document& document) { document.pieces[0].name = to; });
  };
  for (const bool stroke : {false, true})
    for (const size_t back : {size_t(0), size_t(1), size_t(2)}) {
      SCOPED_TRACE(testing::Message() << back << (stroke ? " stroke" : " change"));
      Session session(ball());
      for (const char* step : {"A", "B", "C"}) name(session, step);
      session.goTo(back, true);
      const std::string there = session.document()->pieces[0].name;
      const clay::Version clay = session.version();
      if (stroke) {
        session.beginStroke(kCarve);
        session.addPoint(0, {8, 0, 0});
        session.endStroke();
        EXPECT_NE(session.version(), clay);
      } else {
        name(session, "D");
      }
      const std::string label = back == 0   ? "Back to the beginning"
                                : back == 1 ? "Back to step 1: A"
                                            : "Back to step 2: B";
      EXPECT_EQ(session.history(), (std::vector<std::string>{"A", "B", "C", label, stroke ? "Carve" : "D"}));
      EXPECT_EQ(session.counts().kept, 3 - back);
      EXPECT_EQ(session.undoSteps(), 5u);
      session.undo();
      EXPECT_EQ(session.document()->pieces[0].name, there);
      EXPECT_EQ(session.version(), clay);
      session.goTo(3);
      EXPECT_EQ(session.document()->pieces[0].name, "C") << "the later steps are there";
      session.goTo(5);
      name(session, "E");
      EXPECT_EQ(session.history().size(), 6u) << "at the end nothing is to be kept";
    }
  // Undo drops them as ever, where nobody went back in the history.
  Session session(ball());
  for (const char* step : {"A", "B", "C"}) name(session, step);
  session.undo();
  name(session, "D");
  EXPECT_EQ(session.history(), (std::vector<std::string>{"A", "B", "D"}));
  session.goTo(1, true);
  session.redo();
  session.redo();
  session.undo();
  name(session, "E");
  EXPECT_EQ(session.history(), (std::vector<std::string>{"A", "B", "E"})) << "the end was reached meanwhile";
}

TEST(SessionOfADocument, AStrokeWorksOnTheActivePieceAlone) {
  Session session(ball());
  const clay::Version second = ball(8);
  session.change("Add", [&](Document& document) { document.active = document.add(pieceOf(second)); });
  const clay::Version firstBefore = session.document()->pieces[0].version;
  session.beginStroke(kCarve);
  session.addPoint(0, {8, 0, 0});
  session.endStroke();
  EXPECT_EQ(session.document()->pieces[0].version, firstBefore);
  EXPECT_NE(session.document()->pieces[1].version, second);
  EXPECT_EQ(session.history().back(), "Carve");
  session.change("Lock", [](Document& document) { document.pieces[1].locked = true; });
  EXPECT_THROW(session.beginStroke(kCarve), Error);
  session.change("Remove", [](Document& document) { document.remove(document.active); });
  EXPECT_EQ(session.version(), firstBefore);
  session.goTo(0);
  EXPECT_EQ(session.document()->pieces.size(), 1u);
}

// φ at a voxel, tiles as ± the band.
float phi(const clay::Version& version, Coord voxel) {
  const clay::Slot slot = version.find({voxel.x >> 3, voxel.y >> 3, voxel.z >> 3});
  return slot.phi(clay::Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7), version.grid().band);
}

TEST(SessionOfADocument, SymmetryRepeatsAStrokeInEveryPlane) {
  Session session(ball());
  session.change("Symmetry", [](Document& document) { document.symmetry.x = document.symmetry.y = true; });
  session.beginStroke(kCarve);
  session.addPoint(0, {6, 6, 4});
  session.addPoint(0.1, {8, 4, 4});
  const clay::Version cut = session.endStroke();
  const clay::Grid grid = cut.grid();
  size_t changed = 0;
  const clay::Version whole = ball();
  for (int z = 0; z < 20; ++z) {
    for (int y = 0; y < 22; ++y) {
      for (int x = 0; x < 22; ++x) {
        const Coord at{x, y, z};
        const float value = phi(cut, at);
        changed += value != phi(whole, at);
        for (const Coord image : {Coord{-x, y, z}, Coord{x, -y, z}, Coord{-x, -y, z}}) {
          // The surface itself is a mirror image to a hundredth of a voxel; redistancing runs in fixed directions.
          if (std::abs(value) < 0.5f) {
            EXPECT_NEAR(phi(cut, image), value, 0.01f);
          }
        }
      }
    }
  }
  EXPECT_GT(changed, 100u);
  EXPECT_EQ(grid.voxelMm, 0.5);
}

// A switch of the hand: no step, redo stays, and undo leaves it as it is; the planes keep the place that each state
// has.
TEST(SessionOfADocument, SwitchingSymmetryIsNoStepAndLeavesRedo) {
  Session session(ball());
  session.change("Move the planes", [](Document& document) { document.symmetry.pose.translation = {1, 0, 0}; });
  Tool tool;
  tool.radiusMm = 2;
  const auto dab = [&] {
    session.beginStroke(tool);
    session.addPoint(0, {6, 0, 8});
    session.endStroke();
  };
  dab();
  const clay::Version carved = session.version();
  ASSERT_EQ(session.undoSteps(), 2u);
  ASSERT_TRUE(session.undo());
  Symmetry on;
  on.x = true;
  on.turns = 3;
  session.setSymmetry(on);
  EXPECT_EQ(session.undoSteps(), 1u);
  EXPECT_EQ(session.redoSteps(), 1u);
  EXPECT_TRUE(session.document()->symmetry.x);
  EXPECT_EQ(session.document()->symmetry.pose.translation, Vec3d(1, 0, 0));
  ASSERT_TRUE(session.redo());
  EXPECT_EQ(session.version(), carved);
  EXPECT_TRUE(session.document()->symmetry.x);
  EXPECT_EQ(session.document()->symmetry.turns, 3);
  session.goTo(0);
  EXPECT_TRUE(session.document()->symmetry.x);
  EXPECT_EQ(session.document()->symmetry.pose.translation, Vec3d::Zero());
  // What is done next keeps it, and strokes are mirrored.
  dab();
  EXPECT_TRUE(session.document()->symmetry.x);
  EXPECT_EQ(session.document()->images().mirrors.size(), 1u);
  session.setSymmetry({});
  EXPECT_FALSE(session.document()->symmetry.any());
  session.undo();
  EXPECT_FALSE(session.document()->symmetry.any());
}

TEST(SessionOfADocument, ARecordingWithSymmetryGivesEqualBits) {
  const clay::Version first = ball();
  Session session(first);
  session.record();
  session.change("Symmetry", [](Document& document) {
    document.symmetry.x = true;
    document.symmetry.pose.translation = {0.3, 0, 0};
  });
  session.beginStroke(kCarve);
  for (int i = 0; i < 10; ++i) session.addPoint(0.01 * i, {8, 0.5 * i, 4});
  session.endStroke();
  const Script script = parseScript(formatScript(session.recording()), "recording");
  ASSERT_EQ(script.strokes.size(), 1u);
  ASSERT_EQ(script.strokes[0].images.mirrors.size(), 1u);
  Session again(first);
  again.beginStroke(script.strokes[0].tool, script.strokes[0].images);
  for (const PathPoint& point : script.strokes[0].path) again.addPoint(point.timeS, point.mm);
  EXPECT_EQ(again.endStroke().hash(), session.version().hash());
}

TEST(ToolTable, RowsAreComplete) {
  for (const ToolRow& row : toolTable()) {
    EXPECT_EQ(findTool(row.id), &row);
    EXPECT_FALSE(row.help.empty());
    EXPECT_TRUE(row.opposite.empty() || findTool(row.opposite)) << row.id;
    EXPECT_FALSE(row.operations.empty());
    Tool tool = standardTool(row);
    EXPECT_EQ(&rowOf(tool), &row);
    for (const Parameter<Tool>& parameter : row.parameters) {
      EXPECT_LT(parameter.low, parameter.high);
      parameter.change(tool, parameter.high * 10);
      EXPECT_NEAR(parameter.get(tool), parameter.high, 1e-4 * parameter.high);
    }
  }
  EXPECT_EQ(findTool("axe"), nullptr);
}

}  // namespace
}  // namespace argil::engine
