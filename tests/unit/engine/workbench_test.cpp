#include "engine/session/workbench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <set>
#include <thread>

#include "clay/mesh/mesh_topology.h"
#include "clay/surface/surface.h"
#include "engine/document/beside.h"
#include "engine/models/model_files.h"
#include "engine/text/script.h"
#include "engine/tools/tool_table.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

TEST_F(WorkbenchTest, APointerCarvesTheBlockAndUndoBringsItBack) {
  block();
  const clay::Version before = document()->pieces[0].version;
  SurfaceChanges whole = bench.takeSurfaces();
  ASSERT_EQ(whole.pieces.size(), 1u);
  EXPECT_TRUE(whole.pieces[0].whole);
  Tool tool;
  tool.radiusMm = 3;
  bench.setTool(tool);
  drag(1.5);
  ASSERT_TRUE(rest());
  EXPECT_EQ(problems(), "");
  const auto now = bench.snapshot();
  EXPECT_NE(now->document->pieces[0].version, before);
  EXPECT_EQ(now->done, 2u);
  EXPECT_EQ(now->history->back(), "Carve");
  const SurfaceChanges changes = bench.takeSurfaces();
  ASSERT_EQ(changes.pieces.size(), 1u);
  EXPECT_FALSE(changes.pieces[0].whole);
  EXPECT_LT(changes.pieces[0].delta.changed.size(), 400u);
  EXPECT_GT(changes.oldestSampleNs, 0);
  bench.undo();
  ASSERT_TRUE(until([&] { return document()->pieces[0].version == before; }));
  bench.redo();
  ASSERT_TRUE(until([&] { return document() == now->document; }));
  bench.goTo(0);
  ASSERT_TRUE(until([&] { return document()->pieces.empty(); }));
  const SurfaceChanges gone = bench.takeSurfaces();
  ASSERT_EQ(gone.pieces.size(), 1u);
  EXPECT_TRUE(gone.pieces[0].removed);
}

TEST_F(WorkbenchTest, SurfacesTakenOneByOneAreTheWholeSurface) {
  block();
  Tool tool;
  tool.radiusMm = 3;
  bench.setTool(tool);
  std::map<std::array<int, 3>, uint64_t> quads;
  const auto take = [&] {
    for (const SurfaceChange& change : bench.takeSurfaces().pieces) {
      if (change.whole) quads.clear();
      for (const auto& mesh : change.delta.changed)
        quads[{mesh->brick.x, mesh->brick.y, mesh->brick.z}] = mesh->quads.size();
    }
  };
  take();
  for (int i = 0; i < 3; ++i) {
    drag(1 + i);
    take();
  }
  ASSERT_TRUE(rest());
  take();
  clay::Surface fresh;
  fresh.update(document()->pieces[0].version);
  uint64_t sum = 0;
  for (const auto& [brick, count] : quads) sum += count;
  EXPECT_EQ(sum, fresh.quadCount());
  bench.resendSurfaces();
  ASSERT_TRUE(until([&] {
    const SurfaceChanges again = bench.takeSurfaces();
    return again.pieces.size() == 1 && again.pieces[0].whole;
  }));
}

// Its thread ends with a turn, not with the statistics that it looks at twice a second.
TEST(WorkbenchAlone, BeginsWithADocumentAndEndsAtOnce) {
  constexpr int kBenches = 20;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < kBenches; ++i) {
    const Workbench bench(withoutJournal());
    const auto first = bench.snapshot();
    ASSERT_NE(first->document, nullptr);
    ASSERT_NE(first->history, nullptr);
    std::this_thread::sleep_for(20ms);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kBenches * 250ms);
}

TEST_F(WorkbenchTest, TellsWhatTheClayTakes) {
  block();
  const uint64_t bytes = document()->pieces[0].version.stats().bytes();
  EXPECT_TRUE(until([&] { return bench.snapshot()->clayBytes >= bytes; }));
  EXPECT_LT(bench.snapshot()->clayBytes, 4 * bytes);
}

