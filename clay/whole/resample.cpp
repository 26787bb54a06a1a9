#include "clay/whole/resample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "clay/base/memory_guard.h"
#include "clay/base/parallel.h"
#include "clay/field/region_work.h"
#include "clay/field/renewed_block.h"
#include "clay/field/settle.h"
#include "clay/field/work_rooms.h"
#include "clay/store/brick_set.h"
#include "clay/store/channel_source.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"

namespace argil::clay {

namespace {

constexpr double kMostActiveVoxels = 1 << 30;  // 6 GB of 16 bits, 12 of 32; memory itself: MemoryGuard
constexpr double kLargestStep = 2;    // of voxel sizes: what lies beside the surface has to lie within the old band
constexpr double kWholeVoxel = 1e-9;  // voxels: a shift this near to whole voxels is one
// New voxels: what lies beside the surface is nearer, and read by splines. Two old voxels each are still in the band.
constexpr float kBeside = 1.3f;
// New voxels, from the middle of a brick or of an eighth of one to its farthest voxel.
constexpr float kBrickHalfDiagonal = 6.1f, kPartHalfDiagonal = 2.6f;
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
        // Where splines reach the end of the new band nothing is left to be solved.
        solves_(!whole_ && kOwnDistance < grid.band * scale_),
        channels_(ChannelSource::any(source)) {
    if (whole_) {
      map_.matrix = map_.matrix.array().round().eval();
      map_.shift = map_.shift.array().round().eval();
    }
  }

  Version run(int threads, const WorkPart& part) {
    collect();
    Editor editor(Version::empty(Store::make(source_.store()->precision()), grid_));
    fillTiles(editor, Editor::blockFirst({0, 0, 0}, kTreeLevels), kTreeLevels);
    std::vector<Coord> blocks;
    for (const auto& [block, bricks] : byBlock_) blocks.push_back(block);
    std::sort(blocks.begin(), blocks.end());
    std::mutex editing;
    forEachWithRoom<RenewedBlock>(blocks.size(), threads, part.part(0, 0.98),
                                  [&](size_t i, RenewedBlock& room) { fill(blocks[i], room, editor, editing); });
    // Splines are steeper than the distances that they lead through where those have a crease.
    if (!whole_) {
      std::erase_if(bricks_, [&](Coord brick) { return editor.find(brick).isTile(); });
      limitSlopes(editor, bricks_, threads, part.part(0.98, 1));
    }
    return editor.commit();
  }

 private:
  // New bricks that can have a distance within the band: by old ones that have voxels beside the surface.
  void collect() {
    BrickSet wanted;
    const double reach = grid_.band * scale_ + 2;
    const Vec3d r = Vec3d::Constant(reach), size = Vec3d::Constant(kBrickEdge - 1);
    source_.forEachBrick([&](const Brick& brick) {
      if (!whole_ && !besideSurface(brick)) return;
      const Vec3d first = (brick.coord * kBrickEdge).toVec3d();
      Vec3d low, high;
      bounds(inverse_, first - r, first + size + r, low, high);
      const double limit = double(kBrickReach) * kBrickEdge - kBlockEdge * kBrickEdge;
      if (low.minCoeff() < -limit || high.maxCoeff() > limit)
        throw Error(
            "the piece would lie farther than clay can from its grid's origin, 112 000 voxels: use a larger voxel or "
            "another origin",
            Error::Kind::work);
      const auto brickOf = [&](double v) { return static_cast<int>(std::floor(v / kBrickEdge)); };
      for (int x = brickOf(low.x()); x <= brickOf(high.x()); ++x)
        for (int y = brickOf(low.y()); y <= brickOf(high.y()); ++y)
          for (int z = brickOf(low.z()); z <= brickOf(high.z()); ++z) wanted.add({x, y, z});
    });
    bricks_ = wanted.sorted();
    std::sort(bricks_.begin(), bricks_.end());
    for (const Coord brick : bricks_) {
      const Coord own = brick >> kBlockBits, low = (brick - Coord{1, 1, 1}) >> kBlockBits,
                  high = (brick + Coord{1, 1, 1}) >> kBlockBits;
      byBlock_[own].push_back(brick);
      // Bricks at its rim count for the blocks beside it.
      for (int x = low.x; x <= high.x; ++x)
        for (int y = low.y; y <= high.y; ++y)
          for (int z = low.z; z <= high.z; ++z)
            if (Coord{x, y, z} != own && solves_) byBlock_[{x, y, z}].push_back(brick);
    }
  }
  // Whether a voxel lies within two of the surface, as one beside each crossing does, however steep the field is there.
  static bool besideSurface(const Brick& brick) {
    if (brick.anyInside && brick.anyOutside) return true;
    BrickValues room;
    const BrickValues& values = brick.values(room);
    return std::any_of(std::begin(values), std::end(values), [](float phi) { return std::abs(phi) <= 2; });
  }

