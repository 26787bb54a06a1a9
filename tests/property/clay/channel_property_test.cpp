// Colour, material and mask under random strokes: what the clay promises about them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "clay/brush/brush.h"
#include "clay/brush/brush_channels.h"
#include "clay/field/primitives.h"
#include "clay/store/channel_source.h"
#include "clay/store/store.h"
#include "clay/surface/vertex_channels.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr double kRadius = 40;                // voxels
const Vec3d kCentre = Vec3d::Constant(-0.5);  // between voxels: its mirror planes are brick faces

Version sphere() {
  return makeSphere(Store::make(), Grid{0.5, 0.5 * kCentre, 3}, Vec3d::Zero() + 0.5 * 2 * kCentre, 0.5 * kRadius);
}

std::shared_ptr<Brush> brushOf(std::vector<Operation> operations) {
  auto brush = std::make_shared<Brush>();
  brush->operations = std::move(operations);
  return brush;
}
Operation distance(Method method, float amount = 1) {
  return {Property::distance, method, Falloff::smooth, amount};
}
Operation channel(Property property, Method method = Method::set, float amount = 1, Falloff shape = Falloff::constant) {
  return {property, method, shape, amount};
}

Version paintAll(const Version& base, std::array<uint8_t, 3> colour, uint8_t material) {
  const auto brush = brushOf({channel(Property::colour), channel(Property::material)});
  brush->colour = colour;
  brush->material = material;
  BrushStroke stroke(base, brush);
  stroke.apply(Stamp{Vec3d::Zero(), Vec3d::Zero(), 100});
  return stroke.finish();
}

Vec3d randomDirection(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vec3d(normal(random), normal(random), normal(random)).normalized();
}

std::shared_ptr<const Brush> randomBrush(std::mt19937_64& random) {
  const auto colourOf = [&] {
    return std::array{static_cast<uint8_t>(random()), static_cast<uint8_t>(random()), static_cast<uint8_t>(random())};
  };
  std::shared_ptr<Brush> brush;
  switch (random() % 10) {
    case 0:
      brush = brushOf({distance(Method::carve)});
      break;
    case 1:
      brush = brushOf({distance(Method::add)});
      break;
    case 2:
      brush = brushOf({distance(Method::smooth)});
      break;
    case 3:
      brush = brushOf({channel(Property::colour)});
      break;
    case 4:
      brush = brushOf({channel(Property::colour, Method::set, 0.1f, Falloff::smooth)});
      break;
    case 5:
      brush = brushOf({channel(Property::material)});
      break;
    case 6:
      brush = brushOf({channel(Property::mask, Method::set, random() % 2 ? 1.0f : -0.7f, Falloff::dome)});
      break;
    case 7:
      brush = brushOf({channel(Property::colour, Method::blur), channel(Property::mask, Method::blur)});
      break;
    case 8:
      brush = brushOf({distance(Method::carve), channel(Property::colour)});
      break;
    default:
      brush = brushOf({distance(Method::add)});
      brush->dye = true;
  }
  brush->colour = colourOf();
  brush->material = static_cast<uint8_t>(random() % 5);
  return brush;
}

Version randomStrokes(Version version, int strokes, uint64_t seed, size_t publishEvery,
                      const std::function<std::vector<Stamp>(const Stamp&)>& images) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int s = 0; s < strokes; ++s) {
    BrushStroke stroke(version, randomBrush(random));
    Vec3d a = kCentre + kRadius * randomDirection(random);
    const double radius = 4 + 4 * (u(random) + 1);
    const size_t count = 1 + random() % 6;
    for (size_t i = 0; i < count; ++i) {
      const Vec3d b = a + 0.4 * radius * Vec3d(u(random), u(random), u(random));
      stroke.apply(images(Stamp{a, b, radius, static_cast<float>(0.6 + 0.4 * u(random))}));
      a = b;
      if (publishEvery > 0 && i % publishEvery == 0) (void)stroke.publish();
    }
    version = stroke.finish();
  }
  return version;
}
std::vector<Stamp> alone(const Stamp& stamp) {
  return {stamp};
}

uint8_t byteAt(const Version& version, Channel channel, Coord voxel) {
  return version.find(channel, voxel >> 3).value(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7));
}
float phiAt(const Version& version, Coord voxel) {
  return version.find(voxel >> 3).phi(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7), version.grid().band);
}

