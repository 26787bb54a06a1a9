#include "clay/whole/deform.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <thread>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/field/settle.h"
#include "clay/field/wide_band.h"
#include "clay/store/brick_set.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

using Eigen::Matrix3d;

// Places an axis where folds are looked for: a Bernstein polynomial of degree 7 has no room between them.
constexpr int kSamples = 33;
// Below it the determinant counts as zero: its inverse would be mostly rounding.
constexpr double kLeastVolume = 1e-4;
// Up to it a warp needs no wider band: the margin of the old one suffices beside the surface.
constexpr double kFreeStretch = 1.1;
constexpr float kWidest = 8;         // Voxels; what a Grid allows.
constexpr double kHalfBrick = 3.5;   // Voxels, from a brick's middle to its outer samples.
constexpr double kOtherSheet = 8;    // Voxels: sources of one place that are farther apart may be two.
constexpr double kSameSource = 0.5;  // Voxels: solutions that are closer are one.
constexpr double kSolved = 0.02;     // Voxels: Newton's next step squares it.
constexpr int kMostSteps = 24;
// Voxels of the old clay: beside the surface it is read by cubics, whose values are the new clay's.
constexpr double kExact = 0.6;
constexpr double kNear = 0.25;   // Voxels: closer to the surface the first-order distance is exact enough.
constexpr size_t kBatch = 2048;  // Bricks computed before they are linked: 4 MiB.

// Largest singular value by power iteration: no library's cosine decides about clay.
double largestStretch(const Matrix3d& m) {
  const Matrix3d square = m.transpose() * m;
  Vec3d v(0.6, 0.64, 0.48);
  for (int i = 0; i < 12; ++i) {
    v = square * v;
    const double length = std::sqrt(v.squaredNorm());
    if (!(length > 0)) return 0;
    v /= length;
  }
  return std::sqrt(std::sqrt((square * v).squaredNorm()));
}

// How much the warp presses at most. Throws where it folds or goes too far. Looked at where there is clay or its band:
// at places of a lattice over the whole, and in every brick where it is nearest to the surface, so that no clay is too
// thin to be met.
double greatestPressure(const Warp& warp, const Version& version) {
  const Grid& grid = version.grid();
  double stretch = 0, pressure = 0;
  const auto look = [&](const Vec3d& p, float phi) {
    Matrix3d j;
    const Vec3d q = warp.map(p, j);
    const double volume = j.determinant();
    if (!q.allFinite() || !std::isfinite(volume))
      throw Error("the deformation leads to numbers that are not finite: move it less");
    if (!(volume > kLeastVolume))
      throw Error(fmt::format(
          "the deformation folds the clay at ({:.4g}, {:.4g}, {:.4g}) mm: move it less, or in smaller steps", p.x(),
          p.y(), p.z()));
    if (phi > 1) return;  // The band may be pressed as it will.
    stretch = std::max(stretch, largestStretch(j));
    pressure = std::max(pressure, largestStretch(j.inverse()));
  };
  // The bounds are a voxel wider than what is inside.
  const BoxMm solid = boundsOf(version);
  const Vec3d band = Vec3d::Constant((static_cast<double>(grid.band) - 1) * grid.voxelMm);
  const BoxMm box = warp.domain({solid.low - band, solid.high + band});
  const Vec3d step = (box.high - box.low) / (kSamples - 1);
  for (int x = 0; x < kSamples; ++x)
    for (int y = 0; y < kSamples; ++y)
      for (int z = 0; z < kSamples; ++z) {
        const Vec3d p = box.low + Vec3d(x, y, z).cwiseProduct(step), voxel = grid.toVoxel(p).array().floor();
        const Coord at{static_cast<int32_t>(voxel.x()), static_cast<int32_t>(voxel.y()),
                       static_cast<int32_t>(voxel.z())};
        const float phi = version.find(at >> kBrickBits).phi(Brick::offset(at.x & 7, at.y & 7, at.z & 7), grid.band);
        if (phi < grid.band) look(p, phi);
      }
  version.forEachBrick([&](const Brick& brick) {
    int nearest = 0;
    for (int i = 1; i < kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < std::abs(brick.phi(nearest))) nearest = i;
    look(grid.toWorld((brick.coord * kBrickEdge + Coord{nearest >> 6, (nearest >> 3) & 7, nearest & 7}).toVec3d()),
         brick.phi(nearest));
  });
  const double most = std::max(stretch, pressure);
  if (most > kMostStretch)
    throw Error(fmt::format("the deformation {} the clay {:.1f} times: {} times is the most in one step",
                            stretch > pressure ? "stretches" : "presses", most, kMostStretch));
  return pressure;
}

