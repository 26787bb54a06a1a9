#include "render/surface/surface_layout.h"

#include <gtest/gtest.h>

#include "clay/base/error.h"
#include "tests/unit/render/field_surface.h"
#include "tests/unit/render/mirror_sink.h"

namespace argil::render {
namespace {

using test::FieldSurface;
using test::MirrorSink;

test::Field sphere(double radius, Vec3d centre = Vec3d(0.13, 0.21, 0.37)) {
  return [=](const Vec3d& p) { return (p - centre).norm() - radius; };
}

/// Triangles equal although positions were floats per brick: a voxel is 2^14 units, a brick's float holds 2^-20.
void expectSame(const MirrorSink& sink, const SurfaceLayout& layout, const FieldSurface& surface) {
  const auto drawn = sink.drawn(layout);
  EXPECT_EQ(drawn.size(), layout.triangleCount());
  EXPECT_EQ(drawn, test::inUnits(surface.triangles()));
}

TEST(SurfaceLayout, DrawsExactlyTheSurface) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  layout.apply(surface.update({}, {-3, -3, -3}, {2, 2, 2}, sphere(16)), sink);
  EXPECT_GT(layout.triangleCount(), 5000u);
  expectSame(sink, layout, surface);
}

TEST(SurfaceLayout, LeavesRoomForLevelsWhereThereIsMemory) {
  class Limited : public MirrorSink {
   public:
    void reserve(uint32_t vertexCount, uint32_t indexCount) override {
      if (vertexCount > most) throw Error("full", Error::Kind::work);
      ++growths;
      MirrorSink::reserve(vertexCount, indexCount);
    }
    uint32_t most = UINT32_MAX;
    int growths = 0;
  };
  const auto load = [](Limited& sink, bool room) {
    FieldSurface surface;
    BufferRanges ranges;
    if (room) ranges.leaveRoom();
    SurfaceLayout layout(ranges);
    layout.apply(surface.update({}, {-11, -11, -11}, {10, 10, 10}, sphere(80)), sink);
    expectSame(sink, layout, surface);
    try {
      for (size_t i = 0; i < layout.draws().size(); ++i) layout.prepareChunk(i, 2, sink);
    } catch (const Error&) {  // levels need not fit
      EXPECT_LT(sink.most, UINT32_MAX);
    }
    return sink.vertices.size();
  };
  Limited plain, roomy, tight;
  load(plain, false);
  EXPECT_GT(plain.growths, 1) << "the test sees nothing";
  const size_t whole = load(roomy, true);
  EXPECT_EQ(roomy.growths, 1);
  tight.most = uint32_t(whole) * 9 / 10;
  EXPECT_LT(load(tight, true), whole) << "what fits is drawn";
}

TEST(SurfaceLayout, SmallChangeOnALargeModelUploadsLittle) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  const auto ball = sphere(52);
  layout.apply(surface.update({}, {-8, -8, -8}, {7, 7, 7}, ball), sink);
  const uint64_t whole = sink.bytes;
  sink.bytes = 0;
  const Vec3d dent(52, 0, 0);
  const auto dented = [&](const Vec3d& p) { return std::max(ball(p), 3.0 - (p - dent).norm()); };
  const auto delta = surface.update({}, {-8, -8, -8}, {7, 7, 7}, dented);
  ASSERT_GT(delta.changed.size(), 0u);
  layout.apply(delta, sink);
  expectSame(sink, layout, surface);
  uint64_t changedBytes = 0;
  for (const auto& mesh : delta.changed) changedBytes += mesh->positions.size() * 16 + mesh->quads.size() * 24;
  EXPECT_LE(sink.bytes, 4 * changedBytes) << "of the whole " << whole;
  EXPECT_LE(sink.bytes, whole / 20);
}

TEST(SurfaceLayout, TheSameDeltaAgainUploadsNothing) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  const auto delta = surface.update({}, {-2, -2, -2}, {1, 1, 1}, sphere(10));
  layout.apply(delta, sink);
  sink.bytes = 0;
  layout.apply(delta, sink);
  EXPECT_EQ(sink.bytes, 0u);
}