template <class Visit>
void forBandVoxels(const Version& version, const Visit& visit) {
  version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < version.grid().band)
        visit(brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}, brick.phi(i));
  });
}

void expectOnlyInBand(const Version& version) {
  for (const Channel channel : kAllChannels)
    version.forEachBrick(channel, [&](const ChannelBrick& brick) {
      const Slot slot = version.find(brick.coord);
      ASSERT_FALSE(slot.isTile());
      for (int i = 0; i < kBrickVoxels; ++i)
        ASSERT_TRUE(brick.value[i] == 0 || std::abs(slot.brick()->phi(i)) < version.grid().band);
    });
  forBandVoxels(version, [&](Coord at, float) {
    if (byteAt(version, Channel::cover, at) > 0) return;
    for (const Channel channel : {Channel::red, Channel::green, Channel::blue})
      ASSERT_EQ(byteAt(version, channel, at), 0);
  });
}

TEST(Channels, StandOnlyWhereThereIsBandAfterRandomStrokes) {
  Version version = sphere();
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    version = randomStrokes(version, 8, seed, 2, alone);
    expectOnlyInBand(version);
    ASSERT_FALSE(testing::Test::HasFatalFailure()) << "seed " << seed;
  }
  EXPECT_TRUE(version.has(Channel::cover) && version.has(Channel::mask) && version.has(Channel::material));
}

TEST(Channels, AreEqualHoweverPublishedAndOnEverySimdTarget) {
  const uint64_t expected = randomStrokes(sphere(), 40, 7, 0, alone).hash();
  EXPECT_EQ(randomStrokes(sphere(), 40, 7, 1, alone).hash(), expected);
  EXPECT_EQ(randomStrokes(sphere(), 40, 7, 3, alone).hash(), expected);
  tests::forEachSimdTarget(
      [&](const std::string& name) { EXPECT_EQ(randomStrokes(sphere(), 40, 7, 2, alone).hash(), expected) << name; });
}

TEST(Channels, MirroredStrokesGiveMirroredBytes) {
  const auto mirrored = [](const Stamp& stamp) {
    Stamp image = stamp;
    image.a.x() = 2 * kCentre.x() - stamp.a.x();
    image.b.x() = 2 * kCentre.x() - stamp.b.x();
    image.axes.row(0) = -stamp.axes.row(0);
    return std::vector{stamp, image};
  };
  const Version version = randomStrokes(sphere(), 60, 11, 0, mirrored);
  size_t painted = 0;
  forBandVoxels(version, [&](Coord at, float phi) {
    const Coord image{-1 - at.x, at.y, at.z};
    ASSERT_EQ(phiAt(version, image), phi);
    for (const Channel channel : kAllChannels)
      ASSERT_EQ(byteAt(version, channel, image), byteAt(version, channel, at)) << at.x << ' ' << at.y << ' ' << at.z;
    painted += byteAt(version, Channel::cover, at) > 0;
  });
  EXPECT_GT(painted, 10000u);
}

TEST(Channels, NoSpeckOfPaintedClayIsLeftBareByCuttingAndLaying) {
  std::mt19937_64 random(3);
  Version version = paintAll(sphere(), {200, 40, 10}, 3);
  for (int s = 0; s < 30; ++s) {
    BrushStroke stroke(version, Brush::of(std::array{Method::carve, Method::add, Method::smooth}[random() % 3]));
    const Vec3d at = kCentre + 38 * randomDirection(random);
    const Vec3d step = 2 * randomDirection(random);
    for (int i = 0; i < 4; ++i) stroke.apply(Stamp{at + i * step, at + (i + 1) * step, 12});
    version = stroke.finish();
  }
  size_t voxels = 0;
  forBandVoxels(version, [&](Coord at, float) {
    ++voxels;
    ASSERT_EQ(byteAt(version, Channel::cover, at), 255);
    ASSERT_EQ(byteAt(version, Channel::red, at), 200);
    ASSERT_EQ(byteAt(version, Channel::green, at), 40);
    ASSERT_EQ(byteAt(version, Channel::blue, at), 10);
    ASSERT_EQ(byteAt(version, Channel::material, at), 3);
  });
  EXPECT_GT(voxels, 50000u);
}

