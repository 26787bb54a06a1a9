#pragma once
// The writer of the clay: samples in, versions, scenes and changed surface out.

#include <functional>
#include <memory>
#include <thread>

#include "clay/surface.h"
#include "engine/session.h"
#include "engine/stylus_strokes.h"
#include "haptics/histogram.h"
#include "haptics/scene.h"

namespace argil::engine {

/// One turn at a time: takes the samples that wait, publishes at most one document with its scene, then hands it on. Virtual time calls turn() between ticks; in real time an EditThread does. One thread.
class EditLoop {
 public:
  struct Options {
    /// Gets every new document, after the servo: the place to bring surfaces up to it. Called in the editing thread. `oldestNs`: time on
    /// CLOCK_MONOTONIC of the oldest sample whose cut it shows for the first time; 0: none.
    std::function<void(const DocumentPtr& document, int64_t oldestNs)> onDocument;
    /// Called with every sample before it is used: the place to change tools, to record or to count.
    std::function<void(const haptics::StylusSample&)> onSample;
    /// Gets, for each turn that changed clay, the time from the oldest sample that cut to the changed triangles being ready.
    /// Paced: counted from the sample's own time (less than a tick too short: the servo's zero is learnt from the earliest
    /// sample seen); else from the beginning of the turn.
    haptics::Histogram* latency = nullptr;
    bool paced = false;
  };
  using Publish = std::function<void(std::unique_ptr<const haptics::Scene>)>;

  /// `scene` says what besides the document the servo reads (see sceneOf). `publish` gets every new scene. All that is referred to
  /// must outlive it.
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

  /// Takes all that waits in the ring. True when something was published. Publishes only when there is something new.
  bool turn(haptics::SampleRing& ring);
  /// Ends the stroke in work and publishes what it left.
  void finish();

  /// The servo was started (again): its times relate anew to the clock.
  void restartClock() { zeroNs_ = INT64_MAX; }
  [[nodiscard]] uint64_t versions() const { return versions_; }
  [[nodiscard]] const StylusStrokes& strokes() const { return strokes_; }

 private:
  bool publish(uint64_t oldest, int64_t oldestNs);  // `oldest`: sample of this turn that cuts.

  Session& session_;
  haptics::Scene scene_;        // all but the document
  DocumentPtr shown_;           // of the last scene; null before the first
  Publish publish_;
  Options options_;
  StylusStrokes strokes_;
  std::vector<haptics::StylusSample> batch_;
  int64_t zeroNs_ = INT64_MAX;  // of CLOCK_MONOTONIC at sample time zero, as far as known
  uint64_t versions_ = 0;
  uint64_t cutsBefore_ = 0;  // index after the newest sample that cut
  bool cutting_ = true;
  bool changed_ = true;           // tool, workspace or quality
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
