#include "clay/mould/pull_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clay/base/parallel.h"
#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

constexpr double kCell = kBrickEdge;                 // of a column's section, voxels
constexpr double kHalfBox = (kBrickEdge + 2.0) / 2;  // vertices stand a voxel outside of their brick at most
constexpr float kDeep = 0.3f;                        // voxels in the clay that are in the way
constexpr double kLeastStep = 0.4, kShare = 0.9;     // of the way to the surface that a step goes
constexpr double kUpright = std::numbers::pi / 180;  // sine of a degree
constexpr size_t kBlock = 8;

// Whether clay lies from p on, up to `length` voxels along `way`.
bool blocked(Sampler& field, const Vec3d& p, const Vec3d& way, double length) {
  const auto outside = field.band();
  for (double t = kLeastStep; t < length;) {
    const Vec3d at = p + t * way;
    const Coord voxel{static_cast<int32_t>(std::floor(at.x())), static_cast<int32_t>(std::floor(at.y())),
                      static_cast<int32_t>(std::floor(at.z()))};
    const Coord brick = voxel >> 3;
    if (const Slot slot = field.slot(brick); slot.isTile()) {
      if (slot.tile() == Tile::inside) return true;
      // To the end of the tile.
      double leaves = INFINITY;
      const Vec3d first = (brick * kBrickEdge).toVec3d();
      for (int k = 0; k < 3; ++k)
        if (way[k] != 0) leaves = std::min(leaves, ((way[k] > 0 ? first[k] + kBrickEdge : first[k]) - at[k]) / way[k]);
      t += std::max(leaves, 0.0) + 1e-3;
      continue;
    }
    const float phi = field.trilinear(at);
    if (phi < -kDeep) return true;
    t += std::max(kLeastStep, kShare * static_cast<double>(std::min(phi, outside)));
  }
  return false;
}

}  // namespace

size_t PullMap::CellHash::operator()(const Cell& cell) const noexcept {
  return (static_cast<uint64_t>(static_cast<uint32_t>(cell.first)) << 32 | static_cast<uint32_t>(cell.second)) *
         0x9e3779b97f4a7c15u;
}

PullMap::PullMap(const Vec3d& pull) : pull_(pull.normalized()) {
  u_ = pull_.unitOrthogonal();
  v_ = pull_.cross(u_);
  reachU_ = kHalfBox * u_.lpNorm<1>();
  reachV_ = kHalfBox * v_.lpNorm<1>();
  reach_ = kHalfBox * pull_.lpNorm<1>();
}

PullMap::~PullMap() = default;

Vec3d PullMap::middle(Coord brick) const {
  return (brick * kBrickEdge).toVec3d() + Vec3d::Constant(0.5 * kBrickEdge);
}

template <class Visit>
void PullMap::forCells(Coord brick, const Visit& visit) const {
  const Vec3d at = middle(brick);
  const auto cell = [](double along) { return static_cast<int32_t>(std::floor(along / kCell)); };
  for (int32_t i = cell(at.dot(u_) - reachU_); i <= cell(at.dot(u_) + reachU_); ++i)
    for (int32_t k = cell(at.dot(v_) - reachV_); k <= cell(at.dot(v_) + reachV_); ++k) visit(Cell{i, k});
}

void PullMap::put(Coord brick, bool there) {
  if (there == bricks_.contains(brick)) return;
  if (there)
    bricks_.insert(brick);
  else
    bricks_.erase(brick);
  forCells(brick, [&](const Cell& cell) {
    Column& column = columns_[cell];
    if (there)
      column.bricks.push_back(brick);
    else
      std::erase(column.bricks, brick);
  });
}

void PullMap::look(const BrickMesh& mesh, const Version& version, std::vector<uint8_t>& undercut) const {
  Sampler field(version);
  const Vec3d first = (mesh.brick * kBrickEdge).toVec3d();
  undercut.assign(mesh.positions.size(), 0);
  bool any = false;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3d p = first + mesh.positions[i].cast<double>();
    const auto column = columns_.find(
        {static_cast<int32_t>(std::floor(p.dot(u_) / kCell)), static_cast<int32_t>(std::floor(p.dot(v_) / kCell))});
    if (column == columns_.end()) continue;
    const Vec3d normal = mesh.normals[i].unpack().cast<double>();
    const double along = p.dot(pull_), looks = normal.dot(pull_);
    const bool up = looks > -kUpright, down = looks < kUpright;
    const bool held = (!up || blocked(field, p, pull_, column->second.high - along)) &&
                      (!down || blocked(field, p, -pull_, along - column->second.low));
    undercut[i] = held;
    any |= held;
  }
  if (!any) undercut.clear();
}

std::vector<Coord> PullMap::follow(const Surface& surface, std::span<const Coord> changed, int threads) {
  std::vector<Cell> cells;
  for (const Coord brick : changed) {
    put(brick, surface.find(brick) != nullptr);
    forCells(brick, [&](const Cell& cell) { cells.push_back(cell); });
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  std::vector<Coord> bricks(changed.begin(), changed.end());
  for (const Cell& cell : cells) {
    const auto found = columns_.find(cell);
    if (found == columns_.end()) continue;
    Column& column = found->second;
    if (column.bricks.empty()) {
      columns_.erase(found);
      continue;
    }
    column.low = INFINITY, column.high = -INFINITY;
    for (const Coord brick : column.bricks) {
      const double along = middle(brick).dot(pull_);
      column.low = std::min(column.low, along - reach_);
      column.high = std::max(column.high, along + reach_);
    }
    bricks.insert(bricks.end(), column.bricks.begin(), column.bricks.end());
  }
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  std::vector<std::vector<uint8_t>> made(bricks.size());
  parallelBlocks(
      bricks.size(), threads,
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
          if (const BrickMesh* mesh = surface.find(bricks[i])) look(*mesh, surface.version(), made[i]);
      },
      kBlock);
  for (size_t i = 0; i < bricks.size(); ++i) {
    if (made[i].empty())
      undercut_.erase(bricks[i]);
    else
      undercut_[bricks[i]] = std::move(made[i]);
  }
  return bricks;
}

std::span<const uint8_t> PullMap::undercut(Coord brick) const {
  const auto found = undercut_.find(brick);
  return found == undercut_.end() ? std::span<const uint8_t>() : found->second;
}

}  // namespace argil::clay
