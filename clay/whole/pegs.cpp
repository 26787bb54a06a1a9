#include "clay/whole/pegs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/cut.h"
#include "clay/whole/deform.h"

namespace argil::clay {

namespace {

constexpr double kMostCells = 4e6;     // of the section: coarser than voxels where it is larger
constexpr double kLeastWidth = 4;      // voxels, of a peg
constexpr double kMostAutomatic = 10;  // mm: a wider peg holds no better
constexpr double kWall = 0.3;          // of the diameter: clay around a hole
constexpr double kLeastWall = 2;       // voxels
constexpr double kShrink = 0.8;        // from one try to the next
constexpr double kChamfer = 0.15;      // of the diameter
constexpr double kRoot = 2;            // voxels that a peg goes into its own half
constexpr int kCandidates = 400;       // places that are looked at in space, of an area and a diameter

// The section: squares of the plane that are clay, and how far each is from what is none.
class Section {
 public:
  Section(const Version& version, const Vec3d& pointMm, const Vec3d& normal)
      : u_(normal.unitOrthogonal()), v_(normal.cross(u_)) {
    const Grid& grid = version.grid();
    const BoxMm box = boundsOf(version);
    Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = -low;
    origin_ = grid.toVoxel(pointMm);
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner = grid.toVoxel(Vec3d((i & 1 ? box.high : box.low).x(), (i & 2 ? box.high : box.low).y(),
                                              (i & 4 ? box.high : box.low).z())) -
                           origin_;
      const Eigen::Vector2d at(corner.dot(u_), corner.dot(v_));
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
    const Eigen::Vector2d size = high - low;
    step_ = std::max(1.0, std::sqrt(size.prod() / kMostCells));
    low_ = low - Eigen::Vector2d::Constant(step_);
    width_ = static_cast<int>(size.x() / step_) + 4;
    height_ = static_cast<int>(size.y() / step_) + 4;
    Sampler clay(version);
    area_.assign(size_t(width_) * size_t(height_), -1);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        if (clay.trilinear(voxelAt(x, y)) < 0) area_[index(x, y)] = 0;
    findAreas();
    findDistances();
  }

  [[nodiscard]] int areas() const { return areas_; }
  struct Place {
    Vec3d voxel;
    double room;  // voxels to what is no clay, in the plane
  };
  /// Those of an area with at least so much room, about `most` of them, spread evenly.
  [[nodiscard]] std::vector<Place> places(int area, double room, int most) const {
    std::vector<std::pair<int, int>> found;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        if (area_[index(x, y)] == area && distance_[index(x, y)] * step_ >= room) found.emplace_back(x, y);
    const int stride = std::max(1, static_cast<int>(std::sqrt(double(found.size()) / most)));
    std::vector<Place> out;
    for (const auto& [x, y] : found)
      if (x % stride == 0 && y % stride == 0) out.push_back({voxelAt(x, y), distance_[index(x, y)] * step_});
    // A small area may lie between the strides.
    if (out.empty() && !found.empty()) {
      const auto [x, y] = found[found.size() / 2];
      out.push_back({voxelAt(x, y), distance_[index(x, y)] * step_});
    }
    return out;
  }
  [[nodiscard]] double mostRoom(int area) const {
    double most = 0;
    for (size_t i = 0; i < area_.size(); ++i)
      if (area_[i] == area) most = std::max(most, double(distance_[i]) * step_);
    return most;
  }

 private:
  [[nodiscard]] size_t index(int x, int y) const { return size_t(y) * size_t(width_) + size_t(x); }
  [[nodiscard]] Vec3d voxelAt(int x, int y) const {
    return origin_ + (low_.x() + x * step_) * u_ + (low_.y() + y * step_) * v_;
  }

  void findAreas() {
    std::vector<std::pair<int, int>> todo;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        if (area_[index(x, y)] != 0) continue;
        ++areas_;
        todo.assign(1, {x, y});
        area_[index(x, y)] = areas_;
        while (!todo.empty()) {
          const auto [i, j] = todo.back();
          todo.pop_back();
          for (const auto& [a, b] :
               {std::pair{i - 1, j}, std::pair{i + 1, j}, std::pair{i, j - 1}, std::pair{i, j + 1}})
            if (area_[index(a, b)] == 0) area_[index(a, b)] = areas_, todo.emplace_back(a, b);
        }
      }
  }