/// The warp in voxel coordinates.
class VoxelWarp {
 public:
  VoxelWarp(const Warp& warp, const Grid& grid) : warp_(warp), grid_(grid) {}
  Vec3d map(const Vec3d& p, Matrix3d& j) const { return grid_.toVoxel(warp_.map(grid_.toWorld(p), j)); }
  bool fixes(const Vec3d& low, const Vec3d& high) const {
    return warp_.fixes({grid_.toWorld(low), grid_.toWorld(high)});
  }

  /// Finds the place that goes to `p`, from `source` on; `toSource` is the inverse derivative there. False when there
  /// is none near; then `source` is the best that was met.
  bool solve(const Vec3d& p, Vec3d& source, Matrix3d& toSource) const {
    Vec3d best = source;
    double bestRest = INFINITY;
    double damping = 1;
    Vec3d step = Vec3d::Zero();
    for (int i = 0; i < kMostSteps; ++i) {
      Matrix3d j;
      const Vec3d rest = p - map(source, j);
      const double rest2 = rest.squaredNorm();
      if (rest2 < bestRest) {
        best = source;
        bestRest = rest2;
        const double volume = j.determinant();
        if (!(volume > kLeastVolume)) break;
        toSource = j.inverse();
        step = toSource * rest;
        if (rest2 < kSolved * kSolved) {
          source += step;
          return true;
        }
        damping = 1;
      } else {
        damping /= 2;  // The step led away: back, and less of it.
      }
      source = best + damping * step;
    }
    source = best;
    return bestRest < kSolved * kSolved;
  }

 private:
  const Warp& warp_;
  const Grid& grid_;
};

/// A brick of the new clay that may hold some of it, and a place of the old clay that goes to its middle, about. More
/// of them where clay may come to lie over clay.
struct Candidate {
  Coord brick;
  Vec3d source = Vec3d::Zero();
  double away = 0;  // From the middle of the old brick that it comes from: the least is the best guess.
  int32_t next = -1;
};

class Deformer {
  using Places = std::array<Coord, kBrickVoxels>;

