#include "clay/whole/resample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "clay/base/memory_guard.h"
#include "clay/base/parallel.h"
#include "clay/field/region_work.h"
#include "clay/field/settle.h"
#include "clay/store/brick_set.h"
#include "clay/store/channel_source.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"

namespace argil::clay {

namespace {

constexpr double kMostActiveVoxels = 1 << 30;  // 6 GB of 16 bits, 12 of 32; memory itself: MemoryGuard
constexpr double kLargestStep = 2;    // of voxel sizes: each step measures three new voxels of distance, six old ones
constexpr double kWholeVoxel = 1e-9;  // voxels: a shift this near to whole voxels is one
constexpr int kSplineReach = 2;       // voxels beyond the last distance that a spline reads
constexpr double kBrickHalfDiagonal = 6.1;  // voxels, from a brick's middle to its farthest voxel
constexpr size_t kMostErrorPoints = 1'000'000;

// From the new voxels to the old ones.
struct VoxelMap {
  Eigen::Matrix3d matrix;
  Vec3d shift;
  [[nodiscard]] Vec3d operator()(const Vec3d& v) const { return matrix * v + shift; }
};

VoxelMap mapBetween(const Grid& from, const Grid& to, const Eigen::Isometry3d& pose) {
  const Eigen::Isometry3d back = pose.inverse();
  return {back.linear() * (to.voxelMm / from.voxelMm), from.toVoxel(back * to.originMm)};
}

// Whether voxels come to lie on voxels: shifts, turns and reflections along the axes.
bool isWhole(const VoxelMap& map, const Grid& from, const Grid& to) {
  const Eigen::Matrix3d turn = map.matrix.array().round();
  const Vec3d shift = map.shift.array().round();
  return from.band == to.band && std::abs(to.voxelMm / from.voxelMm - 1) < 1e-12 &&
         (map.matrix - turn).cwiseAbs().maxCoeff() < 1e-12 && (map.shift - shift).cwiseAbs().maxCoeff() < kWholeVoxel;
}

// The bounds of a box of source voxels in target voxels.
void bounds(const VoxelMap& toTarget, const Vec3d& low, const Vec3d& high, Vec3d& outLow, Vec3d& outHigh) {
  const Vec3d middle = toTarget((low + high) / 2);
  const Vec3d half = toTarget.matrix.cwiseAbs() * ((high - low) / 2);
  outLow = middle - half;
  outHigh = middle + half;
}

class Resampler {
 public:
  Resampler(const Version& source, const Grid& grid, const Eigen::Isometry3d& pose)
      : source_(source),
        grid_(grid),
        map_(mapBetween(source.grid(), grid, pose)),
        inverse_(mapBetween(grid, source.grid(), pose.inverse())),
        scale_(grid.voxelMm / source.grid().voxelMm),
        whole_(isWhole(map_, source.grid(), grid)),
        channels_(ChannelSource::any(source)) {
    if (whole_) {
      map_.matrix = map_.matrix.array().round().eval();
      map_.shift = map_.shift.array().round().eval();
    }
    // So many bricks that a chunk of them is about a region of the source.
    while (edge_ > 1 && edge_ * scale_ > kRegionBricks) edge_ /= 2;
  }

  Version run(int threads, const WorkPart& part) {
    collectChunks();
    Editor editor(Version::empty(Store::make(source_.store()->precision()), grid_));
    fillTiles(editor, Editor::blockFirst({0, 0, 0}, kTreeLevels), kTreeLevels);
    std::mutex editing;
    forEachItem(chunks_.size(), threads, part.part(0, 0.98),
                [&](size_t i, DistanceBox& box) { chunk(chunks_[i], box, editor, editing); });
    // Splines are steeper than the distances that they lead through where those have a crease.
    if (!whole_) limitSlopes(editor, written_, threads, part.part(0.98, 1));
    return editor.commit();
  }