  // Exact, in two passes of lower envelopes of parabolas (Felzenszwalb, Huttenlocher 2012).
  void findDistances() {
    distance_.assign(area_.size(), 0);
    const float far = static_cast<float>(width_) * static_cast<float>(width_) + float(height_) * float(height_);
    for (size_t i = 0; i < area_.size(); ++i) distance_[i] = area_[i] > 0 ? far : 0;
    for (int x = 0; x < width_; ++x) envelope(&distance_[index(x, 0)], height_, size_t(width_));
    for (int y = 0; y < height_; ++y) envelope(&distance_[index(0, y)], width_, 1);
    for (float& each : distance_) each = std::sqrt(each);
  }
  void envelope(float* at, int count, size_t stride) {
    value_.resize(size_t(count));
    vertex_.resize(size_t(count));
    bound_.resize(size_t(count) + 1);
    for (int i = 0; i < count; ++i) value_[size_t(i)] = at[size_t(i) * stride];
    size_t k = 0;
    vertex_[0] = 0;
    bound_[0] = -std::numeric_limits<float>::infinity();
    bound_[1] = -bound_[0];
    const auto meet = [&](int a, int b) {
      return (value_[size_t(b)] + float(b) * float(b) - value_[size_t(a)] - float(a) * float(a)) / float(2 * (b - a));
    };
    for (int i = 1; i < count; ++i) {
      float from = meet(vertex_[k], i);
      while (from <= bound_[k]) from = meet(vertex_[--k], i);
      vertex_[++k] = i;
      bound_[k] = from;
      bound_[k + 1] = std::numeric_limits<float>::infinity();
    }
    k = 0;
    for (int i = 0; i < count; ++i) {
      while (bound_[k + 1] < float(i)) ++k;
      const auto off = float(i - vertex_[k]);
      at[size_t(i) * stride] = off * off + value_[size_t(vertex_[k])];
    }
  }