TEST_F(WorkbenchTest, AStrokeStaysInALockedPlane) {
  block();
  Tool tool;
  tool.radiusMm = 2;
  bench.setTool(tool);
  bench.edit("Add plane", [](Document& document) {
    Guide plane;
    plane.feel = Guide::Feel::lock;
    plane.pose.translation = {0, 0, 9.5};
    document.add(plane);
  });
  ASSERT_TRUE(until([&] { return document()->guides.size() == 1; }));
  drag(6);  // without the plane the ball would go 6 mm deep
  ASSERT_TRUE(rest());
  EXPECT_EQ(problems(), "");
  const clay::TriangleMesh mesh = meshOf(*document(), 0, true);
  double lowest = 10;
  for (const Vec3d& p : mesh.positions) {
    if (std::abs(p.x()) < 5 && std::abs(p.y()) < 1 && p.z() > 0) lowest = std::min(lowest, p.z());
  }
  EXPECT_NEAR(lowest, 7.5, 0.1);  // the plane less the radius
}

TEST_F(WorkbenchTest, AWellCatchesAPointerWithinItsRangeAlone) {
  block();
  Tool tool;
  tool.radiusMm = 2;
  bench.setTool(tool);
  const auto lowest = [&] {
    double z = 10;
    for (const Vec3d& p : meshOf(*document(), 0, true).positions) {
      if (std::abs(p.x()) < 5 && std::abs(p.y()) < 1 && p.z() > 0) z = std::min(z, p.z());
    }
    return z;
  };
  bench.edit("Add plane", [](Document& document) {
    Guide plane;
    plane.feel = Guide::Feel::well;
    plane.rangeMm = 4;
    plane.pose.translation = {0, 0, 9.5};
    document.add(plane);
  });
  ASSERT_TRUE(until([&] { return document()->guides.size() == 1; }));
  drag(2);  // 1.5 mm below the plane: caught
  ASSERT_TRUE(rest());
  EXPECT_NEAR(lowest(), 7.5, 0.1);
  bench.undo();
  ASSERT_TRUE(until([&] { return lowest() > 9.9; }));
  drag(6);  // 5.5 mm below it: free
  ASSERT_TRUE(rest());
  EXPECT_NEAR(lowest(), 2, 0.2);
  EXPECT_EQ(problems(), "");
}

// How far the corner of the block's surface, as it is handed to the picture, lies from the block's own.
TEST_F(WorkbenchTest, TheSurfaceIsOfTheGradeThatWasAskedForAndFollowsInIt) {
  bench.addBlock({20.3, 20.3, 20.3}, 0, {.voxelMm = 0.5});
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 1; }));
  ASSERT_TRUE(rest());
  std::map<clay::Grade, std::map<Coord, clay::BrickMeshPtr>> shown;
  const auto take = [&](clay::Grade grade) {
    bool whole = false;
    for (const SurfaceChange& change : bench.takeSurfaces().pieces) {
      whole |= change.whole;
      if (change.whole) shown[grade].clear();
      for (const clay::BrickMeshPtr& mesh : change.delta.changed) shown[grade][mesh->brick] = mesh;
    }
    return whole;
  };
  const auto equals = [&](clay::Grade grade) {
    clay::Surface anew(true, grade);
    anew.update(document()->pieces[0].version);
    bool same = true;
    size_t met = 0;
    anew.forEach([&](const clay::BrickMesh& mesh) {
      const auto found = shown[grade].find(mesh.brick);
      same &= found != shown[grade].end() && std::ranges::equal(found->second->positions, mesh.positions);
      ++met;
    });
    return same && met > 50;
  };
  ASSERT_TRUE(take(clay::Grade::draft));
  EXPECT_TRUE(equals(clay::Grade::draft));
  EXPECT_FALSE(equals(clay::Grade::fine));
  bench.setSurface(clay::Grade::fine);
  ASSERT_TRUE(until([&] { return take(clay::Grade::fine); }));
  EXPECT_TRUE(equals(clay::Grade::fine));
  drag(2);
  ASSERT_TRUE(rest());
  take(clay::Grade::fine);
  EXPECT_TRUE(equals(clay::Grade::fine));
  // Asked for in a hurry: the last wish counts.
  bench.setSurface(clay::Grade::draft);
  bench.setSurface(clay::Grade::fine);
  bench.setSurface(clay::Grade::draft);
  ASSERT_TRUE(rest());
  take(clay::Grade::draft);
  EXPECT_TRUE(equals(clay::Grade::draft));
}

TEST_F(WorkbenchTest, HiddenAndLockedPiecesAreNotCut) {
  block();
  bench.edit("Lock", [](Document& document) { document.pieces[0].locked = true; });
  ASSERT_TRUE(until([&] { return document()->pieces[0].locked; }));
  const clay::Version before = document()->pieces[0].version;
  drag(2);
  ASSERT_TRUE(rest());
  EXPECT_EQ(document()->pieces[0].version, before);
}

