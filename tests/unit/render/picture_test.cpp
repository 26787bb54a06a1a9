// Pictures of known scenes, measured. Every test draws through the validation layer where it is installed.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "clay/base/error.h"
#include "render/renderer/renderer.h"
#include "render/view/scale.h"
#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using test::brightness;
using test::brightnessAround;
using test::Field;
using test::FieldSurface;
using test::kBare;
using test::meanDifference;
using test::Picture;

bool isClay(const Image& image, int x, int y) {
  const uint8_t* p = image.pixel(x, y);
  return p[0] > p[2] + 12;  // warm; all else is grey or blue
}

TEST_F(Picture, SphereCoversItsDisc) {
  load(sphere());
  const View from = view("front");
  const Image image = draw(from, kBare);
  int count = 0;
  double sumX = 0, sumY = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (!isClay(image, x, y)) continue;
      ++count;
      sumX += x + 0.5;
      sumY += y + 0.5;
    }
  }
  const double pixelsPerMm = kHeight / from.heightAtTarget();
  const double disc = std::numbers::pi * std::pow(kRadius * kVoxel * pixelsPerMm, 2);
  EXPECT_NEAR(count, disc, 0.02 * disc);
  EXPECT_NEAR(sumX / count, 0.5 * kWidth, 0.5);
  EXPECT_NEAR(sumY / count, 0.5 * kHeight, 0.5);
}

TEST_F(Picture, LightComesFromTheUpperLeft) {
  load(sphere());
  for (const char* name : {"front", "back", "top", "bottom", "iso"}) {
    const Image image = draw(view(name, Projection::perspective), kBare);
    const Vec3d centre(0.5 * kWidth, 0.5 * kHeight, 0);
    EXPECT_GT(brightnessAround(image, centre + Vec3d(-28, -28, 0)),
              brightnessAround(image, centre + Vec3d(35, 35, 0)) + 40)
        << name;
  }
}

TEST_F(Picture, FarFromTheOriginAndAtAnyScaleThePictureIsTheSame) {
  load(sphere());
  Look look = kBare;
  look.cavity = true;
  const Image near = draw(view("iso", Projection::perspective), look);
  const struct {
    Vec3d origin;
    double voxel;
  } places[] = {{{1e6, -1e6, 1e6}, 0.5}, {{1e6, 1e6, 1e6}, 1e-3}, {{0, 0, 0}, 1e-3}, {{-1e6, 0, 0}, 1e3}};
  for (const auto& place : places) {
    surface_ = {};
    renderer_->clear();
    load(sphere(), place.origin, place.voxel);
    const Image far = draw(view("iso", Projection::perspective), look);
    int different = 0;
    for (size_t i = 0; i < near.rgba.size(); ++i) different += std::abs(int(near.rgba[i]) - int(far.rgba[i])) > 6;
    EXPECT_LT(different, kWidth * kHeight * 4 / 200)
        << "origin " << place.origin.transpose() << ", voxel " << place.voxel;
  }
}

// The map has several texels a pixel: what the picture shows coarsely casts a shadow as coarse.
TEST_F(Picture, ShadowsAreOfTheLevelThatIsSeen) {
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  renderer_->update(surface_.update(grid, {-8, -8, -8}, {7, 7, 7}, [](const Vec3d& p) { return p.norm() - 60; }));
  const View near = view("iso", Projection::perspective);
  View far = near;
  far.position = near.target + 4 * (near.position - near.target);
  const auto inShadow = [&](const View& from, const Look& look) {
    for (int i = 0; i < 4; ++i) static_cast<void>(draw(from, look));
    return renderer_->drawStats().shadowTriangles;
  };
  const uint64_t all = renderer_->triangleCount();
  Look look = kBare;
  EXPECT_EQ(inShadow(near, look), all) << "so near each triangle is seen";
  EXPECT_LT(inShadow(far, look), all / 3);
  EXPECT_GE(inShadow(far, look), renderer_->drawStats().trianglesDrawn) << "its back casts too";
  look.keyShadow = false;
  EXPECT_EQ(inShadow(far, look), 0u);
}

