#include "render/gpu/gpu.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "clay/base/error.h"
#include "render/gpu/gpu_instance.h"

namespace argil::render {
namespace {

const char* resultName(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of graphics memory";
    case VK_ERROR_DEVICE_LOST:
      return "the graphics device was lost";
    case VK_ERROR_SURFACE_LOST_KHR:
      return "the window no longer takes pictures";
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

std::string lower(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool deviceHas(VkPhysicalDevice device, const char* extension) {
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> all(count);
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, all.data());
  return std::any_of(all.begin(), all.end(),
                     [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, extension) == 0; });
}

}  // namespace

void check(VkResult result, const char* what) {
  if (result == VK_SUCCESS) return;
  const char* advice = "choose a smaller picture or another device with ARGIL_GPU";
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY) {
    advice = "close other programs that draw, hide pieces, choose a smaller picture or another device with ARGIL_GPU";
  }
  if (result == VK_ERROR_DEVICE_LOST) advice = "the work is safe, the view has to be started again";
  if (result == VK_ERROR_SURFACE_LOST_KHR) advice = "the work is safe, open the window again";
  throw Error(std::string("cannot draw: ") + resultName(result) + " (" + std::to_string(int(result)) + ") when " +
                  what + "; " + advice,
              Error::Kind::work);
}

void Gpu::check(VkResult result, const char* what) {
  if (result == VK_ERROR_DEVICE_LOST) lost_ = true;
  render::check(result, what);
}

Gpu::Gpu(const RendererOptions& options, std::shared_ptr<MessageLog> log)
    : limit_(options.memoryLimitBytes), log_(std::move(log)) {
  const std::lock_guard lock(loaderMutex());
  try {
    createInstance(options.validation);
    chooseDevice(options.device);
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
    vkDestroySemaphore(device_, done_, nullptr);
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
  messenger.pUserData = log_.get();
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
  auto features11 = structure<VkPhysicalDeviceVulkan11Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
  features11.multiview = VK_TRUE;
  auto features12 = structure<VkPhysicalDeviceVulkan12Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  features12.pNext = &features11;
  features12.timelineSemaphore = VK_TRUE;
  kernels_ = canRunKernels(physical_, family_);
  features12.bufferDeviceAddress = kernels_ ? VK_TRUE : VK_FALSE;
  auto features = structure<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  features.pNext = &features12;
  features.dynamicRendering = VK_TRUE;
  features.synchronization2 = VK_TRUE;
  features.maintenance4 = VK_TRUE;  // a fragment shader may ignore what the vertex shader hands it
  auto info = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  info.pNext = &features;
  VkPhysicalDeviceFeatures core{};
  core.multiDrawIndirect = VK_TRUE;  // every 1.3 driver of a desktop has it
  info.pEnabledFeatures = &core;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  const char* swapchain = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
  swapchains_ = !surfaceExtensions().empty() && deviceHas(physical_, swapchain);
  info.enabledExtensionCount = swapchains_ ? 1 : 0;
  info.ppEnabledExtensionNames = &swapchain;
  check(vkCreateDevice(physical_, &info, nullptr, &device_), "opening the device");
  vkGetDeviceQueue(device_, family_, 0, &queue_);

  auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = family_;
  check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "making a command pool");
  auto timeline = structure<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
  timeline.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  auto semaphore = structure<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
  semaphore.pNext = &timeline;
  check(vkCreateSemaphore(device_, &semaphore, nullptr, &done_), "making a semaphore");
}

