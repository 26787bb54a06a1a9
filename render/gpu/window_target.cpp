#include "render/gpu/window_target.h"

#include <algorithm>

#include "clay/base/error.h"
#include "render/gpu/gpu_instance.h"

namespace argil::render {
namespace {

/// A window that shows nothing (hidden behind others on some systems) gives no image: then this frame is left out.
constexpr uint64_t kPatienceNs = 500'000'000;

VkSemaphore makeSemaphore(Gpu& gpu) {
  const auto info = structure<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
  VkSemaphore semaphore = VK_NULL_HANDLE;
  gpu.check(vkCreateSemaphore(gpu.device(), &info, nullptr, &semaphore), "making a semaphore");
  return semaphore;
}

}  // namespace

WindowTarget::WindowTarget(Gpu& gpu, const WindowHooks& hooks) : gpu_(gpu), hooks_(hooks) {
  if (!hooks.makeSurface || !hooks.size)
    throw Error("a window cannot be drawn in without its size and a way to make a surface");
  for (const std::string& wanted : hooks.instanceExtensions) {
    if (std::find(surfaceExtensions().begin(), surfaceExtensions().end(), wanted) == surfaceExtensions().end()) {
      throw Error("the Vulkan loader cannot draw in windows of this kind: it lacks " + wanted + "; " + kInstallHint,
                  Error::Kind::work);
    }
  }
  if (!gpu.hasSwapchains()) {
    throw Error("'" + std::string(gpu.properties().deviceName) +
                    "' draws pictures but shows none in windows; choose another device with ARGIL_GPU",
                Error::Kind::work);
  }
  try {
    makeSurface();
    chooseFormat();
  } catch (...) {
    drop();
    throw;
  }
}

WindowTarget::~WindowTarget() {
  drop();
}

void WindowTarget::makeSurface() {
  const uint64_t made = hooks_.makeSurface(gpu_.instance());
  if (made == 0) throw Error("the window gives no surface to draw on; open it again", Error::Kind::work);
  surface_ = reinterpret_cast<VkSurfaceKHR>(made);
  VkBool32 fits = VK_FALSE;
  gpu_.check(vkGetPhysicalDeviceSurfaceSupportKHR(gpu_.physical(), gpu_.family(), surface_, &fits),
             "looking at the window");
  if (!fits) {
    throw Error("'" + std::string(gpu_.properties().deviceName) +
                    "' cannot show pictures in this window; choose another device with ARGIL_GPU",
                Error::Kind::work);
  }
}

void WindowTarget::chooseFormat() {
  uint32_t count = 0;
  gpu_.check(vkGetPhysicalDeviceSurfaceFormatsKHR(gpu_.physical(), surface_, &count, nullptr), "asking for formats");
  std::vector<VkSurfaceFormatKHR> offered(count);
  gpu_.check(vkGetPhysicalDeviceSurfaceFormatsKHR(gpu_.physical(), surface_, &count, offered.data()),
             "asking for formats");
  for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_A8B8G8R8_UNORM_PACK32}) {
    for (const VkSurfaceFormatKHR& format : offered) {
      if (format.format != wanted || format.colorSpace != VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) continue;
      format_ = format;
      return;
    }
  }
  throw Error("the window takes no pictures of 8 bits a channel; choose another device with ARGIL_GPU",
              Error::Kind::work);
}

std::optional<VkExtent2D> WindowTarget::prepare() {
  const std::array<int, 2> size = hooks_.size();
  if (size[0] <= 0 || size[1] <= 0) return std::nullopt;
  if (surfaceLost_) {
    drop();
    makeSurface();
    chooseFormat();
    surfaceLost_ = false;
  }
  if (!stale_ && size == windowSize_) return extent_;

  VkSurfaceCapabilitiesKHR capabilities;
  const VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu_.physical(), surface_, &capabilities);
  surfaceLost_ = result == VK_ERROR_SURFACE_LOST_KHR;
  gpu_.check(result, "asking for the window's size");
  VkExtent2D extent = capabilities.currentExtent;
  if (extent.width == UINT32_MAX) {  // the window takes the size of what is shown
    extent.width = std::clamp(uint32_t(size[0]), capabilities.minImageExtent.width, capabilities.maxImageExtent.width);
    extent.height =
        std::clamp(uint32_t(size[1]), capabilities.minImageExtent.height, capabilities.maxImageExtent.height);
  }
  if (extent.width == 0 || extent.height == 0) return std::nullopt;
  build(capabilities, extent);
  windowSize_ = size;
  stale_ = false;
  return extent_;
}

