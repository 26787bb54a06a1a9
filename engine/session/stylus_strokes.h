#pragma once
// From the samples of a stylus to strokes of a session.

#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <vector>

#include "engine/saving/session.h"
#include "engine/tools/path_point.h"
#include "haptics/base/pose.h"
#include "haptics/scene/guide.h"
#include "haptics/threads/sample_ring.h"

namespace argil::engine {

/// Reads samples in order and edits the session: clay is cut exactly at the servo's cut points. A stroke begins with
/// the first sample that cuts and ends when its button is released or its tool changes; where cutting pauses the tool
/// is lifted, unless it goes on at once and nearby. What happens depends on the samples alone, not on how many come at
/// a time nor on how their work is parted. A sample far from the one before is reached in straight pieces, so that no
/// piece has more than a few stamps of a large tool. The edit thread's; it touches the session between take() and
/// finish() as well as its owner does.
class StylusStrokes {
 public:
  /// The session must outlive it.
  explicit StylusStrokes(Session& session) : session_(session) {}

  /// Samples that carry this tool's id use this tool. Throws Error when it does not fit the clay that is worked on.
  void setTool(uint32_t id, const Tool& tool);

  /// Whether the samples' rotations are those of a hand: else tips stand on the surface.
  void setOriented(bool on) { oriented_ = on; }

  void take(const haptics::StylusSample& sample) {
    begin(sample);
    while (more()) step();
  }
  /// The same in parts, for those who may not take long at a time: reads the sample, and leaves its stamps to step().
  /// What the sample before it left is done first. `joined`: samples between this one and the one before were left out
  /// on purpose, and the path goes on.
  void begin(const haptics::StylusSample& sample, bool joined = false);
  [[nodiscard]] bool more() const { return session_.stampsWait() || wayDone_ < wayPieces_; }
  /// One stamp at most.
  void step();
  /// No more samples: does what is left and ends the stroke in work.
  void finish();
  /// Ends the stroke in work where it is: what more() tells of is left out, apart from the stamps of the last piece.
  /// Nothing is cut until a sample comes without the button, where `held` says that it is down. When the stroke cannot
  /// be ended (no memory) it is left out whole, and that is thrown.
  void cutShort(bool held);

  /// What a least wall leaves of the way of the stroke in work, as planes that the tool's ball may not pass; world mm,
  /// the nearest first. They hold near the ball, until the next stamp.
  [[nodiscard]] std::vector<haptics::KeepOutPlane> wallsAhead();

  /// Samples of this tool that are nearer to each other than this, world mm, are one to the clay.
  [[nodiscard]] double samePlaceMm(uint32_t tool) const;

  /// Every sample with a smaller index is in what the session publishes next (haptics::Scene::samplesApplied).
  [[nodiscard]] uint64_t samplesApplied() const { return pending_.empty() ? next_ : pending_.front(); }
  /// Samples that should have cut and were refused: not a place in the clay's reach, or a tool that nobody set.
  [[nodiscard]] uint64_t refused() const { return refused_; }

 private:
  void cut(const haptics::StylusSample& sample, const Vec3d& mm, bool joined);
  [[nodiscard]] PathPoint wayPoint(uint64_t piece) const;
  void forgetCovered();

  Session& session_;
  std::map<uint32_t, Tool> tools_;
  uint64_t next_ = 0, refused_ = 0;
  bool oriented_ = false;
  // The stroke in work.
  clay::Grid grid_;
  haptics::Pose pose_;  // from the piece's millimetres to the world's, in which samples are
  uint32_t tool_ = 0;
  std::deque<uint64_t> pending_;  // indices of samples that the clay does not show yet
  uint64_t shown_ = 0;            // points of the stroke that it does
  bool lifted_ = true;
  bool waitsForRelease_ = false;  // the stroke was cut short while the button was down
  PathPoint from_, to_;           // the way to the sample in work, in pieces
  uint64_t wayPieces_ = 0, wayDone_ = 0;
  uint64_t lastIndex_ = 0;
  double lastTimeS_ = 0;
};

}  // namespace argil::engine