TEST_F(WorkbenchTest, ImportExportAndBadFilesAreTold) {
  block();
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "argil_workbench";
  std::filesystem::create_directories(folder);
  bench.exportTo({folder / "a.stl", folder / "a.obj", folder / "a.ply"});
  ASSERT_TRUE(rest());
  EXPECT_EQ(bench.takeMessages().size(), 3u);
  for (const char* name : {"a.stl", "a.obj", "a.ply"}) EXPECT_GT(std::filesystem::file_size(folder / name), 10000u);
  Workbench::ImportOptions how;
  how.voxelMm = 1;
  bench.import(folder / "a.stl", how);
  // What was read is there to be shown until the clay is.
  ASSERT_TRUE(until([&] { return bench.preview() != nullptr || document()->pieces.size() == 2; }));
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 2; }));
  ASSERT_TRUE(until([&] { return bench.preview() == nullptr; }));
  EXPECT_EQ(document()->pieces[1].name, "a");
  EXPECT_EQ(document()->active, document()->pieces[1].id);
  how.asPart = true;
  bench.import(folder / "a.stl", how);
  ASSERT_TRUE(until([&] { return document()->parts.size() == 1; })) << problems();
  EXPECT_NE(document()->parts[0].felt, nullptr);
  EXPECT_EQ(document()->parts[0].name, "a");
  const auto boxOf = [&](Id id) {
    ModelExport one;
    one.piece = id;
    Eigen::AlignedBox3d box;
    const std::vector<io::ModelObject> model = modelOf(*document(), one);
    for (const Vec3d& p : model.at(0).mesh.positions) box.extend(p);
    return box;
  };
  // One that was put beside what is there goes back to where its file has it.
  how.asPart = false;
  how.stands = true;
  bench.import(folder / "a.stl", how);
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 3; })) << problems();
  ModelExport what;
  what.piece = document()->pieces[2].id;
  const auto middle = [&](const Document& of) {
    Eigen::AlignedBox3d box;
    const std::vector<io::ModelObject> model = modelOf(of, what);
    for (const Vec3d& p : model.at(0).mesh.positions) box.extend(p);
    return Vec3d(box.center());
  };
  const Vec3d placed = middle(*document());
  what.putBack = true;
  const Vec3d back = middle(*document());
  what.piece = document()->pieces[0].id;
  EXPECT_LT((back - middle(*document())).norm(), 0.1);
  EXPECT_GT((back - placed).norm(), 1);
  // Or lies there from the beginning.
  how.stands = false;
  bench.import(folder / "a.stl", how);
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 4; })) << problems();
  EXPECT_NEAR(boxOf(document()->pieces[3].id).min().z(), boxOf(document()->pieces[0].id).min().z(), 0.1);
  EXPECT_LT(boxOf(document()->pieces[3].id).min().z(), -5);
  const DocumentPtr before = document();
  (void)bench.takeMessages();
  bench.import(folder / "none.stl", how);
  bench.exportTo({folder / "a.xyz"});
  bench.exportTo({folder / "missing" / "a.stl"});
  bench.useDevice("spoon");
  ASSERT_TRUE(until([&] { return bench.idle() && bench.touch(false).device == "pointer"; }));
  const auto messages = bench.takeMessages();
  EXPECT_EQ(messages.size(), 4u);
  for (const Message& message : messages) EXPECT_EQ(message.level, Message::Level::error) << message.text;
  EXPECT_EQ(document(), before);
  std::filesystem::remove_all(folder);
}

TEST_F(WorkbenchTest, JobsShowProgressAndCanBeCancelled) {
  bench.addSphere(400, {.voxelMm = 0.5});  // 1 600 voxels across: far more than the time until it is cancelled
  ASSERT_TRUE(until([&] { return !bench.jobs().empty() && bench.jobs()[0].fraction > 0; }));
  EXPECT_EQ(bench.jobs()[0].name, "Making a sphere");
  bench.cancelJob(bench.jobs()[0].id);
  ASSERT_TRUE(rest());
  EXPECT_TRUE(document()->pieces.empty());
  const auto messages = bench.takeMessages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].text, "Cancelled; nothing was changed.");
}

TEST_F(WorkbenchTest, EditsOfADragAreOneStep) {
  block();
  for (int i = 1; i <= 100; ++i) {
    bench.edit(
        "Move", [i](Document& document) { document.pieces[0].pose.translation.z() = i; }, "drag");
  }
  bench.endMerge();
  ASSERT_TRUE(until([&] { return document()->pieces[0].pose.translation.z() == 100; }));
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == 2; }));
  bench.undo();
  ASSERT_TRUE(until([&] { return document()->pieces[0].pose.translation.z() == 0; }));
}

