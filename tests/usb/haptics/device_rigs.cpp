// The conformance suite once more, through libusb and an emulated bus.

#include <algorithm>
#include <chrono>
#include <thread>

#include "../../support/devices/emulated_usb.h"
#include "../../unit/haptics/device_conformance.h"
#include "haptics/base/clock.h"
#include "haptics/devices/falcon.h"

namespace argil::haptics::testing {
namespace {

/// All rigs hang on one bus: only one can be at a time, and two Falcons may be plugged into it.
std::shared_ptr<EmulatedUsb> theBus() {
  static std::weak_ptr<EmulatedUsb> bus;
  auto shared = bus.lock();
  if (!shared) bus = shared = std::make_shared<EmulatedUsb>();
  return shared;
}

class FalconUsbRig final : public DeviceRig {
 public:
  static constexpr Traits kTraits = {
      .force = true, .cable = true, .follows = true, .bytes = true, .resolutionMm = 0.061};
  FalconUsbRig() : bus_(theBus()) {
    static int next = 0;
    port_ = std::to_string(1 + next++ % 6);
    bus_->plug(falcon_, port_);
  }
  ~FalconUsbRig() override { bus_->unplug(port_); }

  std::unique_ptr<Device> open() override {
    FalconOptions options;
    options.where = "1-" + port_;
    options.realtime = false;  // Waiting for the emulated bus burns a core: never at real-time priority.
    return openFalcon(options);
  }
  void hand(const Vec3d& positionMm, uint32_t buttons) override { falcon_.hand(positionMm, buttons & 1 ? 4 : 0); }
  Vec3d forceN() const override { return falcon_.forceN(); }
  double peakN() const override { return falcon_.peakN(); }
  uint64_t told() const override { return falcon_.packets(); }
  Vec3d toldN(uint64_t which) const override { return falcon_.toldN(which); }
  bool misbehave(Misbehaviour what) override {
    // Nine answers of ten in time is more than an emulated bus can promise: falcon_usb_test.cpp asks for less.
    return what != Misbehaviour::split && testing::misbehave(falcon_, what);
  }
  double slack() const override {
    static const double measured = measure();
    return measured;
  }
  void unplug() override { bus_->unplug(port_); }
  void replug() override { bus_->plug(falcon_, port_); }

 private:
  // A servo's turn takes a millisecond: as many of them as an exchange takes, and twice that for the scheduler.
  static double measure() {
    constexpr int kExchanges = 50;
    FalconUsbRig rig;
    const auto device = rig.open();
    int64_t begin = 0;
    for (int count = 0; count < kExchanges && (begin == 0 || nowNs() - begin < 30'000'000'000);) {
      DeviceState state;
      const bool fresh = device->read(double(nowNs()) * 1e-9, state);
      device->write(double(nowNs()) * 1e-9, Vec3d::Zero());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (fresh && begin == 0) begin = nowNs();
      count += fresh;
    }
    return std::clamp(2e-6 * double(nowNs() - begin) / kExchanges, 1.0, 50.0);
  }

  FalconEmulator falcon_{{}};
  std::shared_ptr<EmulatedUsb> bus_;
  std::string port_;
};

}  // namespace

std::vector<RigMaker> deviceRigs(bool DeviceRig::Traits::*) {
  return {{"falconOverUsb", FalconUsbRig::kTraits, [] { return std::make_unique<FalconUsbRig>(); }}};
}

}  // namespace argil::haptics::testing
