#pragma once
// The Vulkan device and the few things made from it. Only for the .cpp files of render/: it brings in Vulkan's headers.

#include <volk.h>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "render/view/renderer_options.h"

namespace argil::render {

class Gpu;

/// A Vulkan structure of its type, all else zero.
template <class T>
[[nodiscard]] T structure(VkStructureType type) {
  T result{};
  result.sType = type;
  return result;
}

/// Throws Error (work) with what was being done, unless the call succeeded. Calls that can lose the device go through
/// Gpu::check.
void check(VkResult result, const char* what);

/// A buffer with memory of its own: there are few, large ones; what lives in them is sub-allocated by RangeAllocator.
/// Goes only after the frames under way that may use it, for which it waits: do not make and drop them each frame.
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
  /// For kernels; of a buffer made with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT.
  [[nodiscard]] VkDeviceAddress address() const;

 private:
  Gpu* gpu_ = nullptr;
  VkBuffer handle_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize size_ = 0, taken_ = 0;
  std::byte* mapped_ = nullptr;
};

/// A 2-D image with its view, one level, one sample. Goes as a Buffer does.
class Texture {
 public:
  Texture() = default;
  /// `layers` 0: one layer, seen as a plain image; else seen as an array of so many. `alias`: a format of the same size
  /// in which aliasView() shows the same bytes. `swizzle`: how shaders see the channels.
  Texture(Gpu& gpu, VkFormat format, uint32_t width, uint32_t height, VkImageUsageFlags usage, uint32_t layers = 0,
          VkFormat alias = VK_FORMAT_UNDEFINED, VkComponentMapping swizzle = {});
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
  VkDeviceSize taken_ = 0;
  VkImageView view_ = VK_NULL_HANDLE, aliasView_ = VK_NULL_HANDLE;
  std::array<VkImageView, 2> layerViews_{};
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  VkExtent2D extent_{};
};

/// What a submission waits for and tells: a window's semaphores.
struct SubmitSemaphores {
  VkSemaphore wait = VK_NULL_HANDLE;
  VkPipelineStageFlags2 waitStage = VK_PIPELINE_STAGE_2_NONE;
  VkSemaphore signal = VK_NULL_HANDLE;
};

/// What the validation layer says. Outlives the device that it speaks of, whose end it may have something to say about.
class MessageLog {
 public:
  void add(const char* message) {
    const std::lock_guard lock(mutex_);
    messages_.emplace_back(message);
  }
  [[nodiscard]] std::vector<std::string> all() const {
    const std::lock_guard lock(mutex_);
    return messages_;
  }

 private:
  mutable std::mutex mutex_;  // layers may call back from any thread
  std::vector<std::string> messages_;
};

/// Instance, device and its one queue. Vulkan 1.3 with dynamic rendering and synchronization2. One thread at a time.
class Gpu {
 public:
  /// Names a submission; later ones are greater.
  using Ticket = uint64_t;

  /// Uses `device`, `validation` and `memoryLimitBytes` of the options. Throws Error (work) when there is no driver or
  /// no such device.
  Gpu(const RendererOptions& options, std::shared_ptr<MessageLog> log);
  ~Gpu();
  Gpu(const Gpu&) = delete;
  Gpu& operator=(const Gpu&) = delete;

  [[nodiscard]] VkInstance instance() const { return instance_; }
  [[nodiscard]] VkPhysicalDevice physical() const { return physical_; }
  [[nodiscard]] VkDevice device() const { return device_; }
  [[nodiscard]] VkQueue queue() const { return queue_; }
  [[nodiscard]] uint32_t family() const { return family_; }
  [[nodiscard]] bool hasSwapchains() const { return swapchains_; }
  /// Whether its queue runs kernels, which may be given the addresses of buffers.
  [[nodiscard]] bool hasKernels() const { return kernels_; }
  [[nodiscard]] bool software() const { return properties_.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU; }
  [[nodiscard]] const VkPhysicalDeviceProperties& properties() const { return properties_; }
  [[nodiscard]] bool validating() const { return messenger_ != VK_NULL_HANDLE; }

  /// Records and submits. The device runs submissions one after the other: each sees all that earlier ones wrote.
  Ticket submit(const std::function<void(VkCommandBuffer)>& record, const SubmitSemaphores& semaphores = {});
  /// Returns when the device is done with a submission and with all before it.
  void wait(Ticket ticket);
  /// Both.
  void run(const std::function<void(VkCommandBuffer)>& record) { wait(submit(record)); }
  /// Waits for all submissions, on a lost device too.
  void settle() noexcept;

  /// As the function of that name; remembers that the device was lost.
  void check(VkResult result, const char* what);
  [[nodiscard]] bool lost() const { return lost_; }
  void loseAtNextSubmit() { loseNext_ = true; }

  /// Memory of the best matching type; `addressed`: for a buffer that has an address. Throws Error when there is none
  /// left.
  VkDeviceMemory allocate(const VkMemoryRequirements& needs, Buffer::Memory use, bool addressed = false);
  void free(VkDeviceMemory memory, VkDeviceSize size) noexcept;
  [[nodiscard]] VkDeviceSize allocatedBytes() const { return allocated_; }

 private:
  void createInstance(bool validation);
  void chooseDevice(const std::string& wanted);
  void createDevice();
  void destroy() noexcept;
  void reclaim();
  static VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                  VkDebugUtilsMessageTypeFlagsEXT,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* log);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  uint32_t family_ = 0;
  bool swapchains_ = false, kernels_ = false;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkSemaphore done_ = VK_NULL_HANDLE;  ///< Timeline: its value is the last ticket that is done.
  Ticket submitted_ = 0, settled_ = 0;
  struct Pending {
    Ticket ticket;
    VkCommandBuffer commands;
  };
  std::deque<Pending> pending_;
  bool lost_ = false, loseNext_ = false;
  VkDeviceSize allocated_ = 0, limit_ = 0;
  std::shared_ptr<MessageLog> log_;
};

/// One barrier of all memory, recorded at once.
struct MemoryUse {
  VkPipelineStageFlags2 stage;
  VkAccessFlags2 access;
};
void barrier(VkCommandBuffer commands, const MemoryUse& from, const MemoryUse& to);

/// One image barrier, recorded at once.
struct ImageUse {
  VkPipelineStageFlags2 stage;
  VkAccessFlags2 access;
  VkImageLayout layout;
};
void transition(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, const ImageUse& from,
                const ImageUse& to);
inline void transition(VkCommandBuffer commands, const Texture& texture, const ImageUse& from, const ImageUse& to) {
  transition(commands, texture.image(), texture.aspect(), from, to);
}

}  // namespace argil::render
