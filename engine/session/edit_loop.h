#pragma once
// The writer of the clay: samples in, versions, scenes and changed surface out.

#include <deque>
#include <functional>
#include <memory>
#include <thread>

#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/session/stylus_strokes.h"
#include "engine/session/turn_time.h"
#include "engine/tools/felt_pieces.h"
#include "haptics/base/histogram.h"
#include "haptics/scene/scene.h"

namespace argil::engine {

/// One turn at a time: takes the samples that wait, works on them until its budget is spent, publishes at most one
/// document with its scene, then hands it on. What it did not get to waits for the next turn, so a tool that is slower
/// than the hand is seen at work and whatever else is asked is answered between two turns. Virtual time calls turn()
/// between ticks; in real time an EditThread does. One thread. NOTES.md, "From samples to strokes".
class EditLoop {
 public:
  struct Options {
    /// Gets every new document, after the servo: the place to bring surfaces up to it. Called in the editing thread.
    /// `oldestNs`: time on CLOCK_MONOTONIC of the oldest sample whose cut it shows for the first time; 0: none.
    std::function<void(const DocumentPtr& document, int64_t oldestNs)> onDocument;
    /// Called with every sample, when it is taken from the ring: the place to change tools, to record or to count.
    std::function<void(const haptics::StylusSample&)> onSample;
    /// Gets, for each turn that changed clay, the time from the oldest sample that cut to the changed triangles being
    /// ready. Paced: counted from the sample's own time (less than a tick too short: the servo's zero is learnt from
    /// the earliest sample seen); else from the beginning of the turn.
    haptics::Histogram* latency = nullptr;
    bool paced = false;
    /// A turn begins no more steps of stamps after so long (kTurnBudgetNs in front of a user; TurnTime); 0: it works
    /// off all that waits, so that what is published does not depend on the clock. One step, and extracting what
    /// changed, comes on top.
    int64_t budgetNs = 0;
    /// The same by counting, for repeatable overload; 0: off.
    int budgetStamps = 0;
  };
  static constexpr int64_t kTurnBudgetNs = 8'000'000;
  /// From so far behind the hand on, samples that are nearer to each other than the clay can tell become one.
  static constexpr double kCoalesceS = 1;
  using Publish = std::function<void(std::unique_ptr<const haptics::Scene>)>;

  /// `scene` says what besides the document the servo reads (see sceneOf). `publish` gets every new scene. All that is
  /// referred to must outlive it.
  EditLoop(Session& session, haptics::Scene scene, Publish publish, Options options);

  /// The tool that the servo is to hold from the next scene on, with its way of working on the clay: the stroke in work
  /// ends with the first sample that carries another tool. Throws Error when it does not fit the clay.
  void setTool(const Tool& tool);
  /// While false the tool only touches: the hand holds something else than clay.
  void setCutting(bool on);
  /// As StylusStrokes has it.
  void setOriented(bool on) { strokes_.setOriented(on); }
  /// Workspace and quality that the servo is to have from the next scene on. Throws Error for what haptics refuses.
  void setWorkspace(const haptics::Workspace& workspace);
  void setQuality(const haptics::Quality& quality);

  /// Guides beside those of the document, felt before them, from the next scene on. Throws Error for what haptics
  /// refuses.
  void setGuides(std::vector<haptics::Guide> guides);

  /// Takes all that waits in the ring and works on it. True when something was published. Publishes only when there is
  /// something new.
  bool turn(haptics::SampleRing& ring);
  /// Takes what waits in the ring, so that it does not overflow; turn() does so itself.
  void gather(haptics::SampleRing& ring);
  /// Works off all that was taken however long it lasts, ends the stroke in work and publishes what it left.
  void finish();
  /// What waits is left out: the stroke in work ends where the clay is. Bounded: a few stamps. Returns how many seconds
  /// of a hand that was cutting were left out, 0 for none. A button that is down cuts again when it has been released.
  /// Throws what ended no stroke (no memory): then that is left out whole.
  double cutShort();

  /// How far the clay is behind the hand: seconds from the sample in work to the newest that was taken.
  [[nodiscard]] double behindS() const;
  /// So many seconds of a hand that cuts are not in the clay yet.
  [[nodiscard]] double leftS() const;
  /// Samples or stamps wait for the next turn.
  [[nodiscard]] bool behind() const { return !waiting_.empty() || strokes_.more(); }
  /// How many samples wait: coalescing bounds them where the hand's path allows it.
  [[nodiscard]] size_t waiting() const { return waiting_.size(); }
  /// Samples that are worked on as one with others, because the tool could not keep up.
  [[nodiscard]] uint64_t coalesced() const { return coalesced_; }
  /// Samples that the ring had no room for: nobody took them for all the seconds that it holds.
  [[nodiscard]] uint64_t lost() const { return lost_; }

  /// The servo was started (again): its times relate anew to the clock.
  void restartClock() { zeroNs_ = INT64_MAX; }
  [[nodiscard]] uint64_t versions() const { return versions_; }
  /// Pieces of the newest document that are visible; of more than haptics::kMaxPieces the hand feels those nearest to
  /// it.
  [[nodiscard]] size_t visiblePieces() const { return felt_.visible(); }
  [[nodiscard]] const StylusStrokes& strokes() const { return strokes_; }

 private:
  struct Waiting {
    haptics::StylusSample sample;
    bool joined = false;  // those between it and the one before became part of it
  };
  bool publish(uint64_t oldest, int64_t oldestNs);  // `oldest`: sample of this turn that cuts.
  bool lookAhead();
  void coalesce();

  Session& session_;
  haptics::Scene scene_;  // all but the document
  FeltPieces felt_;
  Vec3d handMm_ = Vec3d::Zero();              // where the newest sample has it
  DocumentPtr shown_;                         // of the last scene; null before the first
  std::vector<haptics::KeepOutPlane> walls_;  // that the tool must leave, of the last scene
  Publish publish_;
  Options options_;
  StylusStrokes strokes_;
  TurnTime time_;
  std::vector<haptics::StylusSample> batch_;
  std::deque<Waiting> waiting_;
  haptics::StylusSample inWork_;  // while strokes_.more()
  bool late_ = false;             // the last turn ended before all was done
  size_t coalesceAt_ = 0;         // as many waiting samples call for coalescing
  double newestCutS_ = 0;         // of the samples that were taken
  double coalesceBy_ = 1;         // times what the clay can tell
  uint64_t coalesced_ = 0, lost_ = 0, lostBefore_ = UINT64_MAX;
  int64_t zeroNs_ = INT64_MAX;  // of CLOCK_MONOTONIC at sample time zero, as far as known
  uint64_t versions_ = 0;
  uint64_t cutsBefore_ = 0;  // index after the newest sample that cut
  bool cutting_ = true;
  bool changed_ = true;  // tool, workspace or quality
};

/// Turns an EditLoop 500 times a second. What a turn throws ends the thread and comes out of stop().
class EditThread {
 public:
  EditThread(EditLoop& loop, haptics::SampleRing& ring);
  ~EditThread();
  EditThread(const EditThread&) = delete;
  EditThread& operator=(const EditThread&) = delete;

  /// Takes what is left, ends the stroke in work, waits. Rethrows what went wrong. Idempotent.
  void stop();
  [[nodiscard]] bool failed() const { return failed_.load(); }

 private:
  void run(EditLoop& loop, haptics::SampleRing& ring);
  std::atomic<bool> stop_{false}, failed_{false};
  std::exception_ptr failure_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace argil::engine
