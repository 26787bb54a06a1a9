#pragma once
// What a renderer begins with: the devices of this machine, and which of them in what quality.

#include <cstdint>
#include <string>
#include <vector>

#include "render/view/quality.h"

namespace argil::render {

struct DeviceInfo {
  std::string name;
  bool software = false;  ///< Draws on the CPU.
};

/// The Vulkan 1.3 devices of this machine, best first: discrete, integrated, virtual, software. Empty without a driver.
[[nodiscard]] std::vector<DeviceInfo> devices();

struct RendererOptions {
  /// Part of a device's name, any case; empty: the environment's ARGIL_GPU, else the best device.
  std::string device;
  bool validation = false;  ///< Vulkan's validation layer with synchronization validation, where it is installed.
  Quality quality;
  uint64_t memoryLimitBytes = 0;  ///< Graphics memory that it may take; 0: what the device has.
  /// How both eyes of a stereo picture are drawn: together in one multiview pass or apart, one after the other.
  /// Automatic: together, but apart on software drivers, whose multiview loses large triangles.
  enum class Eyes : uint8_t { automatic, together, apart } eyes = Eyes::automatic;
  /// Where levels of detail are made. Automatic: on the device, but on the CPU where that is the device. They are the
  /// same, to the bit.
  enum class Levels : uint8_t { automatic, device, cpu } levels = Levels::automatic;
};

}  // namespace argil::render