// A ball that is drawn thicker is the ball of that radius, in light, shadow, section and at every level of detail; and
// nothing of it is left out because its chunks are elsewhere.
TEST_F(Picture, GrownClayIsWhatItsOffsetWouldBe) {
  Look look;  // with shadow, cavities and ground
  for (const double grownMm : {0.75, 2.0}) {
    surface_ = {};
    renderer_->clear();
    load([&](const Vec3d& p) { return p.norm() - (kRadius + grownMm / kVoxel); });
    const View near = view("iso", Projection::perspective), wide = view("front");
    View close = near, far = near;
    close.position = near.target + 0.35 * (near.position - near.target);  // its rim is outside of the picture
    far.position = near.target + 6 * (near.position - near.target);       // coarse levels
    Look cut = look;
    cut.section = Section{Vec3d(0, 0, 1), Vec3d(0, 0, 1)};
    const std::pair<View, Look> shots[] = {{near, look}, {wide, look}, {close, look}, {far, look}, {near, cut}};
    std::vector<Image> exact;
    for (const auto& [from, with] : shots) exact.push_back(draw(from, with));
    const Box box = renderer_->bounds();

    surface_ = {};
    renderer_->clear();
    load(sphere());
    PieceLook grown;
    grown.grownMm = grownMm;
    const Image plain = draw(near, look);
    renderer_->place(0, grown);
    EXPECT_NEAR((renderer_->bounds().max - box.max).norm(), 0, 0.1 * kVoxel);
    for (size_t i = 0; i < exact.size(); ++i) {
      const Image preview = draw(shots[i].first, shots[i].second);
      EXPECT_LT(meanDifference(preview, exact[i]), 1.0) << "shot " << i << " of " << grownMm;
    }
    EXPECT_GT(meanDifference(plain, exact[0]), 4) << "the test sees nothing";
    renderer_->place(0, {});
    EXPECT_EQ(draw(near, look), plain);
  }
  PieceLook bad;
  for (const double value : {double(NAN), -1.0}) {
    bad.grownMm = value;
    EXPECT_THROW(renderer_->place(0, bad), Error);
  }
}

// A ball that is shown longer along one axis of the world is that ellipsoid, however the piece is turned.
TEST_F(Picture, StretchedClayIsTheEllipsoidThatItWouldBe) {
  Look look;
  for (int axis = 0; axis < 3; ++axis)
    for (const double factor : {0.5, 1.2}) {
      SCOPED_TRACE(testing::Message() << axis << " × " << factor);
      surface_ = {};
      renderer_->clear();
      Vec3d scale = Vec3d::Ones();
      scale[axis] = factor;
      load([&](const Vec3d& p) {
        const Vec3d q = p.cwiseQuotient(scale), slope = q.cwiseQuotient(scale);
        return q.norm() > 0 ? (q.norm() - kRadius) * q.norm() / slope.norm() : -kRadius;
      });
      const View near = view("iso", Projection::perspective), flat = view("front");
      View far = near;
      far.position = near.target + 6 * (near.position - near.target);  // coarse levels
      const std::array<Image, 3> exact{draw(near, look), draw(flat, look), draw(far, look)};
      const Box box = renderer_->bounds();
      const auto hit = renderer_->pick(near.position, near.axes().forward);
      ASSERT_TRUE(hit);

      surface_ = {};
      renderer_->clear();
      load(sphere());
      const Image plain = draw(near, look);
      PieceLook longer;
      longer.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, -2, 0.5).normalized()));
      longer.scale = scale;
      renderer_->place(0, longer);
      EXPECT_LT((renderer_->bounds().max - box.max).norm(), 0.2 * kVoxel);
      EXPECT_LT((renderer_->bounds().min - box.min).norm(), 0.2 * kVoxel);
      const auto now = renderer_->pick(near.position, near.axes().forward);
      ASSERT_TRUE(now);
      EXPECT_NEAR(now->distanceMm, hit->distanceMm, 0.2 * kVoxel);
      EXPECT_GT(now->normal.dot(hit->normal), 0.99);
      EXPECT_LT(meanDifference(draw(near, look), exact[0]), 1.0);
      EXPECT_LT(meanDifference(draw(flat, look), exact[1]), 1.0);
      EXPECT_LT(meanDifference(draw(far, look), exact[2]), 1.0);
      EXPECT_GT(meanDifference(plain, exact[0]), 1.5) << "the test sees nothing";
    }
}

