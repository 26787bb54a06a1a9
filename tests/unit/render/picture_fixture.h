#pragma once
// Small pictures of known scenes, each drawn through the validation layer where it is installed.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/renderer/renderer.h"
#include "tests/unit/render/field_surface.h"

namespace argil::render::test {

inline double brightness(const Image& image, double x, double y) {
  const uint8_t* p = image.pixel(int(x), int(y));
  return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
}

/// Mean brightness of a square around a place.
inline double brightnessAround(const Image& image, const Vec3d& at, int reach = 2) {
  double sum = 0;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) sum += brightness(image, at.x() + x, at.y() + y);
  }
  return sum / ((2 * reach + 1) * (2 * reach + 1));
}

/// Mean colour of a square around a place, 0 to 255.
inline Vec3d colourAround(const Image& image, const Vec3d& at, int reach = 1) {
  Vec3d sum = Vec3d::Zero();
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const uint8_t* p = image.pixel(int(at.x()) + x, int(at.y()) + y);
      sum += Vec3d(p[0], p[1], p[2]);
    }
  }
  return sum / ((2 * reach + 1) * (2 * reach + 1));
}

inline double displayLinear(double srgb) {
  const double c = srgb / 255;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
inline Vec3d displayLinear(const Vec3d& srgb) {
  return {displayLinear(srgb.x()), displayLinear(srgb.y()), displayLinear(srgb.z())};
}

/// How far two pictures differ, 0 to 255.
inline double meanDifference(const Image& a, const Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i) sum += std::abs(int(a.rgba[i]) - int(b.rgba[i]));
  return sum / double(a.rgba.size()) * 4 / 3;
}
inline int mostDifference(const Image& a, const Image& b) {
  int most = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i) most = std::max(most, std::abs(int(a.rgba[i]) - int(b.rgba[i])));
  return most;
}

/// Clay alone.
inline const Look kBare = [] {
  Look look;
  look.grid = look.scaleBar = look.cavity = false;
  return look;
}();

class Picture : public testing::Test {
 protected:
  static constexpr int kWidth = 320, kHeight = 200;
  static constexpr double kRadius = 16;  // voxels
  static constexpr double kVoxel = 0.5;

  void SetUp() override {
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
    RendererOptions options;
    options.validation = true;
    renderer_.emplace(options);
  }
  void TearDown() override {
    if (!renderer_) return;
    for (const std::string& message : renderer_->validationMessages()) ADD_FAILURE() << message;
    if (!renderer_->validating()) RecordProperty("validation", "layer not installed");
  }

  void load(const Field& field, const Vec3d& originMm = Vec3d::Zero(), double voxelMm = kVoxel) {
    clay::Grid grid;
    grid.voxelMm = voxelMm;
    grid.originMm = originMm;
    stats_ = renderer_->update(surface_.update(grid, {-3, -3, -3}, {2, 2, 2}, field));
  }
  static Field sphere() {
    return [](const Vec3d& p) { return p.norm() - kRadius; };
  }
  View view(const char* name, Projection projection = Projection::orthographic) const {
    return View::named(name, renderer_->bounds(), double(kWidth) / kHeight, projection);
  }
  Image draw(const View& from, const Look& look, const Overlays& overlays = {}, const Stereo& stereo = {}) {
    return renderer_->render(Shot{from, look, stereo, overlays}, kWidth, kHeight);
  }

  FieldSurface surface_;
  std::optional<Renderer> renderer_;
  UploadStats stats_;
};

}  // namespace argil::render::test
