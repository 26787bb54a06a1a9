#pragma once
// What a renderer is made of. Only for the .cpp files of render/.

#include <span>
#include <string>

#include "render/frame.h"
#include "render/model.h"
#include "render/pass_timer.h"
#include "render/pipelines.h"
#include "render/renderer.h"

namespace argil::render {

/// The images of one picture size. Those that are drawn for both eyes have a layer each.
struct Targets {
  int width = 0, height = 0, samples = 0, eyes = 0, shadowPixels = 0;
  bool cavities = false;
  Texture depth, normal, albedo, cavity, shadow, colour, picture;
  Buffer readback;

  /// Colours are drawn straight into the picture: one sample, one eye.
  [[nodiscard]] bool direct() const { return samples == 1 && eyes == 1; }
  [[nodiscard]] uint64_t bytes() const {
    const uint64_t pixels = uint64_t(width) * uint64_t(height),
                   fine = pixels * uint64_t(samples) * uint64_t(samples) * uint64_t(eyes);
    return fine * (4 + 4 + 4 + (direct() ? 0 : 4)) + pixels * (uint64_t(cavities ? 2 * eyes : 0) + 4 + 4) +
           uint64_t(shadowPixels) * uint64_t(shadowPixels) * 4;
  }
};

struct Renderer::State {
  explicit State(const RendererOptions& options)
      : quality(options.quality),
        gpu(options.device, options.validation),
        pipelines(gpu),
        model(gpu),
        timer(gpu),
        uniforms(gpu, sizeof(FrameUniforms), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, Buffer::Memory::upload),
        name(gpu.properties().deviceName),
        // Mesa 22.3's llvmpipe draws triangles over whole tiles of the second view into the first.
        eyesTogether(options.eyes == RendererOptions::Eyes::together ||
                     (options.eyes == RendererOptions::Eyes::automatic &&
                      gpu.properties().deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU)) {}

  // Pictures (picture.cpp, passes.cpp)

  /// Checks a picture that was asked for, makes its images, plans it and uploads what it needs.
  FramePlan prepare(const Shot& shot, int width, int height);
  /// All passes. Ends with the picture in `targets.picture`, as a colour attachment that was just written.
  void recordPicture(VkCommandBuffer commands, const FramePlan& plan);
  /// From there into `targets.readback`.
  void recordReadback(VkCommandBuffer commands);
  [[nodiscard]] Image readback() const;

  void resize(int width, int height, const FramePlan& plan, int samples);
  [[nodiscard]] int samplesOf(int width, int height) const;
  void uploadOverlays(const FramePlan& plan);
  Subject subject(const Shot& shot) const;
  void recordScene(VkCommandBuffer commands, const FramePlan& plan);
  Sight sight(const FramePlan& plan) const;
  void drawClay(VkCommandBuffer commands, const FramePlan& plan, bool intoShadow);
  void drawOverlays(VkCommandBuffer commands, const FramePlan& plan);
  void drawLines(VkCommandBuffer commands, Pass pass, const OverlayConstants& constants, size_t first, size_t count);
  void drawFills(VkCommandBuffer commands, const FramePlan& plan);
  void recordColours(VkCommandBuffer commands, const FramePlan& plan, const Texture& target);
  void fullscreen(VkCommandBuffer commands, Pass pass);
  /// How often a pass is recorded and for whom: Variant::eye of each turn.
  [[nodiscard]] std::span<const int> turns() const;
  [[nodiscard]] VkImageView viewFor(const Texture& texture, int turn) const;
  void bind(VkCommandBuffer commands, Pass pass);

  Quality quality;
  Gpu gpu;
  Pipelines pipelines;
  Model model;
  PassTimer timer;
  Targets targets;
  Buffer uniforms;
  std::string name;
  DrawStats stats;

  // Of the picture that is being recorded
  Variant variant;
  bool eyesTogether;  ///< In one multiview pass.
  Buffer lines;              ///< World lines by depth, screen lines, then fills.
  VkDeviceSize fillsAt = 0;  ///< Where fills begin there, bytes.
};

template <class Constants>
void push(VkCommandBuffer commands, VkPipelineLayout layout, const Constants& constants) {
  vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                     &constants);
}

}  // namespace argil::render
