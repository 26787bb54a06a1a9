// Colours and masks of clay in the buffers and in pictures.

#include <gtest/gtest.h>

#include <cstdlib>

#include "clay/surface/vertex_channels.h"
#include "tests/unit/render/mirror_sink.h"
#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using test::FieldSurface;

class PaintSink : public test::MirrorSink {
 public:
  void writePaint(uint32_t first, std::span<const PackedPaint> data) override {
    paint.resize(std::max(paint.size(), vertices.size()), kUnpainted);
    ASSERT_LE(first + data.size(), paint.size());
    std::copy(data.begin(), data.end(), paint.begin() + first);
    painted += data.size();
  }
  std::vector<PackedPaint> paint;
  size_t painted = 0;
};

double sphere(const Vec3d& p) {
  return p.norm() - 20;
}

std::shared_ptr<const clay::BrickPaint> paintOf(const clay::BrickMesh& mesh, const clay::VertexPaint& paint) {
  auto one = std::make_shared<clay::BrickPaint>();
  one->brick = mesh.brick;
  one->vertices.assign(mesh.positions.size(), paint);
  return one;
}

constexpr clay::VertexPaint kRed{255, 0, 0, 255, 0, 0};

TEST(Paint, PacksWhatIsLeftOfThePieceAndWhatIsAdded) {
  EXPECT_EQ(packPaint({}), kUnpainted);
  EXPECT_EQ(packPaint(kRed), 0x000000ffu);
  EXPECT_EQ(packPaint({10, 20, 30, 0, 5, 0}), kUnpainted);  // it covers nothing
  const PackedPaint masked = packPaint({0, 0, 0, 0, 0, 255});
  EXPECT_EQ(masked & 0xffffffu, 0u);
  EXPECT_NEAR(double(masked >> 24), 0.45 * 255, 1);
}

TEST(Paint, AMaterialsColourLiesUnderThePaintAndOverThePiece) {
  const MaterialColours materials{std::nullopt, std::array<uint8_t, 3>{0, 0, 255}};
  EXPECT_EQ(packPaint({0, 0, 0, 0, 1, 0}, materials), kUnpainted) << "a row without a colour";
  EXPECT_EQ(packPaint({0, 0, 0, 0, 3, 0}, materials), kUnpainted) << "no such row";
  EXPECT_EQ(packPaint({0, 0, 0, 0, 2, 0}, materials), 0x00ff0000u);
  EXPECT_EQ(packPaint({255, 0, 0, 255, 2, 0}, materials), 0x000000ffu) << "painted over";
}

TEST(Paint, ColoursOfMaterialsAreWrittenAnewAndTakenBack) {
  BufferRanges ranges;
  PaintSink sink;
  FieldSurface surface;
  SurfaceLayout layout(ranges);
  clay::SurfaceDelta whole = surface.update(clay::Grid{1, Vec3d::Zero(), 3}, {-4, -4, -4}, {3, 3, 3}, sphere);
  const clay::BrickMeshPtr mesh = whole.changed[whole.changed.size() / 2];
  whole.painted.push_back(paintOf(*mesh, {0, 0, 0, 0, 2, 0}));
  layout.apply(whole, sink);
  const auto blue = [&] { return size_t(std::count(sink.paint.begin(), sink.paint.end(), 0x00ff0000u)); };
  EXPECT_EQ(blue(), 0u);
  const MaterialColours materials{std::nullopt, std::array<uint8_t, 3>{0, 0, 255}};
  layout.colourMaterials(materials, sink);
  EXPECT_EQ(blue(), mesh->positions.size());
  const size_t written = sink.painted;
  layout.colourMaterials(materials, sink);
  EXPECT_EQ(sink.painted, written) << "nothing changed";
  layout.colourMaterials({}, sink);
  EXPECT_EQ(blue(), 0u);
}