  [[nodiscard]] bool isInside(const Vec3d& voxel) { return sampler_.trilinear(map_(voxel)) < 0; }

  // Blocks without such a brick are all inside or all outside, as their middle is.
  void fillTiles(Editor& editor, Coord block, int level) {
    const int edge = 1 << (3 * level);
    const Coord end = block + Coord{edge, edge, edge};
    if (std::min({end.x, end.y, end.z}) <= -kBrickReach || std::max({block.x, block.y, block.z}) >= kBrickReach) return;
    if (level > 0 && touches(block, edge)) {
      for (int i = 0; i < 512; ++i)
        fillTiles(editor, block + Coord{i >> 6, (i >> 3) & 7, i & 7} * (edge / 8), level - 1);
      return;
    }
    if (level == 0 && isWanted(block)) return;
    const Coord c = block;
    if (isInside((c * kBrickEdge).toVec3d() + Vec3d::Constant(edge * kBrickEdge / 2.0)))
      editor.setBlock(block, level, Tile::inside);
  }

  [[nodiscard]] bool isWanted(Coord brick) const { return std::binary_search(bricks_.begin(), bricks_.end(), brick); }

  // Whether one of the bricks lies in the block.
  [[nodiscard]] bool touches(Coord block, int edge) {
    if (edge == 8) return marks(block >> 3, 0);
    int level = 0;
    while ((8 << (3 * level)) < edge) ++level;
    return marks(block, level);
  }

  // Blocks that hold some, by their first brick, one set a level.
  [[nodiscard]] bool marks(Coord key, int level) {
    if (marked_.empty()) {
      marked_.resize(kTreeLevels);
      for (const Coord brick : bricks_)
        for (int l = 0; l < kTreeLevels; ++l)
          marked_[static_cast<size_t>(l)].push_back(l == 0 ? brick >> 3 : Editor::blockFirst(brick, l + 1));
      for (auto& level1 : marked_) {
        std::sort(level1.begin(), level1.end());
        level1.erase(std::unique(level1.begin(), level1.end()), level1.end());
      }
    }
    const auto& sorted = marked_[static_cast<size_t>(level)];
    return std::binary_search(sorted.begin(), sorted.end(), key);
  }

