// Part of a piece is hidden, the rest is worked on, all comes back.

#include <gtest/gtest.h>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/session.h"
#include "engine/text/document_text.h"
#include "engine/tools/piece_jobs.h"
#include "tests/unit/haptics/painted_clay.h"

namespace argil::engine {
namespace {

clay::Version halfMaskedBall() {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), {.voxelMm = 0.5}, Vec3d::Zero(), 10);
  return haptics::testing::painted(ball, clay::Channel::mask, [](Coord v) {
    return v.x > 4 ? uint8_t{200} : v.x > 0 ? uint8_t{90} : uint8_t{0};
  });
}

uint8_t maskAt(const clay::Version& version, Coord v) {
  return version.find(clay::Channel::mask, v >> 3).value(clay::Brick::offset(v.x & 7, v.y & 7, v.z & 7));
}

void run(Session& session, const char* job) {
  const PieceJob* row = findPieceJob(job);
  ASSERT_NE(row, nullptr);
  const DocumentPtr before = session.document();
  const PieceResult result = runPieceJob(*row, *before, standardArguments(*row, *before));
  session.change(std::string(row->name), [&](Document& document) { applyPieceResult(result, *before, document); });
}

TEST(HideMasked, KeepsWhatIsHiddenAsItIsAndBringsItBack) {
  Session session(halfMaskedBall());
  const clay::Version before = session.version();
  run(session, "mask-hide");
  EXPECT_TRUE(session.document()->pieces[0].hideMasked);
  const clay::Version hidden = session.version();
  EXPECT_EQ(maskAt(hidden, {18, 0, 8}), 255);
  EXPECT_EQ(maskAt(hidden, {2, 0, 20}), 90) << "what is masked by half or less is neither hidden nor masked more";
  const haptics::Scene scene = sceneOf(*session.document(), {});
  EXPECT_TRUE(scene.pieces[0].hideMasked);

  // Across the rim, through both halves.
  for (const char* tool : {"carve", "add", "smooth", "inflate"}) {
    session.beginStroke(Tool{tool, 3});
    session.addPoint(0, {-8, 0, 6});
    session.addPoint(0.2, {8, 0, 6});
    session.endStroke();
  }
  const clay::Version worked = session.version();
  size_t compared = 0, changed = 0;
  hidden.forEachBrick([&](const clay::Brick& brick) {
    const clay::Slot now = worked.find(brick.coord);
    for (int i = 0; i < clay::kBrickVoxels; ++i) {
      const Coord v = brick.coord * clay::kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      const bool same = now.phi(i, hidden.grid().band) == brick.phi(i);
      changed += !same;
      if (maskAt(hidden, v) != 255) continue;
      ++compared;
      ASSERT_TRUE(same) << v.x << " " << v.y << " " << v.z;
      ASSERT_EQ(maskAt(worked, v), 255);
    }
  });
  EXPECT_GT(compared, 1000u);
  EXPECT_GT(changed, 1000u) << "the rest was worked on";

  run(session, "mask-show");
  EXPECT_FALSE(session.document()->pieces[0].hideMasked);
  EXPECT_EQ(session.version(), worked) << "showing changes no clay";
  EXPECT_EQ(sceneOf(*session.document(), {}).pieces[0].hideMasked, false);
  session.goTo(0);
  EXPECT_EQ(session.version(), before);
}

TEST(HideMasked, ComesBackFromItsText) {
  Document document = Document::of(halfMaskedBall());
  const std::string shown = documentText(document, {{1, 1}}, {});
  EXPECT_EQ(shown.find("hide_masked"), std::string::npos);
  EXPECT_FALSE(readDocumentText(shown, "it").document.pieces[0].hideMasked);
  document.pieces[0] = hideMasked(document.pieces[0]);
  EXPECT_TRUE(readDocumentText(documentText(document, {{1, 1}}, {}), "it").document.pieces[0].hideMasked);
}

}  // namespace
}  // namespace argil::engine