TEST(Paint, WritesItsBytesAloneAndNothingWhereNothingIsPainted) {
  BufferRanges ranges;
  PaintSink sink;
  FieldSurface surface;
  SurfaceLayout layout(ranges);
  const clay::SurfaceDelta whole = surface.update(clay::Grid{1, Vec3d::Zero(), 3}, {-4, -4, -4}, {3, 3, 3}, sphere);
  layout.apply(whole, sink);
  EXPECT_EQ(sink.painted, 0u);
  EXPECT_FALSE(ranges.painted());
  const uint64_t bytes = sink.bytes;
  clay::SurfaceDelta paint;
  paint.grid = whole.grid;
  const clay::BrickMeshPtr& mesh = whole.changed[whole.changed.size() / 2];
  paint.painted.push_back(paintOf(*mesh, kRed));
  layout.apply(paint, sink);
  EXPECT_EQ(sink.bytes, bytes);
  EXPECT_EQ(sink.painted, mesh->positions.size());
  EXPECT_EQ(size_t(std::count(sink.paint.begin(), sink.paint.end(), packPaint(kRed))), mesh->positions.size());
  // Coarser levels take it over.
  for (uint64_t i = 0; i <= SurfaceLayout::kRestPictures; ++i) layout.nextPicture();
  for (size_t i = 0; i < layout.draws().size(); ++i) layout.prepareChunk(i, 1, sink);
  EXPECT_GT(size_t(std::count(sink.paint.begin(), sink.paint.end(), packPaint(kRed))), mesh->positions.size());
  // Other vertices in that brick are unpainted unless the delta says otherwise.
  const clay::SurfaceDelta moved = surface.update(clay::Grid{1, Vec3d::Zero(), 3}, {-4, -4, -4}, {3, 3, 3},
                                                  [](const Vec3d& p) { return p.norm() - 20.3; });
  layout.apply(moved, sink);
  for (const ChunkDraw& draw : layout.draws()) {
    const ChunkDraw::Range& range = draw.at(0);
    for (uint32_t i = range.firstIndex; i < range.firstIndex + range.indexCount; ++i) {
      const bool empty = i % 3 == 0 && sink.indices[i] == sink.indices[i + 1] && sink.indices[i] == sink.indices[i + 2];
      if (empty) i += 2;
      ASSERT_TRUE(empty || sink.paint[sink.indices[i]] == kUnpainted);
    }
  }
}

// What is drawn follows paint, flag and meshes in any order; coarser levels and rays follow too.
TEST(Paint, UnseenClayHasNoTrianglesAndGetsThemBack) {
  const clay::Grid grid{1, Vec3d::Zero(), 3};
  const auto painted = [](const clay::SurfaceDelta& of, const clay::VertexPaint& paint, bool leftAlone = false) {
    clay::SurfaceDelta delta;
    delta.grid = of.grid;
    for (const clay::BrickMeshPtr& mesh : of.changed)
      if (!leftAlone || mesh->brick.x < 0) delta.painted.push_back(paintOf(*mesh, paint));
    return delta;
  };
  BufferRanges ranges;
  PaintSink sink;
  FieldSurface surface;
  SurfaceLayout layout(ranges);
  const clay::SurfaceDelta whole = surface.update(grid, {-4, -4, -4}, {3, 3, 3}, sphere);
  layout.apply(whole, sink);
  const auto all = sink.drawn(layout);
  const Ray left{{-50, 0.3, 0.2}, Vec3d::UnitX()};
  EXPECT_NEAR(layout.raycast(left)->distanceMm, 30, 0.1);
  layout.apply(painted(whole, {0, 0, 0, 0, kUnseenMaterial, 0}, true), sink);
  const size_t rest = sink.drawn(layout).size();
  EXPECT_NEAR(double(rest), 0.5 * double(all.size()), 0.05 * double(all.size()));
  EXPECT_NEAR(layout.raycast(left)->distanceMm, 70, 0.1);
  const auto coarse = [&] {
    for (uint64_t i = 0; i <= SurfaceLayout::kRestPictures; ++i) layout.nextPicture();
    for (size_t i = 0; i < layout.draws().size(); ++i) layout.prepareChunk(i, 1, sink);
    return sink.drawn(layout, [](const ChunkDraw&) { return 1; }).size();
  };
  const size_t coarseRest = coarse();
  // Any other material is seen.
  layout.apply(painted(whole, {0, 0, 0, 0, 254, 255}), sink);
  EXPECT_EQ(sink.drawn(layout), all);
  EXPECT_GT(coarse(), coarseRest * 3 / 2);
  layout.hideMasked(true, sink);
  EXPECT_TRUE(sink.drawn(layout).empty());
  EXPECT_EQ(coarse(), 0u);
  EXPECT_FALSE(layout.raycast(left).has_value());
  layout.apply(painted(whole, {0, 0, 0, 0, 0, 127}, true), sink);
  EXPECT_NEAR(double(sink.drawn(layout).size()), 0.5 * double(all.size()), 0.05 * double(all.size()))
      << "half a mask is seen";
  layout.hideMasked(false, sink);
  EXPECT_EQ(sink.drawn(layout), all);
}

