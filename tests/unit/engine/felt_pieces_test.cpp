// A document of more pieces than the hand can feel at once.

#include "engine/tools/felt_pieces.h"

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/session/edit_loop.h"

namespace argil::engine {
namespace {

constexpr double kApartMm = 10;

// A row of balls along x; the first is worked on.
Document row(size_t count) {
  clay::Grid grid;
  grid.voxelMm = 1;
  const clay::Version ball = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 4);
  Document document;
  for (size_t i = 0; i < count; ++i) {
    Piece piece;
    piece.version = ball;
    piece.pose.translation = {kApartMm * double(i), 0, 0};
    document.add(std::move(piece));
  }
  return document;
}

std::vector<Id> idsOf(const Document& document, const FeltPieces& felt) {
  std::vector<Id> ids;
  for (const size_t place : felt.places()) ids.push_back(document.pieces.at(place).id);
  return ids;
}

bool has(const std::vector<Id>& ids, Id id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

TEST(FeltPieces, AllAreFeltWhereAllFit) {
  Document document = row(haptics::kMaxPieces);
  document.pieces[3].visible = false;
  FeltPieces felt;
  EXPECT_TRUE(felt.choose(document, Vec3d::Zero()));
  EXPECT_EQ(felt.places().size(), haptics::kMaxPieces - 1);
  EXPECT_EQ(felt.visible(), haptics::kMaxPieces - 1);
  EXPECT_FALSE(felt.choose(document, {300, 0, 0}));
}

TEST(FeltPieces, TheNearestAreFeltAndThoseThatStayKeepTheirPlaces) {
  const Document document = row(200);
  FeltPieces felt;
  EXPECT_TRUE(felt.choose(document, {1500, 5, 0}));
  const std::vector<Id> far = idsOf(document, felt);
  ASSERT_EQ(far.size(), haptics::kMaxPieces);
  EXPECT_EQ(far[0], 1u) << "what is worked on is always felt";
  for (Id id = 125; id <= 175; ++id) EXPECT_TRUE(has(far, id)) << id;
  EXPECT_FALSE(has(far, 50));
  // A little way changes nothing; a longer one some, and the rest stay where they are.
  EXPECT_FALSE(felt.choose(document, {1501, 5, 0}));
  EXPECT_FALSE(felt.choose(document, {1503, 5, 0}));
  EXPECT_TRUE(felt.choose(document, {1600, 5, 0}));
  const std::vector<Id> farther = idsOf(document, felt);
  ASSERT_EQ(farther.size(), haptics::kMaxPieces);
  EXPECT_TRUE(has(farther, 185));
  size_t stayed = 0;
  for (size_t i = 0; i < far.size(); ++i) {
    if (!has(farther, far[i])) continue;
    EXPECT_EQ(farther[i], far[i]);
    ++stayed;
  }
  EXPECT_GT(stayed, 50u);
  EXPECT_LT(stayed, 60u);
}

TEST(FeltPieces, TheSceneFollowsTheHandAndTheDocument) {
  Session session(row(200));
  std::unique_ptr<const haptics::Scene> scene;
  haptics::SampleRing ring(1000);
  EditLoop loop(session, haptics::Scene(),
                [&](std::unique_ptr<const haptics::Scene> next) {
                  next->check();
                  scene = std::move(next);
                },
                {});
  const auto at = [&](double x) {
    haptics::StylusSample sample;
    sample.proxy = {x, 0, 0};
    ring.push(sample);
    loop.turn(ring);
    double low = 1e9, high = -1e9;
    for (size_t i = 1; i < scene->pieces.size(); ++i) {
      low = std::min(low, scene->pieces[i].pose.translation.x());
      high = std::max(high, scene->pieces[i].pose.translation.x());
    }
    EXPECT_EQ(scene->pieces.size(), haptics::kMaxPieces);
    EXPECT_EQ(scene->workedOn, 1u);
    EXPECT_LT(low, x);
    EXPECT_GT(high, x);
  };
  at(700);
  EXPECT_EQ(loop.visiblePieces(), 200u);
  at(1800);
  const uint64_t versions = loop.versions();
  at(1800.5);
  EXPECT_EQ(loop.versions(), versions) << "a hand at rest publishes nothing";
  session.change("Hide", [](Document& document) {
    for (size_t i = 100; i < 190; ++i) document.pieces[i].visible = false;
  });
  loop.turn(ring);
  EXPECT_EQ(loop.visiblePieces(), 110u);
  EXPECT_EQ(scene->pieces.size(), haptics::kMaxPieces);
  session.change("Work on another", [](Document& document) { document.active = 5; });
  loop.turn(ring);
  EXPECT_EQ(scene->pieces[0].pose.translation.x(), 40);
}

TEST(FeltPieces, TheLastOfTheDocumentAreFeltWhereTheHandIs) {
  const Document document = row(200);
  FeltPieces felt;
  EXPECT_TRUE(felt.choose(document, {1990, 5, 0}));
  const std::vector<Id> ids = idsOf(document, felt);
  ASSERT_EQ(ids.size(), haptics::kMaxPieces);
  EXPECT_EQ(ids[0], 1u);
  for (Id id = 201 - Id(haptics::kMaxPieces - 1); id <= 200; ++id) EXPECT_TRUE(has(ids, id)) << id;
}

}  // namespace
}  // namespace argil::engine
