#pragma once
// The Vulkan device and the few things made from it. Only for the .cpp files of render/: it brings in Vulkan's headers.

#include <volk.h>

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "render/renderer.h"

namespace argil::render {

class Gpu;

/// A Vulkan structure of its type, all else zero.
template <class T>
[[nodiscard]] T structure(VkStructureType type) {
  T result{};
  result.sType = type;
  return result;
}

/// Throws Error (work) with what was being done, unless the call succeeded.
void check(VkResult result, const char* what);

/// A buffer with memory of its own: there are few, large ones; what lives in them is sub-allocated by RangeAllocator.
class Buffer {
 public:
  enum class Memory { device, upload, readback };
  Buffer() = default;
  Buffer(Gpu& gpu, VkDeviceSize size, VkBufferUsageFlags usage, Memory memory);
  ~Buffer() { reset(); }
  Buffer(Buffer&& other) noexcept { *this = std::move(other); }
  Buffer& operator=(Buffer&& other) noexcept;
  void reset();

  [[nodiscard]] VkBuffer handle() const { return handle_; }
  [[nodiscard]] VkDeviceSize size() const { return size_; }
  [[nodiscard]] std::byte* mapped() const { return mapped_; }  ///< Null for device memory.

 private:
  Gpu* gpu_ = nullptr;
  VkBuffer handle_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize size_ = 0;
  std::byte* mapped_ = nullptr;
};

/// A 2-D image with its view, one level, one sample.
class Texture {
 public:
  Texture() = default;
  /// `layers` 0: one layer, seen as a plain image; else seen as an array of so many. `alias`: a format of the same size in which
  /// aliasView() shows the same bytes.
  Texture(Gpu& gpu, VkFormat format, uint32_t width, uint32_t height, VkImageUsageFlags usage, uint32_t layers = 0,
          VkFormat alias = VK_FORMAT_UNDEFINED);
  ~Texture() { reset(); }
  Texture(Texture&& other) noexcept { *this = std::move(other); }
  Texture& operator=(Texture&& other) noexcept;
  void reset();

  [[nodiscard]] VkImage image() const { return image_; }
  [[nodiscard]] VkImageView view() const { return view_; }
  [[nodiscard]] VkImageView aliasView() const { return aliasView_; }
  /// One of two layers.
  [[nodiscard]] VkImageView layerView(uint32_t layer) const { return layerViews_[layer]; }
  [[nodiscard]] VkFormat format() const { return format_; }
  [[nodiscard]] VkExtent2D extent() const { return extent_; }
  [[nodiscard]] VkImageAspectFlags aspect() const;

 private:
  Gpu* gpu_ = nullptr;
  VkImage image_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE, aliasView_ = VK_NULL_HANDLE;
  std::array<VkImageView, 2> layerViews_{};
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  VkExtent2D extent_{};
};

/// Instance, device and its one queue. Vulkan 1.3 with dynamic rendering and synchronization2. One thread at a time.
class Gpu {
 public:
  /// `wanted`: part of a device's name, or empty for the best. Throws Error (work) when there is no driver or no such
  /// device.
  Gpu(const std::string& wanted, bool validation);
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  [[nodiscard]] VkDevice device() const { return device_; }
  [[nodiscard]] const VkPhysicalDeviceProperties& properties() const { return properties_; }
  [[nodiscard]] bool validating() const { return messenger_ != VK_NULL_HANDLE; }
  [[nodiscard]] std::vector<std::string> validationMessages() const;

  /// Records, submits and waits until the device is done.
  void run(const std::function<void(VkCommandBuffer)>& record);

  /// Memory of the best matching type. Throws Error when there is none left.
  VkDeviceMemory allocate(const VkMemoryRequirements& needs, Buffer::Memory use);

 private:
  void createInstance(bool validation);
  void chooseDevice(const std::string& wanted);
  void createDevice();
  void destroy() noexcept;
  static VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                  VkDebugUtilsMessageTypeFlagsEXT,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  uint32_t family_ = 0;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  mutable std::mutex messagesMutex_;  // layers may call back from any thread
  std::vector<std::string> messages_;
};

/// One image barrier, recorded at once.
struct ImageUse {
  VkPipelineStageFlags2 stage;
  VkAccessFlags2 access;
  VkImageLayout layout;
};
void transition(VkCommandBuffer commands, const Texture& texture, const ImageUse& from, const ImageUse& to);

}  // namespace argil::render