TEST(Channels, NewClayHasTheColourOfTheSideThatItIsOn) {
  // Blue all over, red where x > 0, then a groove across the seam.
  Version version = paintAll(sphere(), {0, 0, 255}, 1);
  const auto red = brushOf({channel(Property::colour), channel(Property::material)});
  red->colour = {255, 0, 0};
  red->material = 2;
  BrushStroke half(version, red);
  half.apply(Stamp{{1000, 0, 0}, {1000, 0, 0}, 1000});
  version = half.finish();
  BrushStroke groove(version, Brush::of(Method::carve));
  for (int i = -10; i < 10; ++i) groove.apply(Stamp{{2.0 * i, 0, 38}, {2.0 * (i + 1), 0, 38}, 8});
  version = groove.finish();
  size_t far = 0;
  forBandVoxels(version, [&](Coord at, float) {
    if (std::abs(at.x) < 10) return;
    ++far;
    ASSERT_EQ(byteAt(version, Channel::red, at), at.x > 0 ? 255 : 0) << at.x << ' ' << at.y << ' ' << at.z;
    ASSERT_EQ(byteAt(version, Channel::blue, at), at.x > 0 ? 0 : 255);
    ASSERT_EQ(byteAt(version, Channel::material, at), at.x > 0 ? 2 : 1);
  });
  EXPECT_GT(far, 50000u);
}

TEST(Channels, MaskedVoxelsKeepEveryBitUnderAnyBrush) {
  Version version = paintAll(sphere(), {10, 20, 30}, 1);
  BrushStroke masking(version, brushOf({channel(Property::mask)}));
  masking.apply(Stamp{{-0.5, -0.5, 40}, {-0.5, -0.5, 40}, 15});
  version = masking.finish();
  std::vector<Coord> held;
  forBandVoxels(version, [&](Coord at, float) {
    if (byteAt(version, Channel::mask, at) == 255) held.push_back(at);
  });
  ASSERT_GT(held.size(), 1000u);
  const std::vector<std::shared_ptr<Brush>> brushes{
      brushOf({distance(Method::carve)}),     brushOf({distance(Method::add)}),
      brushOf({distance(Method::smooth)}),    brushOf({channel(Property::colour)}),
      brushOf({channel(Property::material)}), brushOf({channel(Property::colour, Method::blur)})};
  for (size_t b = 0; b < brushes.size(); ++b) {
    brushes[b]->colour = {255, 255, 255};
    brushes[b]->material = 9;
    BrushStroke stroke(version, brushes[b]);
    for (int i = 0; i < 6; ++i) stroke.apply(Stamp{{-25.0 + 8 * i, 0, 38}, {-17.0 + 8 * i, 0, 38}, 12});
    const Version after = stroke.finish();
    EXPECT_TRUE(b == 5 || after.hash() != version.hash());  // an even colour stays when it is blurred
    for (const Coord at : held) {
      ASSERT_EQ(phiAt(after, at), phiAt(version, at)) << "brush " << b;
      for (const Channel channel : kAllChannels)
        ASSERT_EQ(byteAt(after, channel, at), byteAt(version, channel, at)) << "brush " << b;
    }
  }
}

TEST(Channels, PaintMakesNoDistanceBrickAndClayWithoutAnyMakesNoChannelBrick) {
  const Version bare = sphere();
  BrushStroke cut(bare, Brush::of(Method::carve));
  for (int i = 0; i < 5; ++i) cut.apply(Stamp{{-0.5 + 3 * i, 0, 40}, {2.5 + 3 * i, 0, 40}, 10});
  const Version after = cut.finish();
  EXPECT_EQ(cut.counts().channelBricksMade, 0u);
  EXPECT_EQ(after.stats().channelBricks, 0u);
  const auto brush = brushOf({channel(Property::colour)});
  brush->colour = {1, 2, 3};
  BrushStroke paint(after, brush);
  paint.apply(Stamp{{-0.5, 0, 40}, {5, 0, 40}, 10});
  const Version painted = paint.finish();
  EXPECT_EQ(paint.counts().bricksMade, 0u);
  EXPECT_GT(paint.counts().channelBricksMade, 0u);
  EXPECT_EQ(painted.stats().bricks, after.stats().bricks);
  // Erased again, nothing is left of it.
  brush->operations[0].amount = -1;
  BrushStroke erase(painted, brush);
  erase.apply(Stamp{{-0.5, 0, 40}, {5, 0, 40}, 12});
  EXPECT_EQ(erase.finish().hash(), after.hash());
}

