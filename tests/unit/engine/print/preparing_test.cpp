// A piece made ready to print, as scripts and the studio do it; and a wall limit under a simulated hand.

#include <gmock/gmock.h>

#include <cmath>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/whole/offset.h"
#include "engine/document/beside.h"
#include "engine/models/prepare_clay.h"
#include "engine/print/print_check.h"
#include "engine/session/run.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {
namespace {

using ::testing::HasSubstr;

clay::Grid grid() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return grid;
}
// A hollow block that stands on its long side, turned so that its y is up in the world.
Document turnedHollow() {
  Document document =
      Document::of(clay::shell(clay::makeBlock(clay::Store::make(), grid(), {3, 0, 0}, {30, 44, 24}, 3), 3, 0));
  Piece& piece = document.pieces[0];
  piece.name = "Box";
  piece.pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3d::UnitX()));
  piece.pose.translation = {100, -20, 7};
  return document;
}
Document done(const Document& before, const char* id, const std::function<void(PieceArguments&)>& change,
              std::vector<std::string>* notes = nullptr) {
  const PieceJob& row = *findPieceJob(id);
  PieceArguments arguments = standardArguments(row, before);
  change(arguments);
  const PieceResult result = runPieceJob(row, before, arguments);
  Document after = before;
  applyPieceResult(result, before, after);
  if (notes) *notes = result.notes;
  return after;
}

TEST(Preparing, DrainHolesLieAtTheWorldsBottom) {
  const Document before = turnedHollow();
  const PrintProcess& resin = printProcess("sla");
  const PrintReport trapped = checkPrint(before.pieces[0].version, before.pieces[0].pose, resin, nullptr);
  ASSERT_EQ(trapped.slices.traps.size(), 1u);
  EXPECT_TRUE(trapped.slices.traps[0].closed);
  std::vector<std::string> notes;
  const Document after = done(
      before, "drain", [](PieceArguments& a) { a.change<DrainValues>().plugs = true; }, &notes);
  ASSERT_EQ(after.pieces.size(), 3u);
  EXPECT_THAT(notes.at(0), HasSubstr("2 holes"));
  EXPECT_TRUE(checkPrint(after.pieces[0].version, after.pieces[0].pose, resin, nullptr).slices.traps.empty());
  // One bores through the lowest wall, one through the highest.
  const clay::BoxMm box = boundsOf(before.pieces[0]);
  clay::Sampler was(before.pieces[0].version), is(after.pieces[0].version);
  int low = 0, high = 0;
  for (double x = box.low.x(); x < box.high.x(); x += 0.5)
    for (double y = box.low.y(); y < box.high.y(); y += 0.5)
      for (const double z : {box.low.z() + 1.5, box.high.z() - 1.5}) {
        const Vec3d at = grid().toVoxel(before.pieces[0].pose.applyInverse({x, y, z}));
        if (was.trilinear(at) < 0 && is.trilinear(at) >= 0) ++(z < box.high.z() - 10 ? low : high);
      }
  const double hole = M_PI * 1.5 * 1.5 / 0.25;
  EXPECT_NEAR(low, hole, 10);
  EXPECT_NEAR(high, hole, 10);
  // Plugs stand beside it, on the ground, upright, and touch nothing.
  for (size_t i = 1; i < 3; ++i) {
    const clay::BoxMm plug = boundsOf(after.pieces[i]);
    EXPECT_GT(plug.low.x(), box.high.x());
    EXPECT_NEAR(plug.low.z(), box.low.z(), 0.6);
    EXPECT_NEAR((plug.high - plug.low).x(), 3.6, 0.9);  // its box, as it is turned
    EXPECT_THAT(after.pieces[i].name, HasSubstr("Box, plug"));
  }
  EXPECT_LT(boundsOf(after.pieces[1]).high.x(), boundsOf(after.pieces[2]).low.x());
}

TEST(Preparing, InfillHoldsAHollowAndSaysHowMuch) {
  const Document before = turnedHollow();
  std::vector<std::string> notes;
  const Document after = done(
      before, "infill",
      [](PieceArguments& a) { a.change<InfillValues>() = {.kind = clay::Infill::struts, .percent = 20, .wallMm = 2}; },
      &notes);
  EXPECT_THAT(notes.at(0), ::testing::AnyOf(HasSubstr("20 %"), HasSubstr("19.9 %"), HasSubstr("20.1 %"),
                                            HasSubstr("19.8 %"), HasSubstr("20.2 %")));
  // Bars are one way: two holes still drain all of it, as far as nothing stays on them.
  const Document drained = done(
      after, "drain", [](PieceArguments&) {}, &notes);
  const PrintReport report =
      checkPrint(drained.pieces[0].version, drained.pieces[0].pose, printProcess("sla"), nullptr);
  for (const clay::Trap& trap : report.slices.traps) EXPECT_FALSE(trap.closed);
}

