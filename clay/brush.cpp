#include "clay/brush.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <unordered_map>
#include <vector>

#include <fmt/format.h>

#include "clay/brick_set.h"
#include "clay/brush_kernels.h"
#include "clay/error.h"
#include "clay/redistance.h"

namespace argil::clay {

namespace {

constexpr double kMinRadius = 0.5, kMaxRadius = 4096;  // voxels
constexpr double kReachVoxels = 8.0 * kBrickReach - 8 * kMaxRadius;
// From the centre of a brick's voxels to its corner voxel, and a little that covers rounding: bricks farther out are
// decided without looking at their voxels, with the same result.
const double kHalfDiagonal = 3.5 * std::sqrt(3.0) + 0.01;
// The same for a region of 8×8×8 bricks, so that a brush of any size costs its surface.
const double kRegionHalfDiagonal = 31.5 * std::sqrt(3.0) + 0.01;

// Redistancing follows this many stamps behind the last one that touched a brick: the tool has moved on by then.
constexpr uint64_t kTrail = 2;
// Due bricks are gathered until their count is worth the ring of neighbours that is solved along with them.
constexpr size_t kBatch = 64;
constexpr uint64_t kDone = 0;

// Distance of a point to the segment, as the kernels define it but in double: it only selects bricks.
double segmentDistance(const Stamp& s, const Vec3d& p) {
  const Vec3d d = s.b - s.a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - s.a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - s.a - t * d).norm();
}

SweptBall relativeTo(const Stamp& s, Coord brick) {
  const Vec3d a = s.a - (brick * kBrickEdge).toVec3d(), d = s.b - s.a;
  SweptBall ball{};
  ball.ax = static_cast<float>(a.x());
  ball.ay = static_cast<float>(a.y());
  ball.az = static_cast<float>(a.z());
  ball.dx = static_cast<float>(d.x());
  ball.dy = static_cast<float>(d.y());
  ball.dz = static_cast<float>(d.z());
  const float length2 = (ball.dx * ball.dx + ball.dy * ball.dy) + ball.dz * ball.dz;
  // A segment too short for its inverse to be finite is a dab.
  const float inverse = length2 > 0 ? 1.0f / length2 : 0.0f;
  ball.inverseLength2 = std::isfinite(inverse) ? inverse : 0.0f;
  ball.radius = static_cast<float>(s.radius);
  return ball;
}

void check(const Stamp& s) {
  if (!s.a.allFinite() || !s.b.allFinite() || !std::isfinite(s.radius) || !std::isfinite(s.strength))
    throw Error("stamp with a number that is not finite");
  if (s.radius < kMinRadius || s.radius > kMaxRadius)
    throw Error(fmt::format("brush radius of {} voxels: give one from {} to {} voxels", s.radius, kMinRadius, kMaxRadius));
  if (s.a.cwiseAbs().maxCoeff() > kReachVoxels || s.b.cwiseAbs().maxCoeff() > kReachVoxels)
    throw Error("stamp out of the clay's reach: move the tool nearer to the model");
  if (s.strength < 0 || s.strength > 1) throw Error(fmt::format("brush strength {}: give one from 0 to 1", s.strength));
}

}  // namespace

struct BrushStroke::State {
  explicit State(Version base) : editor(std::in_place, std::move(base)) {}

  std::optional<Editor> editor;
  Editor::Counts before;  // of the editors that were published
  uint64_t stamps = 0, touched = 0;

  // Redistancing: when a brick was last within the band of a stamp, in the order of stamps.
  std::unordered_map<Coord, uint64_t, CoordHash> lastTouch;  // kDone once it was redistanced
  std::deque<std::pair<uint64_t, std::vector<Coord>>> influencedBy;
  std::vector<Coord> due;

  void carveOrAdd(const Stamp& s, std::vector<Coord>& influenced);
  void smooth(const Stamp& s, std::vector<Coord>& influenced);
  void trail(uint64_t upTo);
  void redistanceDue();

  // Visits the bricks around a stamp, region by region, so that consecutive ones share a node. `enter` is asked first, with the
  // region's first brick and the distance of its middle to the segment.
  template <class Enter, class Visit>
  void forBricks(const Stamp& s, double margin, const Enter& enter, const Visit& visit) {
    const Vec3d low = s.a.cwiseMin(s.b) - Vec3d::Constant(margin), high = s.a.cwiseMax(s.b) + Vec3d::Constant(margin);
    Coord first, last;
    first = {static_cast<int32_t>(std::floor(low.x() / 8)), static_cast<int32_t>(std::floor(low.y() / 8)), static_cast<int32_t>(std::floor(low.z() / 8))};
    last = {static_cast<int32_t>(std::floor(high.x() / 8)), static_cast<int32_t>(std::floor(high.y() / 8)), static_cast<int32_t>(std::floor(high.z() / 8))};
    for (int rx = first.x >> 3; rx <= last.x >> 3; ++rx)
      for (int ry = first.y >> 3; ry <= last.y >> 3; ++ry)
        for (int rz = first.z >> 3; rz <= last.z >> 3; ++rz) {
          const Coord region = Coord{rx, ry, rz} * 8;
          if (!enter(region, segmentDistance(s, (region * kBrickEdge).toVec3d() + Vec3d::Constant(31.5)))) continue;
          for (int x = std::max(first.x, region.x); x <= std::min(last.x, region.x + 7); ++x)
            for (int y = std::max(first.y, region.y); y <= std::min(last.y, region.y + 7); ++y)
              for (int z = std::max(first.z, region.z); z <= std::min(last.z, region.z + 7); ++z) visit(Coord{x, y, z});
        }
  }
};

