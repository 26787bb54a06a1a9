#include "clay/whole/cut.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/field/redistance.h"
#include "clay/field/settle.h"
#include "clay/field/thin_parts.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"
#include "clay/store/tree_view.h"
#include "clay/whole/wedge.h"

namespace argil::clay {

namespace {

constexpr size_t kBatch = 2048;  // Bricks computed before they are linked: 4 MiB.

Vec3d unit(const char* what, const Vec3d& v) {
  const double length = std::sqrt(v.squaredNorm());
  if (!v.allFinite() || !(length > 1e-12))
    throw Error(fmt::format("cut with a {} that is zero or not finite: give a direction", what));
  return v / length;
}

class Cutter {
 public:
  Cutter(const Version& version, const Divider& divider, bool keepFirst, std::shared_ptr<Store> store, Job* job,
         int threads, ThinParts* gone)
      : version_(version),
        divider_(divider),
        sign_(keepFirst ? 1 : -1),
        copies_(store != version.store()),
        editor_(copies_ ? Version::empty(std::move(store), version.grid()) : version),
        job_(job),
        threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
        gone_(gone) {}

  Version run() {
    walk(TreePlace::root(version_), 0, 0.2);
    compute();
    const WorkPart part(job_, 0.8, 1);
    removeFilms();
    dropWithoutSurface(editor_, cutBricks_);
    std::sort(ends_.begin(), ends_.end());
    ends_.erase(std::unique(ends_.begin(), ends_.end()), ends_.end());
    Sampler field(version_);
    const auto test = [&](Coord voxel, float) { return stands(field, voxel); };
    redistanceAll(editor_, ends_, part.part(0, 0.8), kExactTolerance, test);
    for (int round = 0; round < kFallenRounds && !fallen_.empty(); ++round) {
      std::sort(fallen_.begin(), fallen_.end());
      fallen_.erase(std::unique(fallen_.begin(), fallen_.end()), fallen_.end());
      const std::vector<Coord> around = bricksAround(editor_, std::exchange(fallen_, {}));
      redistanceAll(editor_, around, WorkPart(nullptr), kExactTolerance, test);
      ends_.insert(ends_.end(), around.begin(), around.end());
    }
    std::sort(ends_.begin(), ends_.end());
    ends_.erase(std::unique(ends_.begin(), ends_.end()), ends_.end());
    std::erase_if(ends_, [&](Coord each) { return !editor_.find(each).brick(); });
    limitSlopes(editor_, ends_, threads_, part.part(0.8, 1));
    if (gone_ != nullptr)
      gone_->betweenVoxels += volumeBetweenVoxels(
          editor_, rims_, [&](Coord voxel) { return std::abs(field.voxel(voxel)) < kThinReach; },
          [&](const Vec3d& p) { return double(field.distance(p)); }, [&](const Vec3d& p) { return distance(p); });
    keepChannels(editor_, version_);
    return editor_.commit();
  }

 private:
  // Voxels, negative on the kept side.
  double distance(const Vec3d& voxel) const {
    return sign_ * divider_.distance(version_.grid().toWorld(voxel)) / version_.grid().voxelMm;
  }

  void walk(const TreePlace& place, double from, double to) {
    if (place.isTile() && place.tile() == Tile::outside) return;
    const int edge = 1 << (3 * place.level());
    const double half = 0.5 * (edge * kBrickEdge - 1);
    const double middle = distance((place.first() * kBrickEdge).toVec3d() + Vec3d::Constant(half));
    // Half a voxel more than needed keeps rounding out of the decision.
    const double reach = half * std::sqrt(3.0) + double(version_.grid().band) + 0.5;
    if (middle < -reach) {
      if (copies_) copy(place);
      return;
    }
    if (middle > reach) {
      if (!copies_) editor_.setBlock(place.first(), place.level(), Tile::outside);
      return;
    }
    if (place.level() == 0) {
      cutBricks_.push_back(place.first());
      return;
    }
    if (job_) job_->step(from);
    for (int i = 0; i < 512; ++i)
      walk(place.child(i), from + (to - from) * i / 512, from + (to - from) * (i + 1) / 512);
  }

  void copy(const TreePlace& place) {
    if (const Brick* brick = place.brick()) {
      BrickValues scratch;
      editor_.setVoxels(brick->coord, brick->values(scratch));
    } else if (place.isTile()) {
      if (place.tile() == Tile::inside) editor_.setBlock(place.first(), place.level(), Tile::inside);
    } else {
      if (job_ && job_->cancelled()) throw Cancelled();
      for (int i = 0; i < 512; ++i) copy(place.child(i));
    }
  }

