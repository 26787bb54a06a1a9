#include "render/gpu.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "clay/error.h"

namespace argil::render {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr const char* kInstallHint =
    "install a Vulkan driver (Debian: mesa-vulkan-drivers, which also draws without a graphics card) and libvulkan1";

const char* resultName(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of graphics memory";
    case VK_ERROR_DEVICE_LOST:
      return "the graphics device was lost";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "the driver did not start";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "the driver lacks an extension";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "the driver lacks a feature";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no driver fits";
    default:
      return "the driver refused";
  }
}

/// volk's entry points are process-wide: whoever loads or fills them holds this.
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

std::string lower(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

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

/// Devices that can run the renderer, best first.
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

VkInstance makeInstance(bool validation, const void* next) {
  auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "Argil";
  application.apiVersion = VK_API_VERSION_1_3;
  auto info = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pNext = next;
  info.pApplicationInfo = &application;
  const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  if (validation) {
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = 2;
    info.ppEnabledExtensionNames = extensions;
  }
  VkInstance instance = VK_NULL_HANDLE;
  if (vkCreateInstance(&info, nullptr, &instance) != VK_SUCCESS) return VK_NULL_HANDLE;
  return instance;
}

/// Opens the loader; false when there is none. One instance stays for as long as the process: without any, the loader
/// would unload the drivers, whose threads and caches do not all end before that.
bool openLoader() {
  if (volkInitialize() != VK_SUCCESS) return false;
  static const VkInstance anchor = makeInstance(false, nullptr);
  static_cast<void>(anchor);
  return true;
}

}  // namespace

void check(VkResult result, const char* what) {
  if (result == VK_SUCCESS) return;
  throw Error(std::string("cannot draw: ") + resultName(result) + " (" + std::to_string(int(result)) + ") when " +
                  what + "; choose a smaller picture or another device with ARGIL_GPU",
              Error::Kind::work);
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

Gpu::Gpu(const std::string& wanted, bool validation) {
  const std::lock_guard lock(loaderMutex());
  try {
    createInstance(validation);
    chooseDevice(wanted);
    createDevice();
  } catch (...) {
    destroy();
    throw;
  }
}

Gpu::~Gpu() {
  destroy();
}

void Gpu::destroy() noexcept {
  if (device_) {
    vkDeviceWaitIdle(device_);
    vkDestroyFence(device_, fence_, nullptr);
    vkDestroyCommandPool(device_, pool_, nullptr);
    vkDestroyDevice(device_, nullptr);
  }
  if (messenger_) {
    // Asked for by instance: volk's own pointer is whatever the last instance of the process had.
    const auto destroyMessenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    if (destroyMessenger) destroyMessenger(instance_, messenger_, nullptr);
  }
  if (instance_) vkDestroyInstance(instance_, nullptr);
}

void Gpu::createInstance(bool validation) {
  if (!openLoader()) {
    throw Error(std::string("no Vulkan on this machine; ") + kInstallHint, Error::Kind::work);
  }
  validation = validation && layerPresent();

  auto messenger =
      structure<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messenger.pfnUserCallback = onMessage;
  messenger.pUserData = this;
  const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  auto features = structure<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.pNext = &messenger;
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enabled;

  if (validation) {
    static const VkInstance layerAnchor = makeInstance(true, nullptr);  // as openLoader()'s, for the layer
    static_cast<void>(layerAnchor);
  }
  instance_ = makeInstance(validation, validation ? &features : nullptr);
  if (!instance_) throw Error(std::string("Vulkan finds no driver; ") + kInstallHint, Error::Kind::work);
  volkLoadInstance(instance_);
  if (validation) {
    check(vkCreateDebugUtilsMessengerEXT(instance_, &messenger, nullptr, &messenger_), "starting the validation layer");
  }
}

void Gpu::chooseDevice(const std::string& wanted) {
  const std::vector<VkPhysicalDevice> usable = usableDevices(instance_);
  if (usable.empty()) {
    throw Error(std::string("no graphics driver here offers Vulkan 1.3; ") + kInstallHint, Error::Kind::work);
  }
  std::string known;
  for (VkPhysicalDevice device : usable) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device, &properties);
    known += (known.empty() ? "'" : ", '") + std::string(properties.deviceName) + "'";
    if (lower(properties.deviceName).find(lower(wanted)) == std::string::npos) continue;
    physical_ = device;
    properties_ = properties;
    family_ = *graphicsFamily(device);
    vkGetPhysicalDeviceMemoryProperties(device, &memory_);
    return;
  }
  throw Error("no graphics device is named like '" + wanted + "'; this machine has " + known, Error::Kind::input);
}