void BrushStroke::State::carveOrAdd(const Stamp& s, std::vector<Coord>& influenced) {
  const double band = editor->grid().band;
  const bool carving = s.operation == Operation::carve;
  const Tile result = carving ? Tile::outside : Tile::inside;
  float flat[kBrickVoxels];
  std::optional<Tile> flatTile;
  const auto enter = [&](Coord region, double middle) {
    if (middle - kRegionHalfDiagonal - s.radius >= band) return false;
    if (middle + kRegionHalfDiagonal - s.radius > -band) return true;
    touched += editor->setBlock(region, 1, result);
    return false;
  };
  forBricks(s, s.radius + band, enter, [&](Coord coord) {
    const double centre = segmentDistance(s, (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5));
    if (centre - kHalfDiagonal - s.radius >= band) return;
    const Slot slot = editor->find(coord);
    if (centre + kHalfDiagonal - s.radius <= -band) {
      if (slot != Slot(result)) {
        ++touched;
        editor->setTile(coord, result);
      }
      return;
    }
    if (slot == Slot(result)) return;
    ++touched;
    const float* source = nullptr;
    if (slot.isTile()) {
      if (flatTile != slot.tile()) {
        std::fill(std::begin(flat), std::end(flat), slot.phi(0, editor->grid().band));
        flatTile = slot.tile();
      }
      source = flat;
    } else {
      source = slot.brick()->phi;
    }
    Brick* mine = slot.isTile() ? nullptr : editor->own(coord);
    Brick* target = mine ? mine : editor->newBrick(coord);
    const SweptBall ball = relativeTo(s, coord);
    const BrickChange change = carving ? carveBrick(ball, editor->grid().band, source, *target) : addBrick(ball, editor->grid().band, source, *target);
    if (!change.changed) {
      if (!mine) editor->recycle(target);
    } else {
      editor->link(target, change.inBand);
    }
    if (!editor->find(coord).isTile()) influenced.push_back(coord);
  });
}

void BrushStroke::State::smooth(const Stamp& s, std::vector<Coord>& influenced) {
  struct Result {
    Brick* brick;
    bool inBand;
  };
  std::vector<Result> results;
  float padded[kPaddedSize];
  std::fill(std::begin(padded), std::end(padded), 0.0f);
  const auto enter = [&](Coord, double middle) { return middle - kRegionHalfDiagonal < s.radius; };
  forBricks(s, s.radius, enter, [&](Coord coord) {
    const double centre = segmentDistance(s, (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5));
    if (centre - kHalfDiagonal >= s.radius) return;
    if (editor->find(coord).isTile()) return;
    ++touched;
    gatherPadded(*editor, coord, padded);
    Brick* brick = editor->newBrick(coord);
    const BrickChange change = smoothBrick(relativeTo(s, coord), editor->grid().band, s.strength, padded, *brick);
    if (change.changed)
      results.push_back({brick, change.inBand});
    else
      editor->recycle(brick);
  });
  // Linked once all have been computed: every brick smooths the field as it was before the stamp.
  for (const Result& r : results) {
    const Coord coord = r.brick->coord;
    editor->link(r.brick, r.inBand);
    for (int i = 0; i < 27; ++i) {
      // The surface may have come nearer to a neighbour that is a tile yet: redistancing makes the brick if so.
      const Coord near = coord + Coord{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
      influenced.push_back(near);
    }
  }
  std::sort(influenced.begin(), influenced.end());
  influenced.erase(std::unique(influenced.begin(), influenced.end()), influenced.end());
}

void BrushStroke::State::redistanceDue() {
  if (due.empty()) return;
  // Neighbours that were redistanced before are solved again: they met values of these that were only a bound. Those that
  // still trail need not be, for they will be solved against what is solved now.
  std::vector<Coord> all;
  all.reserve(due.size() * 4);
  for (const Coord c : due) lastTouch[c] = kDone;
  for (const Coord c : due)
    for (int i = 0; i < 27; ++i) {
      const Coord near = c + Coord{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
      const auto it = lastTouch.find(near);
      if (it != lastTouch.end() && it->second == kDone) all.push_back(near);
    }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  redistance(*editor, all);
  due.clear();
}

void BrushStroke::State::trail(uint64_t upTo) {
  while (!influencedBy.empty() && influencedBy.front().first <= upTo) {
    for (const Coord c : influencedBy.front().second)
      if (lastTouch[c] == influencedBy.front().first) due.push_back(c);
    influencedBy.pop_front();
  }
}

BrushStroke::BrushStroke(Version base) : state_(std::make_unique<State>(std::move(base))) {}
BrushStroke::~BrushStroke() = default;

void BrushStroke::apply(const Stamp& stamp) {
  check(stamp);
  State& s = *state_;
  std::vector<Coord> influenced;
  if (stamp.operation == Operation::smooth)
    s.smooth(stamp, influenced);
  else
    s.carveOrAdd(stamp, influenced);
  const uint64_t number = ++s.stamps;
  for (const Coord c : influenced) s.lastTouch[c] = number;
  s.influencedBy.emplace_back(number, std::move(influenced));
  if (number > kTrail) s.trail(number - kTrail);
  if (s.due.size() >= kBatch) s.redistanceDue();
}

Version BrushStroke::publish() {
  State& s = *state_;
  s.before = counts();
  Version version = s.editor->commit();
  s.editor.emplace(version);
  return version;
}

Version BrushStroke::finish() {
  State& s = *state_;
  s.trail(s.stamps);
  s.redistanceDue();
  return publish();
}

uint64_t BrushStroke::touched() const { return state_->touched; }

Editor::Counts BrushStroke::counts() const {
  const Editor::Counts now = state_->editor->counts();
  return {state_->before.bricksMade + now.bricksMade, state_->before.nodesMade + now.nodesMade};
}

}  // namespace argil::clay
