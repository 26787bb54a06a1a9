#include "clay/surface/wall_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/surface/quads.h"

namespace argil::clay {

namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr float kMostVoxels = 256;
constexpr uint32_t kPad = kBrickEdge;  // floats that kernels read behind a row
// How far, in voxels, a ball may touch a vertex's tangent plane from the vertex.
constexpr float kBeside = 1.5f;
// Normals have 16 bits an axis, and a cone's axis is rounded.
constexpr float kConeSlack = 0.01f;
constexpr float kOppositeAngle = 2.0943951f;  // acos(kOppositeCosine)
constexpr size_t kBricksABlock = 64;
constexpr size_t kBricksAStep = 512;  // between two looks at the job: 0.1 s where all is thin

}  // namespace

struct WallMap::Points {
  Coord brick;
  std::vector<float> rows;  // SurfacePoints; voxels from the brick's corner
  uint32_t count = 0;
  Vec3f low, high;    // around them
  Vec3f axis;         // of a cone that holds their normals
  float angle = 0;    // of the cone, rad; π: any
  float besides = 1;  // cosine from the axis from which on a normal is opposite to none of them
  std::vector<float> sizes[2];
  std::vector<Partner> partners[2];

  [[nodiscard]] size_t stride() const { return count + kPad; }
  [[nodiscard]] SurfacePoints points() const { return {rows.data(), stride(), count}; }
  [[nodiscard]] float at(size_t row, uint32_t i) const { return rows[row * stride() + i]; }
};

struct WallMap::Room {
  struct Beside {
    const Points* points;
    Vec3f shift;      // from the corner of the brick that is measured to its own
    Vec3f low, high;  // from there
  };
  std::vector<Beside> beside;
};

WallMap::WallMap(double wallVoxels, double gapVoxels)
    : limits_{static_cast<float>(wallVoxels), static_cast<float>(gapVoxels)} {
  for (const float limit : limits_)
    if (!(limit >= 0 && limit <= kMostVoxels)) throw Error("walls and gaps are looked for up to 256 voxels");
  while (static_cast<float>(kBrickEdge << shift_) < reach() + kBrickEdge) ++shift_;
}

WallMap::~WallMap() = default;

std::span<const float> WallMap::sizes(Coord brick, SideOf side) const {
  const auto it = bricks_.find(brick);
  if (it == bricks_.end()) return {};
  return it->second->sizes[static_cast<size_t>(side)];
}

std::span<const WallMap::Partner> WallMap::partners(Coord brick, SideOf side) const {
  const auto it = bricks_.find(brick);
  if (it == bricks_.end()) return {};
  return it->second->partners[static_cast<size_t>(side)];
}

// Takes what a brick's mesh is now; without vertices it is gone.
void WallMap::put(const BrickMesh& mesh) {
  const auto it = bricks_.find(mesh.brick);
  const Coord block = mesh.brick >> shift_;
  if (mesh.positions.empty()) {
    if (it == bricks_.end()) return;
    auto& there = blocks_[block];
    std::erase(there, it->second.get());
    if (there.empty()) blocks_.erase(block);
    bricks_.erase(it);
    return;
  }
  if (mesh.normals.size() != mesh.positions.size()) throw std::logic_error("walls are measured with normals");
  Points* points = it == bricks_.end() ? nullptr : it->second.get();
  if (!points) {
    points = bricks_.emplace(mesh.brick, std::make_unique<Points>()).first->second.get();
    points->brick = mesh.brick;
    blocks_[block].push_back(points);
  }
  points->count = static_cast<uint32_t>(mesh.positions.size());
  points->rows.assign(6 * points->stride(), 0.0f);
  points->low = points->high = mesh.positions[0];
  Vec3f sum = Vec3f::Zero();
  for (uint32_t i = 0; i < points->count; ++i) {
    const Vec3f &p = mesh.positions[i], n = mesh.normals[i].unpack();
    points->low = points->low.cwiseMin(p);
    points->high = points->high.cwiseMax(p);
    sum += n;
    for (size_t k = 0; k < 3; ++k) {
      points->rows[k * points->stride() + i] = p[static_cast<int>(k)];
      points->rows[(3 + k) * points->stride() + i] = n[static_cast<int>(k)];
    }
  }
  const float length = sum.norm();
  points->angle = std::numbers::pi_v<float>;
  if (length > 0.1f * static_cast<float>(points->count)) {
    points->axis = sum / length;
    float least = 1;
    for (uint32_t i = 0; i < points->count; ++i)
      least = std::min(least, points->axis.dot(Vec3f(points->at(3, i), points->at(4, i), points->at(5, i))));
    points->angle = std::acos(std::clamp(least, -1.0f, 1.0f)) + kConeSlack;
  } else {
    points->axis = Vec3f::UnitZ();
  }
  points->besides = points->angle < kOppositeAngle ? std::cos(kOppositeAngle - points->angle) : 1.1f;
  points->sizes[0].clear();
  points->sizes[1].clear();
}

