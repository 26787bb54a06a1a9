// The picture's way beside the edit thread: what is large, what failed, what never came.

#include "engine/session/surfaces.h"

#include <gtest/gtest.h>

#include <new>
#include <thread>

#include "clay/base/memory_guard.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/store/unshared.h"
#include "clay/whole/boolean.h"
#include "tests/support/refusing_system.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

clay::Version ball(double radiusVoxels, std::shared_ptr<clay::Store> store = clay::Store::make()) {
  clay::Grid grid;
  grid.voxelMm = 1;
  return clay::makeSphere(std::move(store), grid, Vec3d::Zero(), radiusVoxels);
}

clay::Version dabbed(const clay::Version& from, const Vec3d& at, double radius) {
  clay::BrushStroke brush(from, clay::Brush::of(clay::Method::carve));
  brush.apply({at, at, radius});
  return brush.finish();
}

Document with(const std::vector<clay::Version>& versions) {
  Document document;
  for (const clay::Version& version : versions) {
    Piece piece;
    piece.version = version;
    document.add(std::move(piece));
  }
  return document;
}

// What a renderer has of a piece.
class Picture {
 public:
  void take(Surfaces& surfaces) {
    for (SurfaceChange& change : surfaces.take().pieces) {
      auto& bricks = pieces_[change.piece];
      if (change.whole || change.removed) bricks.clear();
      wholes += change.whole;
      if (change.removed) pieces_.erase(change.piece);
      for (const clay::BrickMeshPtr& mesh : change.delta.changed) bricks[mesh->brick] = mesh;
    }
  }
  [[nodiscard]] bool shows(Id piece, const clay::Version& version, clay::Grade grade = clay::Grade::draft) const {
    clay::Surface surface(true, grade);
    surface.update(version);
    const auto found = pieces_.find(piece);
    if (found == pieces_.end()) return surface.quadCount() == 0;
    uint64_t quads = 0;
    for (const auto& [brick, mesh] : found->second) quads += mesh->quads.size();
    bool same = quads == surface.quadCount();
    surface.forEach([&](const clay::BrickMesh& mesh) {
      const auto brick = found->second.find(mesh.brick);
      same = same && brick != found->second.end() && std::ranges::equal(brick->second->positions, mesh.positions);
    });
    return same;
  }
  [[nodiscard]] bool has(Id piece) const { return pieces_.count(piece) > 0; }
  int wholes = 0;

 private:
  std::map<Id, std::map<Coord, clay::BrickMeshPtr>> pieces_;
};

class SurfacesTest : public ::testing::Test {
 protected:
  void settle(const Document& document) {
    for (int i = 0; i < 60'000 && surfaces.behind(); ++i) {
      if (surfaces.arrived()) surfaces.follow(document, 0);
      std::this_thread::sleep_for(1ms);
    }
    ASSERT_FALSE(surfaces.behind());
    picture.take(surfaces);
  }
  Surfaces surfaces;
  Picture picture;
};

TEST_F(SurfacesTest, OnlyWhatAStrokeChangedIsDelivered) {
  Document document = with({ball(60)});
  surfaces.follow(document, 0);
  picture.take(surfaces);
  for (const Vec3d& at : {Vec3d(60, 0, 0), Vec3d(0, 60, 0)}) {
    document.pieces[0].version = dabbed(document.pieces[0].version, at, 4);
    surfaces.follow(document, 1);
    const SurfaceChanges changes = surfaces.take();
    ASSERT_EQ(changes.pieces.size(), 1u);
    EXPECT_FALSE(changes.pieces[0].whole);
    EXPECT_GT(changes.pieces[0].delta.changed.size(), 0u);
    EXPECT_LE(changes.pieces[0].delta.changed.size(), 27u);
  }
  surfaces.follow(document, 0);
  EXPECT_TRUE(surfaces.take().pieces.empty());
}

// Each is small enough for the edit thread and all together are not.
TEST_F(SurfacesTest, ManyPiecesTogetherAreNoMoreThanALargeOne) {
  const clay::Version each = ball(120);
  const uint64_t bricks = each.stats().bricks;
  ASSERT_LT(bricks, Surfaces::kMostOwnBricks);
  ASSERT_GT(6 * bricks, 2 * Surfaces::kMostOwnBricks);
  Document document = with({each, ball(120), ball(120), ball(120), ball(120), ball(120)});
  surfaces.follow(document, 0);
  EXPECT_GT(surfaces.ownBricks(), 0u);
  EXPECT_LE(surfaces.ownBricks(), Surfaces::kMostOwnBricks);
  EXPECT_TRUE(surfaces.behind());
  settle(document);
  for (const Piece& piece : document.pieces) EXPECT_TRUE(picture.shows(piece.id, piece.version)) << piece.id;
}

