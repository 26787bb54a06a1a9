#pragma once
// Panels over a finished picture. Only for the .cpp files of render/.

#include <array>
#include <map>

#include "render/gpu/gpu.h"
#include "render/view/ui_frame.h"

namespace argil::render {

/// Frames that may be under way at once: one is drawn while the next is made.
inline constexpr size_t kFramesInFlight = 2;

/// Draws the triangles of a UiFrame, clipped and textured, blended in sRGB into a picture that already holds sRGB. A
/// pass of its own instead of the interface library's: that one calls Vulkan's functions by their names, which are
/// volk's pointers here.
class UiPass {
 public:
  UiPass(Gpu& gpu, VkFormat picture);
  ~UiPass();
  UiPass(const UiPass&) = delete;
  UiPass& operator=(const UiPass&) = delete;

  /// As Renderer::setUiTexture. Waits for the device.
  void setTexture(uint32_t texture, int width, int height, int channels, const uint8_t* pixels);
  /// Throws Error for a frame that names what is not there: indices, vertices, textures.
  void check(const UiFrame& frame) const;
  /// Copies the triangles of a frame for slot `slot`, which the device must be done with.
  void upload(const UiFrame& frame, size_t slot);
  /// Records the pass over a picture in colour attachment layout. Only for the frame uploaded last to that slot.
  void draw(VkCommandBuffer commands, const UiFrame& frame, size_t slot, const Texture& picture) const;

 private:
  struct Panel {
    Texture image;
    int channels = 0;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  struct Slot {
    Buffer vertices, indices;
  };
  void createPipeline(VkFormat picture);
  void makeSet(Panel& panel);
  void destroy() noexcept;

  Gpu& gpu_;
  VkSampler linear_ = VK_NULL_HANDLE;
  VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  std::map<uint32_t, Panel> textures_;
  std::array<Slot, kFramesInFlight> slots_;
};

}  // namespace argil::render
