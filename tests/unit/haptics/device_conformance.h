#pragma once
// The suite that every driver passes, whatever it drives: device_conformance_test.cpp. A driver joins by a rig and a
// line in device_conformance_rigs.cpp.

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "../../support/devices/device_rig.h"

namespace argil::haptics::testing {

struct RigMaker {
  std::string name;
  DeviceRig::Traits traits;
  std::function<std::unique_ptr<DeviceRig>()> make;
};

inline void PrintTo(const RigMaker& maker, std::ostream* out) {
  *out << maker.name;
}

/// Of every driver there is, or of those whose trait is set.
[[nodiscard]] std::vector<RigMaker> deviceRigs(bool DeviceRig::Traits::*trait = nullptr);

}  // namespace argil::haptics::testing