// A helper on a busy machine may have them for long.
TEST_F(SurfacesTest, AStrokeLooksAtOnePieceAlsoWhileTheHelperHasOthers) {
  const clay::Version plain = ball(20), cut = dabbed(plain, Vec3d(20, 0, 0), 4);
  std::vector<clay::Version> versions(200, ball(3));
  versions.front() = plain;
  const size_t large = 8;
  for (size_t i = 0; i < large; ++i) versions.push_back(ball(120));
  Document document = with(versions);
  ASSERT_EQ(document.active, document.pieces[0].id);
  document.stroke = 7;
  surfaces.follow(document, 1);
  EXPECT_TRUE(surfaces.behind());
  const uint64_t before = surfaces.looks();
  constexpr uint64_t kTurns = 300;
  for (uint64_t i = 0; i < kTurns; ++i) {
    document.pieces[0].version = i % 2 == 0 ? cut : plain;
    surfaces.follow(document, 1);
    picture.take(surfaces);
    if (i < 2) {
      EXPECT_TRUE(picture.shows(document.active, document.pieces[0].version));
    }
  }
  EXPECT_LE(surfaces.looks() - before, kTurns + large * versions.size());
  settle(document);
  for (const Piece& piece : document.pieces) EXPECT_TRUE(picture.shows(piece.id, piece.version)) << piece.id;
}

// The helper still has it when it goes, or is asked for anew.
TEST_F(SurfacesTest, WhatComesBackTooLateIsDropped) {
  const Document document = with({ball(230)}), empty;
  surfaces.follow(document, 0);
  ASSERT_TRUE(surfaces.behind());
  surfaces.follow(empty, 0);
  settle(empty);
  EXPECT_FALSE(picture.has(1));
  surfaces.follow(document, 0);
  surfaces.forget();
  surfaces.follow(document, 0);
  settle(document);
  EXPECT_TRUE(picture.shows(1, document.pieces[0].version));
  EXPECT_EQ(picture.wholes, 1);
}

// As undo and redo of an operation that changed a whole piece do.
TEST_F(SurfacesTest, AnotherWholePieceIsExtractedBesideTheEditThread) {
  const clay::Version small = ball(20), large = ball(230);
  ASSERT_GT(large.stats().bricks, Surfaces::kMostOwnBricks);
  Document document = with({small});
  surfaces.follow(document, 0);
  picture.take(surfaces);
  EXPECT_TRUE(picture.shows(1, small));
  const uint64_t own = surfaces.ownBricks();
  document.pieces[0].version = large;
  surfaces.follow(document, 0);
  EXPECT_EQ(surfaces.ownBricks(), own) << "the edit thread extracted nothing";
  EXPECT_TRUE(surfaces.behind());
  picture.take(surfaces);
  EXPECT_TRUE(picture.shows(1, small)) << "what was there is seen until the other is ready";
  settle(document);
  EXPECT_TRUE(picture.shows(1, large));
  // The same store, but much of it: a difference, not a whole.
  const clay::Version cut = dabbed(large, {0, 0, 230}, 200);
  const int wholes = picture.wholes;
  document.pieces[0].version = cut;
  surfaces.follow(document, 0);
  EXPECT_EQ(surfaces.ownBricks(), own);
  settle(document);
  EXPECT_EQ(picture.wholes, wholes);
  EXPECT_TRUE(picture.shows(1, cut));
  // A stroke is followed by the thread that makes it.
  const clay::Version dab = dabbed(cut, {230, 0, 0}, 10);
  document.pieces[0].version = dab;
  surfaces.follow(document, 1);
  picture.take(surfaces);
  EXPECT_TRUE(picture.shows(1, dab));
}

// What an operation on a whole piece replaced is kept: the edit thread swaps it back, and nobody waits.
TEST_F(SurfacesTest, UndoOfAWholePieceStepIsThereAtOnce) {
  const clay::Version large = ball(230), cut = dabbed(large, {0, 0, 230}, 200);
  ASSERT_GT(clay::differingLeaves(large, cut, Surfaces::kMostOwnBricks), Surfaces::kMostOwnBricks);
  Document document = with({large});
  surfaces.follow(document, 0);
  settle(document);
  document.pieces[0].version = cut;
  surfaces.follow(document, 0);
  settle(document);
  const uint64_t own = surfaces.ownBricks();
  for (const clay::Version& version : {large, cut, large}) {
    document.pieces[0].version = version;
    surfaces.follow(document, 0);
    EXPECT_FALSE(surfaces.behind());
    picture.take(surfaces);
    EXPECT_TRUE(picture.shows(1, version));
  }
  EXPECT_EQ(surfaces.ownBricks(), own) << "nothing was extracted";
}

