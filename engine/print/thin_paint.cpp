#include "engine/print/thin_paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "clay/surface/vertex_channels.h"

namespace argil::engine {

namespace {

using Rgb = std::array<float, 3>;
constexpr Rgb kNoWall{225, 30, 30}, kWallLimit{250, 210, 60};
constexpr Rgb kNoGap{90, 40, 200}, kGapLimit{130, 190, 250};
constexpr double kMostVoxels = 256;

void mix(const Rgb& from, const Rgb& to, float share, clay::VertexPaint& paint) {
  const auto channel = [&](size_t k) { return uint8_t(std::lround(from[k] + share * (to[k] - from[k]))); };
  paint.red = channel(0), paint.green = channel(1), paint.blue = channel(2);
  paint.cover = 255;
}

}  // namespace

void ThinPaint::follow(const clay::Surface& surface, clay::SurfaceDelta& delta, int threads) {
  if (!map_) {
    const double voxel = delta.grid.voxelMm;
    wall_ = float(std::min(limits_.wallMm / voxel, kMostVoxels));
    gap_ = float(std::min(limits_.gapMm / voxel, kMostVoxels));
    map_.emplace(wall_, gap_);
  }
  const std::vector<Coord> measured = map_->follow(delta, threads);
  std::unordered_map<Coord, size_t, clay::CoordHash> painted;  // by place in delta.painted
  for (size_t i = 0; i < delta.painted.size(); ++i) painted.emplace(delta.painted[i]->brick, i);
  std::vector<Coord> look = measured;
  for (const auto& paint : delta.painted) look.push_back(paint->brick);
  std::sort(look.begin(), look.end());
  look.erase(std::unique(look.begin(), look.end()), look.end());
  for (const Coord brick : look) {
    const clay::BrickMesh* mesh = surface.find(brick);
    const bool had = shown_.erase(brick) > 0;
    if (!mesh) continue;
    const auto walls = map_->sizes(brick, clay::SideOf::wall), gaps = map_->sizes(brick, clay::SideOf::gap);
    const auto thin = [](float size) { return std::isfinite(size); };
    const bool any = std::any_of(walls.begin(), walls.end(), thin) || std::any_of(gaps.begin(), gaps.end(), thin);
    const auto own = painted.find(brick);
    if (!any && (!had || own != painted.end())) continue;  // what the clay shows is in the delta, or is there already
    auto paint = std::make_shared<clay::BrickPaint>();
    paint->brick = brick;
    paint->vertices =
        own != painted.end() ? delta.painted[own->second]->vertices : brickPaint(surface.version(), *mesh);
    if (any) {
      shown_.insert(brick);
      paint->vertices.resize(mesh->positions.size());
      for (size_t i = 0; i < paint->vertices.size(); ++i) {
        if (thin(walls[i]))
          mix(kNoWall, kWallLimit, walls[i] / wall_, paint->vertices[i]);
        else if (thin(gaps[i]))
          mix(kNoGap, kGapLimit, gaps[i] / gap_, paint->vertices[i]);
      }
    }
    if (own != painted.end())
      delta.painted[own->second] = std::move(paint);
    else
      delta.painted.push_back(std::move(paint));
  }
}

}  // namespace argil::engine