  void compute() {
    const Grid& grid = version_.grid();
    std::vector<std::array<float, kBrickVoxels>> fields(std::min(kBatch, cutBricks_.size()));
    std::vector<uint8_t> ends(fields.size()), rims(fields.size());
    std::vector<BrickMask> facing(fields.size());
    std::atomic<size_t> done{0};
    for (size_t begin = 0; begin < cutBricks_.size(); begin += kBatch) {
      const size_t count = std::min(kBatch, cutBricks_.size() - begin);
      std::fill(ends.begin(), ends.end(), uint8_t{0});
      std::fill(rims.begin(), rims.end(), uint8_t{0});
      std::fill(facing.begin(), facing.end(), BrickMask{});
      parallelBlocks(
          count, threads_,
          [&](size_t from, size_t to) {
            std::array<double, kBrickVoxels> away;
            Sampler field(version_);
            for (size_t i = from; i < to; ++i) {
              const Coord brick = cutBricks_[begin + i];
              const Slot slot = version_.find(brick);
              divider_.distances(grid.toWorld((brick * kBrickEdge).toVec3d()), grid.voxelMm, away);
              for (int v = 0; v < kBrickVoxels; ++v) {
                const float own = slot.phi(v, grid.band);
                const auto off = static_cast<float>(sign_ * away[static_cast<size_t>(v)] / grid.voxelMm);
                float value = std::max(own, off);
                if (mayEnd(own, off, grid.band)) {
                  ends[i] = 1;
                  value = outside(field, voxelOf(brick, v), own, off);
                }
                if (std::abs(own) < kThinReach && std::abs(off) < kThinReach) rims[i] = 1;
                if (own + off > -kThinnest && own + off < kHiding && faces(field, voxelOf(brick, v), own, off))
                  facing[i][static_cast<size_t>(v >> 6)] |= uint64_t{1} << (v & 63);
                fields[i][static_cast<size_t>(v)] = value;
              }
              if (job_)
                job_->step(0.2 +
                           0.6 * double(done.fetch_add(1, std::memory_order_relaxed)) / double(cutBricks_.size()));
            }
          },
          32);
      for (size_t i = 0; i < count; ++i) {
        editor_.setVoxels(cutBricks_[begin + i], fields[i]);
        if (ends[i] != 0) ends_.push_back(cutBricks_[begin + i]);
        if (rims[i] != 0) rims_.push_back(cutBricks_[begin + i]);
        for (int v = 0; v < kBrickVoxels; ++v)
          if (holds(facing[i], v))
            facing_.add(voxelOf(cutBricks_[begin + i], v), fields[i][static_cast<size_t>(v)] < 0);
      }
    }
  }
  [[nodiscard]] static Coord voxelOf(Coord brick, int v) {
    return brick * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
  }
  [[nodiscard]] static Coord beside(Coord voxel, int axis, int step) {
    return voxel + Coord{axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
  }
  float outside(Sampler& field, Coord voxel, float own, float off) const {
    return wedgeDistance(
        own, off, version_.grid().band, [&](int axis, int step) { return field.voxel(beside(voxel, axis, step)); },
        [&](int axis, int step) { return static_cast<float>(distance(beside(voxel, axis, step).toVec3d())); });
  }
  [[nodiscard]] bool faces(Sampler& field, Coord voxel, float own, float off) const {
    return faceEachOther(
        own, off, version_.grid().band, [&](int axis, int step) { return field.voxel(beside(voxel, axis, step)); },
        [&](int axis, int step) { return static_cast<float>(distance(beside(voxel, axis, step).toVec3d())); });
  }
  // Whether the distance that a voxel was given is one to the new surface.
  [[nodiscard]] bool stands(Sampler& field, Coord voxel) {
    const float own = field.voxel(voxel), off = static_cast<float>(distance(voxel.toVec3d()));
    if (facing_.holds(voxel)) return false;
    if (std::max(own, off) <= 0) return true;
    return standsOnSurface(
        voxel.toVec3d(), own, off, version_.grid().band,
        [&](int axis, int step) { return field.voxel(beside(voxel, axis, step)); },
        [&](int axis, int step) { return static_cast<float>(distance(beside(voxel, axis, step).toVec3d())); },
        [&](const Vec3d& p) {
          const auto inside = [&](Coord at) {
            return editor_.find(at >> kBrickBits).phi(Brick::offset(at.x & 7, at.y & 7, at.z & 7), 1) < 0;
          };
          const float value = std::max(field.trilinear(p), static_cast<float>(distance(p)));
          if (value > version_.grid().band || anyInside(p, inside)) return value;
          fallen_.push_back(voxel >> kBrickBits);
          return version_.grid().band;
        });
  }
  // Where the cut runs along the surface.
  void removeFilms() {
    if (facing_.empty()) return;
    ThinParts here;
    facing_.settle(editor_, here);
    here = {};  // Their volume is among what lies between voxels.
    const std::vector<Coord> around = bricksAround(editor_, facing_.bricks());
    ThinVoxels rest(Tile::outside);
    rest.find(editor_, around);
    if (!rest.empty()) rest.settle(editor_, here);
    if (gone_ != nullptr) *gone_ += here;
    ends_.insert(ends_.end(), around.begin(), around.end());
  }

  const Version& version_;
  const Divider& divider_;
  double sign_;
  bool copies_;
  Editor editor_;
  Job* job_;
  int threads_;
  ThinParts* gone_;
  ThinVoxels facing_{Tile::outside};
  // Bricks where distances did not stand because what they were measured to is too thin.
  std::vector<Coord> fallen_;
  std::vector<Coord> cutBricks_;
  std::vector<Coord> rims_;  // with voxels near both surfaces
  std::vector<Coord> ends_;  // with voxels whose distance was measured to what the other side took away
};

}  // namespace

void Divider::distances(const Vec3d& first, double step, std::span<double, kBrickVoxels> out) const {
  for (int i = 0; i < kBrickVoxels; ++i)
    out[static_cast<size_t>(i)] = distance(first + step * Coord{i >> 6, (i >> 3) & 7, i & 7}.toVec3d());
}

PlaneDivider::PlaneDivider(const Vec3d& pointMm, const Vec3d& normal)
    : point_(pointMm), normal_(unit("normal", normal)) {
  if (!pointMm.allFinite()) throw Error("cut by a plane through a point that is not finite: give finite numbers");
}

Version cut(const Version& version, const Divider& divider, bool keepFirst, std::shared_ptr<Store> store, Job* job,
            int threads, ThinParts* gone) {
  return Cutter(version, divider, keepFirst, std::move(store), job, threads, gone).run();
}

}  // namespace argil::clay
