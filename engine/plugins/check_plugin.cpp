#include "engine/plugins/check_plugin.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/brush/formula.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/plugins/plugin.h"

namespace argil::engine {

namespace {

constexpr double kRadius = 9, kBall = 30;  // voxels
constexpr int kRandom = 6;                 // sets of numbers

class BrushTrial {
 public:
  explicit BrushTrial(const FormulaTool& tool) : tool_(tool) {
    std::vector<std::string> names;
    names.reserve(tool.numbers.size());
    for (const auto& number : tool.numbers) names.push_back(number.id);
    formula_ = std::make_shared<const clay::Formula>(tool.formula, names);
    clay::Grid grid;
    grid.originMm = Vec3d::Constant(grid.voxelMm / 2);  // a plane between bricks through the middle
    ball_ = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kBall * grid.voxelMm);
  }

  // Sets of numbers: as it begins, all low, all high, at random.
  [[nodiscard]] std::vector<std::vector<float>> numbers() const {
    std::vector<std::vector<float>> sets(3 + kRandom);
    Random random(1);
    for (const auto& number : tool_.numbers)
      for (size_t i = 0; i < sets.size(); ++i)
        sets[i].push_back(static_cast<float>(i == 0   ? number.standard
                                             : i == 1 ? number.low
                                             : i == 2 ? number.high
                                             : number.logarithmic
                                                 ? number.low * std::pow(number.high / number.low, random.unit())
                                                 : random.between(number.low, number.high)));
    return sets;
  }

  [[nodiscard]] clay::Version stroked(const std::vector<float>& numbers, float strength, float amount = 1,
                                      bool mirrored = false, int publishEvery = 100) const {
    auto brush = std::make_shared<clay::Brush>();
    brush->operations.push_back({clay::Property::distance, clay::Method::formula, tool_.falloff, amount});
    brush->formula = formula_;
    brush->values = numbers;
    clay::BrushStroke stroke(ball_, brush);
    for (size_t i = 0; i < stamps().size(); ++i) {
      clay::Stamp stamp = stamps()[i];
      stamp.strength = strength;
      clay::Stamp image = stamp;
      image.a.x() = -1 - stamp.a.x();
      image.b.x() = -1 - stamp.b.x();
      image.axes.row(0) *= -1;
      if (mirrored)
        stroke.apply(std::array{stamp, image});
      else
        stroke.apply(stamp);
      if (static_cast<int>(i + 1) % publishEvery == 0) (void)stroke.publish();
    }
    return stroke.finish();
  }

  [[nodiscard]] const clay::Version& ball() const { return ball_; }

  // Empty, or what is wrong with clay that it made.
  [[nodiscard]] std::string problemOf(const clay::Version& made) const {
    const double reach = kRadius + 3 + 2 * clay::kBrickEdge;
    std::string problem;
    made.forEachBrick([&](const clay::Brick& brick) {
      const Vec3d middle = (brick.coord * clay::kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
      double away = 1e9;
      for (const clay::Stamp& each : stamps()) away = std::min(away, (middle - each.a).norm());
      const clay::Slot was = ball_.find(brick.coord);
      for (int i = 0; i < clay::kBrickVoxels; ++i) {
        if (!(std::abs(brick.phi(i)) <= 3)) problem = "a distance that is not finite or beyond the band";
        if (away > reach && brick.phi(i) != was.phi(i, 3)) problem = "clay changed beyond the tip";
      }
    });
    clay::Surface surface(false);
    surface.update(made);
    if (!clay::checkTopology(surface.toMesh()).closed()) problem = "the surface is not closed";
    return problem;
  }

  // Whether the half below x = −1/2 is the mirror image of the other, to the bit.
  [[nodiscard]] static bool symmetric(const clay::Version& made) {
    bool same = true;
    made.forEachBrick([&](const clay::Brick& brick) {
      const clay::Slot slot = made.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
      for (int i = 0; i < clay::kBrickVoxels; ++i)
        same = same && brick.phi(i) == slot.phi(clay::Brick::offset(7 - (i >> 6), (i >> 3) & 7, i & 7), 3);
    });
    return same;
  }

 private:
  static const std::vector<clay::Stamp>& stamps() {
    static const std::vector<clay::Stamp> all = [] {
      std::vector<clay::Stamp> made;
      Vec3d at(4, 3, kBall);
      for (int i = 0; i < 12; ++i) {
        const Vec3d to = at + Vec3d(0.9, 0.4, -0.2);
        made.push_back({at, to, kRadius});
        at = to;
      }
      return made;
    }();
    return all;
  }

  FormulaTool tool_;
  std::shared_ptr<const clay::Formula> formula_;
  clay::Version ball_;
};

void checkBrush(const FormulaTool& tool, std::vector<PluginCheck>& checks) {
  const auto say = [&](const char* what, std::string problem) {
    checks.push_back({fmt::format("{}: {}", tool.id, what), std::move(problem)});
  };
  const BrushTrial trial(tool);
  const auto sets = trial.numbers();
  const clay::Version usual = trial.stroked(sets[0], 1);
  say("changes the clay", usual == trial.ball() || usual.hash() == trial.ball().hash()
                              ? "it does nothing at full strength, with its numbers as they begin"
                              : "");
  std::string problem;
  for (const auto& numbers : sets)
    for (const float amount : {1.0f, -1.0f}) {
      if (amount < 0 && !tool.inverts) continue;
      if (std::string found = trial.problemOf(trial.stroked(numbers, 1, amount)); !found.empty()) {
        problem = std::move(found);
        for (size_t i = 0; i < numbers.size(); ++i)
          problem += fmt::format("{}{} = {:g}", i == 0 ? ", with " : ", ", tool.numbers[i].id, numbers[i]);
      }
    }
  say("leaves closed clay, changed under the tip alone, whatever its numbers", problem);
  say("does nothing at strength 0",
      trial.stroked(sets[0], 0).hash() == trial.ball().hash() ? "" : "it changes the clay");
  say("does the same however it is published",
      trial.stroked(sets[0], 1, 1, false, 1).hash() == usual.hash() ? "" : "it does not");
  say("mirrors to the bit", BrushTrial::symmetric(trial.stroked(sets[0], 1, 1, true)) ? "" : "it does not");
}

}  // namespace

std::vector<PluginCheck> checkPlugin(const std::filesystem::path& folder) {
  std::vector<PluginCheck> checks;
  Plugin plugin;
  try {
    plugin = readPlugin(folder);
    checks.push_back({fmt::format("{} can be read", kPluginFile), ""});
  } catch (const Error& error) {
    checks.push_back({fmt::format("{} can be read", kPluginFile), error.what()});
    return checks;
  }
  for (const FormulaTool& brush : plugin.brushes) checkBrush(brush, checks);
  return checks;
}

}  // namespace argil::engine