void Gpu::createDevice() {
  const float priority = 1;
  auto queue = structure<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  auto features = structure<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  features.dynamicRendering = VK_TRUE;
  features.synchronization2 = VK_TRUE;
  features.maintenance4 = VK_TRUE;  // a fragment shader may ignore what the vertex shader hands it
  auto multiview = structure<VkPhysicalDeviceVulkan11Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
  multiview.multiview = VK_TRUE;
  features.pNext = &multiview;
  auto info = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  info.pNext = &features;
  VkPhysicalDeviceFeatures core{};
  core.multiDrawIndirect = VK_TRUE;  // every 1.3 driver of a desktop has it
  info.pEnabledFeatures = &core;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  check(vkCreateDevice(physical_, &info, nullptr, &device_), "opening the device");
  vkGetDeviceQueue(device_, family_, 0, &queue_);

  auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = family_;
  check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "making a command pool");
  const auto fence = structure<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  check(vkCreateFence(device_, &fence, nullptr, &fence_), "making a fence");
}

void Gpu::run(const std::function<void(VkCommandBuffer)>& record) {
  auto allocate = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  check(vkAllocateCommandBuffers(device_, &allocate, &commands), "making a command buffer");
  auto begin = structure<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VkResult result = vkBeginCommandBuffer(commands, &begin);
  if (result == VK_SUCCESS) {
    record(commands);
    result = vkEndCommandBuffer(commands);
  }
  if (result == VK_SUCCESS) {
    auto one = structure<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
    one.commandBuffer = commands;
    auto submit = structure<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
    submit.commandBufferInfoCount = 1;
    submit.pCommandBufferInfos = &one;
    result = vkQueueSubmit2(queue_, 1, &submit, fence_);
    if (result == VK_SUCCESS) {
      result = vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX);
      vkResetFences(device_, 1, &fence_);
    }
  }
  vkFreeCommandBuffers(device_, pool_, 1, &commands);
  check(result, "running the passes");
}

VkDeviceMemory Gpu::allocate(const VkMemoryRequirements& needs, Buffer::Memory use) {
  constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryPropertyFlags required = 0, liked = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  if (use == Buffer::Memory::upload) required = host, liked = 0;
  if (use == Buffer::Memory::readback) required = host, liked = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  for (const VkMemoryPropertyFlags flags : {required | liked, required}) {
    for (uint32_t type = 0; type < memory_.memoryTypeCount; ++type) {
      if (!(needs.memoryTypeBits & (1u << type)) || (memory_.memoryTypes[type].propertyFlags & flags) != flags)
        continue;
      auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
      info.allocationSize = needs.size;
      info.memoryTypeIndex = type;
      VkDeviceMemory memory = VK_NULL_HANDLE;
      if (vkAllocateMemory(device_, &info, nullptr, &memory) == VK_SUCCESS) return memory;
    }
  }
  check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "taking graphics memory");
  return VK_NULL_HANDLE;
}

std::vector<std::string> Gpu::validationMessages() const {
  const std::lock_guard lock(messagesMutex_);
  return messages_;
}

VkBool32 Gpu::onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                        const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
  auto* gpu = static_cast<Gpu*>(self);
  const std::lock_guard lock(gpu->messagesMutex_);
  gpu->messages_.emplace_back(data->pMessage);
  return VK_FALSE;
}

