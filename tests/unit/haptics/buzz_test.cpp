// The buzz of the source's volumes comes with a penalty and goes with a proxy.

#include "haptics/analysis/buzz.h"

#include <gtest/gtest.h>

#include "haptics/devices/sheets.h"

namespace argil::haptics {
namespace {

TEST(Buzz, ComesWithThePenaltyAndGoesWithTheProxy) {
  const DeviceSheet& sheet = deviceSheet("premium15");
  const BuzzRun penalty = runBuzz("penalty", sheet), god = runBuzz("god-object", sheet),
                proxy = runBuzz("proxy", sheet);
  std::printf(
      "tick to tick %.2f, %.2f, %.2f %% of peak; swing %.3f, %.3f, %.3f mm; %.0f, %.0f, %.0f turns a second (penalty, "
      "god-object, proxy)\n",
      penalty.jumpRms, god.jumpRms, proxy.jumpRms, penalty.swingMm, god.swingMm, proxy.swingMm, penalty.reversals,
      god.reversals, proxy.reversals);
  EXPECT_GT(penalty.jumpRms, 3);
  EXPECT_GT(penalty.swingMm, 0.5);
  EXPECT_GT(penalty.reversals, 20);
  for (const BuzzRun* quiet : {&god, &proxy}) {
    EXPECT_LT(quiet->jumpRms, 1);
    EXPECT_LT(quiet->swingMm, 0.05);
    EXPECT_EQ(quiet->reversals, 0);
    EXPECT_EQ(quiet->popped, 0);
    EXPECT_TRUE(quiet->ticks.back().touching);
  }
}

}  // namespace
}  // namespace argil::haptics
