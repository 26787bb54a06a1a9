#pragma once
// A session in small, for tests of the servo: drains samples, carves them, publishes scenes a fixed time later.

#include <array>
#include <deque>
#include <memory>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/scene/scene.h"
#include "haptics/threads/published.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics::testing {

class VirtualSession {
 public:
  /// A block with its top at z = 0, 1 N/mm at most, as the tool says.
  VirtualSession(double voxelMm, const Tool& tool, int delayTicks = 10, int everyTicks = 10)
      : store_(clay::Store::make()),
        delay_(static_cast<uint64_t>(delayTicks)),
        every_(static_cast<uint64_t>(everyTicks)) {
    clay::Grid grid;
    grid.voxelMm = voxelMm;
    scene_.pieces.push_back({clay::makeBlock(store_, grid, {0, 0, -10}, {80, 60, 20}, 1), Pose(), 0});
    scene_.tool = tool;
    publish();
  }

  Published<Scene>& published() { return published_; }
  Scene& scene() { return scene_; }
  void publish() { published_.publish(std::make_unique<const Scene>(scene_)); }

  /// Between ticks.
  void step(SampleRing& ring, uint64_t index) {
    const size_t count = ring.pop(buffer_);
    for (size_t i = 0; i < count; ++i) waiting_.push_back(buffer_[i]);
    if (index % every_ != 0) return;
    bool changed = false;
    while (!waiting_.empty() && waiting_.front().index + delay_ <= index) {
      changed = apply(waiting_.front()) || changed;
      scene_.samplesApplied = waiting_.front().index + 1;
      waiting_.pop_front();
    }
    if (!changed) return;
    scene_.pieces[0].version = stroke_ ? stroke_->publish() : scene_.pieces[0].version;
    publish();
    store_->collect();
  }
  uint64_t stamps = 0, strokes = 0;

 private:
  bool apply(const StylusSample& sample) {
    if (!(sample.flags & kCutting)) {
      if (!stroke_) return false;
      scene_.pieces[0].version = stroke_->finish();
      stroke_.reset();
      return true;
    }
    const clay::Grid& grid = scene_.pieces[0].version.grid();
    const Vec3d at = grid.toVoxel(sample.cutPoint);
    if (!stroke_) {
      stroke_ = std::make_unique<clay::BrushStroke>(scene_.pieces[0].version, clay::Brush::of(clay::Method::carve));
      last_ = at;
      ++strokes;
    } else if ((at - last_).norm() < 0.25) {
      return false;
    }
    clay::Stamp stamp;
    stamp.a = last_;
    stamp.b = last_ = at;
    stamp.radius = scene_.tool.radiusMm / grid.voxelMm;
    stroke_->apply(stamp);
    ++stamps;
    return true;
  }

  std::shared_ptr<clay::Store> store_;
  Scene scene_;
  Published<Scene> published_;
  std::unique_ptr<clay::BrushStroke> stroke_;
  std::deque<StylusSample> waiting_;
  std::array<StylusSample, 256> buffer_;
  Vec3d last_ = Vec3d::Zero();
  uint64_t delay_, every_;
};

/// Strokes to and fro over the block's top, `depthMm` deep, each 0.03 mm deeper so that there is always clay to cut;
/// button 1 down while moving.
inline HandPath scribble(double seconds, double radiusMm, double depthMm) {
  std::vector<HandPoint> points;
  double t = 0;
  for (int stroke = 0; t < seconds; ++stroke) {
    const double y = -20 + 40 * std::fmod(stroke * 0.381966, 1.0), x = stroke % 2 ? 30 : -30;
    const double z = radiusMm - depthMm - 0.03 * stroke;
    const auto add = [&](double dt, double px, double pz, uint32_t buttons) {
      HandPoint p;
      p.timeS = t;
      p.position = {px, y, pz};
      p.buttons = buttons;
      points.push_back(p);
      t += dt;
    };
    add(0.2, x, radiusMm + 3, 0);
    add(0.2, x, z, 1);
    add(1.2, x, z, 1);
    add(0.1, -x, z, 1);
    add(0.3, -x, radiusMm + 3, 0);
  }
  return HandPath(std::move(points));
}

}  // namespace argil::haptics::testing
