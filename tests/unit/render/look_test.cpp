// What each shading and each cue for depth does to a picture, and what it leaves alone. Tolerances are in levels of
// 255.

#include <numbers>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using namespace test;

/// Unit vector to the key light, as render/renderer/NOTES.md has it.
Vec3d toKey(const View& view) {
  const View::Axes a = view.axes();
  return (-0.50 * a.right + 0.66 * a.up - 0.56 * a.forward).normalized();
}

class Shaded : public Picture {
 protected:
  static constexpr double kRadiusMm = kRadius * kVoxel;

  /// Where the sphere's surface of a normal (right, up, towards the viewer) is in an orthographic picture.
  static Vec3d place(const View& from, const Vec3d& n) {
    const View::Axes a = from.axes();
    return from.project(kRadiusMm * (n.x() * a.right + n.y() * a.up - n.z() * a.forward), kWidth, kHeight);
  }
  static Look shaded(Shading shading, Matcap matcap = Matcap::clay) {
    Look look = kBare;
    look.shading = shading;
    look.matcap = matcap;
    look.keyShadow = false;
    return look;
  }
  void piece(const Colour& colour, float roughness, float gloss, bool dimmed = false) {
    PieceLook look;
    look.colour = colour;
    look.roughness = roughness;
    look.gloss = gloss;
    look.dimmed = dimmed;
    renderer_->place(0, look);
  }
};

TEST_F(Shaded, MatcapsFollowTheNormalInTheViewAlone) {
  load(sphere());
  for (int m = 0; m < 6; ++m) {
    const Look look = shaded(Shading::matcap, Matcap(m));
    const View front = view("front");
    const Image first = draw(front, look);
    for (const char* name : {"left", "iso", "top"}) {
      const Image other = draw(view(name), look);
      for (const Vec3d& n :
           {Vec3d(0, 0, 1), Vec3d(-0.4, 0.5, 0.768), Vec3d(0.6, 0.1, 0.794), Vec3d(0.2, -0.7, 0.686)}) {
        const Vec3d a = colourAround(first, place(front, n), 2), b = colourAround(other, place(view(name), n), 2);
        // Facets of the sphere turn normals by a degree or two: sharp reflections move by that.
        EXPECT_LT((a - b).cwiseAbs().maxCoeff(), Matcap(m) == Matcap::steel ? 40 : 8)
            << matcapNames()[size_t(m)] << " from " << name << " at " << n.transpose();
      }
    }
  }
}

TEST_F(Shaded, TheNormalsMatcapIsThePictureOfNormals) {
  load(sphere());
  const View from = view("front");
  const Image image = draw(from, shaded(Shading::matcap, Matcap::normals));
  for (const Vec3d& n :
       {Vec3d(0, 0, 1), Vec3d(-0.6, 0, 0.8), Vec3d(0.6, 0, 0.8), Vec3d(0, 0.6, 0.8), Vec3d(0.48, -0.64, 0.6)}) {
    const Vec3d seen = colourAround(image, place(from, n), 2), expected = 255 * 0.5 * (n + Vec3d::Ones());
    EXPECT_LT((seen - expected).cwiseAbs().maxCoeff(), 16) << seen.transpose() << " for " << n.transpose();
  }
}

// A block whose edges lie between voxels: in the crisp grade each face has its own normal up to its edges.
TEST_F(Shaded, FacesAreFlatUpToACrispEdge) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  const clay::Version block = clay::makeBlock(clay::Store::make(), grid, Vec3d(0.1, 0.2, 0.3), Vec3d(11, 9, 8), 0);
  const Look look = shaded(Shading::matcap, Matcap::normals);
  const auto strayPixels = [&](clay::Grade grade) {
    renderer_.emplace();
    clay::Surface surface(true, grade);
    renderer_->update(surface.update(block));
    const View from = view("iso");
    const View::Axes axes = from.axes();
    std::vector<Vec3d> faces;
    for (int face = 0; face < 6; ++face) {
      const Vec3d n = (face & 1 ? 1 : -1) * Vec3d::Unit(face / 2);
      faces.push_back(127.5 * (Vec3d(n.dot(axes.right), n.dot(axes.up), -n.dot(axes.forward)) + Vec3d::Ones()));
    }
    const Image image = draw(from, look);
    renderer_.emplace();
    const Image empty = draw(from, look);
    int stray = 0, flat = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const uint8_t* p = image.pixel(x, y);
        const Vec3d seen(p[0], p[1], p[2]);
        const uint8_t* behind = empty.pixel(x, y);
        if ((seen - Vec3d(behind[0], behind[1], behind[2])).cwiseAbs().maxCoeff() < 3) continue;
        const bool onFace = std::any_of(faces.begin(), faces.end(),
                                        [&](const Vec3d& each) { return (seen - each).cwiseAbs().maxCoeff() < 20; });
        ++(onFace ? flat : stray);
      }
    EXPECT_GT(flat, 2000);
    return stray;
  };
  const int draft = strayPixels(clay::Grade::draft), crisp = strayPixels(clay::Grade::crisp);
  EXPECT_LT(3 * crisp, draft) << crisp << " pixels beside " << draft;
}

