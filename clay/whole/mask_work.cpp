#include "clay/whole/mask_work.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/parallel.h"
#include "clay/base/work_part.h"
#include "clay/store/channel_blur.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

constexpr size_t kSlice = 1024;  // bricks between two looks at the job: a few ms
// curvature is taken over so many voxels: less sees the steps of the grid, more leaves the band
constexpr float kOver = 2;

using Bytes = std::array<uint8_t, kBrickVoxels>;

// What one thread reads the version with, for a slice.
struct Reading {
  explicit Reading(const Version& version) : channels(version), field(version) {}
  ChannelReader<Version> channels;
  Sampler field;
  ChannelBlur blur;
};

Coord voxelOf(Coord brick, int i) {
  return brick * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
}

// The new mask of each brick from the version as it is: `fill(reading, brick, mask)` changes the mask; what is out of
// the band is cleared here.
template <class Fill>
Version work(const Version& version, const WorkPart& part, int threads, const Fill& fill) {
  std::vector<const Brick*> bricks;
  bricks.reserve(version.stats().bricks);
  version.forEachBrick([&](const Brick& brick) { bricks.push_back(&brick); });
  Editor editor(version);
  const float band = version.grid().band;
  std::vector<Bytes> masks;
  for (size_t begin = 0; begin < bricks.size(); begin += kSlice) {
    part.step(static_cast<double>(begin) / static_cast<double>(bricks.size()));
    const size_t count = std::min(kSlice, bricks.size() - begin);
    masks.resize(count);
    parallelBlocks(
        count, threads,
        [&](size_t from, size_t to) {
          Reading reading(version);
          for (size_t i = from; i < to; ++i) {
            const Brick& brick = *bricks[begin + i];
            const ChannelSlot now = version.find(Channel::mask, brick.coord);
            for (int v = 0; v < kBrickVoxels; ++v) masks[i][static_cast<size_t>(v)] = now.value(v);
            fill(reading, brick, masks[i]);
            for (int v = 0; v < kBrickVoxels; ++v)
              if (!(std::abs(brick.phi(v)) < band)) masks[i][static_cast<size_t>(v)] = 0;
          }
        },
        128);
    for (size_t i = 0; i < count; ++i) editor.setChannel(Channel::mask, bricks[begin + i]->coord, masks[i]);
  }
  part.step(1);
  return editor.commit();
}

uint8_t byteOf(float share) {
  return static_cast<uint8_t>(std::clamp(share, 0.0f, 1.0f) * 255 + 0.5f);
}

// Outwards, of unit length; zero where nothing slopes.
Vec3f normalAt(Sampler& field, Coord v) {
  const Vec3f slope(field.voxel(v + Coord{1, 0, 0}) - field.voxel(v - Coord{1, 0, 0}),
                    field.voxel(v + Coord{0, 1, 0}) - field.voxel(v - Coord{0, 1, 0}),
                    field.voxel(v + Coord{0, 0, 1}) - field.voxel(v - Coord{0, 0, 1}));
  const float length = slope.norm();
  return length > 1e-6f ? Vec3f(slope / length) : Vec3f::Zero();
}

bool inside(const std::vector<Eigen::Vector2d>& curve, const Eigen::Vector2d& p) {
  bool in = false;
  for (size_t i = 0, j = curve.size() - 1; i < curve.size(); j = i++) {
    const Eigen::Vector2d &a = curve[i], &b = curve[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      in = !in;
  }
  return in;
}

}  // namespace

Version clearMask(const Version& version, Job* job) {
  if (!version.has(Channel::mask)) return version;
  return work(version, WorkPart(job), 1, [](Reading&, const Brick&, Bytes& mask) { mask.fill(0); });
}

Version invertMask(const Version& version, Job* job, int threads) {
  return work(version, WorkPart(job), threads, [](Reading&, const Brick&, Bytes& mask) {
    for (uint8_t& each : mask) each = static_cast<uint8_t>(255 - each);
  });
}

