#include "render/gpu/gpu_instance.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "render/gpu/gpu.h"

namespace argil::render {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

int rank(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return 3;
    default:
      return 4;
  }
}

}  // namespace

std::mutex& loaderMutex() {
  static std::mutex mutex;
  return mutex;
}

bool layerPresent() {
  uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
    return std::strcmp(layer.layerName, kValidationLayer) == 0;
  });
}

const std::vector<std::string>& surfaceExtensions() {
  static const std::vector<std::string> present = [] {
    uint32_t count = 0;
    vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> all(count);
    vkEnumerateInstanceExtensionProperties(nullptr, &count, all.data());
    std::vector<std::string> result;
    for (const std::string name :
         {"VK_KHR_surface", "VK_KHR_xcb_surface", "VK_KHR_xlib_surface", "VK_KHR_wayland_surface"}) {
      // Drivers look for a Wayland server at once and complain when there can be none.
      if (name == "VK_KHR_wayland_surface" && !std::getenv("XDG_RUNTIME_DIR")) continue;
      if (std::any_of(all.begin(), all.end(), [&](const auto& e) { return e.extensionName == name; })) {
        result.push_back(name);
      }
    }
    return result;
  }();
  return present;
}

VkInstance makeInstance(bool validation, const void* next) {
  auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "Argil";
  application.apiVersion = VK_API_VERSION_1_3;
  auto info = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pNext = next;
  info.pApplicationInfo = &application;
  std::vector<const char*> extensions;
  for (const std::string& name : surfaceExtensions()) extensions.push_back(name.c_str());
  if (validation) {
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
  }
  info.enabledExtensionCount = uint32_t(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkInstance instance = VK_NULL_HANDLE;
  if (vkCreateInstance(&info, nullptr, &instance) != VK_SUCCESS) return VK_NULL_HANDLE;
  return instance;
}

bool openLoader() {
  if (volkInitialize() != VK_SUCCESS) return false;
  static const VkInstance anchor = makeInstance(false, nullptr);
  static_cast<void>(anchor);
  return true;
}

std::optional<uint32_t> graphicsFamily(VkPhysicalDevice device) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (uint32_t i = 0; i < count; ++i) {
    if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) return i;
  }
  return std::nullopt;
}

bool canRunKernels(VkPhysicalDevice device, uint32_t family) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  auto twelve = structure<VkPhysicalDeviceVulkan12Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  auto features = structure<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  features.pNext = &twelve;
  vkGetPhysicalDeviceFeatures2(device, &features);
  return (families[family].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0 && twelve.bufferDeviceAddress == VK_TRUE;
}

std::vector<VkPhysicalDevice> usableDevices(VkInstance instance) {
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance, &count, nullptr);
  std::vector<VkPhysicalDevice> all(count);
  vkEnumeratePhysicalDevices(instance, &count, all.data());
  all.resize(count);
  const auto properties = [](VkPhysicalDevice device) {
    VkPhysicalDeviceProperties result;
    vkGetPhysicalDeviceProperties(device, &result);
    return result;
  };
  std::erase_if(all, [&](VkPhysicalDevice device) {
    return properties(device).apiVersion < VK_API_VERSION_1_3 || !graphicsFamily(device);
  });
  std::stable_sort(all.begin(), all.end(), [&](VkPhysicalDevice a, VkPhysicalDevice b) {
    return rank(properties(a).deviceType) < rank(properties(b).deviceType);
  });
  return all;
}

std::vector<DeviceInfo> devices() {
  const std::lock_guard lock(loaderMutex());
  std::vector<DeviceInfo> result;
  if (!openLoader()) return result;
  const VkInstance instance = makeInstance(false, nullptr);
  if (!instance) return result;
  volkLoadInstance(instance);
  for (VkPhysicalDevice device : usableDevices(instance)) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device, &properties);
    result.push_back({properties.deviceName, properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU});
  }
  vkDestroyInstance(instance, nullptr);
  return result;
}

}  // namespace argil::render
