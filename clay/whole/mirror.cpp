#include "clay/whole/mirror.h"

#include <algorithm>
#include <cmath>

#include "clay/field/settle.h"
#include "clay/store/channel_source.h"
#include "clay/store/editor.h"
#include "clay/store/tree_view.h"
#include "clay/whole/resample.h"

namespace argil::clay {

namespace {

constexpr float kSame = 0.1f;         // voxels: as kRedistanceTolerance, what is no reason to measure anew
constexpr uint64_t kStepEvery = 512;  // bricks between two looks at the job

// Takes another version's content beyond a plane, voxel by voxel.
class HalfTaker {
 public:
  HalfTaker(Editor& editor, const Version& other, const Vec3d& point, const Vec3d& normal, const WorkPart& part)
      : editor_(editor),
        own_(editor.base()),
        other_(other),
        point_(point),
        normal_(normal),
        channels_(ChannelSource::any(own_) || ChannelSource::any(other)),
        part_(part) {}

  void take() { take(TreePlace::root(own_), TreePlace::root(other_)); }
  /// Bricks beside the plane in which both halves say different things.
  [[nodiscard]] const std::vector<Coord>& differing() const { return differing_; }
  /// Channels of what came into the band since, on the side that is kept: those of the nearest voxel.
  void fill(const std::vector<Coord>& bricks) {
    if (!channels_) return;
    ChannelSource own(own_);
    const float band = editor_.grid().band;
    for (const Coord coord : bricks) {
      const Slot now = editor_.find(coord), was = own_.find(coord);
      ChannelPlace place{now, {}};
      for (const Channel channel : kAllChannels) place.channel[indexOf(channel)] = editor_.find(channel, coord);
      ChannelBlock block(place);
      for (int v = 0; v < kBrickVoxels; ++v) {
        ChannelBytes bytes{};
        if (std::abs(now.phi(v, band)) < band && (side(coord, v) < 0 || std::abs(was.phi(v, band)) < band)) continue;
        if (std::abs(now.phi(v, band)) < band)
          own.nearest(coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7}, bytes);
        block.set(v, bytes);
      }
      block.store(editor_, coord);
    }
  }

 private:
  void take(const TreePlace& own, const TreePlace& other) {
    if (own.isTile() && other.isTile() && own.tile() == other.tile()) return;
    const int edge = 1 << (3 * own.level());
    const Vec3d low = (own.first() * kBrickEdge).toVec3d(), size = Vec3d::Constant(edge * kBrickEdge - 1);
    const double middle = normal_.dot(low + size / 2 - point_), half = normal_.cwiseAbs().dot(size) / 2;
    if (middle - half >= 0 && middle - half > editor_.grid().band) return;
    const Coord last = own.first() + Coord{1, 1, 1} * (edge - 1);
    if (std::min({last.x, last.y, last.z}) < -kBrickReach ||
        std::max({own.first().x, own.first().y, own.first().z}) >= kBrickReach)
      return;
    if (own.level() > 0 && (own.isNode() || other.isNode() || (middle + half >= 0))) {
      for (int i = 0; i < 512; ++i) take(own.child(i), other.child(i));
      return;
    }
    if (own.level() > 0) {
      const Coord f = own.first();
      // No brick of its own lies there, so no channel either.
      editor_.setBlock({std::max(f.x, -kBrickReach), std::max(f.y, -kBrickReach), std::max(f.z, -kBrickReach)},
                       own.level(), other.tile());
      return;
    }
    brick(own, other);
  }
  [[nodiscard]] double side(Coord brick, int v) const {
    return normal_.dot((brick * kBrickEdge).toVec3d() + Vec3d(v >> 6, (v >> 3) & 7, v & 7) - point_);
  }

  void brick(const TreePlace& own, const TreePlace& other) {
    if (++done_ % kStepEvery == 0) part_.step(0);
    const float band = editor_.grid().band;
    const auto slot = [](const TreePlace& p) { return p.brick() ? Slot(p.brick()) : Slot(p.tile()); };
    const Slot a = slot(own), b = slot(other);
    BrickValues phi, scratchA, scratchB;
    const BrickValues &valuesA = a.values(scratchA, band), &valuesB = b.values(scratchB, band);
    bool differs = false, changed = false, crosses = false;
    for (int v = 0; v < kBrickVoxels; ++v) {
      const double away = side(own.first(), v);
      const float pa = valuesA[v], pb = valuesB[v];
      differs |= std::abs(away) < double(band) && std::abs(pa - pb) > kSame;
      changed |= away < 0 && pa != pb;
      crosses |= away < 0;
      phi[v] = away < 0 ? pb : pa;
    }
    if (changed) editor_.setVoxels(own.first(), phi);
    if (differs) differing_.push_back(own.first());
    if (channels_ && crosses) takeChannels(own.first());
  }

  void takeChannels(Coord coord) {
    const Slot now = editor_.find(coord);
    for (const Channel channel : kAllChannels) {
      if (!own_.has(channel) && !other_.has(channel)) continue;
      const ChannelSlot a = own_.find(channel, coord), b = other_.find(channel, coord);
      std::array<uint8_t, kBrickVoxels> values{};
      if (now.brick())
        for (int v = 0; v < kBrickVoxels; ++v) values[static_cast<size_t>(v)] = (side(coord, v) < 0 ? b : a).value(v);
      editor_.setChannel(channel, coord, values);
    }
  }

  Editor& editor_;
  const Version own_, other_;
  Vec3d point_, normal_;
  bool channels_;
  std::vector<Coord> differing_;
  uint64_t done_ = 0;
  WorkPart part_;
};

}  // namespace

Version mirrorHalf(const Version& version, const Vec3d& pointMm, const Vec3d& normal, int threads, Job* job) {
  if (!pointMm.allFinite() || !normal.allFinite() || !(normal.norm() > 0))
    throw Error("the mirror plane needs a finite point and a normal with a length");
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
    HalfTaker taker(editor, image, point, n, part.part(0.7, 0.7));
    taker.take();
    const bool again = round == 0 && !taker.differing().empty();
    if (again) {
      const std::vector<Coord> beside = bricksAround(editor, taker.differing());
      redistanceAll(editor, beside, part.part(0.7, 1));
      taker.fill(beside);
    }
    now = editor.commit();
    if (!again) break;
  }
  if (now.stats().bricks == 0)
    throw Error("nothing lies on the side of the plane that its normal points to: turn the plane or move it",
                Error::Kind::work);
  if (job) job->step(1);
  return now;
}

}  // namespace argil::clay