// A ball that is shown larger is the ball of larger voxels, wherever it lies; rays meet it where it is seen.
TEST_F(Picture, ScaledClayIsWhatItsScaledVoxelsWouldBe) {
  Look look;  // with shadow, cavities and ground
  for (const double scale : {0.5, 1.25, 2.0}) {
    for (const Vec3d& origin : {Vec3d(0, 0, 0), Vec3d(7, -3, 2)}) {
      surface_ = {};
      renderer_->clear();
      load(sphere(), scale * origin, scale * kVoxel);
      const View near = view("iso", Projection::perspective), flat = view("front");
      const std::array<Image, 2> exact{draw(near, look), draw(flat, look)};
      const Box box = renderer_->bounds();
      const auto hit = renderer_->pick(near.position, near.axes().forward);
      ASSERT_TRUE(hit);

      surface_ = {};
      renderer_->clear();
      load(sphere(), origin);
      const Image plain = draw(near, look);
      PieceLook larger;
      larger.scale.setConstant(scale);
      renderer_->place(0, larger);
      EXPECT_LT((renderer_->bounds().max - box.max).norm(), 1e-6);
      EXPECT_LT((renderer_->bounds().min - box.min).norm(), 1e-6);
      const auto now = renderer_->pick(near.position, near.axes().forward);
      ASSERT_TRUE(now);
      EXPECT_NEAR(now->distanceMm, hit->distanceMm, 1e-6);
      EXPECT_LT(meanDifference(draw(near, look), exact[0]), 1.0) << scale;
      EXPECT_LT(meanDifference(draw(flat, look), exact[1]), 1.0) << scale;
      EXPECT_GT(meanDifference(plain, exact[0]), 4) << "the test sees nothing";
    }
  }
  PieceLook bad;
  for (const double value : {double(NAN), 0.0, -1.0}) {
    bad.scale = {1, value, 1};
    EXPECT_THROW(renderer_->place(0, bad), Error);
  }
}

// A plane across a ball is a thin line on it, straight from where it is seen from its edge, and a tint beyond.
TEST_F(Picture, APlaneIsAThinLineOnTheClay) {
  load(sphere());
  const View from = view("front");
  const Image bare = draw(from, kBare);
  const double pixelsPerMm = kHeight / from.heightAtTarget();
  for (const double x : {-4.0, 0.0, 3.0}) {
    Overlays overlays;
    PlaneMark mark;
    mark.pointMm = {x, 5, 1};
    mark.normal = {2, 0, 0};
    mark.line = {1, 0, 0, 1};
    mark.widthPixels = 3;
    overlays.planes = {mark};
    const Image image = draw(from, kBare, overlays);
    const double at = 0.5 * kWidth + x * pixelsPerMm;
    for (const double z : {-3.0, 0.0, 4.0}) {
      const int row = int(0.5 * kHeight - z * pixelsPerMm);
      double sum = 0, weight = 0;
      for (int column = 0; column < kWidth; ++column) {
        const uint8_t *p = image.pixel(column, row), *q = bare.pixel(column, row);
        const double other = std::abs(p[1] - q[1]);  // Red has no green.
        if (other < 12) continue;
        EXPECT_NEAR(column + 0.5, at, 2.5) << "thin";
        sum += other * (column + 0.5);
        weight += other;
      }
      ASSERT_GT(weight, 60) << x << " " << z;
      EXPECT_NEAR(sum / weight, at, 0.6);
    }
    // Beyond it the clay is blue; on this side it is as it was.
    overlays.planes[0].line.a = 0;
    overlays.planes[0].beyond = {0, 0, 1, 0.8f};
    const Image tinted = draw(from, kBare, overlays);
    const int row = kHeight / 2, right = int(at) + 6, left = int(at) - 6;
    EXPECT_GT(tinted.pixel(right, row)[2], tinted.pixel(right, row)[0] + 60);
    EXPECT_EQ(tinted.pixel(left, row)[2], bare.pixel(left, row)[2]);
    // What is dimmed shows neither where it is not to.
    PieceLook dimmed;
    dimmed.dimmed = true;
    renderer_->place(0, dimmed);
    const Image without = draw(from, kBare);
    overlays.planes[0].dimmedToo = false;
    EXPECT_EQ(draw(from, kBare, overlays), without);
    renderer_->place(0, {});
  }
  Overlays many;
  many.planes.resize(kMostPlaneMarks + 1);
  EXPECT_THROW((void)draw(from, kBare, many), Error);
  many.planes.resize(1);
  many.planes[0].normal = Vec3d::Zero();
  EXPECT_THROW((void)draw(from, kBare, many), Error);
}