TEST_F(WorkbenchTest, OpensAScriptWithItsStrokes) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "argil_workbench.json";
  {
    Script script;
    script.clay = SphereSetup{10, Vec3d::Zero()};
    ScriptStroke stroke;
    stroke.tool.radiusMm = 2;
    stroke.path = {{0, {10, 0, 0}}, {1, {0, 10, 0}}};
    script.strokes.push_back(stroke);
    writeScript(file, script);
  }
  bench.open(file);
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 1; }));
  EXPECT_EQ(document()->pieces[0].name, "argil_workbench");
  EXPECT_EQ(bench.snapshot()->done, 0u);
  EXPECT_EQ(problems(), "");
  std::filesystem::remove(file);
}

// A stroke that met nothing is not taken for one that did its work.
TEST_F(WorkbenchTest, AStrokeThatChangesNothingIsTold) {
  block();
  bench.strokeAlong({{-10, 0, 60}, {10, 0, 60}});
  ASSERT_TRUE(rest());
  std::string said;
  ASSERT_TRUE(until([&] { return (said += problems()).find("changed nothing") != std::string::npos; })) << said;
  EXPECT_EQ(bench.snapshot()->done, 1u);
  bench.strokeAlong({{-10, 0, 10}, {10, 0, 10}});
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == 2; }));
  ASSERT_TRUE(rest());
  EXPECT_EQ(problems(), "");
}

// Work that is left after the hand has ended is told, and comes to an end.
TEST(WorkbenchPace, WhatIsLeftOfAStrokeIsTold) {
  Workbench::Options given = withoutJournal();
  given.stampsATurn = 1;
  Workbench bench(given);
  bench.addBlock({200, 40, 20}, 2, {.voxelMm = 0.5});
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
  EXPECT_FALSE(bench.strokeWork().on);
  Tool tool;
  tool.radiusMm = 1;
  bench.setTool(tool);
  // An edit that takes as long as the whole stroke: all of it is left then, on any machine.
  std::promise<void> begun, done;
  bench.edit("Wait", [&](Document&) {
    begun.set_value();
    done.get_future().wait();
  });
  begun.get_future().wait();
  Finger finger(bench);
  for (int i = 0; i < 30; ++i) finger.feed(-80, 0, -8);
  for (int i = 0; i < 30; ++i) finger.feed(-80, 1, 0.5);
  for (int i = 0; i <= 100; ++i) finger.feed(-80 + 1.6 * i, 1, 0.5);
  for (int i = 0; i < 10; ++i) finger.feed(80, 0, -8);
  done.set_value();
  // The hand is up. What is left does not grow any more.
  std::vector<double> left;
  ASSERT_TRUE(until([&] {
    const Workbench::StrokeWork work = bench.strokeWork();
    if (work.on) left.push_back(work.leftS);
    return !work.on && bench.idle();
  }));
  ASSERT_FALSE(left.empty()) << "it is not told";
  EXPECT_GT(left.front(), 0);
  EXPECT_TRUE(std::is_sorted(left.rbegin(), left.rend())) << "what is left grew";
  EXPECT_EQ(bench.strokeWork().leftS, 0);
}

// A cursor hovers exactly on the surface that is seen under it, mostly at an angle: that is where the ball begins. A
// tool that rubs works all along its way.
TEST_F(WorkbenchTest, AToolThatRubsFollowsAPointerThatLooksFromTheSide) {
  block();
  for (const Vec3d& sight : {Vec3d(0, 0, -1), Vec3d(-0.45, 0.6, -0.66), Vec3d(0.9, 0, -0.3), Vec3d(0, -0.9, -0.4)})
    for (const double radius : {1.5, 5.0}) {
      SCOPED_TRACE(fmt::format("{} {} {}, radius {}", sight.x(), sight.y(), sight.z(), radius));
      Tool tool = standardTool(*findTool("paint"));
      tool.radiusMm = radius;
      bench.setTool(tool);
      ASSERT_TRUE(rest());
      haptics::PointerSample sample;
      sample.direction = sight.normalized();
      sample.surfaceMm = 50;
      const auto feed = [&](double x, uint32_t buttons, double depthMm) {
        sample.origin = Vec3d(x, 0, 10) - (sample.surfaceMm - depthMm) * sample.direction;
        sample.buttons = buttons;
        bench.feedPointer(sample);
        std::this_thread::sleep_for(4ms);
      };
      for (int i = 0; i < 3; ++i) feed(-10, 0, 0);  // A quick hand.
      for (int i = 0; i <= 100; ++i) feed(-10 + 0.2 * i, 1, 0.6 * radius);
      for (int i = 0; i < 30; ++i) feed(10, 0, 0);
      ASSERT_TRUE(rest());
      const clay::Version after = document()->pieces[0].version;
      for (int x = -18; x <= 18; ++x) {  // Voxels of half a millimetre, on the line that was drawn.
        int most = 0;
        for (int y = -1; y <= 1; ++y)
          for (int z = 17; z < 22; ++z)
            most = std::max(most, int(after.find(clay::Channel::cover, Coord{x, y, z} >> 3)
                                          .value(clay::Brick::offset(x & 7, y & 7, z & 7))));
        EXPECT_GT(most, 200) << "not painted at x = " << 0.5 * x << " mm";
      }
      bench.undo();
      ASSERT_TRUE(until([&] { return bench.snapshot()->done == 1; }));
      EXPECT_EQ(problems(), "");
    }
}

