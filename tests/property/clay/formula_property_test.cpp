// What formulas promise: the arithmetic that they say, equal bits everywhere, mirrored in mirrors, bounded whatever
// they say.

#include "clay/brush/formula.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

const std::vector<std::string> kNumbers{"height", "pitch"};

// 512 random values for each input, and what a formula makes of them.
struct Voxels {
  explicit Voxels(uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> values(-3, 3);
    for (auto& input : of)
      for (float& each : input) each = values(random);
    for (size_t i = 0; i < kFormulaInputs; ++i) inputs[i] = {of[i], i >= static_cast<size_t>(FormulaInput::radius)};
  }
  [[nodiscard]] float at(FormulaInput input, int voxel) const {
    const auto i = static_cast<size_t>(input);
    return of[i][inputs[i].one ? 0 : voxel];
  }
  float of[kFormulaInputs][kBrickVoxels];
  FormulaOperand inputs[kFormulaInputs];
};

std::vector<float> run(const std::string& text, const Voxels& voxels, std::vector<float> numbers = {0.5f, 2}) {
  const Formula formula(text, kNumbers);
  float out[kBrickVoxels];
  formula.run(voxels.inputs, numbers, out);
  return {std::begin(out), std::end(out)};
}

std::string problemOf(const std::string& text, std::span<const std::string> numbers = kNumbers) {
  try {
    const Formula formula(text, numbers);
    return "none";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(Formula, SaysWhatDoublesSay) {
  struct Case {
    const char* text;
    std::function<double(double phi, double x, double y, double z, double height, double pitch)> says;
    double within;
  };
  const auto smooth = [](double a, double b, double t) {
    t = std::clamp((t - a) / (b - a), 0.0, 1.0);
    return t * t * (3 - 2 * t);
  };
  const std::vector<Case> cases{
      {"phi", [](double phi, auto...) { return phi; }, 0},
      {"2", [](auto...) { return 2; }, 0},
      {"height", [](double, double, double, double, double height, double) { return height; }, 0},
      {"1 + 2 * 3 - 4 / 8", [](auto...) { return 6.5; }, 0},
      {"x - y - z", [](double, double x, double y, double z, auto...) { return x - y - z; }, 1e-6},
      {"-x * -y", [](double, double x, double y, auto...) { return x * y; }, 1e-6},
      {"x / (y * y + 1)", [](double, double x, double y, auto...) { return x / (y * y + 1); }, 1e-6},
      {"min(x, max(y, z))", [](double, double x, double y, double z, auto...) { return std::min(x, std::max(y, z)); },
       0},
      {"x < y ? 1 : x > z ? 2 : 3",
       [](double, double x, double y, double z, auto...) { return x < y   ? 1
                                                                  : x > z ? 2
                                                                          : 3; }, 0},
      {"(x <= x) + (x >= y)", [](double, double x, double y, auto...) { return 1 + (x >= y); }, 0},
      {"sqrt(x)", [](double, double x, auto...) { return std::sqrt(std::max(x, 0.0)); }, 1e-6},
      {"floor(x) + fract(x)", [](double, double x, auto...) { return x; }, 1e-6},
      {"abs(x)", [](double, double x, auto...) { return std::abs(x); }, 0},
      {"sin(x * 300)",
       [](double, double x, auto...) { return std::sin(static_cast<double>(static_cast<float>(x) * 300.0f)); }, 1e-6},
      {"sin(x)", [](double, double x, auto...) { return std::sin(x); }, 1e-6},
      {"cos(x)", [](double, double x, auto...) { return std::cos(x); }, 1e-6},
      {"clamp(x, -1, height)",
       [](double, double x, double, double, double height, double) { return std::min(std::max(x, -1.0), height); }, 0},
      {"mix(x, y, height)",
       [](double, double x, double y, double, double height, double) { return x + height * (y - x); }, 1e-6},
      {"smoothstep(-1, pitch, x)",
       [smooth](double, double x, double, double, double, double pitch) { return smooth(-1, pitch, x); }, 1e-6},
      {"length(x, y, z)",
       [](double, double x, double y, double z, auto...) { return std::sqrt(x * x + y * y + z * z); }, 1e-6},
      {"a = x * y; b = a + z; b * a + phi;",
       [](double phi, double x, double y, double z, auto...) { return (x * y + z) * x * y + phi; }, 1e-5},
      {"\n phi\t- 1.5e-1 ", [](double phi, auto...) { return phi - 0.15; }, 1e-6},
  };
  const Voxels voxels(1);
  for (const Case& each : cases) {
    SCOPED_TRACE(each.text);
    const std::vector<float> out = run(each.text, voxels);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const double says = each.says(voxels.at(FormulaInput::phi, i), voxels.at(FormulaInput::x, i),
                                    voxels.at(FormulaInput::y, i), voxels.at(FormulaInput::z, i), 0.5, 2);
      ASSERT_NEAR(out[static_cast<size_t>(i)], says, each.within * std::max(1.0, std::abs(says))) << i;
    }
  }
}

TEST(Formula, WhatCannotBeReadIsSaidInOneLineThatNamesThePlace) {
  const std::vector<std::pair<std::string, const char*>> wrong{
      {"", "character 1: a value is missing at the end"},
      {"phi +", "a value is missing at the end"},
      {"phi + * 2", "character 7: a value is missing here"},
      {"phi phi", "nothing may follow"},
      {"phi - heigth", "character 7: \"heigth\" is not known"},
      {"tan(x)", "there is no function \"tan\""},
      {"min(x)", "',' is missing"},
      {"min(x, y", "')' is missing"},
      {"(x", "')' is missing"},
      {"x ? 1", "':' is missing"},
      {"a = 1", "';' is missing"},
      {"a = 1;", "a value is missing at the end"},
      {"x = 1; phi", "\"x\" has a meaning already"},
      {"height = 1; phi", "\"height\" has a meaning already"},
      {"sin = 1; phi", "\"sin\" has a meaning already"},
      {"a = 1; a = 2; a", "\"a\" has a meaning already"},
      {"1e99", "no number that can be used"},
      {"phi; phi", "nothing may follow"},
      {"x == y", "nothing may follow"},
      {std::string(5000, ' '), "5000 characters: 4000 is the most"},
      {std::string(100, '(') + "x" + std::string(100, ')'), "too deep"},
      {std::string(200, '-') + "x", "too deep"},
  };
  for (const auto& [text, what] : wrong) {
    const std::string said = problemOf(text);
    EXPECT_NE(said.find(what), std::string::npos) << text.substr(0, 40) << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
  std::string many = "x";
  for (int i = 0; i < 300; ++i) many += " * y + " + std::to_string(i);
  EXPECT_NE(problemOf(many).find("more than 256 steps"), std::string::npos) << problemOf(many);
  EXPECT_NE(problemOf("phi", std::vector<std::string>(9, "a")).find("8 is the most"), std::string::npos);
}

// Any text of a formula's own words is read or refused, and what is read runs.
TEST(Formula, RandomTextsAreReadOrRefused) {
  const std::vector<std::string> words{"phi", "x", "weight", "height", "1",   "0.5",  "+",   "-",   "*",
                                       "/",   "(", ")",      ",",      "?",   ":",    "<",   ">=",  ";",
                                       "=",   "a", "sin",    "noise",  "min", "mean", "mix", "sqrt"};
  std::mt19937_64 random(7);
  const Voxels voxels(2);
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (size_t n = 1 + random() % 9; n > 0; --n) text += words[random() % words.size()] + " ";
    try {
      (void)run(text, voxels);
      ++read;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(read, 500);
}

TEST(Formula, EqualPartsRunOnceAndNumbersNotAtAll) {
  EXPECT_EQ(Formula("phi + 1 / 3 * sin(2)", kNumbers).steps(), 1u);
  EXPECT_EQ(Formula("(x * y + 1) * (x * y + 1)", kNumbers).steps(), 3u);
  EXPECT_EQ(Formula("a = sin(x); phi", kNumbers).steps(), 0u) << "nobody reads a";
}

TEST(Formula, EqualBitsOnEveryTarget) {
  const Voxels voxels(3);
  const std::string text =
      "a = noise(x * 7, y * 7, z * 7); b = sin(a * 40) / (y + 0.01) + sqrt(abs(z)); b > a ? min(b, x) : floor(b * 3) + "
      "a";
  std::vector<float> first;
  tests::forEachSimdTarget([&](const std::string& name) {
    const std::vector<float> out = run(text, voxels);
    if (first.empty()) first = out;
    EXPECT_EQ(std::memcmp(out.data(), first.data(), sizeof(float) * out.size()), 0) << name;
  });
}

// Noise has no jumps, no direction that it prefers, and fills its range.
TEST(Formula, NoiseIsSmoothAndWithinItsRange) {
  Voxels voxels(4);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> far(-1000, 1000);
  double sum = 0, squares = 0;
  float least = 1, most = -1;
  const int rounds = 40;
  for (int round = 0; round < rounds; ++round) {
    for (size_t axis = 3; axis < 6; ++axis)
      for (float& each : voxels.of[axis]) each = far(random);
    const std::vector<float> here = run("noise(x, y, z)", voxels), beside = run("noise(x + 0.001, y, z)", voxels);
    for (size_t i = 0; i < here.size(); ++i) {
      least = std::min(least, here[i]);
      most = std::max(most, here[i]);
      sum += here[i];
      squares += here[i] * here[i];
      EXPECT_LE(std::abs(here[i] - beside[i]), 0.005);
    }
  }
  const double n = rounds * kBrickVoxels;
  EXPECT_NEAR(sum / n, 0, 0.02);
  EXPECT_NEAR(std::sqrt(squares / n), 0.4, 0.03);
  EXPECT_GE(least, -1);
  EXPECT_LE(most, 1);
  EXPECT_LT(least, -0.7);
  EXPECT_GT(most, 0.7);
}

std::shared_ptr<Brush> brushOf(const std::string& text, std::vector<float> values = {},
                               std::vector<std::string> names = {}) {
  auto brush = std::make_shared<Brush>();
  brush->operations.push_back({Property::distance, Method::formula});
  brush->formula = std::make_shared<const Formula>(text, names);
  brush->values = std::move(values);
  return brush;
}

Version sphere() {
  return makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
}

std::vector<Stamp> stamps() {
  std::vector<Stamp> all;
  Vec3d at(0, 3, 40);
  for (int i = 0; i < 12; ++i) {
    const Vec3d to = at + Vec3d(1.3, 0.4, -0.2);
    all.push_back({at, to, 9, 0.6f});
    at = to;
  }
  return all;
}

Version stroked(const Version& base, const std::shared_ptr<const Brush>& brush, int publishEvery = 1000,
                int threads = 1) {
  BrushStroke stroke(base, brush, {}, threads);
  int n = 0;
  for (const Stamp& each : stamps()) {
    stroke.apply(each);
    if (++n % publishEvery == 0) (void)stroke.publish();
  }
  return stroke.finish();
}

constexpr const char* kRipple = "phi - 0.4 * weight * (0.5 + 0.5 * sin(9 * r)) * (0.6 + noise(x, y, z)) * abs(nz + u)";

TEST(FormulaBrush, TheSameHoweverItIsPublishedAndOnAnyThreadsAndTargets) {
  const Version base = sphere();
  const auto brush = brushOf(kRipple);
  const uint64_t hash = stroked(base, brush).hash();
  EXPECT_NE(hash, base.hash());
  EXPECT_EQ(stroked(base, brush, 1).hash(), hash);
  EXPECT_EQ(stroked(base, brush, 5, 4).hash(), hash);
  tests::forEachSimdTarget([&](const std::string& name) { EXPECT_EQ(stroked(base, brush).hash(), hash) << name; });
}

TEST(FormulaBrush, LeavesAClosedSurface) {
  Surface surface(true, Grade::crisp);
  surface.update(stroked(sphere(), brushOf(kRipple)));
  EXPECT_TRUE(checkTopology(surface.toMesh()).closed());
}

// Smoothing that is written down is the built-in one: what the peer in the benchmark is, too.
TEST(FormulaBrush, SmoothingWrittenDownIsSmoothing) {
  const Version base = stroked(sphere(), brushOf(kRipple));
  const Version written = stroked(base, brushOf("phi + weight * (mean - phi)"));
  BrushStroke stroke(base, Brush::of(Method::smooth));
  for (const Stamp& each : stamps()) stroke.apply(each);
  const Version built = stroke.finish();
  float most = 0;
  built.forEachBrick([&](const Brick& brick) {
    const Slot other = written.find(brick.coord);
    for (int i = 0; i < kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < 1) most = std::max(most, std::abs(brick.phi(i) - other.phi(i, 3)));
  });
  EXPECT_LT(most, 0.001);
}

TEST(FormulaBrush, MirrorsToTheBit) {
  // Voxel 4 of a brick mirrors voxel 3 of another about the plane between bricks.
  Grid grid;
  grid.originMm = Vec3d::Constant(grid.voxelMm / 2);
  const Version base = makeSphere(Store::make(), grid, Vec3d::Zero(), 20);
  for (int axis = 0; axis < 3; ++axis) {
    BrushStroke stroke(base, brushOf(kRipple));
    for (Stamp each : stamps()) {
      each.axes = Eigen::AngleAxisf(0.7f, Vec3f(1, 2, 3).normalized()).toRotationMatrix();
      Stamp image = each;
      image.a[axis] = -1 - each.a[axis];
      image.b[axis] = -1 - each.b[axis];
      image.axes.row(axis) *= -1;
      stroke.apply(std::array{each, image});
    }
    const Version made = stroke.finish();
    EXPECT_NE(made.hash(), base.hash());
    made.forEachBrick([&](const Brick& brick) {
      Coord other = brick.coord;
      (&other.x)[axis] = -1 - (&other.x)[axis];
      const Slot slot = made.find(other);
      ASSERT_FALSE(slot.isTile());
      for (int i = 0; i < kBrickVoxels; ++i) {
        int p[3] = {i >> 6, (i >> 3) & 7, i & 7};
        p[axis] = 7 - p[axis];
        ASSERT_EQ(brick.phi(i), slot.phi(Brick::offset(p[0], p[1], p[2]), 3)) << axis;
      }
    });
  }
}

// Whatever a formula says, the clay stays a narrow band of finite distances, and changes under the tip alone.
TEST(FormulaBrush, NonsenseDoesNoHarm) {
  for (const char* text :
       {"0 / 0", "1 / 0", "-1 / 0", "phi - 1e30", "phi + 1e30", "sqrt(-1) / 0 * phi", "phi * 1e38 * 1e38", "0", "-0.0",
        "1", "noise(x * 1e30, y / 0, z)", "sin(1e38 * x)", "x < 3 ? 1 / 0 : phi - 2"}) {
    SCOPED_TRACE(text);
    const Version base = sphere(), made = stroked(base, brushOf(text));
    made.forEachBrick([&](const Brick& brick) {
      const Vec3d middle = (brick.coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
      const Slot was = base.find(brick.coord);
      double away = 1e9;
      for (const Stamp& each : stamps()) away = std::min(away, (middle - each.a).norm());
      for (int i = 0; i < kBrickVoxels; ++i) {
        ASSERT_TRUE(std::abs(brick.phi(i)) <= 3);
        ASSERT_FALSE(std::signbit(brick.phi(i)) && brick.phi(i) == 0);
        if (away > 9 + 7 + 8 + 3) {
          ASSERT_EQ(brick.phi(i), was.phi(i, 3));
        }
      }
    });
    Surface surface(false);
    surface.update(made);
    EXPECT_TRUE(checkTopology(surface.toMesh()).closed());
  }
}

TEST(FormulaBrush, AStampMovesTheSurfaceByAVoxelAndAHalfAtMost) {
  const Version base = sphere();
  BrushStroke stroke(base, brushOf("phi - 1e6"));
  stroke.apply(Stamp{Vec3d(0, 0, 40), Vec3d(0, 0, 40), 12, 1.0f});
  const Version made = stroke.finish();
  float highest = 0;
  made.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Vec3d p = (brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
      if (brick.phi(i) < 0) highest = std::max(highest, static_cast<float>(p.norm() - 40));
    }
  });
  EXPECT_GT(highest, 0.5f);
  EXPECT_LE(highest, 1.51f);
}

}  // namespace
}  // namespace argil::clay
