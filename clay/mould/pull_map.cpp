#include "clay/mould/pull_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clay/base/parallel.h"

namespace argil::clay {

namespace {

constexpr double kCell = kBrickEdge;                 // of a column's section, voxels
constexpr double kHalfBox = (kBrickEdge + 2.0) / 2;  // vertices stand a voxel outside of their brick at most
constexpr float kDeep = 0.3f;                        // voxels in the clay that are in the way
constexpr double kLeastStep = 1;                     // voxels along a line, else as far as the surface is away
constexpr double kUpright = std::numbers::pi / 180;  // sine of a degree
constexpr size_t kBlock = 8;

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
      column.push_back({middle(brick).dot(pull_), brick});
    else
      std::erase_if(column, [&](const InColumn& each) { return each.brick == brick; });
  });
}

// Whether clay lies from p on along the pull, or against it. Only where bricks are can a line enter clay.
bool PullMap::blocked(Sampler& field, const Vec3d& p, const Column& column, bool against) const {
  const double along = (against ? -1 : 1) * p.dot(pull_);
  const Vec3d way = against ? Vec3d(-pull_) : pull_;
  double t = kLeastStep;
  for (size_t i = 0; i < column.size(); ++i) {
    const double middle = against ? -column[column.size() - 1 - i].along : column[i].along;
    t = std::max(t, middle - reach_ - along);
    for (const double end = middle + reach_ - along; t < end;) {
      const float phi = field.trilinear(p + t * way);
      if (phi < -kDeep) return true;
      t += std::max(kLeastStep, static_cast<double>(phi));
    }
  }
  return false;
}

// `cells`: sorted, those in which something may have changed; all, where the brick did.
void PullMap::look(const BrickMesh& mesh, const Version& version, std::span<const Cell> cells, bool all,
                   std::vector<uint8_t>& undercut) const {
  Sampler field(version);
  const Vec3d first = (mesh.brick * kBrickEdge).toVec3d();
  undercut.resize(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3d p = first + mesh.positions[i].cast<double>();
    const Cell cell{static_cast<int32_t>(std::floor(p.dot(u_) / kCell)),
                    static_cast<int32_t>(std::floor(p.dot(v_) / kCell))};
    if (!all && !std::binary_search(cells.begin(), cells.end(), cell)) continue;
    const auto column = columns_.find(cell);
    const double looks = mesh.normals[i].unpack().cast<double>().dot(pull_);
    undercut[i] = column != columns_.end() && (looks <= -kUpright || blocked(field, p, column->second, false)) &&
                  (looks >= kUpright || blocked(field, p, column->second, true));
  }
  if (std::find(undercut.begin(), undercut.end(), 1) == undercut.end()) undercut.clear();
}

std::vector<Coord> PullMap::follow(const Surface& surface, std::span<const Coord> changed, int threads) {
  std::vector<Cell> cells;
  for (const Coord brick : changed) {
    put(brick, surface.find(brick) != nullptr);
    forCells(brick, [&](const Cell& cell) { cells.push_back(cell); });
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  std::vector<Coord> own(changed.begin(), changed.end());
  std::sort(own.begin(), own.end());
  std::vector<Coord> bricks = own;
  for (const Cell& cell : cells) {
    const auto found = columns_.find(cell);
    if (found == columns_.end()) continue;
    Column& column = found->second;
    if (column.empty()) {
      columns_.erase(found);
      continue;
    }
    std::sort(column.begin(), column.end(), [](const InColumn& a, const InColumn& b) { return a.along < b.along; });
    for (const InColumn& each : column) bricks.push_back(each.brick);
  }
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  std::vector<std::vector<uint8_t>> made(bricks.size());
  parallelBlocks(
      bricks.size(), threads,
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          const BrickMesh* mesh = surface.find(bricks[i]);
          if (!mesh) continue;
          const bool all = std::binary_search(own.begin(), own.end(), bricks[i]);
          if (const auto before = undercut_.find(bricks[i]); !all && before != undercut_.end())
            made[i] = before->second;
          look(*mesh, surface.version(), cells, all, made[i]);
        }
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