Gpu::Ticket Gpu::submit(const std::function<void(VkCommandBuffer)>& record, const SubmitSemaphores& semaphores) {
  if (lost_) check(VK_ERROR_DEVICE_LOST, "starting a picture");
  reclaim();
  auto allocation = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  allocation.commandPool = pool_;
  allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocation.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  check(vkAllocateCommandBuffers(device_, &allocation, &commands), "making a command buffer");
  auto begin = structure<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VkResult result = vkBeginCommandBuffer(commands, &begin);
  if (result == VK_SUCCESS) {
    // Frames under way share images and buffers: the next one starts when the one before has written.
    barrier(commands, {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT},
            {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT});
    try {
      record(commands);
    } catch (...) {
      vkFreeCommandBuffers(device_, pool_, 1, &commands);
      throw;
    }
    result = vkEndCommandBuffer(commands);
  }
  if (result == VK_SUCCESS && std::exchange(loseNext_, false)) result = VK_ERROR_DEVICE_LOST;
  if (result == VK_SUCCESS) {
    auto one = structure<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
    one.commandBuffer = commands;
    auto wait = structure<VkSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
    wait.semaphore = semaphores.wait;
    wait.stageMask = semaphores.waitStage;
    VkSemaphoreSubmitInfo signals[2];
    signals[0] = signals[1] = structure<VkSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
    signals[0].semaphore = done_;
    signals[0].value = submitted_ + 1;
    signals[1].semaphore = semaphores.signal;
    signals[0].stageMask = signals[1].stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    auto submission = structure<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
    submission.waitSemaphoreInfoCount = semaphores.wait ? 1 : 0;
    submission.pWaitSemaphoreInfos = &wait;
    submission.commandBufferInfoCount = 1;
    submission.pCommandBufferInfos = &one;
    submission.signalSemaphoreInfoCount = semaphores.signal ? 2 : 1;
    submission.pSignalSemaphoreInfos = signals;
    result = vkQueueSubmit2(queue_, 1, &submission, VK_NULL_HANDLE);
  }
  if (result != VK_SUCCESS) vkFreeCommandBuffers(device_, pool_, 1, &commands);
  check(result, "running the passes");
  pending_.push_back({++submitted_, commands});
  return submitted_;
}

void Gpu::wait(Ticket ticket) {
  if (ticket <= settled_) return;
  if (lost_) check(VK_ERROR_DEVICE_LOST, "waiting for a picture");
  auto info = structure<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
  info.semaphoreCount = 1;
  info.pSemaphores = &done_;
  info.pValues = &ticket;
  check(vkWaitSemaphores(device_, &info, UINT64_MAX), "waiting for a picture");
  settled_ = ticket;
}

void Gpu::settle() noexcept {
  if (settled_ == submitted_) return;
  vkDeviceWaitIdle(device_);
  settled_ = submitted_;
}

void Gpu::reclaim() {
  uint64_t done = 0;
  check(vkGetSemaphoreCounterValue(device_, done_, &done), "asking for progress");
  while (!pending_.empty() && pending_.front().ticket <= done) {
    vkFreeCommandBuffers(device_, pool_, 1, &pending_.front().commands);
    pending_.pop_front();
  }
}

VkDeviceMemory Gpu::allocate(const VkMemoryRequirements& needs, Buffer::Memory use, bool addressed) {
  constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryPropertyFlags required = 0, liked = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  if (use == Buffer::Memory::upload) required = host, liked = 0;
  if (use == Buffer::Memory::readback) required = host, liked = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  const bool allowed = limit_ == 0 || allocated_ + needs.size <= limit_;
  for (const VkMemoryPropertyFlags flags : {required | liked, required}) {
    if (!allowed) break;
    for (uint32_t type = 0; type < memory_.memoryTypeCount; ++type) {
      if (!(needs.memoryTypeBits & (1u << type)) || (memory_.memoryTypes[type].propertyFlags & flags) != flags)
        continue;
      auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
      info.allocationSize = needs.size;
      info.memoryTypeIndex = type;
      auto flagged = structure<VkMemoryAllocateFlagsInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO);
      flagged.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
      if (addressed) info.pNext = &flagged;
      VkDeviceMemory memory = VK_NULL_HANDLE;
      const VkResult result = vkAllocateMemory(device_, &info, nullptr, &memory);
      if (result == VK_SUCCESS) {
        allocated_ += needs.size;
        return memory;
      }
      if (result == VK_ERROR_DEVICE_LOST) check(result, "taking graphics memory");
    }
  }
  check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "taking graphics memory");
  return VK_NULL_HANDLE;
}

void Gpu::free(VkDeviceMemory memory, VkDeviceSize size) noexcept {
  vkFreeMemory(device_, memory, nullptr);
  allocated_ -= size;
}

VkBool32 Gpu::onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                        const VkDebugUtilsMessengerCallbackDataEXT* data, void* log) {
  static_cast<MessageLog*>(log)->add(data->pMessage);
  return VK_FALSE;
}