TEST(Channels, AWeakBrushArrivesAndNeverPasses) {
  uint8_t value = 0;
  ChannelBytes bytes{};
  for (int i = 0; i < 400; ++i) {
    const uint8_t next = approach(value, 255, 0.02f);
    ASSERT_GE(next, value);
    value = next;
    layColour(bytes, {250, 100, 7}, 0.02f);
  }
  EXPECT_EQ(value, 255);
  EXPECT_EQ(bytes, (ChannelBytes{250, 100, 7, 255, 0, 0}));
  EXPECT_EQ(approach(10, 0, 0.001f), 10);
}

TEST(Channels, BlurMeetsInTheMiddleAndKeepsAnEvenColour) {
  Version version = paintAll(sphere(), {0, 0, 255}, 1);
  const auto red = brushOf({channel(Property::colour)});
  red->colour = {255, 0, 0};
  BrushStroke half(version, red);
  half.apply(Stamp{{1000, 0, 0}, {1000, 0, 0}, 1000.8});  // its border at x = 0, 40 voxels above the middle
  version = half.finish();
  BrushStroke blurring(version, brushOf({channel(Property::colour, Method::blur)}));
  for (int i = 0; i < 30; ++i) blurring.apply(Stamp{{0, 0, 40}, {0, 0, 40}, 14});
  const Version after = blurring.finish();
  const auto redAt = [&](int x) { return int{byteAt(after, Channel::red, {x, 0, 39})}; };
  EXPECT_NEAR(redAt(0), 128, 20);
  for (int x = -8; x < 8; ++x) EXPECT_LE(redAt(x), redAt(x + 1));
  EXPECT_EQ(redAt(-14), 0);
  EXPECT_EQ(redAt(14), 255);
  forBandVoxels(after, [&](Coord at, float) { ASSERT_EQ(byteAt(after, Channel::cover, at), 255); });
}

TEST(Channels, ADyeingBrushColoursWhatItLaysAndNothingElse) {
  const Version version = paintAll(sphere(), {0, 0, 255}, 1);
  const auto brush = brushOf({distance(Method::add)});
  brush->dye = true;
  brush->colour = {255, 255, 0};
  BrushStroke stroke(version, brush);
  stroke.apply(Stamp{{-0.5, -0.5, 40}, {-0.5, -0.5, 40}, 10});
  const Version after = stroke.finish();
  size_t laid = 0;
  forBandVoxels(after, [&](Coord at, float phi) {
    const float moved = phiAt(version, at) - phi;
    if (moved >= 1) {
      ++laid;
      // What redistancing moved by less than a voxel dyes in part.
      ASSERT_GE(byteAt(after, Channel::red, at), std::abs(phi) < 0.5f ? 255 : 170);
      ASSERT_LE(byteAt(after, Channel::blue, at), std::abs(phi) < 0.5f ? 0 : 85);
    } else if (moved <= 0 && std::abs(phiAt(version, at)) < 3) {
      ASSERT_EQ(byteAt(after, Channel::red, at), 0);
    }
  });
  EXPECT_GT(laid, 1000u);
}

