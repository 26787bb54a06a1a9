#include "clay/mould/mould.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <thread>
#include <unordered_set>

#include "clay/base/error.h"
#include "clay/base/memory_guard.h"
#include "clay/base/parallel.h"
#include "clay/field/primitives.h"
#include "clay/field/settle.h"
#include "clay/mould/best_pull.h"
#include "clay/mould/parting_surface.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/deform.h"
#include "clay/whole/resample.h"

namespace argil::clay {

namespace {

constexpr double kLeastWall = 4;        // voxels
constexpr double kLeastVent = 3;        // voxels
constexpr double kLeastKey = 3;         // voxels, of a key's radius
constexpr double kKey = 0.25;           // of the wall: a key's radius
constexpr double kOther = 0.75;         // of the others' size, of one key: so that halves fit in one way alone
constexpr double kTaper = 0.4;          // of a key's radius over its height, which is as much as its radius
constexpr double kRoot = 2;             // voxels that a key and a way in go into what they stand on
constexpr double kMostSlope = 0.5;      // of a key's radius: how uneven the ground of a key may be
constexpr double kFunnel = 1.5;         // how much wider a sprue is outside
constexpr double kPeakMm = 1;           // that air is caught in, and
constexpr double kPeak = 2;             // voxels
constexpr float kUneven = 0.1f;         // voxels that a wall which stands upright may be uneven by
constexpr size_t kMostWays = 64;        // of sprues and vents
constexpr size_t kColumnsAtOnce = 128;  // of bricks, before they are linked

Eigen::Matrix3d turnTo(const Vec3d& pull) {
  // An axis goes to +z by whole quarters, so that voxels come to lie on voxels.
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0})
      if ((pull - sign * Vec3d::Unit(axis)).norm() < 1e-9) {
        Eigen::Matrix3d turn;
        turn.row(2) = sign * Vec3d::Unit(axis);
        turn.row(0) = Vec3d::Unit((axis + 1) % 3);
        turn.row(1) = turn.row(2).cross(turn.row(0));
        return turn;
      }
  return Eigen::Quaterniond::FromTwoVectors(pull, Vec3d::UnitZ()).toRotationMatrix();
}

// The box of the block, voxels, and its bricks.
struct Block {
  Vec3d low, high;
  Coord first, last;
  Block(const Vec3d& from, const Vec3d& to, double band) : low(from), high(to) {
    const auto brick = [](double voxel) { return static_cast<int>(std::floor(voxel / kBrickEdge)); };
    first = {brick(low.x() - band), brick(low.y() - band), brick(low.z() - band)};
    last = {brick(high.x() + band) + 1, brick(high.y() + band) + 1, brick(high.z() + band) + 1};
  }
  [[nodiscard]] int bricks(int axis) const {
    return axis == 0 ? last.x - first.x : axis == 1 ? last.y - first.y : last.z - first.z;
  }
  [[nodiscard]] double distance(const Vec3d& p) const {
    const Vec3d off = (low - p).cwiseMax(p - high);
    return off.cwiseMax(0.0).norm() + std::min(0.0, off.maxCoeff());
  }
};

// Clay in a column of bricks: for each voxel the least distance of those from it upwards, and from it downwards. What
// has clay above it is where the first is below zero.
class Shadows {
 public:
  static constexpr int kColumns = kBrickEdge * kBrickEdge;
  using Layer = std::array<float, kColumns>;  // x·8 + y
  Shadows(const Version& version, const Block& block, int x, int y) {
    const int count = block.bricks(2);
    clay.resize(size_t(count) * kBrickEdge);
    for (int b = 0; b < count; ++b) {
      BrickValues scratch;
      const BrickValues& values =
          version.find({block.first.x + x, block.first.y + y, block.first.z + b}).values(scratch, version.grid().band);
      for (int k = 0; k < kBrickEdge; ++k)
        for (int c = 0; c < kColumns; ++c) clay[size_t(b * kBrickEdge + k)][size_t(c)] = values[c * kBrickEdge + k];
    }
    fromHere = clay, toHere = clay;
    for (size_t z = clay.size() - 1; z-- > 0;)
      for (size_t c = 0; c < kColumns; ++c) fromHere[z][c] = std::min(fromHere[z][c], fromHere[z + 1][c]);
    for (size_t z = 1; z < clay.size(); ++z)
      for (size_t c = 0; c < kColumns; ++c) toHere[z][c] = std::min(toHere[z][c], toHere[z - 1][c]);
  }
  std::vector<Layer> clay, fromHere, toHere;
};