 private:
  // What new bricks can have a distance within the band, in chunks of edge_³.
  void collectChunks() {
    BrickSet chunks;
    const double reach = grid_.band * scale_ + 1;
    const Vec3d r = Vec3d::Constant(reach), size = Vec3d::Constant(kBrickEdge - 1);
    const double chunkVoxels = edge_ * kBrickEdge;
    source_.forEachBrick([&](const Brick& brick) {
      const Vec3d first = (brick.coord * kBrickEdge).toVec3d();
      Vec3d low, high;
      bounds(inverse_, first - r, first + size + r, low, high);
      const double limit = double(kBrickReach) * kBrickEdge - chunkVoxels;
      if (low.minCoeff() < -limit || high.maxCoeff() > limit)
        throw Error(
            "the piece would lie farther than clay can from its grid's origin, 112 000 voxels: use a larger voxel or "
            "another origin",
            Error::Kind::work);
      const auto chunkOf = [&](double v) { return static_cast<int>(std::floor(v / chunkVoxels)); };
      for (int x = chunkOf(low.x()); x <= chunkOf(high.x()); ++x)
        for (int y = chunkOf(low.y()); y <= chunkOf(high.y()); ++y)
          for (int z = chunkOf(low.z()); z <= chunkOf(high.z()); ++z) chunks.add({x, y, z});
    });
    chunks_ = chunks.sorted();
  }

  [[nodiscard]] bool isInside(const Vec3d& voxel) { return sampler_.trilinear(map_(voxel)) < 0; }

  // Blocks without a chunk are all inside or all outside, as their middle is.
  void fillTiles(Editor& editor, Coord block, int level) {
    const int edge = 1 << (3 * level);
    const Coord end = block + Coord{edge, edge, edge};
    if (std::min({end.x, end.y, end.z}) <= -kBrickReach || std::max({block.x, block.y, block.z}) >= kBrickReach) return;
    if (level > 0 && touches(block, edge)) {
      for (int i = 0; i < 512; ++i)
        fillTiles(editor, block + Coord{i >> 6, (i >> 3) & 7, i & 7} * (edge / 8), level - 1);
      return;
    }
    if (level == 0 && std::binary_search(chunks_.begin(), chunks_.end(), chunkOf(block))) return;
    const Coord c = block;
    if (isInside((c * kBrickEdge).toVec3d() + Vec3d::Constant(edge * kBrickEdge / 2.0)))
      editor.setBlock(block, level, Tile::inside);
  }

  [[nodiscard]] Coord chunkOf(Coord brick) const {
    const int bits = edge_ == 8 ? 3 : edge_ == 4 ? 2 : edge_ == 2 ? 1 : 0;
    return brick >> bits;
  }

  // Whether some chunk lies in the block: chunks are sorted by x, then y, then z.
  [[nodiscard]] bool touches(Coord block, int edge) {
    if (edge == 8) return marks(block >> 3, 0);
    int level = 0;
    while ((8 << (3 * level)) < edge) ++level;
    return marks(block, level);
  }

  // Blocks that hold chunks, by their first brick, one set a level.
  [[nodiscard]] bool marks(Coord key, int level) {
    if (marked_.empty()) {
      marked_.resize(kTreeLevels);
      for (const Coord chunk : chunks_) {
        const Coord brick = chunk * edge_;
        for (int l = 0; l < kTreeLevels; ++l)
          marked_[static_cast<size_t>(l)].push_back(l == 0 ? brick >> 3 : Editor::blockFirst(brick, l + 1));
      }
      for (auto& level1 : marked_) {
        std::sort(level1.begin(), level1.end());
        level1.erase(std::unique(level1.begin(), level1.end()), level1.end());
      }
    }
    const auto& sorted = marked_[static_cast<size_t>(level)];
    return std::binary_search(sorted.begin(), sorted.end(), key);
  }

