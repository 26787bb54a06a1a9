#include "haptics/devices/added_devices.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace argil::haptics {

namespace {

std::mutex mutex;
std::vector<AddedDevice>& devices() {
  static std::vector<AddedDevice> all;
  return all;
}

}  // namespace

void addDevice(AddedDevice device) {
  const std::lock_guard lock(mutex);
  auto& all = devices();
  if (std::none_of(all.begin(), all.end(), [&](const AddedDevice& each) { return each.name == device.name; }))
    all.push_back(std::move(device));
}

std::vector<AddedDevice> addedDevices() {
  const std::lock_guard lock(mutex);
  return devices();
}

}  // namespace argil::haptics