// Where a distance that is `here` at z and `next` at z + 1 is 0.
float crossing(float z, float here, float next) {
  return z + here / (here - next);
}
double filled(float phi) {
  return std::clamp(0.5 - double(phi), 0.0, 1.0);
}

class MouldMaker {
 public:
  MouldMaker(const Version& version, const MouldOptions& options, int threads, const WorkPart& part)
      : options_(options), threads_(threads > 0 ? threads : int(std::max(1u, std::thread::hardware_concurrency()))) {
    const BoxMm box = boundsOf(version);
    if (!((box.high - box.low).minCoeff() >= 0)) throw Error("it has no clay");
    Vec3d pull = Vec3d::UnitZ();
    if (options.pull) {
      pull = options.pull->normalized();
    } else {
      Surface surface(false);
      (void)surface.update(version, threads_);
      pull = bestPull(surface.toMesh(), version.grid().voxelMm, threads_, part.part(0, 0.2)).pull;
    }
    mould_.turn = turnTo(pull);
    clay_ = version;
    if (!mould_.turn.isIdentity(1e-12)) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.linear() = mould_.turn;
      clay_ = resample(version, version.grid(), pose, threads_, part.part(0.2, 0.4));
    }
    const BoxMm turned = boundsOf(clay_);
    const double wall = options.wallMm / voxel();
    block_.emplace(grid().toVoxel(turned.low) - Vec3d::Constant(wall),
                   grid().toVoxel(turned.high) + Vec3d::Constant(wall), double(grid().band));
    const Vec3d size = block_->high - block_->low;
    const double area = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x()) + 2 * size.x() * size.y();
    requireMemory(2 * bytesOfClay(area, version.store()->precision()),
                  fmt::format("a mould of {:.0f} × {:.0f} × {:.0f} mm at voxels of {} mm", size.x() * voxel(),
                              size.y() * voxel(), size.z() * voxel(), voxel()),
                  "use a larger voxel");
    lookAtColumns(part.part(0.4, 0.5));
    heights_ = partingHeights(columns_, part.part(0.5, 0.6));
    findSlopes();
    divide(part.part(0.6, 0.9));
    if (options.keys) addKeys();
    part.step(0.95);
    addWays();
    part.step(1);
  }
  [[nodiscard]] Mould take() { return std::move(mould_); }

 private:
  [[nodiscard]] const Grid& grid() const { return clay_.grid(); }
  [[nodiscard]] double voxel() const { return grid().voxelMm; }
  // Voxel coordinates of a column, and of the lowest voxel.
  [[nodiscard]] Vec3d first() const { return (block_->first * kBrickEdge).toVec3d(); }
  [[nodiscard]] size_t brickColumns() const { return size_t(block_->bricks(0)) * size_t(block_->bricks(1)); }
  [[nodiscard]] std::pair<int, int> brickColumn(size_t i) const {
    return {static_cast<int>(i) % block_->bricks(0), static_cast<int>(i) / block_->bricks(0)};
  }

  void lookAtColumns(const WorkPart& part) {
    columns_.width = block_->bricks(0) * kBrickEdge;
    columns_.height = block_->bricks(1) * kBrickEdge;
    const size_t count = size_t(columns_.width) * size_t(columns_.height);
    columns_.bottom.assign(count, NAN);
    columns_.top.assign(count, NAN);
    std::vector<double> undercut(brickColumns(), 0), clay(brickColumns(), 0);
    parallelBlocks(
        brickColumns(), threads_,
        [&](size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) {
            part.step(double(i) / double(brickColumns()));
            const auto [x, y] = brickColumn(i);
            const Shadows shadows(clay_, *block_, x, y);
            undercut[i] = lookAt(shadows, x, y, clay[i]);
          }
        },
        8);
    // In order, so that the sum is the same for any threads.
    const double voxel3 = voxel() * voxel() * voxel();
    mould_.undercutMm3 = std::accumulate(undercut.begin(), undercut.end(), 0.0) * voxel3;
    mould_.clayMm3 = std::accumulate(clay.begin(), clay.end(), 0.0) * voxel3;
  }
  double lookAt(const Shadows& shadows, int x, int y, double& clay) {
    double undercut = 0;
    const auto z0 = static_cast<float>(first().z());
    for (size_t c = 0; c < Shadows::kColumns; ++c) {
      if (!(shadows.fromHere[0][c] < 0)) continue;
      const size_t at = columns_.index(x * kBrickEdge + int(c) / kBrickEdge, y * kBrickEdge + int(c) % kBrickEdge);
      // The block reaches beyond the clay on both ends.
      for (size_t z = 0; z + 1 < shadows.clay.size(); ++z) {
        const float here = shadows.clay[z][c], next = shadows.clay[z + 1][c];
        if ((here < 0) == (next < 0)) continue;
        const float height = crossing(z0 + float(z), here, next);
        if (next < 0 && !columns_.covered(at)) columns_.bottom[at] = height;
        if (here < 0) columns_.top[at] = height;
      }
      for (size_t z = 0; z < shadows.clay.size(); ++z) {
        const float here = shadows.clay[z][c], cast = std::max(shadows.fromHere[z][c], shadows.toHere[z][c]);
        clay += filled(here);
        if (here - cast > kUneven) undercut += filled(cast) - filled(here);
      }
    }
    return undercut;
  }

  void findSlopes() {
    cosines_.resize(heights_.size());
    double steepest = 0;
    for (int y = 0; y < columns_.height; ++y)
      for (int x = 0; x < columns_.width; ++x) {
        const auto at = [&](int i, int j) {
          return columns_.index(std::clamp(i, 0, columns_.width - 1), std::clamp(j, 0, columns_.height - 1));
        };
        const double dx = 0.5 * double(heights_[at(x + 1, y)] - heights_[at(x - 1, y)]);
        const double dy = 0.5 * double(heights_[at(x, y + 1)] - heights_[at(x, y - 1)]);
        const double slope = std::hypot(dx, dy);
        cosines_[at(x, y)] = static_cast<float>(1 / std::sqrt(1 + slope * slope));
        if (!columns_.covered(at(x, y)) && !columns_.covered(at(x + 1, y)) && !columns_.covered(at(x - 1, y)) &&
            !columns_.covered(at(x, y + 1)) && !columns_.covered(at(x, y - 1)))
          steepest = std::max(steepest, slope);
      }
    mould_.steepestDegrees = std::atan(steepest) * 180 / std::numbers::pi;
  }

  // What a brick of a half becomes.
  struct Made {
    Coord brick;
    bool whole = false;  // all inside
    std::array<float, kBrickVoxels> phi;
  };
  struct Bricks {
    std::vector<Made> upper, lower;
  };

  void divide(const WorkPart& part) {
    const Precision precision = clay_.store()->precision();
    Editor upper(Version::empty(Store::make(precision), grid())), lower(Version::empty(Store::make(precision), grid()));
    std::vector<Coord> upperBricks, lowerBricks;
    std::vector<Bricks> made(std::min(kColumnsAtOnce, brickColumns()));
    for (size_t begin = 0; begin < brickColumns(); begin += kColumnsAtOnce) {
      part.step(0.8 * double(begin) / double(brickColumns()));
      const size_t count = std::min(kColumnsAtOnce, brickColumns() - begin);
      parallelBlocks(
          count, threads_,
          [&](size_t from, size_t to) {
            for (size_t i = from; i < to; ++i) made[i] = fields(begin + i);
          },
          4);
      const auto link = [](Editor& editor, const std::vector<Made>& bricks, std::vector<Coord>& computed) {
        for (const Made& each : bricks) {
          if (each.whole) {
            editor.setTile(each.brick, Tile::inside);
          } else {
            editor.setVoxels(each.brick, each.phi);
            computed.push_back(each.brick);
          }
        }
      };
      for (size_t i = 0; i < count; ++i) {
        link(upper, made[i].upper, upperBricks);
        link(lower, made[i].lower, lowerBricks);
      }
    }
    redistanceAll(upper, std::move(upperBricks), part.part(0.8, 0.9));
    redistanceAll(lower, std::move(lowerBricks), part.part(0.9, 1));
    mould_.upper = upper.commit();
    mould_.lower = lower.commit();
  }

  Bricks fields(size_t column) const {
    const auto [bx, by] = brickColumn(column);
    const Shadows shadows(clay_, *block_, bx, by);
    const float band = grid().band;
    Bricks out;
    std::array<float, Shadows::kColumns> height, cosine;
    for (int c = 0; c < Shadows::kColumns; ++c) {
      const size_t at = columns_.index(bx * kBrickEdge + c / kBrickEdge, by * kBrickEdge + c % kBrickEdge);
      height[size_t(c)] = heights_[at], cosine[size_t(c)] = cosines_[at];
    }
    for (int bz = 0; bz < block_->bricks(2); ++bz) {
      const Coord brick{block_->first.x + bx, block_->first.y + by, block_->first.z + bz};
      const Vec3d corner = (brick * kBrickEdge).toVec3d();
      const double half = 0.5 * (kBrickEdge - 1), reach = half * std::sqrt(3.0) + double(band) + 0.5;
      const double away = block_->distance(corner + Vec3d::Constant(half));
      if (away > reach) continue;
      Made up{brick, false, {}}, down{brick, false, {}};
      // Whether all of it is one thing, for each half.
      bool allUpper = away < -reach, allLower = allUpper, noUpper = true, noLower = true;
      for (int x = 0; x < kBrickEdge; ++x)
        for (int y = 0; y < kBrickEdge; ++y) {
          const size_t c = size_t(x * kBrickEdge + y);
          for (int k = 0; k < kBrickEdge; ++k) {
            const size_t z = size_t(bz * kBrickEdge + k);
            const float block =
                away < -reach ? -2 * band : static_cast<float>(block_->distance(corner + Vec3d(x, y, k)));
            const float under = shadows.fromHere[z][c], over = shadows.toHere[z][c];  // below 0: clay above, below
            const float below = (static_cast<float>(corner.z()) + float(k) - height[c]) * cosine[c];
            const int v = Brick::offset(x, y, k);
            const float first = std::max({block, std::min(-below, over), -under});
            const float second = std::max({block, std::min(below, under), -over});
            up.phi[size_t(v)] = first, down.phi[size_t(v)] = second;
            allUpper &= first <= -band, allLower &= second <= -band;
            noUpper &= first >= band, noLower &= second >= band;
          }
        }
      if (!noUpper) up.whole = allUpper, out.upper.push_back(up);
      if (!noLower) down.whole = allLower, out.lower.push_back(down);
    }
    return out;
  }

  // mm, of voxel coordinates.
  [[nodiscard]] Version cone(const Vec3d& foot, double baseRadius, double topRadius, double height) const {
    return makeCone(Store::make(clay_.store()->precision()), grid(), grid().toWorld(foot + Vec3d(0, 0, height / 2)),
                    baseRadius * voxel(), topRadius * voxel(), height * voxel());
  }

  // In each corner of the block one, where the surface between the halves is even enough.
  void addKeys() {
    const double wall = options_.wallMm / voxel();
    for (int corner = 0; corner < 4; ++corner) {
      const double radius = kKey * wall * (corner == 0 ? kOther : 1);
      if (radius < kLeastKey) return;
      const Vec3d at(corner & 1 ? block_->high.x() - wall / 2 : block_->low.x() + wall / 2,
                     corner & 2 ? block_->high.y() - wall / 2 : block_->low.y() + wall / 2, 0);
      double low = INFINITY, high = -INFINITY;
      const Vec3d in = at - first();
      for (int y = int(in.y() - radius); y <= int(in.y() + radius) + 1; ++y)
        for (int x = int(in.x() - radius); x <= int(in.x() + radius) + 1; ++x) {
          const double h = double(heights_[columns_.index(x, y)]);
          low = std::min(low, h), high = std::max(high, h);
        }
      const double clearance = options_.clearanceMm / voxel();
      if (high - low > kMostSlope * radius || high + radius + clearance + kRoot > block_->high.z() ||
          low - kRoot < block_->low.z())
        continue;
      // As a cone goes on below the ground.
      const double deep = high - low + kRoot, height = radius + deep;
      const double base = radius * (1 + kTaper * deep / radius), top = radius * (1 - kTaper);
      const Vec3d foot(at.x(), at.y(), low - kRoot);
      mould_.lower = combine(mould_.lower, cone(foot, base, top, height), Combination::join);
      mould_.upper =
          combine(mould_.upper, cone(foot, base + clearance, top + clearance, height + clearance), Combination::cut);
      ++mould_.keys;
    }
  }

  struct Peak {
    size_t at;
    double above;  // the place where it meets a higher one; without end for the highest of all that hang together
  };
  // Peaks of the clay as seen along the pull, the highest first, by a merge tree of its columns.
  [[nodiscard]] std::vector<Peak> peaks() const {
    std::vector<uint32_t> order;
    for (size_t i = 0; i < columns_.top.size(); ++i)
      if (columns_.covered(i)) order.push_back(static_cast<uint32_t>(i));
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return columns_.top[a] != columns_.top[b] ? columns_.top[a] > columns_.top[b] : a < b;
    });
    std::vector<uint32_t> of(columns_.top.size(), UINT32_MAX);  // its peak, or one on the way to it
    const auto peakOf = [&](uint32_t i) {
      while (of[i] != i) i = of[i] = of[of[i]];
      return i;
    };
    std::vector<Peak> found;
    const double least = std::max(kPeak, kPeakMm / voxel());
    const auto rank = [&](uint32_t a, uint32_t b) {
      return columns_.top[a] != columns_.top[b] ? columns_.top[a] > columns_.top[b] : a < b;
    };
    for (const uint32_t i : order) {
      of[i] = i;
      const int x = static_cast<int>(i) % columns_.width, y = static_cast<int>(i) / columns_.width;
      for (int j = std::max(0, y - 1); j <= std::min(columns_.height - 1, y + 1); ++j)
        for (int k = std::max(0, x - 1); k <= std::min(columns_.width - 1, x + 1); ++k) {
          const auto beside = static_cast<uint32_t>(columns_.index(k, j));
          if (of[beside] == UINT32_MAX || beside == i) continue;
          uint32_t a = peakOf(beside), b = peakOf(i);
          if (a == b) continue;
          if (rank(b, a)) std::swap(a, b);
          of[b] = a;
          const double above = double(columns_.top[b] - columns_.top[i]);
          if (above >= least) found.push_back({b, above});
        }
    }
    for (const uint32_t i : order)
      if (of[i] == i) found.push_back({i, INFINITY});
    std::stable_sort(found.begin(), found.end(), [](const Peak& a, const Peak& b) { return a.above > b.above; });
    if (found.size() > kMostWays) found.resize(kMostWays);
    for (Peak& peak : found) peak.at = middleOf(peak.at);
    return found;
  }
  // A peak may be a plain: its column that is nearest to the middle of all that are as high, but for half a voxel.
  [[nodiscard]] size_t middleOf(size_t peak) const {
    const float least = columns_.top[peak] - 0.5f;
    std::vector<size_t> plain{peak};
    std::unordered_set<size_t> seen{peak};
    for (size_t i = 0; i < plain.size(); ++i)
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int x = int(plain[i] % size_t(columns_.width)) + dx, y = int(plain[i] / size_t(columns_.width)) + dy;
        if (x < 0 || y < 0 || x >= columns_.width || y >= columns_.height) continue;
        const size_t beside = columns_.index(x, y);
        if (columns_.covered(beside) && columns_.top[beside] >= least && seen.insert(beside).second)
          plain.push_back(beside);
      }
    const auto placeOf = [&](size_t i) {
      return Eigen::Vector2d(double(i % size_t(columns_.width)), double(i / size_t(columns_.width)));
    };
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const size_t i : plain) middle += placeOf(i) / double(plain.size());
    return *std::min_element(plain.begin(), plain.end(), [&](size_t a, size_t b) {
      return (placeOf(a) - middle).squaredNorm() < (placeOf(b) - middle).squaredNorm();
    });
  }

  void addWays() {
    if (options_.sprueMm == 0 && !options_.vents) return;
    for (const Peak& peak : peaks()) {
      const bool sprue = std::isinf(peak.above) && options_.sprueMm > 0;
      if (!sprue && !options_.vents) continue;
      const double radius = (sprue ? options_.sprueMm : options_.ventMm) / 2 / voxel();
      const Vec3d foot =
          first() + Vec3d(double(peak.at % size_t(columns_.width)), double(peak.at / size_t(columns_.width)), 0);
      const double from = double(columns_.top[peak.at]) - kRoot;
      const double height = block_->high.z() + kRoot - from;
      mould_.upper =
          combine(mould_.upper, cone({foot.x(), foot.y(), from}, radius, sprue ? kFunnel * radius : radius, height),
                  Combination::cut);
      ++(sprue ? mould_.sprues : mould_.vents);
    }
  }

  MouldOptions options_;
  int threads_;
  Version clay_;  // turned
  std::optional<Block> block_;
  MouldColumns columns_;
  std::vector<float> heights_, cosines_;
  Mould mould_;
};

}  // namespace