TEST(SurfacePaint, FollowedEqualsFreshAndPaintExtractsNothing) {
  Version version = sphere();
  Surface followed;
  std::map<Coord, std::vector<VertexPaint>> shown;
  const auto follow = [&](const Version& next) {
    const SurfaceDelta delta = followed.update(next);
    for (const BrickMeshPtr& mesh : delta.changed)
      if (mesh->positions.empty()) shown.erase(mesh->brick);
    for (const auto& paint : delta.painted) shown[paint->brick] = paint->vertices;
    return delta.changed.size();
  };
  follow(version);
  EXPECT_TRUE(shown.empty());
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    version = randomStrokes(version, 4, seed, 0, alone);
    follow(version);
    const std::vector<VertexPaint> fresh = meshPaint(followed);
    if (!version.has(Channel::cover) && !version.has(Channel::mask) && !version.has(Channel::material)) continue;
    ASSERT_EQ(fresh.size(), followed.vertexCount());
    size_t at = 0, set = 0;
    followed.forEach([&](const BrickMesh& mesh) {
      const auto mine = shown.find(mesh.brick);
      for (size_t i = 0; i < mesh.positions.size(); ++i, ++at) {
        const VertexPaint paint = mine == shown.end() || mine->second.empty() ? VertexPaint{} : mine->second.at(i);
        ASSERT_EQ(paint, fresh[at]) << "seed " << seed;
        set += paint != VertexPaint{};
      }
    });
    EXPECT_GT(set, 100u);
  }
  const auto brush = brushOf({channel(Property::colour)});
  brush->colour = {9, 8, 7};
  BrushStroke stroke(version, brush);
  stroke.apply(Stamp{{0, 0, 40}, {0, 0, 40}, 6});
  const Version painted = stroke.finish();
  EXPECT_EQ(follow(painted), 0u);
  bool found = false;
  for (const auto& [brick, paint] : shown)
    for (const VertexPaint& each : paint)
      found = found || (each.red == 9 && each.green == 8 && each.blue == 7 && each.cover == 255);
  EXPECT_TRUE(found);
}

// Clay that moves without changing its shape.
class Shift : public DistanceMethod {
 public:
  bool brick(Sampler&, std::span<const Stamp>, Coord, float (&)[kBrickVoxels]) const override { return false; }
  bool origins(std::span<const Stamp>, Coord coord, Vec3f (&from)[kBrickVoxels]) const override {
    for (int i = 0; i < kBrickVoxels; ++i)
      from[i] = (coord * kBrickEdge + Coord{(i >> 6) - 3, (i >> 3) & 7, i & 7}).toVec3d().cast<float>();
    return true;
  }
};

TEST(Channels, GoAlongWithClayThatMovesThoughItLooksTheSame) {
  const Version plain = paintAll(makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {60, 40, 20}, 0), {0, 0, 255}, 1);
  const auto spot = brushOf({channel(Property::colour), channel(Property::material)});
  spot->colour = {255, 0, 0};
  spot->material = 4;
  BrushStroke stroke(plain, spot);
  stroke.apply(Stamp{{0, 0, 20}, {0, 0, 20}, 6});
  const Version painted = stroke.finish();
  Editor editor(painted);
  const Shift shift;
  const Stamp stamp{{0, 0, 20}, {0, 0, 20}, 20};
  CarriedFrom carried;
  carryChannels(editor, painted, *Brush::of(Method::tug), &shift, std::span(&stamp, 1), carried);
  const Version moved = editor.commit();
  for (int x = -12; x <= 12; ++x)
    for (int y = -12; y <= 12; ++y)
      for (const Channel channel : {Channel::red, Channel::blue, Channel::cover, Channel::material})
        ASSERT_EQ(byteAt(moved, channel, {x, y, 20}), byteAt(painted, channel, {x - 3, y, 20}));
  EXPECT_NE(moved.hash(), painted.hash());
}

// A thread of clay longer than 65 535 voxels, away from painted clay: colours come from as many steps away as a count
// of 16 bits does not hold.
TEST(Channels, AStrokeLongerThanAnyCountOfStepsTakesItsColourAlong) {
  const auto store = Store::make();
  constexpr double kEnd = 33500;
  const Version start = paintAll(makeSphere(store, Grid{}, Vec3d(-kEnd / 2, 0, 0), 6), {200, 10, 30}, 2);
  Version version = start;
  {
    const auto brush = brushOf({channel(Property::colour), channel(Property::material)});
    brush->colour = {200, 10, 30};
    brush->material = 2;
    BrushStroke paint(version, brush);
    paint.apply(Stamp{{-kEnd, 0, 0}, {-kEnd, 0, 0}, 30});
    version = paint.finish();
  }
  BrushStroke stroke(version, Brush::of(Method::add));
  // Forth and back, and across: the far end is more than 65 535 steps along the band from the paint.
  for (double x = -kEnd; x < kEnd; x += 250) stroke.apply(Stamp{{x, 0, 0}, {x + 250, 0, 0}, 2.5});
  const Version after = stroke.finish();
  size_t seen = 0;
  for (int x = static_cast<int>(kEnd) - 40; x < static_cast<int>(kEnd); ++x)
    for (int y = -4; y <= 4; ++y) {
      const Coord at{x, y, 0};
      if (std::abs(phiAt(after, at)) >= 3) continue;
      ++seen;
      ASSERT_EQ(byteAt(after, Channel::red, at), 200) << x << ' ' << y;
      ASSERT_EQ(byteAt(after, Channel::material, at), 2);
    }
  EXPECT_GT(seen, 200u);
}