// A groove as wide as the ball would hold it; a cursor goes over it.
TEST_F(WorkbenchTest, AToolThatRubsLeavesTheGrooveThatTheLastOneMade) {
  block();
  Tool tool = standardTool(*findTool("carve"));
  tool.radiusMm = 3;
  bench.setTool(tool);
  drag(4);  // Its middle is 4 mm below the top: walls stand upright beside it.
  ASSERT_TRUE(rest());
  tool = standardTool(*findTool("paint"));
  tool.radiusMm = 3;
  bench.setTool(tool);
  ASSERT_TRUE(rest());
  // From the middle of the groove (3 mm on each side of y = 0) to the flat beside it.
  haptics::PointerSample sample;
  sample.direction = {0, 0, -1};
  sample.surfaceMm = 50;
  const auto feed = [&](double y, uint32_t buttons, double depthMm) {
    sample.origin = {0, y, 60 - depthMm - (std::abs(y) < 3 ? 7 : 0)};
    sample.buttons = buttons;
    bench.feedPointer(sample);
    std::this_thread::sleep_for(4ms);
  };
  for (int i = 0; i < 3; ++i) feed(0, 0, 0);
  for (int i = 0; i <= 100; ++i) feed(0.12 * i, 1, 1.8);
  for (int i = 0; i < 10; ++i) feed(12, 0, 0);
  ASSERT_TRUE(rest());
  const clay::Version after = document()->pieces[0].version;
  for (int y = 10; y <= 24; ++y) {  // Voxels of half a millimetre.
    int most = 0;
    for (int z = 17; z < 22; ++z)
      most = std::max(
          most, int(after.find(clay::Channel::cover, Coord{0, y, z} >> 3).value(clay::Brick::offset(0, y & 7, z & 7))));
    EXPECT_GT(most, 200) << "not painted at y = " << 0.5 * y << " mm";
  }
}

TEST_F(WorkbenchTest, ANewDocumentEmptiesThePicture) {
  block();
  std::set<Id> seen;
  const auto look = [&] {
    for (const SurfaceChange& change : bench.takeSurfaces().pieces) {
      if (change.removed) seen.erase(change.piece);
      if (change.whole) seen.insert(change.piece);
    }
    return seen.size();
  };
  ASSERT_TRUE(until([&] { return look() == 1; }));
  bench.newDocument();
  ASSERT_TRUE(until([&] { return document()->pieces.empty(); }));
  EXPECT_TRUE(until([&] { return look() == 0; }));
}

TEST_F(WorkbenchTest, CopiesAreNumberedOnByOne) {
  const auto names = [&] {
    std::vector<std::string> all;
    const DocumentPtr now = document();
    for (const Piece& piece : now->pieces) all.push_back(piece.name);
    return all;
  };
  for (size_t i = 1; i <= 2; ++i) {
    bench.addBlock({10, 10, 10}, 1, {.voxelMm = 0.5});
    ASSERT_TRUE(until([&] { return document()->pieces.size() == i; }));
  }
  for (size_t i = 3; i <= 4; ++i) {
    Workbench::Things copy;
    copy.pieces = {document()->pieces[1]};
    bench.add("Duplicate", copy);
    ASSERT_TRUE(until([&] { return document()->pieces.size() == i; }));
  }
  EXPECT_EQ(names(), (std::vector<std::string>{"Block", "Block 2", "Block 3", "Block 4"}));
}