TEST(Preparing, PegsStandAcrossTheCutInTheWorld) {
  Document before = turnedHollow();
  before.pieces[0].version = clay::makeBlock(clay::Store::make(), grid(), {3, 0, 0}, {30, 44, 24}, 3);
  std::vector<std::string> notes;
  for (const bool loose : {false, true}) {
    const Document after = done(
        before, "cut-pegs",
        [&](PieceArguments& a) {
          a.plane.pointMm = {100, -20, 9};
          a.plane.normal = Vec3d::UnitZ();
          a.change<PegValues>().loose = loose;
        },
        &notes);
    ASSERT_EQ(after.pieces.size(), loose ? 4u : 2u);
    EXPECT_THAT(notes.at(0), HasSubstr("2 pegs"));
    EXPECT_EQ(after.pieces[1].name, "Box, other side");
    // The upper half is what the plane faces; pegs of the lower one stand above the plane.
    EXPECT_NEAR(boundsOf(after.pieces[0]).low.z(), 9, 0.6);
    if (loose)
      EXPECT_NEAR(boundsOf(after.pieces[1]).high.z(), 9, 0.6);
    else
      EXPECT_GT(boundsOf(after.pieces[1]).high.z(), 12);
  }
}

// A wall before a mirror image holds the hand where it is, whatever the planes and turns.
TEST(Preparing, WallsOfImagesComeBackToTheHand) {
  StrokeImages images;
  images.mirrors = {{{3, 1, 2}, {1, 2, 0.5}}, {{-1, 4, 0}, {0, 1, -1}}};
  images.turns = 3;
  images.axisPointMm = {5, 1, 0};
  images.axis = {0.2, 0.1, 1};
  haptics::Pose pose;
  pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 1, 0).normalized()));
  pose.translation = {4, -3, 9};
  const ImageMaps maps(images, grid(), pose);
  ASSERT_EQ(maps.count(), 12u);
  clay::Stamp stamp;
  stamp.a = {10, -7, 3};
  stamp.b = {13, -5, 4};
  std::vector<clay::Stamp> out;
  maps.apply(stamp, out);
  for (size_t i = 0; i < out.size(); ++i) {
    clay::WallAhead wall{out[i].a, (out[i].b - out[i].a).normalized(), i};
    maps.bringBack(wall);
    EXPECT_LT((wall.place - stamp.a).norm(), 1e-9) << i;
    EXPECT_LT((wall.wall - (stamp.b - stamp.a).normalized()).norm(), 1e-9) << i;
  }
}

// However far a hand pushes the stylus through.
TEST(Preparing, AWallLimitHoldsUnderAHand) {
  const auto ran = [](double leastWallMm) {
    struct Ran {
      std::unique_ptr<Session> session;
      RunReport report;
      double left = 0, least = INFINITY, lowest = INFINITY;  // of the wall; of the ball's centre
    } result;
    const Script script = parseScript(
        R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.5}, {"block": {"size_mm": [60, 60, 14], "round_mm": 0}}],
            "strokes": [{"tool": "carve", "radius_mm": 4, "drive": "hand", "least_wall_mm": )" +
            std::to_string(leastWallMm) + R"(, "path": [[0,-10,0,16],[1.5,-10,0,-8],[2.5,10,3,-8],[3,10,3,16]]}]})",
        "test");
    result.session = std::make_unique<Session>(prepareClay(clay::Store::make(), script).version);
    clay::Surface surface;
    result.report = runScript(*result.session, surface, script, {});
    clay::Sampler sampler(result.session->version());
    const auto thick = [&](double x, double y) {
      double sum = 0;
      for (double z = -10; z < 12; z += 0.02)
        sum += sampler.trilinear(result.session->version().grid().toVoxel({x, y, z})) < 0 ? 0.02 : 0;
      return sum;
    };
    result.left = thick(-10, 0);
    for (double x = -20; x < 20; x += 0.5)
      for (double y = -9; y < 12; y += 0.5) result.least = std::min(result.least, thick(x, y));
    for (const ScriptStroke& each : result.report.recorded.strokes)
      for (const PathPoint& point : each.path) result.lowest = std::min(result.lowest, point.mm.z());
    return result;
  };
  const auto free = ran(0), limited = ran(3);
  EXPECT_LT(free.left, 0.5) << "the hand goes through";
  EXPECT_GE(limited.left, 3 - 0.05);
  EXPECT_LE(limited.left, 3.4) << "and is let down to it";
  std::printf("wall of 3 mm: %.2f mm left, %.2f at least; without a limit %.2f\n", limited.left, limited.least,
              free.left);
  EXPECT_GE(limited.least, 3 - 0.05) << "nowhere thinner";
  // Felt: the ball of 4 mm stays above the wall, and the hand that wants to go on feels it.
  const ServoReport &felt = *limited.report.servo, &unfelt = *free.report.servo;
  std::printf(
      "the ball's centre goes down to %.3f mm (0 is the limit; %.2f without it); %llu ticks at the most force (%llu)\n",
      limited.lowest, free.lowest, static_cast<unsigned long long>(felt.clamped),
      static_cast<unsigned long long>(unfelt.clamped));
  EXPECT_LT(free.lowest, -7);
  EXPECT_GE(limited.lowest, -0.05);
  EXPECT_GT(felt.clamped, unfelt.clamped + 500) << "pushed by several mm for most of a second";
  EXPECT_TRUE(limited.report.servo->fault.empty()) << limited.report.servo->fault;
}

}  // namespace
}  // namespace argil::engine
