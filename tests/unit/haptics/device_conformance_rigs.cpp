// The drivers that the conformance suite runs, each against its emulator.

#include "../../support/haply_emulator.h"
#include "device_conformance.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"

namespace argil::haptics::testing {
namespace {

class SimulatedRig final : public DeviceRig {
 public:
  Traits traits() const override { return {.resolutionMm = 0.1}; }
  std::unique_ptr<Device> open() override {
    SimulatedDevice::Options options;
    options.prescribed = true;
    return std::make_unique<SimulatedDevice>(deviceSheet("touch"), HandPath::hold(place(), 10), options);
  }
  void hand(const Vec3d&, uint32_t) override {}
  Vec3d place() const override { return {1, 2, 3}; }
};

class HaplyRig final : public DeviceRig {
 public:
  explicit HaplyRig(bool grip) {
    arm_.plug();
    if (grip) grip_.plug();
    options_.port = arm_.path();
    if (grip) options_.grip = grip_.path();
  }
  Traits traits() const override { return {.force = true, .cable = true, .follows = true}; }
  std::unique_ptr<Device> open() override { return openHaply(options_); }
  void hand(const Vec3d& positionMm, uint32_t buttons) override {
    arm_.hand(positionMm, buttons);
    grip_.hand(positionMm, buttons);
  }
  Vec3d forceN() const override { return arm_.forceN(); }
  double peakN() const override { return arm_.peakN(); }
  bool misbehave(Misbehaviour what) override {
    arm_.misbehave(what);
    return true;
  }
  void unplug() override { arm_.unplug(); }
  void replug() override { arm_.plug(); }

 private:
  HaplyOptions options_;
  HaplyArmEmulator arm_{HaplyOptions().centreMm};
  HaplyGripEmulator grip_;
};

template <class Rig, class... Arguments>
RigMaker maker(const char* name, Arguments... arguments) {
  return {name, [arguments...] { return std::make_unique<Rig>(arguments...); }};
}

}  // namespace

std::vector<RigMaker> deviceRigs() {
  return {
      maker<SimulatedRig>("simulated"),
      maker<HaplyRig>("haply", false),
      maker<HaplyRig>("haplyWithGrip", true),
  };
}

}  // namespace argil::haptics::testing