  void chunk(Coord at, DistanceBox& box, Editor& editor, std::mutex& editing) {
    const Coord first = at * edge_;
    const float band = grid_.band;
    const Vec3d from = (first * kBrickEdge).toVec3d();
    Vec3d low, high;
    bounds(map_, from, from + Vec3d::Constant(edge_ * kBrickEdge - 1), low, high);
    const auto margin = whole_ ? 0 : kSplineReach;
    const Coord boxLow = Coord{int(std::floor(low.x())), int(std::floor(low.y())), int(std::floor(low.z()))} -
                         Coord{margin, margin, margin};
    const Coord boxHigh = Coord{int(std::ceil(high.x())), int(std::ceil(high.y())), int(std::ceil(high.z()))} +
                          Coord{margin + 1, margin + 1, margin + 1};
    const float reach = whole_ ? source_.grid().band : static_cast<float>(band * scale_) + kSplineReach;
    const bool surface = box.fill(source_, boxLow, boxHigh - boxLow, {reach, reach, channels_});
    ChannelSource old(source_);
    std::vector<ChannelBlock> paint;
    std::vector<std::array<float, kBrickVoxels>> values;
    std::vector<Coord> bricks;
    const float perVoxel = static_cast<float>(1 / scale_);
    for (int b = 0; b < edge_ * edge_ * edge_; ++b) {
      const Coord brick = first + Coord{b / (edge_ * edge_), b / edge_ % edge_, b % edge_};
      const Vec3d voxel = (brick * kBrickEdge).toVec3d();
      float centre =
          surface ? box.sample(map_(voxel + Vec3d::Constant(3.5))) * perVoxel : tileValue(box.uniform(), band);
      if (!surface || std::abs(centre) > band + kBrickHalfDiagonal) {
        if (centre >= 0) continue;
        const std::lock_guard lock(editing);
        editor.setTile(brick, Tile::inside);
        continue;
      }
      values.emplace_back();
      bricks.push_back(brick);
      for (int v = 0; v < kBrickVoxels; ++v) {
        const Vec3d p = map_(voxel + Coord{v >> 6, (v >> 3) & 7, v & 7}.toVec3d());
        values.back()[static_cast<size_t>(v)] =
            whole_ ? box.at({int(std::lround(p.x())), int(std::lround(p.y())), int(std::lround(p.z()))})
                   : box.sample(p) * perVoxel;
      }
      if (channels_) paint.push_back(carried(box, old, voxel, values.back()));
    }
    const std::lock_guard lock(editing);
    for (size_t k = 0; k < bricks.size(); ++k) {
      editor.setVoxels(bricks[k], values[k]);
      if (!channels_) continue;
      paint[k].store(editor, bricks[k]);
      clearChannelsRoundedAway(editor, bricks[k]);
    }
    written_.insert(written_.end(), bricks.begin(), bricks.end());
  }

  // The old clay's channels where a new voxel comes from; farther off than its band those of the nearest place of its
  // surface.
  [[nodiscard]] ChannelBlock carried(const DistanceBox& box, ChannelSource& old, const Vec3d& first,
                                     std::span<const float, kBrickVoxels> phi) const {
    ChannelBlock block{ChannelPlace{}};
    ChannelBytes bytes;
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (!(std::abs(phi[static_cast<size_t>(v)]) < grid_.band)) continue;
      const Vec3d p = map_(first + Coord{v >> 6, (v >> 3) & 7, v & 7}.toVec3d());
      const Coord near{int(std::lround(p.x())), int(std::lround(p.y())), int(std::lround(p.z()))};
      if (old.between(p, bytes) || old.nearest(box.foot(near), bytes) != ChannelSource::kNone) block.set(v, bytes);
    }
    return block;
  }

