#pragma once
// Hand-driven strokes of a script: simulated hand and device, servo, edits. For runScript.

#include <memory>
#include <vector>

#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/session/edit_loop.h"
#include "engine/session/run.h"
#include "engine/text/lay.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo.h"
#include "haptics/threads/bare_loop.h"
#include "haptics/threads/published.h"

namespace argil::engine {

/// One simulated hand that walks through all hand-driven strokes it was given, in as many parts as wanted. One thread.
class HandRun {
 public:
  /// `strokes` in order, each with a point at least. Throws Error for a tool that does not fit or an unknown device.
  /// `script`: whose material and guides are felt.
  HandRun(Session& session, clay::Surface& surface, const std::vector<LaidStroke>& strokes, const Script& script,
          const RunOptions& options, haptics::Histogram& latency);

  /// Walks through the next `count` strokes, in real or in virtual time, while the job's fraction goes from one value
  /// to the other. Throws Error, Cancelled.
  void walk(size_t count, double fromFraction, double toFraction);

  /// Of several, in order, together; of one at least.
  [[nodiscard]] static ServoReport report(const std::vector<std::unique_ptr<HandRun>>& runs);
  [[nodiscard]] uint64_t versions() const { return loop_.versions(); }

 private:
  struct Part {
    Tool tool;
    double changeS = 0;  // from here on the hand is on its way to this stroke, button released
    double endS = 0;     // its button is released for good
  };
  struct Plan {
    std::vector<Part> parts;
    haptics::Workspace workspace;
    haptics::HandPath path;
  };
  static Plan plan(const std::vector<LaidStroke>& strokes, const haptics::DeviceSheet& sheet);
  static haptics::Scene firstScene(const Session& session, const Plan& plan, const Script& script);
  EditLoop::Options loopOptions(haptics::Histogram& latency);

  void walkVirtual();
  void walkLive();
  void progress(double timeS);
  void changeTool(double timeS);

  const RunOptions& options_;
  clay::Surface& surface_;
  Plan plan_;
  size_t done_ = 0, tool_ = 0;  // parts walked; parts whose tool was taken up
  haptics::Published<haptics::Scene> scene_;
  haptics::SimulatedDevice device_;
  haptics::Servo servo_;
  haptics::BareLoop bare_;
  // virtual time: with the tick that sees it
  std::vector<std::pair<uint64_t, std::unique_ptr<const haptics::Scene>>> coming_;
  uint64_t tick_ = 0;
  double fromS_ = 0, untilS_ = 0, fromFraction_ = 0, toFraction_ = 0;  // of this walk
  std::string grant_;
  EditLoop loop_;
};

}  // namespace argil::engine
