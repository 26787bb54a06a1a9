#include "engine/print/check_paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include "clay/surface/vertex_channels.h"

namespace argil::engine {

namespace {

using Rgb = std::array<float, 3>;
constexpr Rgb kNoWall{225, 30, 30}, kWallLimit{250, 210, 60};
constexpr Rgb kNoGap{90, 40, 200}, kGapLimit{130, 190, 250};
constexpr Rgb kUndercut{215, 40, 150};
constexpr Rgb kNoDraft{20, 110, 60}, kDraftLimit{150, 225, 150};
constexpr double kMostVoxels = 256;

void mix(const Rgb& from, const Rgb& to, float share, clay::VertexPaint& paint) {
  const auto channel = [&](size_t k) { return uint8_t(std::lround(from[k] + share * (to[k] - from[k]))); };
  paint.red = channel(0), paint.green = channel(1), paint.blue = channel(2);
  paint.cover = 255;
}

// Against the pull: the cosine of a face's normal.
float against(const clay::BrickMesh& mesh, size_t i, const Vec3f& pull) {
  return std::abs(mesh.normals[i].unpack().dot(pull));
}

bool isThin(std::span<const float> sizes, size_t i) {
  return i < sizes.size() && std::isfinite(sizes[i]);
}
bool isHeld(std::span<const uint8_t> undercut, size_t i) {
  return i < undercut.size() && undercut[i] != 0;
}

}  // namespace

CheckPaint::CheckPaint(const CheckLimits& limits) : limits_(limits) {
  if (!limits.draft) return;
  pull_ = limits.draft->pull.cast<float>();
  draft_ = float(std::sin(limits.draft->degrees * std::numbers::pi / 180));
}

bool CheckPaint::turn(const Eigen::Quaterniond& rotation) {
  if (!limits_.draft) return false;
  const Vec3f pull = (rotation.conjugate() * limits_.draft->pull).cast<float>();
  turned_ = turned_ || pull != pull_;
  pull_ = pull;
  return turned_;
}

bool CheckPaint::anyIn(const clay::BrickMesh& mesh, const Found& found) const {
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    if (isThin(found.walls, i) || isThin(found.gaps, i) || isHeld(found.undercut, i) ||
        (draft_ > 0 && against(mesh, i, pull_) < draft_))
      return true;
  return false;
}

void CheckPaint::paint(const clay::BrickMesh& mesh, const Found& found,
                       std::vector<clay::VertexPaint>& vertices) const {
  vertices.resize(mesh.positions.size());
  for (size_t i = 0; i < vertices.size(); ++i) {
    if (isThin(found.walls, i))
      mix(kNoWall, kWallLimit, found.walls[i] / wall_, vertices[i]);
    else if (isThin(found.gaps, i))
      mix(kNoGap, kGapLimit, found.gaps[i] / gap_, vertices[i]);
    else if (isHeld(found.undercut, i))
      mix(kUndercut, kUndercut, 0, vertices[i]);
    else if (draft_ > 0 && against(mesh, i, pull_) < draft_)
      mix(kNoDraft, kDraftLimit, against(mesh, i, pull_) / draft_, vertices[i]);
  }
}

void CheckPaint::follow(const clay::Surface& surface, clay::SurfaceDelta& delta, int threads) {
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
  if (draft_ > 0) {
    const bool anew = std::exchange(turned_, false) || !pulled_;
    if (anew) pulled_.emplace(pull_.cast<double>());
    std::vector<Coord> changed;
    if (anew)
      surface.forEach([&](const clay::BrickMesh& mesh) { changed.push_back(mesh.brick); });
    else
      for (const clay::BrickMeshPtr& mesh : delta.changed) changed.push_back(mesh->brick);
    const std::vector<Coord> held = pulled_->follow(surface, changed, threads);
    look.insert(look.end(), held.begin(), held.end());
  }
  for (const auto& paint : delta.painted) look.push_back(paint->brick);
  std::sort(look.begin(), look.end());
  look.erase(std::unique(look.begin(), look.end()), look.end());
  for (const Coord brick : look) {
    const clay::BrickMesh* mesh = surface.find(brick);
    const bool had = shown_.erase(brick) > 0;
    if (!mesh) continue;
    const Found found{map_->sizes(brick, clay::SideOf::wall), map_->sizes(brick, clay::SideOf::gap),
                      pulled_ ? pulled_->undercut(brick) : std::span<const uint8_t>()};
    const bool any = anyIn(*mesh, found);
    const auto own = painted.find(brick);
    if (!any && (!had || own != painted.end())) continue;  // what the clay shows is in the delta, or is there already
    auto paint = std::make_shared<clay::BrickPaint>();
    paint->brick = brick;
    paint->vertices =
        own != painted.end() ? delta.painted[own->second]->vertices : brickPaint(surface.version(), *mesh);
    if (any) {
      shown_.insert(brick);
      this->paint(*mesh, found, paint->vertices);
    }
    if (own != painted.end())
      delta.painted[own->second] = std::move(paint);
    else
      delta.painted.push_back(std::move(paint));
  }
}

}  // namespace argil::engine