using PaintPicture = test::Picture;

TEST_F(PaintPicture, HiddenClayShowsWhatIsBehindIt) {
  const clay::Grid grid{kVoxel, Vec3d::Zero(), 3};
  const clay::SurfaceDelta whole = surface_.update(grid, {-3, -3, -3}, {2, 2, 2}, Picture::sphere());
  renderer_->update(whole);
  const Image plain = draw(view("front"), test::kBare);
  clay::SurfaceDelta paint;
  paint.grid = grid;
  for (const clay::BrickMeshPtr& mesh : whole.changed)
    if (mesh->brick.x < 0) paint.painted.push_back(paintOf(*mesh, {0, 0, 0, 0, 0, 255}));
  renderer_->update(paint);
  PieceLook look;
  look.hideMasked = true;
  renderer_->place(0, look);
  const Image hidden = draw(view("front"), test::kBare);
  const Vec3d left(kWidth / 2 - 30, kHeight / 2 + 20, 0), right(kWidth / 2 + 30, kHeight / 2 + 20, 0),
      corner(20, 20, 0);
  EXPECT_NEAR(test::brightnessAround(hidden, right), test::brightnessAround(plain, right), 1);
  EXPECT_NEAR(test::brightnessAround(hidden, left), test::brightnessAround(hidden, corner), 25) << "the backdrop";
  if (const char* folder = std::getenv("ARGIL_TEST_PICTURES")) writePng(hidden, std::string(folder) + "/hidden.png");
}

TEST_F(PaintPicture, PaintedClayHasItsColourAndMaskedClayIsDarker) {
  const clay::Grid grid{kVoxel, Vec3d::Zero(), 3};
  const clay::SurfaceDelta whole = surface_.update(grid, {-3, -3, -3}, {2, 2, 2}, Picture::sphere());
  renderer_->update(whole);
  const Image plain = draw(view("front"), test::kBare);
  clay::SurfaceDelta paint;
  paint.grid = grid;
  for (const clay::BrickMeshPtr& mesh : whole.changed) {
    if (mesh->brick.x < 0) paint.painted.push_back(paintOf(*mesh, kRed));
    if (mesh->brick.x >= 0 && mesh->brick.z >= 0) paint.painted.push_back(paintOf(*mesh, {0, 0, 0, 0, 0, 255}));
  }
  renderer_->update(paint);
  const Image painted = draw(view("front"), test::kBare);
  const Vec3d left(kWidth / 2 - 30, kHeight / 2 + 20, 0), upper(kWidth / 2 + 30, kHeight / 2 - 20, 0),
      lower(kWidth / 2 + 30, kHeight / 2 + 20, 0);
  const Vec3d red = test::colourAround(painted, left);
  EXPECT_GT(red.x(), 3 * std::max(red.y(), red.z()));
  EXPECT_LT(test::brightnessAround(painted, upper), 0.8 * test::brightnessAround(plain, upper));
  EXPECT_NEAR(test::brightnessAround(painted, lower), test::brightnessAround(plain, lower), 1);
  if (const char* folder = std::getenv("ARGIL_TEST_PICTURES")) writePng(painted, std::string(folder) + "/paint.png");
}

}  // namespace
}  // namespace argil::render