TEST_F(Picture, TheSameTwice) {
  load(sphere());
  Overlays overlays;
  overlays.cursor.emplace();
  overlays.cursor->positionMm = {0, -3, 12};
  const Image first = draw(view("iso", Projection::perspective), {}, overlays);
  EXPECT_EQ(first, draw(view("iso", Projection::perspective), {}, overlays));
  Renderer other;
  FieldSurface again;
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  other.update(again.update(grid, {-3, -3, -3}, {2, 2, 2}, sphere()));
  EXPECT_EQ(first, other.render(view("iso", Projection::perspective), overlays, kWidth, kHeight));
}

TEST_F(Picture, AnUpdatedModelLooksLikeAFreshOne) {
  load(sphere());
  const auto dented = [](const Vec3d& p) { return std::max(p.norm() - kRadius, 5 - (p - Vec3d(0, -16, 0)).norm()); };
  const Image before = draw(view("front"), kBare);
  const uint64_t whole = stats_.bytes;
  load(dented);
  EXPECT_GT(stats_.bytes, 0u);
  EXPECT_LT(stats_.bytes, whole / 3);
  const Image after = draw(view("front"), kBare);
  EXPECT_NE(before, after);
  surface_ = {};
  renderer_->clear();
  load(dented);
  EXPECT_EQ(after, draw(view("front"), kBare));
}

TEST_F(Picture, CavityDarkensAGrooveAndLeavesTheRest) {
  // A block with a groove along x at z = 0 of its front.
  load([](const Vec3d& p) {
    const double block = (p.cwiseAbs() - Vec3d(15, 12, 15)).maxCoeff();
    const double groove = std::hypot(p.y() + 12, p.z()) - 2.0;
    return std::max(block, -groove);
  });
  const View from = view("front");
  Look look = kBare;
  const Image without = draw(from, look);
  look.cavity = true;
  const Image with = draw(from, look);
  const Vec3d groove = from.project({2, -5.2, 0}, kWidth, kHeight), plain = from.project({2, -6, 4}, kWidth, kHeight);
  EXPECT_LT(brightnessAround(with, groove, 1), brightnessAround(without, groove, 1) - 12);
  EXPECT_NEAR(brightnessAround(with, plain), brightnessAround(without, plain), 3);
}

/// A flat slab seen from above, and a cursor over it.
class CursorPicture : public Picture {
 protected:
  void slab() {
    load([](const Vec3d& p) { return (p.cwiseAbs() - Vec3d(20, 20, 4)).maxCoeff(); });
  }
  static Overlays over(const Vec3d& at) {
    Overlays overlays;
    overlays.cursor.emplace();
    overlays.cursor->positionMm = at;
    overlays.cursor->radiusMm = 1.5;
    overlays.cursor->shaft = Vec3d::UnitZ();
    return overlays;
  }
};

TEST_F(CursorPicture, ShadowFallsOnClayAwayFromTheLight) {
  slab();
  const View from = view("top");
  // The key light stands over the viewer's left shoulder: from above its shadow goes to the right and down.
  const View::Axes a = from.axes();
  const Vec3d toKey = (-0.50 * a.right + 0.66 * a.up - 0.56 * a.forward).normalized();
  const Vec3d ball(-1, 1, 6);
  const Vec3d shadow = ball - toKey * ((ball.z() - 2) / toKey.z());
  const Image without = draw(from, kBare), with = draw(from, kBare, over(ball));
  const Vec3d at = from.project(shadow, kWidth, kHeight);
  EXPECT_LT(brightnessAround(with, at), 0.7 * brightnessAround(without, at));
  const Vec3d mirrored =
      from.project(ball + Vec3d(toKey.x(), toKey.y(), 0) * ((ball.z() - 2) / toKey.z()), kWidth, kHeight);
  EXPECT_NEAR(brightnessAround(with, mirrored), brightnessAround(without, mirrored), 3);
}