TEST_F(Shaded, MatcapsAreLitFromTheUpperLeftAndDiffer) {
  load(sphere());
  const View from = view("front");
  std::vector<Image> images;
  for (int m = 0; m < 6; ++m) {
    images.push_back(draw(from, shaded(Shading::matcap, Matcap(m))));
    if (Matcap(m) != Matcap::normals) {
      EXPECT_GT(brightnessAround(images.back(), place(from, {-0.45, 0.5, 0.74}), 4),
                brightnessAround(images.back(), place(from, {0.45, -0.6, 0.66}), 4) + 15)
          << matcapNames()[size_t(m)];
    }
    for (int other = 0; other < m; ++other)
      EXPECT_GT(meanDifference(images[size_t(other)], images.back()), 2) << other << " and " << m;
  }
}

TEST_F(Shaded, LitClayDarkensAwayFromTheLight) {
  load(sphere());
  const View from = view("front");
  const Image image = draw(from, shaded(Shading::lit));
  const Vec3d l(-0.50, 0.66, 0.56), k = l.normalized(),
                                    across = Vec3d(k.y(), -k.x(), 0).normalized().cross(k).normalized();
  // From between light and eye, where the highlight is, to the far edge of what is seen.
  double last = 256;
  for (double angle = 0.6; angle < 2.0; angle += 0.2) {
    Vec3d n = std::cos(angle) * k + std::sin(angle) * (across.z() > 0 ? across : Vec3d(-across));
    if (n.z() < 0.25) break;
    const double now = brightnessAround(image, place(from, n), 2);
    EXPECT_LT(now, last + 1) << "at " << angle << " rad from the light";
    last = now;
  }
  EXPECT_LT(last, 150);
}

TEST_F(Shaded, ThePiecesColourIsSeenInEveryShadingThatTakesIt) {
  load(sphere());
  const View from = view("front");
  const struct {
    Colour colour;
    int strongest;
  } pieces[] = {{{0.85f, 0.25f, 0.2f, 1}, 0}, {{0.25f, 0.75f, 0.3f, 1}, 1}, {{0.25f, 0.35f, 0.85f, 1}, 2}};
  for (const auto& each : pieces) {
    piece(each.colour, 0.6f, 0.3f);
    for (const Look& look : {shaded(Shading::lit), shaded(Shading::material), shaded(Shading::matcap, Matcap::clay),
                             shaded(Shading::matcap, Matcap::wax)}) {
      const Vec3d seen = colourAround(draw(from, look), place(from, {-0.3, 0.2, 0.93}), 3);
      int strongest = 0;
      seen.maxCoeff(&strongest);
      EXPECT_EQ(strongest, each.strongest) << seen.transpose();
      EXPECT_GT(seen.maxCoeff() - seen.minCoeff(), 40) << seen.transpose();
    }
    const Vec3d steel =
        colourAround(draw(from, shaded(Shading::matcap, Matcap::steel)), place(from, {0.3, -0.2, 0.93}), 3);
    EXPECT_LT(steel.maxCoeff() - steel.minCoeff(), 25) << "steel keeps its own colour";
  }
}

TEST_F(Shaded, GlossPutsItsHighlightBetweenLightAndEyeAndRoughnessSpreadsIt) {
  load(sphere());
  const View from = view("front");
  const View::Axes a = from.axes();
  const Vec3d key = toKey(from);
  const Vec3d half = (Vec3d(key.dot(a.right), key.dot(a.up), -key.dot(a.forward)) + Vec3d(0, 0, 1)).normalized();
  const auto highlight = [&](float roughness) {
    piece({0.2f, 0.2f, 0.2f, 1}, roughness, 0);
    const Image matt = draw(from, shaded(Shading::material));
    piece({0.2f, 0.2f, 0.2f, 1}, roughness, 1);
    const Image shiny = draw(from, shaded(Shading::material));
    // Centre and size of what the gloss adds near the highlight.
    const Vec3d centre = place(from, half);
    double sum = 0, x = 0, y = 0, most = 0;
    for (int py = int(centre.y()) - 30; py <= int(centre.y()) + 30; ++py) {
      for (int px = int(centre.x()) - 30; px <= int(centre.x()) + 30; ++px) {
        const double more = std::pow(std::max(0.0, brightness(shiny, px, py) - brightness(matt, px, py)), 3);
        sum += more;
        x += more * (px + 0.5);
        y += more * (py + 0.5);
        most = std::max(most, more);
      }
    }
    return std::array<double, 4>{x / sum, y / sum, sum / most, std::cbrt(most)};
  };
  const auto sharp = highlight(0.2f), broad = highlight(0.5f);
  EXPECT_NEAR(sharp[0], place(from, half).x(), 3);
  EXPECT_NEAR(sharp[1], place(from, half).y(), 3);
  EXPECT_GT(broad[2], 1.5 * sharp[2]) << "spread over more pixels";
  EXPECT_GT(sharp[3], broad[3] + 15) << "and dimmer";
  EXPECT_GT(sharp[3], 60);
}