 public:
  Deformer(const Version& version, const Warp& warp, std::shared_ptr<Store> store, Job* job, int threads)
      : old_(version),
        grid_(version.grid()),
        warp_(warp, grid_),
        band_(double(grid_.band)),
        editor_(Version::empty(std::move(store), version.grid())),
        job_(job),
        threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))) {}

  Version run(double pressure) {
    if (pressure > kFreeStretch) {
      const float wide = static_cast<float>(std::min(double(kWidest), std::ceil(band_ * pressure)));
      source_ = wide > grid_.band ? wideBand(old_, wide, job_) : old_;
    } else {
      source_ = old_;
    }
    step(0.1);
    propose();
    compute();
    fillBetween(Editor::blockFirst({0, 0, 0}, kTreeLevels), kTreeLevels);
    settle();
    return editor_.commit();
  }

 private:
  void step(double fraction) const {
    if (job_) job_->step(fraction);
  }

  // Which bricks of the new clay the surface may come near: those around the images of the old ones that hold some of
  // it.
  void propose() {
    const size_t all = old_.stats().bricks;
    size_t done = 0;
    old_.forEachBrick([&](const Brick& brick) {
      if (done++ % 1024 == 0) step(0.1 + 0.1 * double(done) / double(all));
      bool surface = brick.anyInside && brick.anyOutside;
      for (int i = 0; i < kBrickVoxels && !surface; ++i) surface = std::abs(brick.phi(i)) < 1;
      if (surface) propose(brick.coord);
    });
    order_.reserve(first_.size());
    for (const auto& [coord, at] : first_) order_.push_back(at);
    std::sort(order_.begin(), order_.end(),
              [&](uint32_t a, uint32_t b) { return candidates_[a].brick < candidates_[b].brick; });
    upper_.resize(order_.size());
    stays_.resize(order_.size());
    for (const uint32_t i : order_)
      for (int level = 0; level <= kTreeLevels; ++level) {
        if (!occupied_[static_cast<size_t>(level)].insert(Editor::blockFirst(candidates_[i].brick, level)).second)
          break;
      }
  }

  void propose(Coord oldBrick) {
    const Vec3d middle = (oldBrick * kBrickEdge).toVec3d() + Vec3d::Constant(kHalfBrick);
    const double half = kHalfBrick + 0.5;  // The surface may lie between this brick's samples and the next.
    Matrix3d j, unused;
    const Vec3d image = warp_.map(middle, j);
    const Matrix3d back = j.inverse();
    double bent = 0;  // How far the image of the brick is from being straight.
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner(i & 4 ? half : -half, i & 2 ? half : -half, i & 1 ? half : -half);
      bent = std::max(bent, (warp_.map(middle + corner, unused) - image - j * corner).cwiseAbs().maxCoeff());
    }
    const double slack = 2 * bent + 0.5, reach = kHalfBrick + band_ + slack;
    const Vec3d extent = j.cwiseAbs() * Vec3d::Constant(half) + Vec3d::Constant(reach);
    const Vec3d backExtent = back.cwiseAbs() * Vec3d::Constant(reach) + Vec3d::Constant(half);
    if (!(image.cwiseAbs() + extent).allFinite() || (image.cwiseAbs() + extent).maxCoeff() > 8.0 * kBrickReach)
      throw Error("the deformed clay is out of reach: move it less, or use a larger voxel");
    const auto brickAt = [](double v) { return static_cast<int32_t>(std::floor((v - kHalfBrick) / kBrickEdge)); };
    const Vec3d low = image - extent, high = image + extent;
    for (int32_t x = brickAt(low.x()); x <= brickAt(high.x()) + 1; ++x)
      for (int32_t y = brickAt(low.y()); y <= brickAt(high.y()) + 1; ++y)
        for (int32_t z = brickAt(low.z()); z <= brickAt(high.z()) + 1; ++z) {
          const Vec3d offset = (Coord{x, y, z} * kBrickEdge).toVec3d() + Vec3d::Constant(kHalfBrick) - image;
          if ((offset.cwiseAbs().array() > extent.array()).any()) continue;
          const Vec3d away = back * offset;
          if ((away.cwiseAbs().array() > backExtent.array()).any()) continue;
          add({x, y, z}, middle + away, away.squaredNorm());
        }
  }

  void add(Coord brick, const Vec3d& source, double away) {
    const auto fresh = static_cast<uint32_t>(candidates_.size());
    const auto [at, isNew] = first_.try_emplace(brick, fresh);
    if (isNew) {
      candidates_.push_back({brick, source, away, -1});
      return;
    }
    int32_t last = -1;
    for (auto i = static_cast<int32_t>(at->second); i >= 0; i = candidates_[static_cast<size_t>(i)].next) {
      Candidate& c = candidates_[static_cast<size_t>(i)];
      if ((c.source - source).squaredNorm() < kOtherSheet * kOtherSheet) {
        if (away < c.away) {
          c.source = source;
          c.away = away;
        }
        return;
      }
      last = i;
    }
    candidates_[static_cast<size_t>(last)].next = static_cast<int32_t>(fresh);
    candidates_.push_back({brick, source, away, -1});
  }

  void compute() {
    std::vector<std::array<float, kBrickVoxels>> fields(std::min(kBatch, order_.size()));
    std::vector<Places> places(carries_ ? fields.size() : 0);
    std::atomic<size_t> done{0};
    for (size_t begin = 0; begin < order_.size(); begin += kBatch) {
      const size_t count = std::min(kBatch, order_.size() - begin);
      parallelBlocks(
          count, threads_,
          [&](size_t from, size_t to) {
            Sampler sampler(source_);
            for (size_t i = from; i < to; ++i) {
              stays_[begin + i] = computeBrick(sampler, candidates_[order_[begin + i]], fields[i].data(),
                                               carries_ ? &places[i] : nullptr);
              step(0.2 + 0.7 * double(done.fetch_add(1, std::memory_order_relaxed)) / double(order_.size()));
            }
          },
          16);
      for (size_t i = 0; i < count; ++i) {
        editor_.setVoxels(candidates_[order_[begin + i]].brick, fields[i]);
        if (carries_) carry(candidates_[order_[begin + i]].brick, places[i]);
        upper_[begin + i] = fields[i][Brick::offset(0, 0, 7)] < 0 ? Tile::inside : Tile::outside;
      }
    }
  }

  // True when the brick is as it was.
  bool computeBrick(Sampler& sampler, const Candidate& first, float* field, Places* places) const {
    const Vec3d origin = (first.brick * kBrickEdge).toVec3d(), middle = origin + Vec3d::Constant(kHalfBrick);
    // Places of the old clay that go to this brick's middle.
    std::vector<Vec3d> sheets;
    std::vector<Matrix3d> derivatives;
    for (const Candidate* c = &first;; c = &candidates_[static_cast<size_t>(c->next)]) {
      Vec3d source = c->source;
      Matrix3d toSource = Matrix3d::Identity();
      warp_.solve(middle, source, toSource);
      if (std::none_of(sheets.begin(), sheets.end(),
                       [&](const Vec3d& s) { return (s - source).squaredNorm() < kSameSource * kSameSource; })) {
        sheets.push_back(source);
        derivatives.push_back(toSource);
      }
      if (c->next < 0) break;
    }
    // Clay that stays keeps its bits, unless other clay comes there.
    if (first.next < 0 && (first.source - middle).squaredNorm() < kSameSource * kSameSource &&
        warp_.fixes(origin, origin + Vec3d::Constant(2 * kHalfBrick))) {
      const Slot slot = old_.find(first.brick);
      for (int i = 0; i < kBrickVoxels; ++i) {
        field[i] = slot.phi(i, grid_.band);
        if (places) (*places)[static_cast<size_t>(i)] = first.brick * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      }
      return true;
    }
    std::fill(field, field + kBrickVoxels, grid_.band);
    for (size_t s = 0; s < sheets.size(); ++s) {
      Vec3d ofPlane = sheets[s] + derivatives[s] * (origin - middle), ofRow, source;
      Matrix3d planeBack = derivatives[s], rowBack, back;
      for (int x = 0; x < 8; ++x) {
        ofRow = ofPlane;
        rowBack = planeBack;
        for (int y = 0; y < 8; ++y) {
          source = ofRow;
          back = rowBack;
          for (int z = 0; z < 8; ++z) {
            // The neighbour's solution and derivative lead to this one's but for the warp's curvature.
            const Vec3d p = origin + Vec3d(x, y, z);
            if (!warp_.solve(p, source, back)) {
              Vec3d again = sheets[s] + derivatives[s] * (p - middle);
              Matrix3d itsBack = derivatives[s];
              if (warp_.solve(p, again, itsBack)) {
                source = again;
                back = itsBack;
              }
            }
            if (z == 0) {
              ofRow = source;
              rowBack = back;
              if (y == 0) {
                ofPlane = source;
                planeBack = back;
              }
            }
            float& value = field[Brick::offset(x, y, z)];
            Vec3d surface = source;
            const auto away = static_cast<float>(distance(sampler, p, source, back, surface));
            if (places && (s == 0 || away < value)) {
              const Vec3d nearest = (surface + Vec3d::Constant(0.5)).array().floor();
              (*places)[static_cast<size_t>(Brick::offset(x, y, z))] = {int(nearest.x()), int(nearest.y()),
                                                                        int(nearest.z())};
            }
            value = std::min(value, away);
            source += back.col(2);
          }
          ofRow += rowBack.col(1);
        }
        ofPlane += planeBack.col(0);
      }
    }
    return false;
  }

  // From p to the warped surface; `source` goes to p, and `surface` becomes a place of the old clay beside the one that
  // is nearest. One step down the gradient finds a place beside the surface, a second one the surface there.
  double distance(Sampler& sampler, const Vec3d& p, const Vec3d& source, const Matrix3d& back, Vec3d& surface) const {
    const double known = double(sampler.band()) - 0.02;
    Vec3f slope;
    double phi = double(sampler.trilinear(source, slope));
    if (!(std::abs(phi) < known)) return phi < 0 ? -band_ : band_;
    // Farther out this only leads to the surface; beside it, it is the answer.
    if (std::abs(phi) < kExact) phi = double(sampler.tricubic(source, slope));
    Vec3d normal = slope.cast<double>();
    const double length = std::sqrt(normal.squaredNorm());
    if (length < 1e-3) return std::clamp(phi, -band_, band_);
    // phi is a distance: where its gradient is shorter than one there is a crease, and interpolation took its length,
    // not the clay.
    const Vec3d gradient = back.transpose() * (normal / length);
    const double grows = std::sqrt(gradient.squaredNorm());
    const double firstOrder = phi / grows;
    if (std::abs(firstOrder) < kNear && std::abs(phi) < kExact) return std::clamp(firstOrder, -band_, band_);
    if (std::abs(firstOrder) > 1.2 * band_) return std::clamp(firstOrder, -band_, band_);

    Matrix3d j;
    const Vec3d besideSource = source - back * (gradient * (firstOrder / grows));
    const Vec3d beside = warp_.map(besideSource, j);
    surface = besideSource;
    const double rest = double(sampler.tricubic(besideSource, slope));
    normal = slope.cast<double>();
    const double length2 = std::sqrt(normal.squaredNorm());
    if (length2 < 1e-3 || !(j.determinant() > kLeastVolume)) return std::clamp(firstOrder, -band_, band_);
    const Vec3d gradient2 = j.inverse().transpose() * (normal / length2);
    const Vec3d nearest = beside - gradient2 * (rest / gradient2.squaredNorm());
    const double away = std::sqrt((p - nearest).squaredNorm());
    return phi < 0 ? -std::min(away, band_) : std::min(away, band_);
  }

  // Makes blocks without candidates tiles: below a block, in its first column, the last candidate says on which side it
  // is.
  void fillBetween(Coord block, int level) {
    if (!occupied_[static_cast<size_t>(level)].contains(block)) {
      if (sideBelow(block) == Tile::inside) editor_.setBlock(block, level, Tile::inside);
      return;
    }
    if (level == 0) return;
    const int child = 1 << (3 * (level - 1));
    for (int i = 0; i < 512; ++i) fillBetween(block + Coord{i >> 6, (i >> 3) & 7, i & 7} * child, level - 1);
  }

  Tile sideBelow(Coord brick) const {
    const auto at =
        std::partition_point(order_.begin(), order_.end(), [&](uint32_t i) { return candidates_[i].brick < brick; });
    if (at == order_.begin()) return Tile::outside;
    const Coord below = candidates_[*(at - 1)].brick;
    return below.x == brick.x && below.y == brick.y ? upper_[static_cast<size_t>(at - 1 - order_.begin())]
                                                    : Tile::outside;
  }

  // Channels come from the nearest voxel of the old clay.
  void carry(Coord brick, const Places& places) {
    for (const Channel channel : kAllChannels) {
      if (!old_.has(channel)) continue;
      std::array<uint8_t, kBrickVoxels> values;
      Coord last{INT32_MIN, 0, 0};
      ChannelSlot slot;
      for (int i = 0; i < kBrickVoxels; ++i) {
        const Coord v = places[static_cast<size_t>(i)];
        if (last != v >> kBrickBits) {
          last = v >> kBrickBits;
          slot = old_.find(channel, last);
        }
        values[static_cast<size_t>(i)] = slot.value(Brick::offset(v.x & 7, v.y & 7, v.z & 7));
      }
      editor_.setChannel(channel, brick, values);
    }
  }

  // Distances again where the warp left only bounds: beside creases, and where it presses more than the band is wide.
  void settle() {
    std::vector<Coord> bricks;
    bricks.reserve(order_.size());
    for (size_t i = 0; i < order_.size(); ++i)
      if (!stays_[i]) bricks.push_back(candidates_[order_[i]].brick);
    redistanceByRegion(editor_, bricks, job_, 0.9);
    if (!carries_) return;
    for (const uint32_t i : order_) clearChannelsOutsideBand(editor_, candidates_[i].brick);
  }

  const Version& old_;
  const Grid& grid_;
  VoxelWarp warp_;
  double band_;
  Editor editor_;
  Job* job_;
  int threads_;
  bool carries_ =
      std::any_of(kAllChannels.begin(), kAllChannels.end(), [this](Channel channel) { return old_.has(channel); });
  Version source_;
  std::vector<Candidate> candidates_;
  std::unordered_map<Coord, uint32_t, CoordHash> first_;                        // of the candidates of a brick
  std::vector<uint32_t> order_;                                                 // first candidates, by coordinate
  std::array<std::unordered_set<Coord, CoordHash>, kTreeLevels + 1> occupied_;  // blocks of each level that hold some
  std::vector<uint8_t> stays_;  // whether each of them keeps what the old clay has there
  std::vector<Tile> upper_;     // side of the last voxel of the first column of each of them
};

}  // namespace