// A surface that has no room is not tried again and again: it is told once, and made when somebody asks again.
TEST_F(SurfacesTest, WhatTheHelperHasNoRoomForIsToldAndNotTriedForEver) {
  const Document document = with({ball(230)});
  {
    const PretendedMemory none([] { return MemoryRoom{uint64_t{8} << 30, MemoryGuard::kLeastReserve}; });
    surfaces.follow(document, 0);
    ASSERT_TRUE(surfaces.behind());
    int told = 0;
    for (int i = 0; i < 60'000 && surfaces.behind(); ++i) {
      try {
        if (surfaces.arrived()) surfaces.follow(document, 0);
      } catch (const std::bad_alloc&) {
        ++told;
      }
      std::this_thread::sleep_for(1ms);
    }
    EXPECT_EQ(told, 1);
    EXPECT_FALSE(surfaces.behind());
  }
  surfaces.follow(document, 0);
  settle(document);
  EXPECT_TRUE(picture.shows(1, document.pieces[0].version));
}

TEST_F(SurfacesTest, APieceThatChangesOrGoesWhileTheHelperHasItIsShownAsItIs) {
  const clay::Version large = ball(230);
  Document document = with({large, ball(20)});
  surfaces.follow(document, 0);
  document.pieces[0].version = dabbed(large, {230, 0, 0}, 10);
  surfaces.follow(document, 1);
  settle(document);
  EXPECT_TRUE(picture.shows(1, document.pieces[0].version));
  EXPECT_TRUE(picture.shows(2, document.pieces[1].version));
  document.pieces[0].version = ball(231);
  surfaces.follow(document, 0);
  Document without = document;
  without.remove(1);
  surfaces.follow(without, 0);
  settle(without);
  EXPECT_FALSE(picture.has(1));
  EXPECT_TRUE(picture.shows(2, document.pieces[1].version));
  surfaces.follow(document, 0);
  surfaces.setGrade(clay::Grade::fine);
  surfaces.follow(document, 0);
  settle(document);
  EXPECT_TRUE(picture.shows(1, document.pieces[0].version, clay::Grade::fine));
}

// Another document, an empty one too: nothing of the one before stays in the picture.
TEST_F(SurfacesTest, WhatAnotherDocumentDoesNotHaveGoesFromThePicture) {
  const Document before = with({ball(10), ball(12), ball(230)});
  surfaces.follow(before, 0);
  settle(before);
  ASSERT_TRUE(picture.has(1) && picture.has(2) && picture.has(3));
  surfaces.forget();
  const Document smaller = with({ball(11)});
  surfaces.follow(smaller, 0);
  settle(smaller);
  EXPECT_TRUE(picture.shows(1, smaller.pieces[0].version));
  EXPECT_FALSE(picture.has(2) || picture.has(3));
  surfaces.forget();
  surfaces.follow(Document(), 0);
  settle(Document());
  EXPECT_FALSE(picture.has(1));
  // One that was on its way to the helper never comes.
  surfaces.follow(before, 0);
  surfaces.forget();
  surfaces.follow(Document(), 0);
  settle(Document());
  EXPECT_FALSE(picture.has(1) || picture.has(2) || picture.has(3));
}

// What a boolean leaves has the store of the piece that it worked on.
TEST_F(SurfacesTest, WhatWasPreparedIsTakenThoughTheStoreIsTheSame) {
  const clay::Version before = ball(60);
  Document document = with({before});
  surfaces.follow(document, 0);
  picture.take(surfaces);
  const clay::Version after = clay::combine(before, ball(50), clay::Combination::cut);
  ASSERT_EQ(after.store(), before.store());
  const auto ready = surfaces.prepare(after);
  const uint64_t own = surfaces.ownBricks();
  document.pieces[0].version = after;
  surfaces.follow(document, 0);
  EXPECT_EQ(surfaces.ownBricks(), own);
  picture.take(surfaces);
  EXPECT_TRUE(picture.shows(1, after));
}

TEST_F(SurfacesTest, WhatWasPreparedAndNeverCameIsLetGo) {
  std::vector<std::shared_ptr<Surfaces::Prepared>> many;
  std::vector<clay::Version> versions;
  for (int i = 0; i < 12; ++i) {
    versions.push_back(ball(20 + i));
    many.push_back(surfaces.prepare(versions.back()));
  }
  const std::weak_ptr<Surfaces::Prepared> first = many.front();
  many.erase(many.begin());
  EXPECT_TRUE(first.expired());
  const Document document = with(versions);
  surfaces.follow(document, 0);
  EXPECT_EQ(surfaces.ownBricks(), versions[0].stats().bricks) << "all others were ready, however many";
  picture.take(surfaces);
  for (Id piece = 1; piece <= 12; ++piece) EXPECT_TRUE(picture.shows(piece, versions[piece - 1]));
}

