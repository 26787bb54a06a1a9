#pragma once
// The Vulkan loader, its drivers and what they offer, before a device is opened. Only for gpu*.cpp.

#include <volk.h>

#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace argil::render {

inline constexpr const char* kInstallHint =
    "install a Vulkan driver (Debian: mesa-vulkan-drivers, which also draws without a graphics card) and libvulkan1";

/// volk's entry points are process-wide: whoever loads or fills them holds this.
std::mutex& loaderMutex();

/// Opens the loader; false when there is none. One instance stays for as long as the process: without any, the loader
/// would unload the drivers, whose threads and caches do not all end before that.
bool openLoader();

/// The validation layer is installed.
bool layerPresent();

/// Extensions for surfaces in windows of any kind that the loader has. Every instance is made with them: volk keeps one
/// pointer a function for all instances, and a window may come at any time.
const std::vector<std::string>& surfaceExtensions();

/// Null when the driver refuses.
VkInstance makeInstance(bool validation, const void* next);

/// The first queue family that draws.
std::optional<uint32_t> graphicsFamily(VkPhysicalDevice device);

/// Whether that family runs kernels and these may be given the addresses of buffers. Vulkan 1.3 asks for the second.
bool canRunKernels(VkPhysicalDevice device, uint32_t family);

/// Devices that can run the renderer, best first.
std::vector<VkPhysicalDevice> usableDevices(VkInstance instance);

}  // namespace argil::render
