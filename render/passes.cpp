// The passes of a picture, in order.

#include <algorithm>

#include "render/renderer_state.h"

namespace argil::render {
namespace {

constexpr uint32_t kShaftVertices = 28 * 6 * 6;  ///< Sides, rings, corners of shaders/shaft.vert.

constexpr ImageUse kUnused{VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr ImageUse kDrawColour{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                               VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                               VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
constexpr ImageUse kDrawDepth{
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL};
constexpr ImageUse kRead{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                         VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

VkRenderingAttachmentInfo attachment(const Texture& texture, VkImageLayout layout, VkAttachmentLoadOp load,
                                     VkClearValue clear = {}) {
  auto info = structure<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  info.imageView = texture.view();
  info.imageLayout = layout;
  info.loadOp = load;
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  info.clearValue = clear;
  return info;
}

void beginPass(VkCommandBuffer commands, VkExtent2D extent, const VkRenderingAttachmentInfo* colour,
               const VkRenderingAttachmentInfo* depth) {
  auto info = structure<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea.extent = extent;
  info.layerCount = 1;
  info.colorAttachmentCount = colour ? 1 : 0;
  info.pColorAttachments = colour;
  info.pDepthAttachment = depth;
  vkCmdBeginRendering(commands, &info);
  const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
  const VkRect2D scissor{{0, 0}, extent};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
}

}  // namespace

void Renderer::State::resize(int width, int height) {
  // Fine images may be larger than the device allows: then fewer samples.
  int samples = quality.supersample;
  const auto limit = int(gpu.properties().limits.maxImageDimension2D);
  while (samples > 1 && std::max(width, height) * samples > limit) --samples;
  if (targets.width == width && targets.height == height && targets.samples == samples) return;

  targets = Targets();
  Targets made;
  made.width = width;
  made.height = height;
  made.samples = samples;
  made.shadowPixels = quality.keyShadow ? quality.shadowPixels : 1;
  const auto w = uint32_t(width), h = uint32_t(height), fineW = uint32_t(width * samples),
             fineH = uint32_t(height * samples);
  const auto s = uint32_t(made.shadowPixels);
  constexpr VkImageUsageFlags sampled = VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags colour = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  constexpr VkImageUsageFlags depth = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  made.depth = Texture(gpu, kDepthFormat, fineW, fineH, depth | sampled);
  made.normal = Texture(gpu, kNormalFormat, fineW, fineH, colour | sampled);
  made.cavity = Texture(gpu, kCavityFormat, w, h, colour | sampled);
  made.shadow = Texture(gpu, kDepthFormat, s, s, depth | sampled);
  made.colour = Texture(gpu, kColourFormat, fineW, fineH, colour | sampled);
  made.picture = Texture(gpu, kPictureFormat, w, h, colour | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
  targets = std::move(made);
  pipelines.bind(uniforms.handle(),
                 {&targets.depth, &targets.normal, &targets.cavity, &targets.shadow, &targets.colour});
}

void Renderer::State::uploadLines(const FramePlan& plan) {
  const VkDeviceSize bytes = (plan.worldLines.size() + plan.screenLines.size()) * sizeof(LineInstance);
  if (bytes == 0) return;
  Buffer& lines = frame().lines;
  if (lines.size() < bytes) {
    lines = Buffer(gpu, bytes + bytes / 2, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Buffer::Memory::upload);
  }
  auto* out = reinterpret_cast<LineInstance*>(lines.mapped());
  out = std::copy(plan.worldLines.begin(), plan.worldLines.end(), out);
  std::copy(plan.screenLines.begin(), plan.screenLines.end(), out);
}

void Renderer::State::bind(VkCommandBuffer commands, Pass pass) {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines[pass]);
}

void Renderer::State::fullscreen(VkCommandBuffer commands, Pass pass, const Texture& target) {
  const auto colour = attachment(target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_DONT_CARE);
  beginPass(commands, target.extent(), &colour, nullptr);
  bind(commands, pass);
  vkCmdDraw(commands, 3, 1, 0, 0);
  vkCmdEndRendering(commands);
}

void Renderer::State::drawOverlays(VkCommandBuffer commands, const FramePlan& plan, bool cursor) {
  if (cursor) {
    bind(commands, Pass::shaft);
    vkCmdDraw(commands, kShaftVertices, 1, 0, 0);
  }
  const auto drawLines = [&](Pass pass, uint32_t first, size_t count) {
    if (count == 0) return;
    bind(commands, pass);
    const VkBuffer buffer = frame().lines.handle();
    const VkDeviceSize offset = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    push(commands, pipelines.layout(), pass == Pass::screenLines ? 1.0f : 0.0f);
    vkCmdDraw(commands, 6, uint32_t(count), 0, first);
  };
  drawLines(Pass::worldLines, 0, plan.worldLines.size());
  if (cursor) {
    for (const Pass pass : {Pass::ballGhost, Pass::ball}) {
      bind(commands, pass);
      push(commands, pipelines.layout(), pass == Pass::ballGhost ? 1.0f : 0.0f);
      vkCmdDraw(commands, 6, 1, 0, 0);
    }
  }
  drawLines(Pass::screenLines, uint32_t(plan.worldLines.size()), plan.screenLines.size());
}

void Renderer::State::recordPicture(VkCommandBuffer commands, const FramePlan& plan, bool cursor) {
  const VkDescriptorSet set = pipelines.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.layout(), 0, 1, &set, 0, nullptr);

  VkClearValue far{}, lit{};
  far.depthStencil.depth = 0;  // reversed
  lit.depthStencil.depth = 1;
  if (plan.uniforms.keyLight[3] > 0) {
    transition(commands, targets.shadow, kUnused, kDrawDepth);
    const auto depth =
        attachment(targets.shadow, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR, lit);
    beginPass(commands, targets.shadow.extent(), nullptr, &depth);
    drawClay(commands, plan, true);
    vkCmdEndRendering(commands);
    transition(commands, targets.shadow, kDrawDepth, kRead);
  } else {
    transition(commands, targets.shadow, kUnused, kRead);
  }

  transition(commands, targets.depth, kUnused, kDrawDepth);
  transition(commands, targets.normal, kUnused, kDrawColour);
  {
    const auto normal =
        attachment(targets.normal, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR);
    const auto depth =
        attachment(targets.depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR, far);
    beginPass(commands, targets.depth.extent(), &normal, &depth);
    drawClay(commands, plan, false);
    vkCmdEndRendering(commands);
  }
  transition(commands, targets.depth, kDrawDepth, kRead);
  transition(commands, targets.normal, kDrawColour, kRead);

  if (plan.uniforms.marker[2] > 0) {
    transition(commands, targets.cavity, kUnused, kDrawColour);
    fullscreen(commands, Pass::cavity, targets.cavity);
    transition(commands, targets.cavity, kDrawColour, kRead);
  } else {
    transition(commands, targets.cavity, kUnused, kRead);
  }

  transition(commands, targets.colour, kUnused, kDrawColour);
  fullscreen(commands, Pass::shade, targets.colour);

  transition(commands, targets.depth, kRead, kDrawDepth);
  transition(commands, targets.colour, kDrawColour, kDrawColour);
  {
    const auto colour =
        attachment(targets.colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD);
    const auto depth = attachment(targets.depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD);
    beginPass(commands, targets.colour.extent(), &colour, &depth);
    drawOverlays(commands, plan, cursor);
    vkCmdEndRendering(commands);
  }
  transition(commands, targets.colour, kDrawColour, kRead);

  transition(commands, targets.picture, kUnused, kDrawColour);
  fullscreen(commands, Pass::resolve, targets.picture);
}

}  // namespace argil::render