TEST_F(SurfacesTest, AnExtractionThatFailsLeavesNeitherGhostsNorAnotherGrade) {
  const clay::Version before = ball(60), other = ball(25);
  surfaces.setGrade(clay::Grade::fine);
  Document document = with({before, other});
  surfaces.follow(document, 0);
  picture.take(surfaces);
  // Two pieces change; there is no memory for the first, and the upper half of it goes.
  document.pieces[0].version = clay::combine(before, dabbed(ball(80), {0, 0, -80}, 90), clay::Combination::cut);
  document.pieces[1].version = dabbed(other, {25, 0, 0}, 4);
  {
    const tests::NoAlignedMemory none;
    EXPECT_THROW(surfaces.follow(document, 0), std::bad_alloc);
  }
  picture.take(surfaces);
  surfaces.follow(document, 0);
  picture.take(surfaces);
  EXPECT_TRUE(picture.shows(1, document.pieces[0].version, clay::Grade::fine));
  EXPECT_TRUE(picture.shows(2, document.pieces[1].version, clay::Grade::fine));
}

TEST(SurfaceOfOnePiece, KeepsItsGradeWhenAnExtractionFails) {
  const clay::Version before = ball(60);
  clay::Surface surface(true, clay::Grade::fine);
  surface.update(before);
  // Larger: what the first surface left in its pool is not enough.
  const clay::Version after = clay::combine(ball(110), dabbed(ball(140), {0, 0, -140}, 150), clay::Combination::cut);
  {
    const tests::NoAlignedMemory none;
    EXPECT_THROW(surface.update(after), std::bad_alloc);
  }
  surface.update(after);
  clay::Surface fresh(true, clay::Grade::fine);
  fresh.update(after);
  EXPECT_EQ(surface.hash(), fresh.hash());
}

// A system without threads: the first document, and the first journal of one that was begun without.
class RefusedWorkbench : public ::testing::Test {
 protected:
  static std::string said(Workbench& bench, std::string& all) {
    for (const Message& message : bench.takeMessages()) all += message.text + "\n";
    return all;
  }
};

TEST_F(RefusedWorkbench, TheFirstDocumentIsThereWhenTheSystemHasRoomForIt) {
  for (const int first : {1, 2, 3, 4}) {  // the edit thread's own, and then those of session, journal and device
    SCOPED_TRACE(first);
    Workbench::Options options;
    options.realtime = false;
    std::optional<tests::NoThreads> none(std::in_place, first);
    Workbench bench(options);
    std::string all;
    ASSERT_TRUE(until([] { return tests::NoThreads::refused() > 0; }));
    ASSERT_TRUE(until([&] { return !said(bench, all).empty(); }));
    EXPECT_NE(all.find("The system refused"), std::string::npos) << all;
    EXPECT_LT(std::count(all.begin(), all.end(), '\n'), 5) << "told once, not in every turn:\n" << all;
    none.reset();
    bench.addBlock({10, 10, 10}, 1, {.voxelMm = 0.5});
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
    bench.undo();
    EXPECT_TRUE(until([&] { return bench.snapshot()->document->pieces.empty(); }));
  }
}

TEST_F(RefusedWorkbench, AJournalThatCannotBeBegunIsAMessage) {
  Workbench::Options options;
  options.realtime = false;
  options.journal = false;
  options.undoBytes = 1;
  Workbench bench(options);
  bench.addBlock({10, 10, 10}, 1, {.voxelMm = 0.5});
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1 && bench.idle(); }));
  std::string all;
  {
    const tests::NoThreads none;
    // The clay before it is more than the budget: it wants a journal.
    bench.edit("Take away", [](Document& document) { document.remove(document.pieces[0].id); });
    bench.edit("Name", [](Document& document) { document.nextId += 1; });
    ASSERT_TRUE(until([] { return tests::NoThreads::refused() > 0; }));
    ASSERT_TRUE(until([&] { return said(bench, all).find("The system refused") != std::string::npos; })) << all;
    EXPECT_TRUE(until([&] { return bench.snapshot()->document->pieces.empty(); }))
        << "what was done is shown all the same";
  }
  bench.goTo(1);
  EXPECT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
}

}  // namespace
}  // namespace argil::engine