TEST(SurfaceLayout, SurfaceThatIsGoneIsNotDrawn) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  layout.apply(surface.update({}, {-2, -2, -2}, {1, 1, 1}, sphere(10)), sink);
  layout.apply(surface.update({}, {-2, -2, -2}, {1, 1, 1}, [](const Vec3d&) { return 1.0; }), sink);
  EXPECT_EQ(layout.triangleCount(), 0u);
  EXPECT_EQ(layout.brickCount(), 0u);
  EXPECT_TRUE(layout.draws().empty());
  EXPECT_TRUE(layout.bounds().empty());
}

TEST(SurfaceLayout, ReachesTheEndsOfTheCoordinates) {
  for (const int brick : {-16384, 16383}) {
    FieldSurface surface;
    BufferRanges ranges;
    SurfaceLayout layout(ranges);
    MirrorSink sink;
    const Vec3d centre = Vec3d::Constant(brick * 8.0 + 4.1);
    layout.apply(surface.update({}, Coord{brick, brick, brick}, Coord{brick, brick, brick}, sphere(2.5, centre)), sink);
    expectSame(sink, layout, surface);
    ASSERT_EQ(layout.draws().size(), 1u);
    EXPECT_LE(layout.draws()[0].min.x(), centre.x() - 2.5);
    EXPECT_GE(layout.draws()[0].max.x(), centre.x() + 2.5);
  }
}

TEST(SurfaceLayout, BoundsAreTight) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  clay::Grid grid;
  grid.voxelMm = 0.25;
  grid.originMm = {1e6, -1e6, 5};
  layout.apply(surface.update(grid, {-3, -3, -3}, {2, 2, 2}, sphere(16, Vec3d::Zero())), sink);
  const Box box = layout.bounds();
  // A dual vertex lies within a tenth of a voxel of a sphere of 16.
  EXPECT_LT((box.min - (grid.originMm - Vec3d::Constant(4))).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LT((box.max - (grid.originMm + Vec3d::Constant(4))).cwiseAbs().maxCoeff(), 0.03);
}

TEST(SurfaceLayout, RayMeetsTheSphere) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  clay::Grid grid;
  grid.voxelMm = 0.5;
  layout.apply(surface.update(grid, {-3, -3, -3}, {2, 2, 2}, sphere(16, Vec3d::Zero())), sink);
  const auto hit = layout.raycast({{0.1, 0.2, 30}, -Vec3d::UnitZ()});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distanceMm, 22, 0.05);
  EXPECT_TRUE(hit->fromOutside);
  const auto within = layout.raycast({{0.1, 0.2, 0}, Vec3d::UnitX()});
  ASSERT_TRUE(within);
  EXPECT_FALSE(within->fromOutside);
  EXPECT_FALSE(layout.raycast({{0, 0, 30}, Vec3d::UnitZ()}));
  EXPECT_FALSE(layout.raycast({{9, 0, 30}, -Vec3d::UnitZ()}));
}

TEST(SurfaceLayout, IncompleteSurfaceIsRefused) {
  FieldSurface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  auto delta = surface.update({}, {-2, -2, -2}, {1, 1, 1}, sphere(10));
  ASSERT_GT(delta.changed.size(), 2u);
  delta.changed.erase(delta.changed.begin());
  EXPECT_THROW(layout.apply(delta, sink), Error);
}

TEST(RangeAllocator, MergesWhatComesBack) {
  RangeAllocator ranges(100);
  const uint32_t a = *ranges.allocate(40), b = *ranges.allocate(40), c = *ranges.allocate(20);
  EXPECT_FALSE(ranges.allocate(1));
  ranges.release(b, 40);
  EXPECT_FALSE(ranges.allocate(41));
  ranges.release(a, 40);
  EXPECT_EQ(ranges.used(), 20u);
  EXPECT_EQ(ranges.end(), 100u);
  ranges.release(c, 20);
  EXPECT_EQ(ranges.end(), 0u);
  EXPECT_EQ(*ranges.allocate(100), 0u);
  ranges.grow(150);
  EXPECT_EQ(*ranges.allocate(50), 100u);
}

}  // namespace
}  // namespace argil::render