  const Version& source_;
  Grid grid_;
  VoxelMap map_, inverse_;
  double scale_;  // old voxels a new one
  bool whole_, channels_;
  int edge_ = kRegionBricks;
  std::vector<Coord> chunks_, written_;
  std::vector<std::vector<Coord>> marked_;
  Sampler sampler_{source_};
};

void checkSize(const Version& version, const Grid& grid, const Eigen::Isometry3d& pose) {
  grid.check();
  if (!pose.matrix().allFinite())
    throw Error("the piece's pose holds a number that is not finite: give finite numbers");
  const double scale = version.grid().voxelMm / grid.voxelMm;
  // A brick holds about 230 voxels of a band of 3 on each side.
  const double active = double(version.stats().bricks) * 230 * scale * scale * grid.band / version.grid().band;
  if (active > kMostActiveVoxels)
    throw Error(fmt::format(
        "at a voxel size of {:g} mm the piece would take about {:.0f} million voxels, and {:.0f} million is the most: "
        "use {:.3g} mm or more",
        grid.voxelMm, active / 1e6, kMostActiveVoxels / 1e6, grid.voxelMm * std::sqrt(active / kMostActiveVoxels)));
  requireMemory(
      bytesOfClay(double(version.stats().bricks) / kBricksOfArea * scale * scale, version.store()->precision()),
      fmt::format("the piece at a voxel size of {:g} mm", grid.voxelMm), "use a larger one");
}

// Points of a surface, where voxel edges cross it, and how far they lie from another: sums in blocks of bricks, so
// equal on any threads.
void pointErrors(const Version& of, const Version& other, const Eigen::Isometry3d& pose, int threads,
                 const WorkPart& part, double& rms, double& max, uint64_t& points) {
  std::vector<const Brick*> bricks;
  of.forEachBrick([&](const Brick& brick) {
    if (brick.anyInside && brick.anyOutside) bricks.push_back(&brick);
  });
  // About 150 crossings a brick that has some.
  const size_t every = 1 + bricks.size() * 150 / kMostErrorPoints;
  struct Sum {
    double squares = 0, most = 0;
    uint64_t count = 0;
  };
  const size_t used = (bricks.size() + every - 1) / every;
  constexpr size_t kBlock = 64;
  std::vector<Sum> sums((used + kBlock - 1) / kBlock);
  const VoxelMap map = mapBetween(other.grid(), of.grid(), pose);
  std::mutex mutex;
  size_t done = 0;
  parallelBlocks(
      used, threads,
      [&](size_t begin, size_t end) {
        Sampler sampler(other);
        for (size_t i = begin; i < end; ++i) {
          Sum& sum = sums[i / kBlock];
          const Brick& brick = *bricks[i * every];
          const Vec3d first = (brick.coord * kBrickEdge).toVec3d();
          constexpr int kStride[3] = {64, 8, 1};
          BrickValues scratch;
          const BrickValues& values = brick.values(scratch);
          for (int v = 0; v < kBrickVoxels; ++v)
            for (int axis = 0; axis < 3; ++axis) {
              const int place[3] = {v >> 6, (v >> 3) & 7, v & 7};
              if (place[axis] == 7) continue;
              const float a = values[v], b = values[v + kStride[axis]];
              if ((a < 0) == (b < 0)) continue;
              Vec3d p = first + Vec3d(place[0], place[1], place[2]);
              p[axis] += double(a) / (double(a) - double(b));
              Vec3f gradient;
              const double d = std::abs(double(sampler.tricubic(map(p), gradient))) * other.grid().voxelMm;
              sum.squares += d * d;
              sum.most = std::max(sum.most, d);
              ++sum.count;
            }
        }
        const std::lock_guard lock(mutex);
        part.step(double(done += end - begin) / double(used));
      },
      kBlock);
  double squares = 0;
  uint64_t count = 0;
  max = 0;
  for (const Sum& sum : sums) {
    squares += sum.squares;
    max = std::max(max, sum.most);
    count += sum.count;
  }
  rms = count > 0 ? std::sqrt(squares / double(count)) : 0;
  points += count;
}

}  // namespace

Version resample(const Version& version, const Grid& grid, const Eigen::Isometry3d& pose, int threads,
                 const WorkPart& part) {
  checkSize(version, grid, pose);
  threads = threadCount(threads);
  Version now = version;
  Eigen::Isometry3d rest = pose;
  double from = 0;
  // Halves first: the last step alone moves.
  while (grid.voxelMm > now.grid().voxelMm * kLargestStep * (1 + 1e-9)) {
    Grid coarser = now.grid();
    coarser.voxelMm *= kLargestStep;
    const double to = from + (1 - from) * 0.75;  // each step has a quarter of the work that is left after it
    now = Resampler(now, coarser, Eigen::Isometry3d::Identity()).run(threads, part.part(from, to));
    from = to;
  }
  return Resampler(now, grid, rest).run(threads, part.part(from, 1));
}

Version resample(const Version& version, const Grid& grid, const Eigen::Isometry3d& pose, int threads, Job* job) {
  return resample(version, grid, pose, threads, WorkPart(job));
}

ResampleError resampleError(const Version& before, const Version& after, const Eigen::Isometry3d& pose, int threads,
                            const WorkPart& part) {
  ResampleError error;
  error.voxelMm = after.grid().voxelMm;
  threads = threadCount(threads);
  // From points of the first to the second's voxels, and back.
  pointErrors(before, after, pose.inverse(), threads, part.part(0, 0.5), error.lostRmsMm, error.lostMaxMm,
              error.points);
  pointErrors(after, before, pose, threads, part.part(0.5, 1), error.addedRmsMm, error.addedMaxMm, error.points);
  return error;
}

}  // namespace argil::clay
