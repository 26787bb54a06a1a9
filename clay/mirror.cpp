#include "clay/mirror.h"

#include <algorithm>
#include <cmath>

#include "clay/boolean.h"
#include "clay/editor.h"
#include "clay/resample.h"
#include "clay/tree_view.h"

namespace argil::clay {

namespace {

constexpr float kSame = 0.1f;          // voxels: as kRedistanceTolerance, what is no reason to measure anew
constexpr uint64_t kStepEvery = 512;   // bricks between two looks at the job

// Takes another version's content beyond a plane, voxel by voxel.
class HalfTaker {
 public:
  HalfTaker(Editor& editor, const Vec3d& point, const Vec3d& normal, const WorkPart& part) : editor_(editor), point_(point), normal_(normal), part_(part) {}

  void take(const TreePlace& own, const TreePlace& other) {
    if (own.isTile() && other.isTile() && own.tile() == other.tile()) return;
    const int edge = 1 << (3 * own.level());
    const Vec3d low = (own.first() * kBrickEdge).toVec3d(), size = Vec3d::Constant(edge * kBrickEdge - 1);
    const double middle = normal_.dot(low + size / 2 - point_), half = normal_.cwiseAbs().dot(size) / 2;
    if (middle - half >= 0 && middle - half > editor_.grid().band) return;
    const Coord last = own.first() + Coord{1, 1, 1} * (edge - 1);
    if (std::min({last.x, last.y, last.z}) < -kBrickReach || std::max({own.first().x, own.first().y, own.first().z}) >= kBrickReach) return;
    if (own.level() > 0 && (own.isNode() || other.isNode() || (middle + half >= 0))) {
      for (int i = 0; i < 512; ++i) take(own.child(i), other.child(i));
      return;
    }
    if (own.level() > 0) {
      const Coord f = own.first();
      editor_.setBlock({std::max(f.x, -kBrickReach), std::max(f.y, -kBrickReach), std::max(f.z, -kBrickReach)}, own.level(), other.tile());
      return;
    }
    brick(own, other);
  }
  /// Bricks beside the plane in which both halves say different things.
  [[nodiscard]] const std::vector<Coord>& differing() const { return differing_; }

 private:
  void brick(const TreePlace& own, const TreePlace& other) {
    if (++done_ % kStepEvery == 0) part_.step(0);
    const float band = editor_.grid().band;
    const auto slot = [](const TreePlace& p) { return p.brick() ? Slot(p.brick()) : Slot(p.tile()); };
    const Slot a = slot(own), b = slot(other);
    const Vec3d low = (own.first() * kBrickEdge).toVec3d();
    BrickValues phi, scratchA, scratchB;
    const BrickValues &valuesA = a.values(scratchA, band), &valuesB = b.values(scratchB, band);
    bool differs = false, changed = false;
    for (int v = 0; v < kBrickVoxels; ++v) {
      const double side = normal_.dot(low + Vec3d(v >> 6, (v >> 3) & 7, v & 7) - point_);
      const float pa = valuesA[v], pb = valuesB[v];
      differs |= std::abs(side) < double(band) && std::abs(pa - pb) > kSame;
      changed |= side < 0 && pa != pb;
      phi[v] = side < 0 ? pb : pa;
    }
    if (changed) editor_.setVoxels(own.first(), phi);
    if (differs) differing_.push_back(own.first());
  }

  Editor& editor_;
  Vec3d point_, normal_;
  std::vector<Coord> differing_;
  uint64_t done_ = 0;
  WorkPart part_;
};

}  // namespace

Version mirrorHalf(const Version& version, const Vec3d& pointMm, const Vec3d& normal, int threads, Job* job) {
  if (!pointMm.allFinite() || !normal.allFinite() || !(normal.norm() > 0)) throw Error("the mirror plane needs a finite point and a normal with a length");
  const WorkPart all(job);
  const Vec3d n = normal.normalized(), point = version.grid().toVoxel(pointMm);
  Eigen::Isometry3d reflection = Eigen::Isometry3d::Identity();
  reflection.linear() -= 2 * n * n.transpose();
  reflection.translation() = 2 * n.dot(pointMm) * n;

  Version now = version;
  // Once for the shape; distances that the first round made anew beside the plane are mirrored by the second.
  for (int round = 0; round < 2; ++round) {
    const WorkPart part = all.part(round * 0.5, round * 0.5 + 0.5);
    const Version image = resample(now, now.grid(), reflection, threads, part.part(0, 0.7));
    Editor editor(now);
    HalfTaker taker(editor, point, n, part.part(0.7, 0.7));
    taker.take(TreePlace::root(now), TreePlace::root(image));
    const bool again = round == 0 && !taker.differing().empty();
    if (again) redistanceAll(editor, bricksAround(editor, taker.differing()), part.part(0.7, 1));
    now = editor.commit();
    if (!again) break;
  }
  if (now.stats().bricks == 0) throw Error("nothing lies on the side of the plane that its normal points to: turn the plane or move it", Error::Kind::work);
  if (job) job->step(1);
  return now;
}

}  // namespace argil::clay
