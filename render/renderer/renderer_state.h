#pragma once
// What a renderer is made of. Only for the .cpp files of render/.

#include <array>
#include <memory>
#include <span>
#include <string>

#include "render/gpu/pass_timer.h"
#include "render/gpu/ui_pass.h"
#include "render/gpu/window_target.h"
#include "render/renderer/frame.h"
#include "render/renderer/model.h"
#include "render/renderer/pipelines.h"
#include "render/renderer/renderer.h"

namespace argil::render {

/// The images of one picture size. Those that are drawn for both eyes have a layer each.
struct Targets {
  int width = 0, height = 0, samples = 0, eyes = 0, shadowPixels = 0;
  bool cavities = false;
  Texture depth, normal, albedo, cavity, shadow, colour, picture;
  Texture framed;   ///< The picture with panels over it: the picture itself stays for other panels.
  Buffer readback;  ///< Made when first asked for.

  /// Colours are drawn straight into the picture: one sample, one eye.
  [[nodiscard]] bool direct() const { return samples == 1 && eyes == 1; }
};

/// What the CPU writes for one of the frames that may be under way.
struct FrameSlot {
  Gpu::Ticket ticket = 0;  ///< Of the last frame that used it.
  Buffer lines;            ///< World lines by depth, screen lines, then fills.
};

struct Renderer::State {
  explicit State(const RendererOptions& given, std::shared_ptr<MessageLog> messages = std::make_shared<MessageLog>())
      : options(given),
        log(std::move(messages)),
        quality(options.quality),
        gpu(options, log),
        pipelines(gpu),
        model(gpu, options.levels),
        timer(gpu),
        uniforms(gpu, sizeof(FrameUniforms), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                 Buffer::Memory::device),
        name(gpu.properties().deviceName),
        // Mesa 22.3's llvmpipe draws triangles over whole tiles of the second view into the first.
        eyesTogether(options.eyes == RendererOptions::Eyes::together ||
                     (options.eyes == RendererOptions::Eyes::automatic && !gpu.software())),
        ui(gpu, kPictureFormat) {}
  ~State() { gpu.settle(); }

  // Pictures (picture.cpp, passes.cpp)

  /// Checks a picture that was asked for, plans it, makes its images, takes the slot of the frame before the last when
  /// the device is done with it, and uploads what the picture needs. Levels of detail come after that
  /// (Model::prepare): all that a picture cannot do without has its memory by then.
  FramePlan prepare(const Shot& shot, int width, int height, const UiFrame* panels);
  /// All passes. Ends with the picture in `targets.picture`, as a colour attachment that was just written.
  void recordPicture(VkCommandBuffer commands, const FramePlan& plan);
  /// The picture and panels over it. Ends with `targets.picture` ready to be copied from, with panels `targets.framed`
  /// too.
  void recordFrame(VkCommandBuffer commands, const FramePlan& plan, const UiFrame* panels);
  /// Panels over the picture that `targets.picture` holds.
  void recordPanels(VkCommandBuffer commands, const UiFrame& panels);
  void reserveReadBack();
  /// What was drawn last, with or without its panels; waits for it.
  [[nodiscard]] Image readBack(const Texture& source);
  /// The slot of the frame before the last, once the device is done with it.
  void takeSlot();

  void resize(int width, int height, const FramePlan& plan, int samples);
  void makeTargets(int width, int height, const FramePlan& plan, int samples);
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

  RendererOptions options;
  std::shared_ptr<MessageLog> log;
  Quality quality;
  Gpu gpu;
  Pipelines pipelines;
  Model model;
  PassTimer timer;
  Targets targets;
  Targets resting;  ///< Of the same size with other samples, for when pictures move or rest again.
  Buffer uniforms;
  std::string name;
  DrawStats stats;

  // Of the picture that is being recorded
  Variant variant;
  bool eyesTogether;         ///< In one multiview pass.
  VkDeviceSize fillsAt = 0;  ///< Where fills begin in its slot's lines, bytes.

  // Frames and the window (renderer_window.cpp)

  [[nodiscard]] FrameSlot& frame() { return slots[slot]; }
  /// Before another picture is drawn: what the window shows, for lastPresented().
  void keepShown();

  std::array<FrameSlot, kFramesInFlight> slots;
  size_t slot = 0;
  UiPass ui;
  WindowHooks hooks;  ///< Kept when the device is lost.
  bool attached = false;
  std::unique_ptr<WindowTarget> window;
  bool showing = false;   ///< The picture drawn last is the one in the window.
  int64_t waitedNs = 0;   ///< Of the last frame: see Renderer::waitedNs().
  uint64_t pictures = 0;  ///< Drawn so far, with all passes.
  Image shown;            ///< What the window shows if another picture was drawn since.
};

template <class Constants>
void push(VkCommandBuffer commands, VkPipelineLayout layout, const Constants& constants) {
  vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                     &constants);
}

}  // namespace argil::render
