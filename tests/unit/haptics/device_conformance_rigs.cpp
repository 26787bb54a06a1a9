// The drivers that the conformance suite runs, each against its emulator.

#include "../../support/devices/falcon_emulator.h"
#include "../../support/devices/haply_emulator.h"
#include "../../support/devices/spacemouse_emulator.h"
#include "../../support/devices/template_emulator.h"
#include "device_conformance.h"
#include "haptics/devices/driver_template.h"
#include "haptics/devices/falcon.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/pointer.h"
#include "haptics/devices/recorded.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/devices/spacemouse.h"

namespace argil::haptics::testing {
namespace {

class SimulatedRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {.resolutionMm = 0.1};
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
  static constexpr Traits kTraits = {.force = true, .cable = true, .follows = true, .bytes = true};
  std::unique_ptr<Device> open() override { return openHaply(options_); }
  void hand(const Vec3d& positionMm, uint32_t buttons) override {
    arm_.hand(positionMm, buttons);
    grip_.hand(positionMm, buttons);
  }
  Vec3d forceN() const override { return arm_.forceN(); }
  double peakN() const override { return arm_.peakN(); }
  uint64_t told() const override { return arm_.told(); }
  Vec3d toldN(uint64_t which) const override { return arm_.toldN(which); }
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

class TemplateRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {
      .force = true, .cable = true, .follows = true, .bytes = true, .resolutionMm = 0.011};
  TemplateRig() { arm_.plug(); }
  std::unique_ptr<Device> open() override { return openTemplate({arm_.path()}); }
  void hand(const Vec3d& positionMm, uint32_t buttons) override { arm_.hand(positionMm, buttons); }
  Vec3d forceN() const override { return arm_.forceN(); }
  double peakN() const override { return arm_.peakN(); }
  uint64_t told() const override { return arm_.told(); }
  Vec3d toldN(uint64_t which) const override { return arm_.toldN(which); }
  bool misbehave(Misbehaviour what) override {
    arm_.misbehave(what);
    return true;
  }
  void unplug() override { arm_.unplug(); }
  void replug() override { arm_.plug(); }

 private:
  TemplateEmulator arm_;
};

class SpaceMouseRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {.cable = true, .bytes = true, .silenceIsRest = true};
  explicit SpaceMouseRig(SpaceMouseEmulator::Layout layout) : puck_(layout) {}
  std::unique_ptr<Device> open() override { return openSpaceMouse({}, puck_.source()); }
  void hand(const Vec3d&, uint32_t) override {}
  bool misbehave(Misbehaviour what) override {
    if (what != Misbehaviour::none && what != Misbehaviour::garbage && what != Misbehaviour::shortAnswers) return false;
    puck_.misbehave(what);
    return true;
  }
  void unplug() override { puck_.unplug(); }
  void replug() override { puck_.plug(); }

 private:
  SpaceMouseEmulator puck_;
};

class PointerRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {.follows = true};
  std::unique_ptr<Device> open() override {
    auto device = std::make_unique<PointerDevice>();
    device_ = device.get();
    hand({0, 0, 0}, 0);
    return device;
  }
  void hand(const Vec3d& positionMm, uint32_t buttons) override {
    PointerSample sample;
    sample.origin = positionMm + Vec3d(0, 0, 100);
    sample.surfaceMm = 100;
    sample.buttons = buttons;
    device_->feed(sample);
  }

 private:
  PointerDevice* device_ = nullptr;
};

class RecordedRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {};
  std::unique_ptr<Device> open() override {
    return std::make_unique<RecordedDevice>(HandPath::hold(place(), 30), RecordedDevice::Options{});
  }
  void hand(const Vec3d&, uint32_t) override {}
  Vec3d place() const override { return {4, 5, 6}; }
};

class FalconRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {
      .force = true, .cable = true, .follows = true, .bytes = true, .resolutionMm = 0.061};
  std::unique_ptr<Device> open() override { return openFalcon(FalconOptions(), std::make_unique<FalconLine>(falcon_)); }
  void hand(const Vec3d& positionMm, uint32_t buttons) override { falcon_.hand(positionMm, buttons & 1 ? 4 : 0); }
  Vec3d forceN() const override { return falcon_.forceN(); }
  double peakN() const override { return falcon_.peakN(); }
  uint64_t told() const override { return falcon_.packets(); }
  Vec3d toldN(uint64_t which) const override { return falcon_.toldN(which); }
  bool misbehave(Misbehaviour what) override { return testing::misbehave(falcon_, what); }
  void unplug() override { falcon_.unplug(); }
  void replug() override { falcon_.replug(); }

 private:
  FalconEmulator falcon_{{}};
};

template <class Rig, class... Arguments>
RigMaker maker(const char* name, Arguments... arguments) {
  return {name, Rig::kTraits, [arguments...] { return std::make_unique<Rig>(arguments...); }};
}

}  // namespace

std::vector<RigMaker> deviceRigs(bool DeviceRig::Traits::*trait) {
  std::vector<RigMaker> rigs = {
      maker<SimulatedRig>("simulated"),
      maker<RecordedRig>("recorded"),
      maker<PointerRig>("pointer"),
      maker<SpaceMouseRig>("spaceMouse", SpaceMouseEmulator::Layout::twoReports),
      maker<SpaceMouseRig>("spaceMouseWireless", SpaceMouseEmulator::Layout::oneReport),
      maker<HaplyRig>("haply", false),
      maker<HaplyRig>("haplyWithGrip", true),
      maker<TemplateRig>("driverTemplate"),
      maker<FalconRig>("falcon"),
  };
  if (trait) std::erase_if(rigs, [trait](const RigMaker& rig) { return !(rig.traits.*trait); });
  return rigs;
}

}  // namespace argil::haptics::testing