// Visits every brick whose box comes within reach of that of `to`.
template <class Visit>
void WallMap::near(const Points& to, const Visit& visit) const {
  const float squared = reach() * reach();
  const Coord block = to.brick >> shift_;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const auto it = blocks_.find(block + Coord{x, y, z});
        if (it == blocks_.end()) continue;
        for (Points* each : it->second) {
          const Coord step = each->brick - to.brick;
          const Vec3f shift = Vec3f(float(step.x), float(step.y), float(step.z)) * float(kBrickEdge);
          const Vec3f low = each->low + shift, high = each->high + shift;
          const Vec3f apart = (low - to.high).cwiseMax(to.low - high).cwiseMax(0);
          if (apart.squaredNorm() <= squared) visit(*each, shift, low, high);
        }
      }
}

void WallMap::measure(Points& mine, Room& room) const {
  room.beside.clear();
  near(mine, [&](const Points& other, const Vec3f& shift, const Vec3f& low, const Vec3f& high) {
    const float between = std::acos(std::clamp(mine.axis.dot(other.axis), -1.0f, 1.0f));
    if (between + mine.angle + other.angle < kOppositeAngle) return;
    room.beside.push_back({&other, shift, low, high});
  });
  // The order in which blocks came to hold bricks is no part of the result.
  std::sort(room.beside.begin(), room.beside.end(),
            [](const auto& a, const auto& b) { return a.points->brick < b.points->brick; });
  for (size_t side = 0; side < 2; ++side) {
    mine.sizes[side].assign(mine.count, kNone);
    mine.partners[side].clear();
  }
  if (room.beside.empty()) return;
  std::array<const Room::Beside*, 2> last{};
  for (uint32_t i = 0; i < mine.count; ++i) {
    const Vec3f p(mine.at(0, i), mine.at(1, i), mine.at(2, i)), n(mine.at(3, i), mine.at(4, i), mine.at(5, i));
    Opposite found{.wall = limits_[0] + 1, .gap = limits_[1] + 1};
    const Room::Beside* at[2] = {};
    const auto look = [&](const Room::Beside& each) {
      if (n.dot(each.points->axis) > each.points->besides) return;
      // What is in neither ball makes it no smaller.
      const auto meets = [&](float diameter) {
        const Vec3f middle = p - 0.5f * diameter * n;
        const Vec3f apart = (each.low - middle).cwiseMax(middle - each.high).cwiseMax(0);
        return apart.squaredNorm() <= 0.25f * diameter * diameter;
      };
      if (!meets(found.wall) && !meets(-found.gap)) return;
      const Vec3f from = p - each.shift;
      const int which = findOpposite(each.points->points(), from.data(), n.data(), found);
      for (size_t side = 0; side < 2; ++side)
        if (which >> side & 1) at[side] = &each;
    };
    // What was opposite to the vertex before most likely makes the balls small at once.
    for (const Room::Beside* each : last)
      if (each) look(*each);
    for (const Room::Beside& each : room.beside)
      if (&each != last[0] && &each != last[1]) look(each);
    last = {at[0], at[1]};
    for (size_t side = 0; side < 2; ++side) {
      if (!at[side]) continue;
      const Points& other = *at[side]->points;
      const uint32_t k = side == 0 ? found.wallAt : found.gapAt;
      float size = side == 0 ? found.wall : found.gap;
      // The ball that touches the vertex's tangent plane.
      const Vec3f q = Vec3f(other.at(0, k), other.at(1, k), other.at(2, k)) + at[side]->shift;
      const Vec3f m(other.at(3, k), other.at(4, k), other.at(5, k));
      const float inwards = side == 0 ? 1.0f : -1.0f;
      const float radius = inwards * (q - p).dot(m) / (1 - n.dot(m));
      const Vec3f touched = p - inwards * radius * n + inwards * radius * m;
      if (radius > 0 && (touched - q).norm() < kBeside) size = std::min(size, 2 * radius);
      if (!(size <= limits_[side])) continue;
      mine.sizes[side][i] = size;
      mine.partners[side].push_back({i, other.brick, k});
    }
  }
}