BoxMm boundsOf(const Version& version) {
  Coord low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
  version.forEachBrick([&](const Brick& brick) {
    if (!brick.anyInside) return;
    int first = kBrickEdge, last = 0;
    uint64_t any = 0;
    for (int x = 0; x < kBrickEdge; ++x) {
      if (brick.inside[x] == 0) continue;
      first = std::min(first, x);
      last = x;
      any |= brick.inside[x];
    }
    // Bit y · 8 + z.
    uint64_t columns = any;
    for (const int shift : {32, 16, 8}) columns |= columns >> shift;
    const auto alongZ = static_cast<uint8_t>(columns);
    const Coord c = brick.coord * kBrickEdge;
    low = {std::min(low.x, c.x + first), std::min(low.y, c.y + (std::countr_zero(any) >> 3)),
           std::min(low.z, c.z + std::countr_zero(alongZ))};
    high = {std::max(high.x, c.x + last), std::max(high.y, c.y + ((63 - std::countl_zero(any)) >> 3)),
            std::max(high.z, c.z + 7 - std::countl_zero(alongZ))};
  });
  if (low.x > high.x) return {version.grid().toWorld(Vec3d::Ones()), version.grid().toWorld(-Vec3d::Ones())};
  // The surface lies between the outermost voxels inside and those beside them.
  return {version.grid().toWorld(low.toVec3d() - Vec3d::Ones()),
          version.grid().toWorld(high.toVec3d() + Vec3d::Ones())};
}

BoxMm brickBoundsOf(const Version& version) {
  Coord low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
  version.forEachBrick([&](const Brick& brick) {
    const Coord c = brick.coord * kBrickEdge;
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x + 7), std::max(high.y, c.y + 7), std::max(high.z, c.z + 7)};
  });
  return {version.grid().toWorld(low.toVec3d()), version.grid().toWorld(high.toVec3d())};
}

Version deform(const Version& version, const Warp& warp, std::shared_ptr<Store> store, Job* job, int threads) {
  if (version.stats().bricks == 0) return Version::empty(std::move(store), version.grid());
  const double pressure = greatestPressure(warp, version);
  return Deformer(version, warp, std::move(store), job, threads).run(pressure);
}

}  // namespace argil::clay