TEST_F(Shaded, DimmedPiecesComeNearerToTheBackground) {
  load(sphere());
  const View from = view("front");
  for (const Shading shading : {Shading::matcap, Shading::lit, Shading::material}) {
    for (const bool light : {false, true}) {
      Look look = shaded(shading);
      look.lightBackground = light;
      const Vec3d at = place(from, {light ? 0.5 : -0.3, light ? -0.6 : 0.3, 0.6});
      piece({0.8f, 0.62f, 0.5f, 1}, 0.6f, 0.3f);
      const Image plain = draw(from, look);
      piece({0.8f, 0.62f, 0.5f, 1}, 0.6f, 0.3f, true);
      const Image dimmed = draw(from, look);
      const Vec3d back = colourAround(plain, {20, at.y(), 0});
      EXPECT_LT((colourAround(dimmed, at) - back).norm(), 0.8 * (colourAround(plain, at) - back).norm());
      EXPECT_EQ(colourAround(dimmed, {20, at.y(), 0}), back);
    }
  }
}

TEST_F(Shaded, OneSampleAndManyShowTheSameColours) {
  load(sphere());
  Look look;
  look.keyShadow = look.cavity = false;
  Quality quality;
  quality.supersample = 1;
  renderer_->setQuality(quality);
  const Image one = draw(view("iso", Projection::perspective), look);
  quality.supersample = 4;
  renderer_->setQuality(quality);
  const Image many = draw(view("iso", Projection::perspective), look);
  EXPECT_LT(meanDifference(one, many), 1.5);  // edges and lines differ, faces do not
  EXPECT_NE(one, many);
}

TEST_F(Shaded, LightAndDarkBackgrounds) {
  load(sphere());
  Look look = kBare;
  const Image dark = draw(view("front"), look);
  look.lightBackground = true;
  const Image light = draw(view("front"), look);
  for (const Vec3d& corner :
       {Vec3d(4, 4, 0), Vec3d(kWidth - 4, 4, 0), Vec3d(4, kHeight - 4, 0), Vec3d(kWidth - 4, kHeight - 4, 0)}) {
    EXPECT_LT(brightnessAround(dark, corner), 80);
    EXPECT_GT(brightnessAround(light, corner), 170);
  }
  const Vec3d middle(0.5 * kWidth, 0.5 * kHeight, 0);
  EXPECT_NEAR(brightnessAround(dark, middle), brightnessAround(light, middle), 2);
}

TEST_F(Shaded, BadLooksAreRefused) {
  load(sphere());
  Shot shot{view("front"), kBare, {}, {}};
  const auto refused = [&](auto change) {
    Shot bad = shot;
    change(bad);
    EXPECT_THROW((void)renderer_->render(bad, 64, 64), Error);
  };
  refused([](Shot& s) { s.look.cavityStrength = 2.1; });
  refused([](Shot& s) { s.look.depthFadeStrength = std::nan(""); });
  refused([](Shot& s) { s.look.section = Section{Vec3d::Zero(), Vec3d::Zero()}; });
  refused([](Shot& s) { s.look.section = Section{Vec3d::Constant(std::nan("")), Vec3d::UnitX()}; });
  refused([](Shot& s) { s.stereo.eyeDistancePart = -0.1; });
  refused([](Shot& s) { s.stereo.convergencePart = 0.1; });
  refused([](Shot& s) { s.overlays.fills.push_back({{Vec3d::Zero(), Vec3d::UnitX()}, {}, Depth::xray}); });
  refused([](Shot& s) { s.overlays.polylines.push_back({{Vec3d::Zero()}, {}, -1, Depth::hidden}); });
  refused([](Shot& s) { s.overlays.cursor.emplace().forceN = Vec3d::Constant(std::nan("")); });
  refused([](Shot& s) { s.overlays.cursor.emplace().footprint.emplace().normal = Vec3d::Zero(); });
  EXPECT_NO_THROW((void)renderer_->render(shot, 64, 64));
}

}  // namespace
}  // namespace argil::render
