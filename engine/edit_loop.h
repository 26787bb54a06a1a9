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

/// One turn at a time: takes the samples that wait, publishes at most one version with its scene, brings the surface up to
/// it. Virtual time calls turn() between ticks; in real time an EditThread does. One thread.
class EditLoop {
 public:
  struct Options {
    int surfaceThreads = 1;
    /// What a renderer needs; called in the editing thread.
    std::function<void(const clay::SurfaceDelta&)> onSurface;
    /// Called with every sample before it is used: the place to change tools, to record or to count.
    std::function<void(const haptics::StylusSample&)> onSample;
    /// Gets, for each turn that changed clay, the time from the oldest sample that cut to the changed triangles being ready.
    /// Paced: counted from the sample's own time (less than a tick too short: the servo's zero is learnt from the earliest
    /// sample seen); else from the beginning of the turn.
    haptics::Histogram* latency = nullptr;
    bool paced = false;
  };
  using Publish = std::function<void(std::unique_ptr<const haptics::Scene>)>;

  /// `scene` says what besides the clay the servo reads; its pieces are replaced by the session's clay. `publish` gets
  /// every new scene. All that is referred to must outlive it.
  EditLoop(Session& session, clay::Surface& surface, haptics::Scene scene, Publish publish, Options options);

  /// The tool that the servo is to hold from the next scene on, with its way of working on the clay: the stroke in work
  /// ends with the first sample that carries another tool. Throws Error when it does not fit the clay.
  void setTool(const Tool& tool);

  /// Takes all that waits in the ring. True when something was published. Publishes only when there is something new.
  bool turn(haptics::SampleRing& ring);
  /// Ends the stroke in work and publishes what it left.
  void finish();

  /// The servo was started (again): its times relate anew to the clock.
  void restartClock() { zeroNs_ = INT64_MAX; }
  [[nodiscard]] uint64_t versions() const { return versions_; }
  [[nodiscard]] const StylusStrokes& strokes() const { return strokes_; }

 private:
  bool publish(uint64_t oldest);  // `oldest`: sample of this turn that cuts.

  Session& session_;
  clay::Surface& surface_;
  haptics::Scene scene_;
  Publish publish_;
  Options options_;
  StylusStrokes strokes_;
  std::vector<haptics::StylusSample> batch_;
  int64_t zeroNs_ = INT64_MAX;  // of CLOCK_MONOTONIC at sample time zero, as far as known
  uint64_t versions_ = 0;
  uint64_t cutsBefore_ = 0;  // index after the newest sample that cut
  bool toolChanged_ = true;
};

/// Turns an EditLoop at 500 Hz. What a turn throws ends the thread and comes out of stop().
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