Buffer::Buffer(Gpu& gpu, VkDeviceSize size, VkBufferUsageFlags usage, Memory memory) : gpu_(&gpu), size_(size) {
  auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = size;
  info.usage = usage;
  try {
    gpu.check(vkCreateBuffer(gpu.device(), &info, nullptr, &handle_), "making a buffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(gpu.device(), handle_, &needs);
    memory_ = gpu.allocate(needs, memory, (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0);
    taken_ = needs.size;
    gpu.check(vkBindBufferMemory(gpu.device(), handle_, memory_, 0), "binding a buffer");
    if (memory != Memory::device) {
      void* address = nullptr;
      gpu.check(vkMapMemory(gpu.device(), memory_, 0, VK_WHOLE_SIZE, 0, &address), "mapping a buffer");
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
  std::swap(taken_, other.taken_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

void Buffer::reset() {
  if (!gpu_) return;
  gpu_->settle();
  vkDestroyBuffer(gpu_->device(), handle_, nullptr);
  gpu_->free(memory_, taken_);
  gpu_ = nullptr;
  taken_ = 0;
  handle_ = VK_NULL_HANDLE;
  memory_ = VK_NULL_HANDLE;
  size_ = 0;
  mapped_ = nullptr;
}

VkDeviceAddress Buffer::address() const {
  auto info = structure<VkBufferDeviceAddressInfo>(VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO);
  info.buffer = handle_;
  return vkGetBufferDeviceAddress(gpu_->device(), &info);
}

VkImageAspectFlags Texture::aspect() const {
  return format_ == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

Texture::Texture(Gpu& gpu, VkFormat format, uint32_t width, uint32_t height, VkImageUsageFlags usage, uint32_t layers,
                 VkFormat alias, VkComponentMapping swizzle)
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
    gpu.check(vkCreateImage(gpu.device(), &info, nullptr, &image_), "making an image");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(gpu.device(), image_, &needs);
    memory_ = gpu.allocate(needs, Buffer::Memory::device);
    taken_ = needs.size;
    gpu.check(vkBindImageMemory(gpu.device(), image_, memory_, 0), "binding an image");
    auto view = structure<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view.image = image_;
    view.viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.components = swizzle;
    view.subresourceRange = {aspect(), 0, 1, 0, info.arrayLayers};
    gpu.check(vkCreateImageView(gpu.device(), &view, nullptr, &view_), "making an image view");
    for (uint32_t i = 0; layers == 2 && i < 2; ++i) {
      auto layer = view;
      layer.viewType = VK_IMAGE_VIEW_TYPE_2D;
      layer.subresourceRange.baseArrayLayer = i;
      layer.subresourceRange.layerCount = 1;
      gpu.check(vkCreateImageView(gpu.device(), &layer, nullptr, &layerViews_[i]), "making an image view");
    }
    if (alias != VK_FORMAT_UNDEFINED) {
      view.format = alias;
      gpu.check(vkCreateImageView(gpu.device(), &view, nullptr, &aliasView_), "making an image view");
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
  std::swap(taken_, other.taken_);
  std::swap(view_, other.view_);
  std::swap(aliasView_, other.aliasView_);
  std::swap(layerViews_, other.layerViews_);
  std::swap(format_, other.format_);
  std::swap(extent_, other.extent_);
  return *this;
}

void Texture::reset() {
  if (!gpu_) return;
  gpu_->settle();
  vkDestroyImageView(gpu_->device(), view_, nullptr);
  vkDestroyImageView(gpu_->device(), aliasView_, nullptr);
  for (VkImageView& each : layerViews_)
    vkDestroyImageView(gpu_->device(), std::exchange(each, VK_NULL_HANDLE), nullptr);
  vkDestroyImage(gpu_->device(), image_, nullptr);
  gpu_->free(memory_, taken_);
  gpu_ = nullptr;
  taken_ = 0;
  view_ = aliasView_ = VK_NULL_HANDLE;
  image_ = VK_NULL_HANDLE;
  memory_ = VK_NULL_HANDLE;
}

void barrier(VkCommandBuffer commands, const MemoryUse& from, const MemoryUse& to) {
  auto memory = structure<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  memory.srcStageMask = from.stage;
  memory.srcAccessMask = from.access;
  memory.dstStageMask = to.stage;
  memory.dstAccessMask = to.access;
  auto dependency = structure<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  vkCmdPipelineBarrier2(commands, &dependency);
}

void transition(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, const ImageUse& from,
                const ImageUse& to) {
  auto barrier = structure<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  barrier.srcStageMask = from.stage;
  barrier.srcAccessMask = from.access;
  barrier.dstStageMask = to.stage;
  barrier.dstAccessMask = to.access;
  barrier.oldLayout = from.layout;
  barrier.newLayout = to.layout;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
  auto dependency = structure<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

}  // namespace argil::render