Mould makeMould(const Version& version, const MouldOptions& options, int threads, const WorkPart& part) {
  const double voxel = version.grid().voxelMm;
  if (options.pull && !(options.pull->allFinite() && options.pull->norm() > 1e-12))
    throw Error("the pull of a mould is zero or not finite: give a direction");
  if (!(options.wallMm >= kLeastWall * voxel && options.wallMm <= 1000))
    throw Error(fmt::format("a mould's wall of {:g} mm at voxels of {:g} mm: give {:g} to 1000 mm", options.wallMm,
                            voxel, kLeastWall * voxel));
  if (!(options.clearanceMm >= 0 && options.clearanceMm <= 5))
    throw Error(fmt::format("a clearance of {:g} mm: give 0 to 5 mm", options.clearanceMm));
  if (!(options.sprueMm == 0 || (options.sprueMm >= kLeastVent * voxel && options.sprueMm <= 1000)))
    throw Error(fmt::format("a sprue of {:g} mm at voxels of {:g} mm: give {:g} to 1000 mm, or 0 for none",
                            options.sprueMm, voxel, kLeastVent * voxel));
  if (options.vents && !(options.ventMm >= kLeastVent * voxel && options.ventMm <= 1000))
    throw Error(fmt::format("vents of {:g} mm at voxels of {:g} mm: give {:g} to 1000 mm", options.ventMm, voxel,
                            kLeastVent * voxel));
  return MouldMaker(version, options, threads, part).take();
}

}  // namespace argil::clay