Buffer::Buffer(Gpu& gpu, VkDeviceSize size, VkBufferUsageFlags usage, Memory memory) : gpu_(&gpu), size_(size) {
  auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = size;
  info.usage = usage;
  try {
    check(vkCreateBuffer(gpu.device(), &info, nullptr, &handle_), "making a buffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(gpu.device(), handle_, &needs);
    memory_ = gpu.allocate(needs, memory);
    check(vkBindBufferMemory(gpu.device(), handle_, memory_, 0), "binding a buffer");
    if (memory != Memory::device) {
      void* address = nullptr;
      check(vkMapMemory(gpu.device(), memory_, 0, VK_WHOLE_SIZE, 0, &address), "mapping a buffer");
      mapped_ = static_cast<std::byte*>(address);
    }
  } catch (...) {
    reset();
    throw;
  }
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  std::swap(gpu_, other.gpu_);
  std::swap(handle_, other.handle_);
  std::swap(memory_, other.memory_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

void Buffer::reset() {
  if (!gpu_) return;
  vkDestroyBuffer(gpu_->device(), handle_, nullptr);
  vkFreeMemory(gpu_->device(), memory_, nullptr);
  gpu_ = nullptr;
  handle_ = VK_NULL_HANDLE;
  memory_ = VK_NULL_HANDLE;
  size_ = 0;
  mapped_ = nullptr;
}

VkImageAspectFlags Texture::aspect() const {
  return format_ == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

Texture::Texture(Gpu& gpu, VkFormat format, uint32_t width, uint32_t height, VkImageUsageFlags usage,
                 uint32_t layers, VkFormat alias)
    : gpu_(&gpu), format_(format), extent_{width, height} {
  auto info = structure<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {width, height, 1};
  info.flags = alias == VK_FORMAT_UNDEFINED ? 0 : VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
  info.mipLevels = 1;
  info.arrayLayers = layers > 1 ? layers : 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = usage;
  try {
    check(vkCreateImage(gpu.device(), &info, nullptr, &image_), "making an image");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(gpu.device(), image_, &needs);
    memory_ = gpu.allocate(needs, Buffer::Memory::device);
    check(vkBindImageMemory(gpu.device(), image_, memory_, 0), "binding an image");
    auto view = structure<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view.image = image_;
    view.viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = {aspect(), 0, 1, 0, info.arrayLayers};
    check(vkCreateImageView(gpu.device(), &view, nullptr, &view_), "making an image view");
    for (uint32_t i = 0; layers == 2 && i < 2; ++i) {
      auto layer = view;
      layer.viewType = VK_IMAGE_VIEW_TYPE_2D;
      layer.subresourceRange.baseArrayLayer = i;
      layer.subresourceRange.layerCount = 1;
      check(vkCreateImageView(gpu.device(), &layer, nullptr, &layerViews_[i]), "making an image view");
    }
    if (alias != VK_FORMAT_UNDEFINED) {
      view.format = alias;
      check(vkCreateImageView(gpu.device(), &view, nullptr, &aliasView_), "making an image view");
    }
  } catch (...) {
    reset();
    throw;
  }
}

Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(gpu_, other.gpu_);
  std::swap(image_, other.image_);
  std::swap(memory_, other.memory_);
  std::swap(view_, other.view_);
  std::swap(aliasView_, other.aliasView_);
  std::swap(layerViews_, other.layerViews_);
  std::swap(format_, other.format_);
  std::swap(extent_, other.extent_);
  return *this;
}

void Texture::reset() {
  if (!gpu_) return;
  vkDestroyImageView(gpu_->device(), view_, nullptr);
  vkDestroyImageView(gpu_->device(), aliasView_, nullptr);
  for (VkImageView& each : layerViews_) vkDestroyImageView(gpu_->device(), std::exchange(each, VK_NULL_HANDLE), nullptr);
  vkDestroyImage(gpu_->device(), image_, nullptr);
  vkFreeMemory(gpu_->device(), memory_, nullptr);
  gpu_ = nullptr;
  view_ = aliasView_ = VK_NULL_HANDLE;
  image_ = VK_NULL_HANDLE;
  memory_ = VK_NULL_HANDLE;
}

void transition(VkCommandBuffer commands, const Texture& texture, const ImageUse& from, const ImageUse& to) {
  auto barrier = structure<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  barrier.srcStageMask = from.stage;
  barrier.srcAccessMask = from.access;
  barrier.dstStageMask = to.stage;
  barrier.dstAccessMask = to.access;
  barrier.oldLayout = from.layout;
  barrier.newLayout = to.layout;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = texture.image();
  barrier.subresourceRange = {texture.aspect(), 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
  auto dependency = structure<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

}  // namespace argil::render
