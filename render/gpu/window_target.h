#pragma once
// A window's surface and the images that it shows in turn. Only for the .cpp files of render/.

#include <array>
#include <optional>

#include "render/gpu/gpu.h"
#include "render/gpu/ui_pass.h"
#include "render/view/window_hooks.h"

namespace argil::render {

/// Follows the window's size; makes its swapchain anew when the window or the driver asks for it. Images are 8-bit and
/// take sRGB values as they are.
class WindowTarget {
 public:
  /// Throws Error when this device cannot show pictures in that window.
  WindowTarget(Gpu& gpu, const WindowHooks& hooks);
  ~WindowTarget();
  WindowTarget(const WindowTarget&) = delete;
  WindowTarget& operator=(const WindowTarget&) = delete;

  /// Ready for the next frame: the size to draw in, or nothing while there is nothing to draw on.
  std::optional<VkExtent2D> prepare();

  struct Turn {
    uint32_t index;
    VkImage image;
    VkSemaphore free, drawn;  ///< Wait for the first before writing, signal the second after.
  };
  /// The image whose turn it is; the device must be done with the slot's last frame. Nothing when the window changed
  /// meanwhile or shows no pictures: prepare() again. A turn that is taken must be shown or given up.
  std::optional<Turn> take(size_t slot);
  void show(const Turn& turn);
  void giveUp() { stale_ = true; }

  [[nodiscard]] VkExtent2D extent() const { return extent_; }
  /// Pictures of this format are copied as they are; others are converted.
  [[nodiscard]] VkFormat format() const { return format_.format; }

 private:
  void makeSurface();
  void chooseFormat();
  void build(const VkSurfaceCapabilitiesKHR& capabilities, VkExtent2D extent);
  void dropImages() noexcept;
  void drop() noexcept;

  Gpu& gpu_;
  const WindowHooks& hooks_;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  VkSurfaceFormatKHR format_{};
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  VkExtent2D extent_{};
  std::array<int, 2> windowSize_{};  ///< That the swapchain was made for.
  bool stale_ = true, surfaceLost_ = false;
  std::vector<VkImage> images_;
  std::vector<VkSemaphore> drawn_;  ///< One an image: free again when the image comes back.
  std::array<VkSemaphore, kFramesInFlight> free_{};
};

}  // namespace argil::render
