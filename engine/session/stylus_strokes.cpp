#include "engine/session/stylus_strokes.h"

#include <algorithm>
#include <cmath>

#include "engine/tools/stroke_path.h"

namespace argil::engine {
namespace {

// A light press cuts on and off from tick to tick. Breaks shorter than this in both senses are not a lifted tool: the
// sweep across them stays within what the ball has just cut.
constexpr double kPauseS = 0.020;
constexpr double kPauseRadii = 0.25;

// A piece of the way to a sample is at most this long, in radii or voxels, whichever is more: two stamps of a large
// tool, twenty of the smallest. A hand that is sampled a thousand times a second makes no such way; a mouse that jumps
// does.
constexpr double kPieceRadii = 0.2, kPieceVoxels = 10;
// Half of what lies between two stamps.
constexpr double kSamePlaceRadii = 0.05;

constexpr uint32_t kToolsKept = 1000;

constexpr uint32_t kCutButtons = 1;  // as haptics::Tool::buttons has it

}  // namespace

void StylusStrokes::setTool(uint32_t id, const Tool& tool) {
  if (const DocumentPtr now = session_.document(); const Piece* piece = now->workedOn())
    (void)StrokePath(piece->version.grid(), tool);
  // Samples in flight may still carry older ones, but not from so long ago.
  std::erase_if(tools_, [&](const auto& each) { return each.first + kToolsKept < id; });
  tools_[id] = tool;
}

void StylusStrokes::begin(const haptics::StylusSample& sample, bool joined) {
  while (more()) step();
  next_ = sample.index + 1;
  const bool pressed = (sample.buttons & kCutButtons) != 0;
  if (session_.inStroke() && (!pressed || sample.tool != tool_)) finish();
  waitsForRelease_ = waitsForRelease_ && pressed;
  if (waitsForRelease_) return;
  if (sample.flags & haptics::kCutting) {
    if (!session_.inStroke()) {
      const DocumentPtr now = session_.document();
      const Piece* piece = now->workedOn();
      if (!piece) {
        ++refused_;
        return;
      }
      grid_ = piece->version.grid();
      pose_ = piece->pose;
    }
    const Vec3d mm = pose_.applyInverse(sample.cutPoint);
    if (tools_.count(sample.tool) && StrokePath::reaches(grid_, mm)) {
      cut(sample, mm, joined);
    } else {
      ++refused_;
    }
  } else if (session_.inStroke() && !lifted_ && sample.timeS - lastTimeS_ > kPauseS) {
    session_.liftTool();
    lifted_ = true;
  }
  forgetCovered();
}

void StylusStrokes::step() {
  if (!session_.applyStamp() && wayDone_ < wayPieces_) {
    const PathPoint point = wayPoint(++wayDone_);
    session_.queuePoint(point);
    pending_.push_back(lastIndex_);
    lifted_ = false;
    // Most points of a slow hand have no stamp of their own.
    (void)session_.applyStamp();
  }
  forgetCovered();
}

void StylusStrokes::cut(const haptics::StylusSample& sample, const Vec3d& mm, bool joined) {
  const Tool& tool = tools_.at(sample.tool);
  if (!session_.inStroke()) {
    session_.beginStroke(tool);
    tool_ = sample.tool;
    shown_ = 0;
    lifted_ = true;
  }
  const bool paused = !joined && sample.index != lastIndex_ + 1;
  if (!lifted_ && paused &&
      (sample.timeS - lastTimeS_ > kPauseS || (mm - to_.mm).norm() > kPauseRadii * tool.radiusMm)) {
    session_.liftTool();
    lifted_ = true;
  }
  PathPoint point{sample.timeS, mm};
  // A pen or a device without pressure says none at all times: then it is full.
  point.pressure = tool.pressureIsForce ? std::min(sample.forceN.norm() / tool.fullForceN, 1.0)
                                        : std::clamp(double(sample.pressure), 0.0, 1.0);
  if (oriented_) point.rotation = pose_.rotation.conjugate() * sample.device.rotation;
  wayPieces_ = 1;
  wayDone_ = 0;
  if (!lifted_) {
    from_ = to_;
    const double piece = std::max(kPieceRadii * tool.radiusMm, kPieceVoxels * grid_.voxelMm);
    wayPieces_ = static_cast<uint64_t>(std::max(1.0, std::ceil((mm - from_.mm).norm() / piece)));
  }
  to_ = point;
  lastIndex_ = sample.index;
  lastTimeS_ = sample.timeS;
}

// Add, multiply, divide and square root alone: strokes have equal bits everywhere.
PathPoint StylusStrokes::wayPoint(uint64_t piece) const {
  if (piece == wayPieces_) return to_;
  const double share = double(piece) / double(wayPieces_);
  PathPoint point = to_;
  point.timeS = from_.timeS + share * (to_.timeS - from_.timeS);
  point.mm = from_.mm + share * (to_.mm - from_.mm);
  point.pressure = from_.pressure + share * (to_.pressure - from_.pressure);
  if (from_.rotation && to_.rotation) {
    const double side = from_.rotation->dot(*to_.rotation) < 0 ? -1 : 1;
    const Eigen::Vector4d between =
        from_.rotation->coeffs() + share * (side * to_.rotation->coeffs() - from_.rotation->coeffs());
    if (between.norm() > 1e-6) point.rotation = Eigen::Quaterniond(between).normalized();
  }
  return point;
}

std::vector<haptics::KeepOutPlane> StylusStrokes::wallsAhead() {
  std::vector<haptics::KeepOutPlane> planes;
  if (!session_.inStroke() || lifted_) return planes;
  const auto tool = tools_.find(tool_);
  if (tool == tools_.end()) return planes;
  const double radius = tool->second.radiusMm;
  for (const clay::WallAhead& each : session_.wallsAhead()) {
    const Vec3d wall = pose_.rotation * each.wall;
    planes.push_back({pose_.apply(grid_.toWorld(each.place)) + radius * wall, -wall});
  }
  return planes;
}

double StylusStrokes::samePlaceMm(uint32_t tool) const {
  const auto found = tools_.find(tool);
  return found == tools_.end() ? 0 : kSamePlaceRadii * found->second.radiusMm;
}

void StylusStrokes::forgetCovered() {
  for (const uint64_t covered = session_.coveredPoints(); shown_ < covered && !pending_.empty(); ++shown_)
    pending_.pop_front();
}

void StylusStrokes::finish() {
  while (more()) step();
  if (!session_.inStroke()) return;
  session_.endStroke();
  pending_.clear();
}

void StylusStrokes::cutShort(bool held) {
  wayPieces_ = wayDone_ = 0;
  waitsForRelease_ = held;
  pending_.clear();
  if (!session_.inStroke()) return;
  try {
    session_.endStroke();
  } catch (...) {
    session_.abandonStroke();
    throw;
  }
}

}  // namespace argil::engine