// What is made by being asked for stands beside what is there, is worked on, and is told apart from what came
// otherwise.
TEST_F(WorkbenchTest, NewPiecesStandBesideOnTheSameGround) {
  bench.addBlock({40, 40, 20}, 2, {.voxelMm = 0.5, .beside = true});
  ASSERT_TRUE(until([&] { return bench.snapshot()->madeCount == 1; }));
  EXPECT_EQ(document()->pieces[0].pose.translation, Vec3d::Zero()) << "the first one";
  bench.addSphere(15, {.voxelMm = 0.5, .beside = true});
  ASSERT_TRUE(until([&] { return bench.snapshot()->madeCount == 2; }));
  const auto now = bench.snapshot();
  ASSERT_EQ(now->document->pieces.size(), 2u);
  EXPECT_EQ(now->made, now->document->pieces[1].id);
  EXPECT_EQ(now->document->active, now->made);
  const clay::BoxMm first = boundsOf(now->document->pieces[0]), second = boundsOf(now->document->pieces[1]);
  EXPECT_GT(second.low.x(), first.high.x());
  EXPECT_NEAR(second.low.z(), first.low.z(), 1);
  // A row that makes a piece, too.
  PieceArguments ring = standardArguments(*findPieceJob("ring"), *document());
  bench.operate("ring", ring);
  ASSERT_TRUE(until([&] { return bench.snapshot()->madeCount == 3; })) << problems();
  EXPECT_GT(boundsOf(document()->pieces[2]).low.x(), second.high.x());
  EXPECT_EQ(document()->active, document()->pieces[2].id);
  // Undo takes it and nothing is "made" by it.
  bench.undo();
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 2; }));
  EXPECT_EQ(bench.snapshot()->madeCount, 3u);
}

// Copies share their clay, have names of their own, and outlive the document that they were copied from.
TEST_F(WorkbenchTest, CopiesComeIntoThisAndIntoAnotherDocument) {
  block();
  Workbench::Things things;
  things.pieces = document()->pieces;
  bench.add("Duplicate", things);
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 2; }));
  EXPECT_EQ(document()->pieces[1].name, "Block 2");
  EXPECT_EQ(document()->pieces[1].version, document()->pieces[0].version);
  EXPECT_EQ(bench.snapshot()->made, document()->pieces[1].id);
  EXPECT_EQ(bench.snapshot()->done, 2u);
  const uint64_t hash = document()->pieces[0].version.hash();
  bench.newDocument();
  ASSERT_TRUE(until([&] { return document()->pieces.empty(); }));
  bench.add("Paste", things);
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 1; }));
  EXPECT_EQ(document()->pieces[0].name, "Block");
  EXPECT_EQ(document()->pieces[0].pose.translation, Vec3d::Zero());
  // It is worked on and kept like any other.
  bench.strokeAlong({{-10, 0, 10}, {10, 0, 10}});
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == 2; })) << problems();
  EXPECT_NE(document()->pieces[0].version.hash(), hash);
  EXPECT_EQ(things.pieces[0].version.hash(), hash);
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "argil_pasted.argil";
  std::filesystem::remove(file);
  const uint64_t carved = document()->pieces[0].version.hash();
  bench.saveAs(file, {});
  ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << problems();
  bench.open(file);
  ASSERT_TRUE(until([&] { return bench.snapshot()->file.opened > 2 && document()->pieces.size() == 1; }));
  EXPECT_EQ(document()->pieces[0].version.hash(), carved);
  std::filesystem::remove(file);
}

// Switched symmetry belongs to what is saved.
TEST_F(WorkbenchTest, SwitchedSymmetryIsSavedWithTheStateInWork) {
  block();
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "argil_symmetric.argil";
  std::filesystem::remove(file);
  bench.setSymmetry([](Symmetry& symmetry) { symmetry.y = true; });
  ASSERT_TRUE(until([&] { return document()->symmetry.y; }));
  EXPECT_EQ(bench.snapshot()->done, 1u);
  bench.saveAs(file, {});
  ASSERT_TRUE(until([&] { return bench.snapshot()->file.path == file && !bench.snapshot()->file.unsaved; }))
      << problems();
  bench.newDocument();
  ASSERT_TRUE(until([&] { return document()->pieces.empty(); }));
  bench.open(file);
  ASSERT_TRUE(until([&] { return document()->pieces.size() == 1; }));
  EXPECT_TRUE(document()->symmetry.y);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace argil::engine
