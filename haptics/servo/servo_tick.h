#pragma once
// One turn of the servo: device in, contact, safety, device out.

#include <array>
#include <cstdint>

#include "haptics/base/device.h"
#include "haptics/base/tick_clock.h"
#include "haptics/contact/contact.h"
#include "haptics/contact/coupling.h"
#include "haptics/scene/scene.h"
#include "haptics/servo/heat_budget.h"
#include "haptics/servo/passivity.h"
#include "haptics/servo/safety.h"
#include "haptics/servo/velocity_filter.h"
#include "haptics/threads/latest_value.h"
#include "haptics/threads/published.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {

/// What the hand did in a tick to what it touched, as far as the device was really told to push back.
struct Reactions {
  std::array<Reaction, kMaxReactions> all{};
  int count = 0;
  uint64_t index = 0;  ///< StylusSample::index.
};

/// The same code in real and in virtual time. All its memory is its own; made and destroyed off the servo's thread.
class ServoTick {
 public:
  /// All three references must outlive it. `periodS`: 1/8000 to 1/100 s. `contact`: one of contactNames().
  ServoTick(Device& device, Published<Scene>& scene, SampleRing& samples, double periodS,
            std::string_view contact = "proxy");

  /// Runs one tick that begins at servo time `timeS`; TickFlag bits of what happened. `late`: it began a whole period
  /// late. All that follows time (velocities, heat, energy, limits of speed and slew, what glides) goes by the time
  /// since the last tick, however many ticks that should have been. After a gap (TickClock::Step::gap) forces begin
  /// anew from zero, speeds are forgotten, and the scene goes on as if one period had passed; only the motors have
  /// cooled for the whole of it.
  uint32_t run(double timeS, bool late) ARGIL_REALTIME;
  /// The servo stops: zero force, the scene is let go.
  void park(double timeS) ARGIL_REALTIME;
  /// Begins anew after park(): the proxy at the hand, no fault, forces from zero. The workspace stays where it was
  /// panned to, and the motors as warm as they are.
  void reset() noexcept;

  /// Instead of what coupleTo() gives for the device's delay as it is measured, to measure stability; `controlled`:
  /// with passivity control, which knows of `delayS` from command to motor. Not while the servo runs.
  void couple(const Coupling& coupling, bool controlled, double delayS = 0);
  [[nodiscard]] const Coupling& coupling() const noexcept { return coupling_; }
  [[nodiscard]] const Passivity& passivity() const noexcept { return passivity_; }

  [[nodiscard]] const StylusSample& last() const noexcept { return sample_; }
  [[nodiscard]] Safety& safety() noexcept { return safety_; }
  [[nodiscard]] const Safety& safety() const noexcept { return safety_; }
  [[nodiscard]] const HeatBudget& heat() const noexcept { return heat_; }
  [[nodiscard]] HeatBudget& heat() noexcept { return heat_; }  ///< Not while the servo runs.
  /// The mapping as it stands; to reset() it (the tip jumps home) the servo must not run.
  [[nodiscard]] WorkspaceMap& workspace() noexcept { return workspace_; }
  /// In the last tick clay was read for the first time that samples had changed: how many ticks ago the oldest of them
  /// was (Scene::editedFrom); else 0.
  [[nodiscard]] uint64_t feltAfterTicks() const noexcept { return feltAfter_; }
  /// The newest sample, for a cursor: one reader.
  [[nodiscard]] LatestValue<StylusSample>& latest() noexcept { return latest_; }
  /// The newest reactions, for whoever moves pieces or parts: one reader.
  [[nodiscard]] LatestValue<Reactions>& reactions() noexcept { return reactions_; }

 private:
  void followDelay() ARGIL_REALTIME;

  Device& device_;
  Published<Scene>::Reader scene_;
  SampleRing& samples_;
  LatestValue<StylusSample> latest_;
  LatestValue<Reactions> reactions_;
  std::unique_ptr<Contact> contact_;
  WorkspaceMap workspace_;
  HeatBudget heat_;
  Safety safety_;
  void heatUp(const TickClock::Step& step) ARGIL_REALTIME;

  double periodS_;
  TickClock ticked_, measured_;  // From tick to tick; from position to position.
  ForceGate::Word gate_ = 0;     // The device's, in the last tick.
  Vec3d held_ = Vec3d::Zero();   // The last command, device frame.
  VelocityFilter velocity_;
  Coupling coupling_;
  Passivity passivity_;
  bool controlled_ = true;
  bool follows_ = true;  // The coupling follows the device's delay.
  double delayS_ = 0;
  DeviceState state_;
  StylusSample sample_;
  uint64_t index_ = 0;
  uint64_t editedFrom_ = UINT64_MAX, feltAfter_ = 0;
};

}  // namespace argil::haptics