void WindowTarget::build(const VkSurfaceCapabilitiesKHR& capabilities, VkExtent2D extent) {
  if (!(capabilities.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT)) {
    throw Error("the window's images cannot be copied to; choose another device with ARGIL_GPU", Error::Kind::work);
  }
  auto info = structure<VkSwapchainCreateInfoKHR>(VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR);
  info.surface = surface_;
  // One shown, one waiting, one drawn.
  info.minImageCount = std::max(capabilities.minImageCount, 3u);
  if (capabilities.maxImageCount > 0) info.minImageCount = std::min(info.minImageCount, capabilities.maxImageCount);
  info.imageFormat = format_.format;
  info.imageColorSpace = format_.colorSpace;
  info.imageExtent = extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
  info.preTransform = capabilities.currentTransform;
  info.compositeAlpha = capabilities.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                            ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                            : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;  // the one that is always there
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  // Nothing tells when the window is done with a swapchain but an idle device.
  vkDeviceWaitIdle(gpu_.device());
  VkSwapchainKHR made = VK_NULL_HANDLE;
  const VkResult result = vkCreateSwapchainKHR(gpu_.device(), &info, nullptr, &made);
  dropImages();
  swapchain_ = made;
  if (result == VK_ERROR_SURFACE_LOST_KHR) surfaceLost_ = true;
  gpu_.check(result, "following the window's size");

  extent_ = extent;
  uint32_t count = 0;
  gpu_.check(vkGetSwapchainImagesKHR(gpu_.device(), swapchain_, &count, nullptr), "asking for the window's images");
  images_.resize(count);
  gpu_.check(vkGetSwapchainImagesKHR(gpu_.device(), swapchain_, &count, images_.data()),
             "asking for the window's images");
  for (uint32_t i = 0; i < count; ++i) drawn_.push_back(makeSemaphore(gpu_));
  for (VkSemaphore& semaphore : free_) semaphore = makeSemaphore(gpu_);
}

std::optional<WindowTarget::Turn> WindowTarget::take(size_t slot) {
  uint32_t index = 0;
  const VkResult result =
      vkAcquireNextImageKHR(gpu_.device(), swapchain_, kPatienceNs, free_[slot], VK_NULL_HANDLE, &index);
  if (result == VK_TIMEOUT || result == VK_NOT_READY) return std::nullopt;
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_ERROR_SURFACE_LOST_KHR) {
    stale_ = true;
    surfaceLost_ = result == VK_ERROR_SURFACE_LOST_KHR;
    return std::nullopt;
  }
  if (result != VK_SUBOPTIMAL_KHR) gpu_.check(result, "asking for the window's next image");
  return Turn{index, images_[index], free_[slot], drawn_[index]};
}

void WindowTarget::show(const Turn& turn) {
  auto info = structure<VkPresentInfoKHR>(VK_STRUCTURE_TYPE_PRESENT_INFO_KHR);
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = &turn.drawn;
  info.swapchainCount = 1;
  info.pSwapchains = &swapchain_;
  info.pImageIndices = &turn.index;
  const VkResult result = vkQueuePresentKHR(gpu_.queue(), &info);
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) {
    stale_ = true;
  } else if (result == VK_ERROR_SURFACE_LOST_KHR) {
    stale_ = surfaceLost_ = true;
  } else {
    gpu_.check(result, "showing a picture");
  }
}

void WindowTarget::dropImages() noexcept {
  const VkDevice device = gpu_.device();
  for (VkSemaphore semaphore : drawn_) vkDestroySemaphore(device, semaphore, nullptr);
  for (VkSemaphore& semaphore : free_) {
    vkDestroySemaphore(device, semaphore, nullptr);
    semaphore = VK_NULL_HANDLE;
  }
  drawn_.clear();
  images_.clear();
  if (swapchain_) vkDestroySwapchainKHR(device, swapchain_, nullptr);
  swapchain_ = VK_NULL_HANDLE;
}

void WindowTarget::drop() noexcept {
  vkDeviceWaitIdle(gpu_.device());
  dropImages();
  if (surface_) vkDestroySurfaceKHR(gpu_.instance(), surface_, nullptr);
  surface_ = VK_NULL_HANDLE;
  stale_ = true;
}

}  // namespace argil::render
