#include "engine/models/export_cost.h"

#include <gtest/gtest.h>

namespace argil::engine {
namespace {

// Times that were measured lie between those that are said: seconds of a ball and of a sculpted head on one machine.
TEST(ExportTime, HoldsWhatWasMeasured) {
  MachineSpeed machine;
  const double by = machine.dabMs(20, 3, 1.5) / 0.646;
  struct Row {
    bool cad;
    size_t count;
    double tookS;
  };
  for (const Row& row : {Row{true, 100, 7.1}, Row{true, 500, 21}, Row{true, 500, 117}, Row{true, 1000, 34},
                         Row{false, 500, 22}, Row{false, 4000, 17}, Row{false, 4000, 38}, Row{false, 40000, 202}}) {
    ModelExport what;
    if (row.cad)
      what.cadQuads = row.count;
    else
      what.quads = row.count;
    const ExportTime time = exportTime(what, 1, !row.cad, row.cad, machine);
    EXPECT_LT(time.leastS, 1.6 * by * row.tookS) << row.count;
    EXPECT_GT(time.mostS, 0.7 * by * row.tookS) << row.count;
    EXPECT_LT(time.leastS, time.mostS);
    const ExportTime three = exportTime(what, 3, !row.cad, row.cad, machine);
    EXPECT_NEAR(three.mostS, 3 * time.mostS, 1e-9);
  }
  ModelExport triangles;
  EXPECT_EQ(exportTime(triangles, 5, false, false, machine).mostS, 0);
  EXPECT_EQ(exportTime(triangles, 5, true, false, machine).mostS, 0) << "no quads are asked for";
}

TEST(ExportTime, IsSaidInRoundNumbers) {
  EXPECT_EQ(sentence({0, 0}), "");
  EXPECT_EQ(sentence({17, 123}), "15 s to 2 min, by the shape");
  EXPECT_EQ(sentence({0.6, 2.2}), "1 s to 2 s, by the shape");
  EXPECT_EQ(sentence({54, 88}), "50 s to 90 s, by the shape");
  EXPECT_EQ(sentence({118, 122}), "about 2 min");
}

}  // namespace
}  // namespace argil::engine