std::vector<Coord> WallMap::follow(const SurfaceDelta& delta, int threads, const WorkPart& part) {
  BrickSet dirty;
  const auto around = [&](Coord brick) {
    const auto it = bricks_.find(brick);
    if (it == bricks_.end()) return;
    near(*it->second, [&](const Points& each, const Vec3f&, const Vec3f&, const Vec3f&) { dirty.add(each.brick); });
  };
  const bool all = bricks_.empty();
  std::vector<Coord> changed;
  for (const BrickMeshPtr& mesh : delta.changed) {
    const auto it = bricks_.find(mesh->brick);
    changed.push_back(mesh->brick);
    if (!all && it != bricks_.end()) around(mesh->brick);
    put(*mesh);
  }
  for (const Coord brick : changed) {
    dirty.add(brick);
    if (!all) around(brick);
  }
  std::vector<Coord> bricks = dirty.sorted();
  std::sort(bricks.begin(), bricks.end());
  std::vector<Points*> there;
  for (const Coord brick : bricks)
    if (const auto it = bricks_.find(brick); it != bricks_.end()) there.push_back(it->second.get());
  for (size_t first = 0; first < there.size(); first += kBricksAStep) {
    part.step(double(first) / double(there.size()));
    parallelBlocks(
        std::min(kBricksAStep, there.size() - first), threads,
        [&](size_t begin, size_t end) {
          Room room;
          for (size_t i = begin; i < end; ++i) measure(*there[first + i], room);
        },
        kBricksABlock);
  }
  return bricks;
}

ThinParts thinParts(const Surface& surface, const WallMap& map, SideOf side, double limitMm) {
  const double voxel = surface.version().grid().voxelMm;
  const auto limit = static_cast<float>(limitMm / voxel);
  std::unordered_map<Coord, uint32_t, CoordHash> first;
  uint32_t count = 0;
  surface.forEach([&](const BrickMesh& mesh) {
    first.emplace(mesh.brick, count);
    count += static_cast<uint32_t>(mesh.positions.size());
  });
  std::vector<uint32_t> parent(count);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto unite = [&](uint32_t a, uint32_t b) {
    a = find(a), b = find(b);
    parent[std::max(a, b)] = std::min(a, b);
  };
  std::vector<float> sizes(count, kNone);
  std::vector<double> areas(count, 0);
  std::vector<bool> rim(count, false);  // a face that it is a corner of has one that is not thin
  for (const auto& [brick, begin] : first) {
    const auto here = map.sizes(brick, side);
    std::copy(here.begin(), here.end(), sizes.begin() + begin);
  }
  const auto thin = [&](uint32_t i) { return sizes[i] < limit; };
  ThinParts result;
  surface.forEach([&](const BrickMesh& mesh) {
    forEachQuad(surface, mesh, [&](const std::array<Corner, 4>& corners) {
      std::array<Vec3d, 4> p;
      std::array<uint32_t, 4> number;
      for (size_t k = 0; k < 4; ++k) {
        p[k] = corners[k].from(mesh.brick);
        number[k] = first.at(corners[k].mesh->brick) + corners[k].index;
      }
      const double area =
          ((p[1] - p[0]).cross(p[2] - p[0]).norm() + (p[2] - p[0]).cross(p[3] - p[0]).norm()) / 2 * voxel * voxel;
      result.surfaceMm2 += area;
      const bool all = std::all_of(number.begin(), number.end(), thin);
      for (size_t k = 0; k < 4; ++k) {
        if (!thin(number[k])) continue;
        if (!all) rim[number[k]] = true;
        areas[number[k]] += area / 4;
        if (const uint32_t next = number[(k + 1) % 4]; thin(next)) unite(number[k], next);
      }
    });
    for (const WallMap::Partner& each : map.partners(mesh.brick, side)) {
      const uint32_t a = first.at(mesh.brick) + each.vertex, b = first.at(each.brick) + each.other;
      if (thin(a) && thin(b)) unite(a, b);
    }
  });
  struct Part {
    double area = 0;
    float least = kNone;
    Vec3d at = Vec3d::Zero();
    bool inner = false;
  };
  std::unordered_map<uint32_t, Part> parts;
  surface.forEach([&](const BrickMesh& mesh) {
    const uint32_t begin = first.at(mesh.brick);
    for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
      if (!thin(begin + i)) continue;
      Part& part = parts[find(begin + i)];
      part.area += areas[begin + i];
      part.inner = part.inner || !rim[begin + i];
      if (rim[begin + i] || sizes[begin + i] >= part.least) continue;
      part.least = sizes[begin + i];
      part.at = Vec3d(mesh.brick.x, mesh.brick.y, mesh.brick.z) * kBrickEdge + mesh.positions[i].cast<double>();
    }
  });
  for (const auto& [root, part] : parts) {
    if (!part.inner) continue;
    result.areaMm2 += part.area;
    result.parts.push_back({surface.version().grid().toWorld(part.at), double(part.least) * voxel, part.area});
  }
  std::sort(result.parts.begin(), result.parts.end(), [](const ThinPart& a, const ThinPart& b) {
    return std::tie(a.leastMm, a.atMm.x(), a.atMm.y(), a.atMm.z()) <
           std::tie(b.leastMm, b.atMm.x(), b.atMm.y(), b.atMm.z());
  });
  return result;
}

}  // namespace argil::clay
