#pragma once
// What a renderer is made of. Only for the .cpp files of render/.

#include <array>
#include <memory>
#include <string>

#include "render/frame.h"
#include "render/pipelines.h"
#include "render/renderer.h"
#include "render/surface_buffers.h"
#include "render/ui_pass.h"
#include "render/window_target.h"

namespace argil::render {

/// The images of one picture size.
struct Targets {
  int width = 0, height = 0, samples = 0, shadowPixels = 0;
  Texture depth, normal, cavity, shadow, colour, picture;
  Buffer readback;  ///< Made when first asked for.

  [[nodiscard]] uint64_t bytes() const {
    const uint64_t pixels = uint64_t(width) * uint64_t(height), fine = pixels * uint64_t(samples) * uint64_t(samples);
    return fine * (4 + 4 + 8) + pixels * (2 + 4 + 4) + uint64_t(shadowPixels) * uint64_t(shadowPixels) * 4;
  }
};

/// What the CPU writes for one of the frames that may be under way.
struct FrameSlot {
  Gpu::Ticket ticket = 0;  ///< Of the last frame that used it.
  Buffer lines;
};

struct Renderer::State {
  explicit State(const RendererOptions& given)
      : options(given),
        quality(options.quality),
        gpu(options),
        pipelines(gpu),
        surface(gpu),
        uniforms(gpu, sizeof(FrameUniforms), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                 Buffer::Memory::device),
        name(gpu.properties().deviceName),
        ui(gpu, kPictureFormat) {}
  ~State() { gpu.settle(); }

  void resize(int width, int height);
  void uploadLines(const FramePlan& plan);
  Subject subject(const Overlays& overlays) const;
  /// All passes; ends with the finished picture in `targets.picture`, as a colour attachment.
  void recordPicture(VkCommandBuffer commands, const FramePlan& plan, bool cursor);
  void drawClay(VkCommandBuffer commands, const FramePlan& plan, bool intoShadow);
  void drawOverlays(VkCommandBuffer commands, const FramePlan& plan, bool cursor);
  void fullscreen(VkCommandBuffer commands, Pass pass, const Texture& target);
  void bind(VkCommandBuffer commands, Pass pass);

  RendererOptions options;
  Quality quality;
  Gpu gpu;
  Pipelines pipelines;
  SurfaceBuffers surface;
  Targets targets;
  Buffer uniforms;
  std::string name;
  DrawStats stats;

  // Frames and the window (renderer.cpp, renderer_window.cpp)
  [[nodiscard]] FrameSlot& frame() { return slots[slot]; }
  /// Checks and plans a picture, then waits until the device is done with the frame before the last, whose slot it takes.
  FramePlan begin(const Shot& shot, int width, int height, const UiFrame* panels);
  /// The picture and its panels; ends with `targets.picture` ready to be copied from.
  void recordFrame(VkCommandBuffer commands, const Shot& shot, const FramePlan& plan, const UiFrame* panels);
  /// The picture that was drawn last, after the device is done with it.
  Image readBack();
  void keepShown();

  std::array<FrameSlot, kFramesInFlight> slots;
  size_t slot = 0;
  UiPass ui;
  WindowHooks hooks;  ///< Kept when the device is lost.
  bool attached = false;
  std::unique_ptr<WindowTarget> window;
  bool showing = false;  ///< The last picture drawn is the one in the window.
  Image shown;           ///< What the window shows if another picture was drawn since.
  std::vector<std::string> earlierMessages;  ///< Of the devices before this one.
};

template <class Constants>
void push(VkCommandBuffer commands, VkPipelineLayout layout, const Constants& constants) {
  vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                     &constants);
}

}  // namespace argil::render