// Clay that is painted anywhere makes versions of each application: what they alone used is freed on the way.
TEST(Channels, MemoryOfAStrokeFollowsWhatItChangedAndNotItsStamps) {
  const auto store = Store::make();
  const Version version =
      paintAll(makeSphere(store, Grid{0.5, 0.5 * kCentre, 3}, 0.5 * 2 * kCentre, 0.5 * kRadius), {200, 10, 30}, 2);
  while (store->collect()) {
  }
  const uint64_t before = store->usage().bytes();
  BrushStroke stroke(version, Brush::of(Method::add));
  uint64_t most = 0;
  for (int i = 0; i < 600; ++i) {
    const double x = i % 120 < 60 ? i % 60 : 60 - i % 60;
    stroke.apply(Stamp{{30.0 + x, 0, 0}, {31.0 + x, 0, 0}, 10});
    most = std::max(most, store->usage().bytes());
  }
  const Version after = stroke.finish();
  while (store->collect()) {
  }
  const uint64_t changed = store->usage().bytes() - before;
  std::printf("%.1f MB at most for %.1f MB of clay\n", 1e-6 * static_cast<double>(most - before),
              1e-6 * static_cast<double>(changed));
  EXPECT_LE(most - before, 2 * changed + (4u << 20));
}

// Where the cover that a stroke around the sphere's top left falls to half of what it is in the middle, seen from the
// middle along a ray over the sphere: the arc, voxels.
double borderAt(ChannelSource& channels, Channel shown, const Vec3d& top, const Vec3d& along) {
  const auto coverAt = [&](double arc) {
    const double angle = arc / kRadius;
    ChannelBytes bytes{};
    const Vec3d place = kCentre + kRadius * (std::cos(angle) * top + std::sin(angle) * along);
    return channels.between(place, bytes) ? int{bytes[indexOf(shown)]} : 0;
  };
  const int half = (coverAt(0) + 1) / 2;
  double arc = 0;
  while (arc < 40 && coverAt(arc) >= half) arc += 0.01;
  return arc;
}

// The border of what is painted is the stamp's, as the surface has it: no tooth is left of the voxels.
TEST(Channels, APaintedBorderIsAsSmoothAsTheStampsIs) {
  const Version base = sphere();
  for (const Vec3d& given : {Vec3d(0, 0, 1), Vec3d(0.3, -0.2, 1), Vec3d(1, 1, 1), Vec3d(0.1, 1, 0.7)})
    for (const Falloff shape : {Falloff::constant, Falloff::dome, Falloff::smooth, Falloff::linear})
      for (const int stamps : {1, 20}) {
        const Vec3d top = given.normalized(), side = top.unitOrthogonal(), other = top.cross(side);
        const double radius = 12.3;
        const Vec3d middle = kCentre + kRadius * top;
        for (const auto& [property, shown] :
             {std::pair(Property::colour, Channel::cover), std::pair(Property::mask, Channel::mask)}) {
          BrushStroke stroke(base, brushOf({channel(property, Method::set, 1, shape)}));
          for (int i = 0; i < stamps; ++i) stroke.apply(Stamp{middle, middle, radius});
          const Version painted = stroke.finish();
          ChannelSource channels(painted);
          double least = 99, most = 0;
          for (int k = 0; k < 90; ++k) {
            const double angle = k * 0.0698;
            const double arc = borderAt(channels, shown, top, std::cos(angle) * side + std::sin(angle) * other);
            least = std::min(least, arc), most = std::max(most, arc);
          }
          // The constant falloff ends at the ball's border on the sphere.
          const double expected = 2 * kRadius * std::asin(0.5 * radius / kRadius);
          EXPECT_LE(most - least, 0.25) << static_cast<int>(shape) << ", " << stamps << " stamps";
          if (shape == Falloff::constant) {
            EXPECT_NEAR(0.5 * (least + most), expected, 0.15) << stamps << " stamps";
          }
        }
      }
}

}  // namespace
}  // namespace argil::clay