Version blurMask(const Version& version, int passes, Job* job, int threads) {
  if (passes < 1 || passes > 100) throw Error(fmt::format("a mask softened {} times: give 1 to 100", passes));
  Version result = version;
  if (!version.has(Channel::mask)) return result;
  for (int pass = 0; pass < passes; ++pass)
    result = work(result, WorkPart(job, double(pass) / passes, double(pass + 1) / passes), threads,
                  [](Reading& reading, const Brick& brick, Bytes& mask) {
                    if (!reading.blur.gather(reading.channels, brick.coord, false)) return;
                    ChannelBytes bytes{};
                    for (int i = 0; i < kBrickVoxels; ++i) {
                      if (!(std::abs(brick.phi(i)) < reading.channels.band())) continue;
                      bytes[indexOf(Channel::mask)] = mask[static_cast<size_t>(i)];
                      reading.blur.apply(i, 1, bytes);
                      mask[static_cast<size_t>(i)] = bytes[indexOf(Channel::mask)];
                    }
                  });
  return result;
}

Version maskByLasso(const Version& version, const MaskLasso& lasso, Job* job, int threads) {
  if (lasso.curve.size() < 3 || lasso.curve.size() > 100000)
    throw Error(fmt::format("a lasso of {} corners: draw around something", lasso.curve.size()));
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : lasso.curve) {
    if (!corner.allFinite()) throw Error("a lasso with a number that is not finite");
    box.extend(corner);
  }
  if (!lasso.view.allFinite() || (lasso.eye && !lasso.eye->allFinite())) throw Error("a lasso seen from nowhere");
  const auto project = [&](const Vec3d& p, Eigen::Vector2d& at) {
    const Eigen::Vector4d q = lasso.view * p.homogeneous();
    if (!(q.w() > 0)) return false;
    at = q.head<2>() / q.w();
    return true;
  };
  return work(version, WorkPart(job), threads, [&](Reading& reading, const Brick& brick, Bytes& mask) {
    // A brick whose corners lie in front of the eye and beside the curve.
    Eigen::AlignedBox2d seen;
    bool whole = true;
    for (int corner = 0; corner < 8 && whole; ++corner) {
      Eigen::Vector2d at;
      whole = project((brick.coord * kBrickEdge + Coord{corner >> 2, (corner >> 1) & 1, corner & 1} * 7).toVec3d(), at);
      if (whole) seen.extend(at);
    }
    if (whole && !seen.intersects(box)) return;
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (!(std::abs(brick.phi(i)) < reading.channels.band())) continue;
      const Coord voxel = voxelOf(brick.coord, i);
      Eigen::Vector2d at;
      if (!project(voxel.toVec3d(), at) || !box.contains(at)) continue;
      if (lasso.eye && !(normalAt(reading.field, voxel).cast<double>().dot(*lasso.eye - voxel.toVec3d()) > 0)) continue;
      if (inside(lasso.curve, at)) mask[static_cast<size_t>(i)] = lasso.erase ? 0 : 255;
    }
  });
}

float meanCurvature(Sampler& field, Coord voxel) {
  const float phi = field.voxel(voxel);
  // The slope where all neighbours are known: towards the surface where the band ends.
  const Vec3f normal = normalAt(field, voxel);
  const Vec3d foot = voxel.toVec3d() - (phi * normal).cast<double>();
  const float middle = field.trilinear(foot);
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d step = double(kOver) * Vec3d::Unit(axis);
    sum += (field.trilinear(foot + step) + field.trilinear(foot - step)) - 2 * middle;
  }
  return sum / (kOver * kOver) / 2;
}

Version maskByCavity(const Version& version, const MaskByCavity& how, Job* job, int threads) {
  if (!(how.radius >= 1 && how.radius <= 1000))
    throw Error(fmt::format("hollows of a radius of {} voxels: give one from 1 to 1000 voxels", how.radius));
  const auto radius = static_cast<float>(how.ridges ? how.radius : -how.radius);
  return work(version, WorkPart(job), threads, [&](Reading& reading, const Brick& brick, Bytes& mask) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      uint8_t& own = mask[static_cast<size_t>(i)];
      if (!(std::abs(brick.phi(i)) < reading.channels.band())) continue;
      // Half of the curvature is that of twice the radius.
      const uint8_t found = byteOf(2 * (meanCurvature(reading.field, voxelOf(brick.coord, i)) * radius - 0.5f));
      own = how.add ? std::max(own, found) : found;
    }
  });
}

}  // namespace argil::clay
