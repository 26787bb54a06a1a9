#include "engine/stylus_strokes.h"

#include "engine/stroke_path.h"

namespace argil::engine {
namespace {

// A light press cuts on and off from tick to tick. Breaks shorter than this in both senses are not a lifted tool: the
// sweep across them stays within what the ball has just cut.
constexpr double kPauseS = 0.020;
constexpr double kPauseRadii = 0.25;

constexpr uint32_t kToolsKept = 1000;

constexpr uint32_t kCutButtons = 1;  // as haptics::Tool::buttons has it

}  // namespace

void StylusStrokes::setTool(uint32_t id, const Tool& tool) {
  if (const DocumentPtr now = session_.document(); const Piece* piece = now->workedOn()) (void)StrokePath(piece->version.grid(), tool);
  // Samples in flight may still carry older ones, but not from so long ago.
  std::erase_if(tools_, [&](const auto& each) { return each.first + kToolsKept < id; });
  tools_[id] = tool;
}

void StylusStrokes::take(const haptics::StylusSample& sample) {
  next_ = sample.index + 1;
  if (session_.inStroke() && ((sample.buttons & kCutButtons) == 0 || sample.tool != tool_)) finish();
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
      cut(sample, mm);
    } else {
      ++refused_;
    }
  } else if (session_.inStroke() && !lifted_ && sample.timeS - lastTimeS_ > kPauseS) {
    session_.liftTool();
    lifted_ = true;
  }
  forgetCovered();
}

void StylusStrokes::cut(const haptics::StylusSample& sample, const Vec3d& mm) {
  const Tool& tool = tools_.at(sample.tool);
  if (!session_.inStroke()) {
    session_.beginStroke(tool);
    tool_ = sample.tool;
    shown_ = 0;
    lifted_ = true;
  }
  const bool paused = sample.index != lastIndex_ + 1;
  if (!lifted_ && paused &&
      (sample.timeS - lastTimeS_ > kPauseS || (mm - last_).norm() > kPauseRadii * tool.radiusMm)) {
    session_.liftTool();
  }
  PathPoint point{sample.timeS, mm};
  // A pen or a device without pressure says none at all times: then it is full.
  point.pressure = tool.pressureIsForce ? std::min(sample.forceN.norm() / tool.fullForceN, 1.0) : std::clamp(double(sample.pressure), 0.0, 1.0);
  if (oriented_) point.rotation = pose_.rotation.conjugate() * sample.device.rotation;
  session_.addPoint(point);
  pending_.push_back(sample.index);
  lifted_ = false;
  lastIndex_ = sample.index;
  lastTimeS_ = sample.timeS;
  last_ = mm;
}

void StylusStrokes::forgetCovered() {
  for (const uint64_t covered = session_.coveredPoints(); shown_ < covered && !pending_.empty(); ++shown_) pending_.pop_front();
}

void StylusStrokes::finish() {
  if (!session_.inStroke()) return;
  session_.endStroke();
  pending_.clear();
}

}  // namespace argil::engine
