// A minute's scribble over one place: what a long stroke leaves is swollen and smooth, as a short one's.

#include <gtest/gtest.h>

#include <cmath>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {
namespace {

constexpr double kBallMm = 40;

// Over the cap of a ball within 60 degrees of its top, for so long at 60 points a second.
std::vector<PathPoint> scribble(double seconds) {
  std::vector<PathPoint> path;
  for (int i = 0; i < int(60 * seconds); ++i) {
    const double tilt = std::sin(0.0437 * i), turn = 0.0291 * i;
    path.push_back(
        {i / 60.0, kBallMm * Vec3d(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt))});
  }
  return path;
}

struct Shape {
  double volume = 0, area = 0;
  /// 1 for a ball; folds and tears have more surface for what they hold.
  [[nodiscard]] double roughness() const { return area / std::cbrt(36 * M_PI * volume * volume); }
};

TEST(LongScribble, SwellsWithoutFolds) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), {.voxelMm = 1}, Vec3d::Zero(), kBallMm);
  const double before = 4.0 / 3 * M_PI * std::pow(kBallMm, 3);
  for (const char* id : {"inflate", "construct", "layer", "wax", "smooth"}) {
    SCOPED_TRACE(id);
    Tool tool = scriptTool(*findTool(id));
    tool.radiusMm = 15;
    Session session(Document::of(ball));
    session.beginStroke(tool);
    for (const PathPoint& point : scribble(60)) session.addPoint(point);
    session.endStroke();
    clay::Surface surface;
    surface.update(session.version());
    const clay::TopologyReport mesh = clay::checkTopology(surface.toMesh());
    EXPECT_TRUE(mesh.closed());
    EXPECT_EQ(mesh.bodies, 1u);
    const Shape shape{mesh.volume, mesh.area};
    EXPECT_LT(shape.roughness(), 1.08);
    std::printf("%s: %.3f times the volume, roughness %.4f\n", id, shape.volume / before, shape.roughness());
    if (std::string_view(id) == "smooth") {
      EXPECT_NEAR(shape.volume / before, 1, 0.05);
    } else {
      EXPECT_GT(shape.volume, 1.02 * before);
    }
  }
}

}  // namespace
}  // namespace argil::engine