TEST_F(CursorPicture, ShadowFallsOnTheGround) {
  slab();
  View from = view("top");
  from.openingDegrees = 60;  // some ground around the slab
  const Vec3d ball(12, 12, 1);
  const View::Axes a = from.axes();
  const Vec3d toKey = (-0.50 * a.right + 0.66 * a.up - 0.56 * a.forward).normalized();
  Look look = kBare;
  look.grid = true;
  const Vec3d shadow = ball - toKey * ((ball.z() + 2) / toKey.z());
  const Vec3d at = from.project(shadow, kWidth, kHeight);
  EXPECT_LT(brightnessAround(draw(from, look, over(ball)), at), 0.8 * brightnessAround(draw(from, look), at));
}

TEST_F(CursorPicture, BeamAndDotMarkWhereTheBallWouldLand) {
  slab();
  const View side = view("front");
  const Vec3d ball(2, 0, 8);
  const Image image = draw(side, kBare, over(ball));
  const Vec3d middle = side.project({2, 0, 4.2}, kWidth, kHeight);
  const uint8_t* beam = image.pixel(int(middle.x()), int(middle.y()));
  EXPECT_GT(beam[2], beam[0] + 40) << "the beam is blue";
  const View top = view("top");
  Overlays overlays = over(ball);
  overlays.cursor->positionMm = {2, -1, 30};
  overlays.cursor->shaft = {1, 1, 0.1};
  overlays.cursor->drop = Vec3d(0, 0.2, -1);  // lands beside the ball, seen from above
  const double t = (30 - 2) / 1.0;
  const Vec3d hit = top.project({2, -1 + 0.2 * t, 2}, kWidth, kHeight);
  const Image above = draw(top, kBare, overlays);
  const uint8_t* dot = above.pixel(int(hit.x()), int(hit.y()));
  EXPECT_GT(dot[2], dot[0] + 40) << "the dot is blue";
}

TEST_F(CursorPicture, ContactChangesTheColour) {
  slab();
  Overlays overlays = over({0, 0, 4});
  overlays.cursor->shaft = {1, 0, 0.4};
  const View from = view("front");
  const Vec3d at = from.project({-0.8, 0, 4}, kWidth, kHeight);
  const Image free = draw(from, kBare, overlays);
  overlays.cursor->contact = true;
  const Image touching = draw(from, kBare, overlays);
  const uint8_t* a = free.pixel(int(at.x()), int(at.y()));
  const uint8_t* b = touching.pixel(int(at.x()), int(at.y()));
  EXPECT_GT(a[2], a[0]);
  EXPECT_GT(b[0], b[2]);
}

TEST_F(CursorPicture, PathsAreHiddenByClay) {
  slab();
  Overlays overlays;
  Polyline before{{{-8, -12, 0.3}, {8, -12, 0.3}}, {0, 1, 0, 1}, 3},
      behind{{{-8, 12, -0.8}, {8, 12, -0.8}}, {0, 1, 0, 1}, 3};
  overlays.polylines = {before, behind};
  const View from = view("front");
  const Image image = draw(from, kBare, overlays);
  const auto green = [&](const Vec3d& p) {
    const Vec3d at = from.project(p, kWidth, kHeight);
    const uint8_t* c = image.pixel(int(at.x()), int(at.y()));
    return c[1] > c[0] + 60;
  };
  EXPECT_TRUE(green({0.1, -12, 0.3}));
  EXPECT_FALSE(green({0.1, 12, -0.8}));
}

TEST_F(Picture, ScaleBarHasTheLengthThatItNames) {
  load(sphere());
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const int width = 640, height = 360;
    View from = View::named("front", renderer_->bounds(), double(width) / height, projection);
    Look look = kBare;
    look.scaleBar = true;
    const Image image = renderer_->render(Shot{from, look, {}, {}}, width, height);
    // The longest run of light pixels in the rows of the bar.
    int longest = 0;
    for (int y = height - 40; y < height - 10; ++y) {
      int run = 0;
      for (int x = 0; x < width; ++x) {
        run = brightness(image, x, y) > 140 ? run + 1 : 0;
        longest = std::max(longest, run);
      }
    }
    const ScaleBar bar = scaleBar(from, width, height);
    EXPECT_NEAR(bar.pixels, bar.mm * height / from.heightAtTarget(), 1e-9);
    // Round ends add half the bar's thickness of two pixels on either side.
    EXPECT_NEAR(longest, bar.pixels + 2, 1);
  }
}