  void fill(Coord block, RenewedBlock& room, Editor& editor, std::mutex& editing) {
    room.begin(block, grid_.band);
    Sampler field(source_);
    for (const Coord brick : byBlock_.at(block)) {
      const Vec3d middle = map_((brick * kBrickEdge).toVec3d() + Vec3d::Constant(3.5));
      if (float side = 0; !whole_ && isFar(field, middle, kBrickHalfDiagonal, side)) {
        if (room.holds(brick)) room.addTile(brick, side < 0);
        continue;
      }
      sample(field, brick, room.add(brick));
    }
    if (solves_) {
      std::array<BrickValues, 2> tiles;
      std::fill(std::begin(tiles[0]), std::end(tiles[0]), grid_.band);
      std::fill(std::begin(tiles[1]), std::end(tiles[1]), -grid_.band);
      room.solve(
          Renew::none, field,
          [&](Coord brick) {
            const Vec3d middle = (brick * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
            return tiles[field.trilinear(map_(middle)) < 0];
          },
          kOwnDistance / static_cast<float>(scale_));
    }
    ChannelSource old(source_);
    const auto paint = [&](const FloatBrick& brick, size_t number) { return carried(room, number, old, brick); };
    room.put(editor, editing, channels_ ? RenewedBlock::Paint(paint) : nullptr);
  }

  // The old distances beside the surface; elsewhere the side alone.
  void sample(Sampler& field, Coord brick, float* phi) const {
    constexpr int kPart = 4;  // voxels along each edge of what is looked at together
    const Vec3d first = map_((brick * kBrickEdge).toVec3d());
    for (int i = 0; i < 8; ++i) {
      const Coord low = Coord{i >> 2, (i >> 1) & 1, i & 1} * kPart;
      const Vec3d from = first + map_.matrix * low.toVec3d();
      float side = 0;
      const bool far =
          !whole_ && (allTiles(field, from, kPart - 1, side) ||
                      isFar(field, from + map_.matrix * Vec3d::Constant((kPart - 1) / 2.0), kPartHalfDiagonal, side));
      for (int x = 0; x < kPart; ++x)
        for (int y = 0; y < kPart; ++y) {
          float* const row = phi + Brick::offset(low.x + x, low.y + y, low.z);
          if (far)
            std::fill_n(row, kPart, std::copysign(grid_.band, side));
          else
            sampleRow(field, from + map_.matrix * Vec3d(x, y, 0), {row, kPart});
        }
    }
  }
  void sampleRow(Sampler& field, Vec3d p, std::span<float> row) const {
    // Of a voxel, and a field as steep as it may be; and what lines between voxels are off by at a crease.
    constexpr float kHalfDiagonal = 0.95f, kBent = 0.3f;
    // What lies farther from the surface than the new band says no more than the side.
    const float scale = static_cast<float>(scale_),
                near = std::min(std::max(kOwnDistance, kBeside * scale), grid_.band * scale);
    for (float& phi : row) {
      phi = field.voxel({nearestInt(p.x()), nearestInt(p.y()), nearestInt(p.z())});
      if (!whole_) {
        bool far = std::abs(phi) >= std::min(near + kHalfDiagonal, field.band());
        if (!far) far = std::abs(phi = field.trilinear(p)) >= near + kBent;
        phi = far ? std::copysign(grid_.band, phi) : field.distance(p) / scale;
      }
      p += map_.matrix.col(2);
    }
  }
  // Whether the band reaches nothing within so many new voxels of a place, which the old band knows.
  [[nodiscard]] bool isFar(Sampler& field, const Vec3d& middle, float newVoxels, float& side) const {
    side = field.trilinear(middle);
    return std::abs(side) > (grid_.band + newVoxels) * kSteepest * static_cast<float>(scale_);
  }
  static int nearestInt(double v) { return static_cast<int>(std::floor(v + 0.5)); }
  // Whether there are nothing but tiles of one side where a cube of new voxels lies, and all that splines read there.
  [[nodiscard]] bool allTiles(Sampler& field, const Vec3d& from, int edge, float& side) const {
    Vec3d low = from, high = from;
    for (int k = 0; k < 3; ++k) {
      const Vec3d way = map_.matrix.col(k) * edge;
      low += way.cwiseMin(0);
      high += way.cwiseMax(0);
    }
    const auto brickOf = [](double v) { return static_cast<int>(std::floor(v / kBrickEdge)); };
    for (int x = brickOf(low.x() - 1); x <= brickOf(high.x() + 2); ++x)
      for (int y = brickOf(low.y() - 1); y <= brickOf(high.y() + 2); ++y)
        for (int z = brickOf(low.z() - 1); z <= brickOf(high.z() + 2); ++z) {
          const Slot slot = field.slot({x, y, z});
          if (!slot.isTile()) return false;
          const float here = slot.phi(0, field.band());
          if (side * here < 0) return false;
          side = here;
        }
    return true;
  }

  // The old clay's channels where a new voxel comes from; farther off than its band those of the nearest place of its
  // surface.
  [[nodiscard]] ChannelBlock carried(const RenewedBlock& room, size_t number, ChannelSource& old,
                                     const FloatBrick& brick) const {
    ChannelBlock block{ChannelPlace{}};
    ChannelBytes bytes;
    std::optional<RenewedBlock::Feet> feet;
    if (solves_) feet.emplace(room, number);
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (!(std::abs(brick.value[v]) < grid_.band)) continue;
      const Vec3d at = (brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7}).toVec3d();
      const auto foot = [&] {
        const Vec3d p = map_(at + feet->way(v).cast<double>());
        return Coord{int(std::lround(p.x())), int(std::lround(p.y())), int(std::lround(p.z()))};
      };
      if (old.between(map_(at), bytes) || (feet && old.nearest(foot(), bytes) != ChannelSource::kNone))
        block.set(v, bytes);
    }
    return block;
  }

  const Version& source_;
  Grid grid_;
  VoxelMap map_, inverse_;
  double scale_;  // old voxels a new one
  bool whole_, solves_, channels_;
  std::vector<Coord> bricks_;
  std::unordered_map<Coord, std::vector<Coord>, CoordHash> byBlock_;
  std::vector<std::vector<Coord>> marked_;
  Sampler sampler_{source_};
};

void checkSize(const Version& version, const Grid& grid, const Eigen::Isometry3d& pose) {
  grid.check();
  if (!pose.matrix().allFinite())
    throw Error("the piece's pose holds a number that is not finite: give finite numbers");
  const double scale = version.grid().voxelMm / grid.voxelMm;
  const double active = double(version.activeVoxels()) * scale * scale * grid.band / version.grid().band;
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
