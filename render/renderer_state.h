#pragma once
// What a renderer is made of. Only for the .cpp files of render/.

#include <string>

#include "render/frame.h"
#include "render/pipelines.h"
#include "render/renderer.h"
#include "render/surface_buffers.h"

namespace argil::render {

/// The images of one picture size.
struct Targets {
  int width = 0, height = 0, samples = 0, shadowPixels = 0;
  Texture depth, normal, cavity, shadow, colour, picture;
  Buffer readback;

  [[nodiscard]] uint64_t bytes() const {
    const uint64_t pixels = uint64_t(width) * uint64_t(height), fine = pixels * uint64_t(samples) * uint64_t(samples);
    return fine * (4 + 4 + 8) + pixels * (2 + 4 + 4) + uint64_t(shadowPixels) * uint64_t(shadowPixels) * 4;
  }
};

struct Renderer::State {
  explicit State(const RendererOptions& options)
      : quality(options.quality),
        gpu(options.device, options.validation),
        pipelines(gpu),
        surface(gpu),
        uniforms(gpu, sizeof(FrameUniforms), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, Buffer::Memory::upload),
        name(gpu.properties().deviceName) {}

  void resize(int width, int height);
  void uploadLines(const FramePlan& plan);
  Subject subject(const Overlays& overlays) const;
  void record(VkCommandBuffer commands, const FramePlan& plan, bool cursor);
  void drawClay(VkCommandBuffer commands, const FramePlan& plan, bool intoShadow);
  void drawOverlays(VkCommandBuffer commands, const FramePlan& plan, bool cursor);
  void fullscreen(VkCommandBuffer commands, Pass pass, const Texture& target);
  void bind(VkCommandBuffer commands, Pass pass);

  Quality quality;
  Gpu gpu;
  Pipelines pipelines;
  SurfaceBuffers surface;
  Targets targets;
  Buffer uniforms, lines;
  std::string name;
  DrawStats stats;
};

template <class Constants>
void push(VkCommandBuffer commands, VkPipelineLayout layout, const Constants& constants) {
  vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                     &constants);
}

}  // namespace argil::render