TEST_F(Picture, GridLinesAreWhereTheMillimetresAre) {
  load(sphere());
  View from = View::named("top", renderer_->bounds(), double(kWidth) / kHeight, Projection::orthographic);
  Look look = kBare;
  look.grid = true;
  const Image image = draw(from, look);
  const GridSpacing grid = gridSpacing(from, kHeight);
  // Along the left edge of the picture: lines of constant y.
  const double x = -0.47 * from.heightAtTarget() * kWidth / kHeight;
  for (int line = -1; line <= 1; ++line) {
    const double y = line * grid.minor;
    const auto at = [&](double mm) {
      return brightnessAround(image, from.project({x + 0.37 * grid.minor, mm, 0}, kWidth, kHeight), 0);
    };
    EXPECT_GT(at(y - 1e-3 * grid.minor), at(y + 0.5 * grid.minor) + 4) << "at y = " << y << " mm";
  }
}

TEST_F(Picture, DrawsOnlyChunksInThePicture) {
  load(sphere());
  View from = view("front");
  (void)draw(from, kBare);
  EXPECT_EQ(renderer_->drawStats().chunksCulled, 0u);
  EXPECT_GE(renderer_->drawStats().trianglesDrawn, renderer_->triangleCount());
  from.target += Vec3d(1000, 0, 0);
  from.position += Vec3d(1000, 0, 0);
  const Image away = draw(from, kBare);
  EXPECT_EQ(renderer_->drawStats().chunksDrawn, 0u);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) ASSERT_FALSE(isClay(away, x, y));
  }
}

TEST_F(Picture, EverySizeAndViewWorksAlsoWithoutClay) {
  Overlays overlays;
  overlays.cursor.emplace();
  for (const std::string& name : View::names()) {
    const View from = View::named(name, renderer_->bounds(), 1);
    for (const auto& [width, height] : {std::pair(16, 16), std::pair(17, 301), std::pair(301, 17)}) {
      const Image image = renderer_->render(from, overlays, width, height);
      EXPECT_EQ(image.width, width);
      EXPECT_EQ(image.height, height);
    }
  }
}

TEST(NoDriver, IsSaidWithWhatToInstall) {
  // The loader reads these whenever an instance is made; a caller's own choice of driver comes back afterwards.
  struct Setting {
    explicit Setting(const char* variable) : name(variable) {
      if (const char* value = std::getenv(name)) before = value;
      ::setenv(name, "/nonexistent/driver.json", 1);
    }
    ~Setting() { before ? ::setenv(name, before->c_str(), 1) : ::unsetenv(name); }
    const char* name;
    std::optional<std::string> before;
  };
  const Setting icds("VK_ICD_FILENAMES"), drivers("VK_DRIVER_FILES");
  EXPECT_TRUE(devices().empty());
  try {
    const Renderer renderer;
    ADD_FAILURE() << "a renderer without a driver";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::work);
    EXPECT_NE(std::string(error.what()).find("mesa-vulkan-drivers"), std::string::npos) << error.what();
  }
}

TEST_F(Picture, BadCallsAreRefused) {
  load(sphere());
  const View from = view("front");
  EXPECT_THROW((void)renderer_->render(from, {}, 8, 100), Error);
  EXPECT_THROW((void)renderer_->render(from, {}, 100, 9000), Error);
  Overlays overlays;
  overlays.cursor.emplace();
  overlays.cursor->radiusMm = 0;
  EXPECT_THROW((void)draw(from, {}, overlays), Error);
  overlays = {};
  overlays.polylines.push_back({{{std::numeric_limits<double>::infinity(), 0, 0}}, {}, 1});
  EXPECT_THROW((void)draw(from, {}, overlays), Error);
  RendererOptions options;
  options.device = "no such device";
  EXPECT_THROW(Renderer{options}, Error);
  options = {};
  options.quality.supersample = 9;
  EXPECT_THROW(Renderer{options}, Error);
}

}  // namespace
}  // namespace argil::render