  Vec3d u_, v_, origin_ = Vec3d::Zero();
  Eigen::Vector2d low_;
  double step_ = 1;
  int width_ = 0, height_ = 0, areas_ = 0;
  std::vector<int> area_;        // −1 outside, else from 1 on
  std::vector<float> distance_;  // in steps
  std::vector<float> value_, bound_;
  std::vector<int> vertex_;
};

// Whether all of a cylinder around a place of the plane is clay: no voxel of it, or half a voxel beside it, is not.
bool isClay(Sampler& clay, const Vec3d& centre, const Vec3d& n, double radius, double half) {
  const double r = radius + 0.5, h = half + 0.5;
  const Vec3d reach = h * n.cwiseAbs() + r * (Vec3d::Ones() - n.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  const auto brickAt = [](const Vec3d& p) {
    const Vec3d at = p.array().floor();
    return Coord{static_cast<int32_t>(at.x()), static_cast<int32_t>(at.y()), static_cast<int32_t>(at.z())} >>
           kBrickBits;
  };
  const Coord from = brickAt(centre - reach), to = brickAt(centre + reach);
  const auto within = [&](Coord voxel) {
    const Vec3d off = voxel.toVec3d() - centre;
    const double along = off.dot(n);
    return std::abs(along) <= h && off.squaredNorm() - along * along <= r * r;
  };
  for (int bx = from.x; bx <= to.x; ++bx)
    for (int by = from.y; by <= to.y; ++by)
      for (int bz = from.z; bz <= to.z; ++bz) {
        const Coord brick{bx, by, bz};
        const Slot slot = clay.slot(brick);
        if (slot.isTile() && slot.tile() == Tile::inside) continue;
        for (int x = 0; x < kBrickEdge; ++x)
          for (int y = 0; y < kBrickEdge; ++y)
            for (int z = 0; z < kBrickEdge; ++z)
              if (within(brick * kBrickEdge + Coord{x, y, z}) && slot.phi(Brick::offset(x, y, z), clay.band()) >= 0)
                return false;
      }
  return true;
}

// Measures of a peg, voxels.
struct Size {
  double diameter, depth, clearance;
  [[nodiscard]] double wall() const { return std::max(kLeastWall, kWall * diameter); }
  [[nodiscard]] double radiusAround() const { return diameter / 2 + clearance + wall(); }
  [[nodiscard]] double depthAround() const { return depth + clearance + wall(); }
};

// As many as asked for, far apart; fewer where there is no room.
std::vector<Vec3d> placesFor(const Section& section, Sampler& clay, int area, const Vec3d& n, const Size& size,
                             int pegs) {
  std::vector<Section::Place> free = section.places(area, size.radiusAround(), kCandidates);
  std::erase_if(free, [&](const Section::Place& each) {
    return !isClay(clay, each.voxel, n, size.radiusAround(), size.depthAround());
  });
  std::vector<Vec3d> chosen;
  if (free.empty()) return chosen;
  if (pegs == 1) {
    const auto best =
        std::max_element(free.begin(), free.end(), [](const auto& a, const auto& b) { return a.room < b.room; });
    return {best->voxel};
  }
  Vec3d middle = Vec3d::Zero();
  for (const auto& each : free) middle += each.voxel / double(free.size());
  const auto apart = [&](const Section::Place& each) {
    double least = chosen.empty() ? (each.voxel - middle).norm() : std::numeric_limits<double>::infinity();
    for (const Vec3d& other : chosen) least = std::min(least, (each.voxel - other).norm());
    return least;
  };
  while (static_cast<int>(chosen.size()) < pegs) {
    const auto best =
        std::max_element(free.begin(), free.end(), [&](const auto& a, const auto& b) { return apart(a) < apart(b); });
    // Each has its own clay around it.
    if (!chosen.empty() && apart(*best) < 2 * size.diameter + 2 * size.clearance + size.wall()) break;
    chosen.push_back(best->voxel);
  }
  return chosen;
}

}  // namespace

PegPlan planPegs(const Version& version, const PegOptions& options, const WorkPart& part) {
  const Grid& grid = version.grid();
  const double voxel = grid.voxelMm;
  if (options.pegs < 1 || options.pegs > 8) throw Error(fmt::format("{} pegs in an area: give 1 to 8", options.pegs));
  if (!(options.clearanceMm >= 0 && options.clearanceMm <= 5))
    throw Error(fmt::format("a clearance of {:g} mm: give 0 to 5 mm", options.clearanceMm));
  if (options.diameterMm != 0 && !(options.diameterMm >= kLeastWidth * voxel))
    throw Error(fmt::format("pegs of {:g} mm at voxels of {:g} mm: give at least {:g} mm, or 0", options.diameterMm,
                            voxel, kLeastWidth * voxel));
  if (!(options.depthMm == 0 || options.depthMm >= kLeastWall * voxel))
    throw Error(fmt::format("pegs {:g} mm deep at voxels of {:g} mm: give at least {:g} mm, or 0", options.depthMm,
                            voxel, kLeastWall * voxel));
  const Vec3d n = options.normal.normalized();
  PegPlan result;
  const Section section(version, options.pointMm, n);
  Sampler clay(version);
  result.areas = section.areas();
  if (result.areas == 0) throw Error("the cut does not meet the clay: move the plane");
  for (int area = 1; area <= section.areas(); ++area) {
    part.step(double(area) / section.areas());
    const double widest =
        options.diameterMm > 0 ? options.diameterMm / voxel : std::min(kMostAutomatic / voxel, section.mostRoom(area));
    std::vector<Vec3d> places;
    Size size{};
    // Of the widest that all asked for find room; of the rest, the most.
    for (double diameter = widest; diameter >= kLeastWidth; diameter *= kShrink) {
      const Size tried{diameter, options.depthMm > 0 ? options.depthMm / voxel : diameter, options.clearanceMm / voxel};
      std::vector<Vec3d> found = placesFor(section, clay, area, n, tried, options.pegs);
      if (found.size() > places.size()) places = std::move(found), size = tried;
      if (options.diameterMm > 0 || static_cast<int>(places.size()) == options.pegs) break;
    }
    if (places.empty()) ++result.without;
    for (const Vec3d& each : places)
      result.pegs.push_back({grid.toWorld(each), size.diameter * voxel, size.depth * voxel});
  }
  if (result.pegs.empty())
    throw Error("no peg finds room in the cut: give thinner or shorter ones, or move the plane", Error::Kind::work);
  return result;
}

PeggedHalves cutWithPegs(const Version& version, const PegOptions& options, const WorkPart& part) {
  const Grid& grid = version.grid();
  const double voxel = grid.voxelMm;
  PegPlan plan = planPegs(version, options, part.part(0, 0.3));
  const PlaneDivider plane(options.pointMm, options.normal);
  const Vec3d n = options.normal.normalized();
  PeggedHalves result;
  result.front = cut(version, plane, false, version.store());
  result.back = cut(version, plane, true, Store::make(version.store()->precision()));
  if (result.front.stats().bricks == 0 || result.back.stats().bricks == 0)
    throw Error("the cut does not meet the clay: move the plane");
  part.step(0.6);
  result.pegs = std::move(plan.pegs);
  result.areas = plan.areas;
  result.without = plan.without;

  const auto chamferMm = [](const Peg& peg) { return std::min(kChamfer * peg.diameterMm, peg.depthMm / 2); };
  const auto rod = [&](const Peg& peg, double from, double to, double widerMm) {
    return makeRod(Store::make(version.store()->precision()), grid, peg.atMm + from * n, peg.atMm + to * n,
                   peg.diameterMm / 2 + widerMm, chamferMm(peg));
  };
  for (size_t i = 0; i < result.pegs.size(); ++i) {
    part.step(0.6 + 0.4 * double(i) / double(result.pegs.size()));
    const Peg& peg = result.pegs[i];
    const double free = options.clearanceMm, deep = peg.depthMm + free;
    // Straight where it begins: the chamfer of that end lies on the other side of the cut.
    const double behind = chamferMm(peg) + kRoot * voxel;
    if (options.loose) {
      const Version hole = rod(peg, -deep, deep, free);
      result.front = combine(result.front, hole, Combination::cut);
      result.back = combine(result.back, hole, Combination::cut);
      result.pins.push_back(rod(peg, -peg.depthMm, peg.depthMm, 0));
    } else {
      result.front = combine(result.front, rod(peg, -behind, deep, free), Combination::cut);
      result.back = combine(result.back, rod(peg, -behind, peg.depthMm, 0), Combination::join);
    }
  }
  part.step(1);
  return result;
}

}  // namespace argil::clay
