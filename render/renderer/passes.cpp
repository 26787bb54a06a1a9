// The passes of a picture, in order.

#include <algorithm>
#include <span>
#include <utility>

#include "render/renderer/renderer_state.h"

namespace argil::render {
namespace {

constexpr uint32_t kShaftVertices = 28 * 6 * 6;  ///< Sides, rings, corners of shaders/shaft.vert.
/// How much of a guide shows through clay.
constexpr float kXray = 0.24f;

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
constexpr ImageUse kTestDepth{VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |
                                  VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                              VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                              VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL};

VkRenderingAttachmentInfo attachment(VkImageView view, VkImageLayout layout, VkAttachmentLoadOp load,
                                     VkClearValue clear = {}) {
  auto info = structure<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  info.imageView = view;
  info.imageLayout = layout;
  info.loadOp = load;
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  info.clearValue = clear;
  return info;
}

VkRenderingAttachmentInfo colourAttachment(VkImageView view, VkAttachmentLoadOp load, VkClearValue clear = {}) {
  return attachment(view, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, load, clear);
}

VkRenderingAttachmentInfo depthAttachment(VkImageView view, VkAttachmentLoadOp load, VkClearValue clear = {}) {
  return attachment(view, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, load, clear);
}

void beginPass(VkCommandBuffer commands, VkExtent2D extent, int turn,
               std::span<const VkRenderingAttachmentInfo> colours, const VkRenderingAttachmentInfo* depth) {
  auto info = structure<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea.extent = extent;
  info.layerCount = 1;
  info.viewMask = turn == kBothEyes ? 3 : 0;
  info.colorAttachmentCount = uint32_t(colours.size());
  info.pColorAttachments = colours.data();
  info.pDepthAttachment = depth;
  vkCmdBeginRendering(commands, &info);
  const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
  const VkRect2D scissor{{0, 0}, extent};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
}

}  // namespace

int Renderer::State::samplesOf(int width, int height) const {
  // Fine images may be larger than the device allows: then fewer samples.
  int samples = quality.supersample;
  const auto limit = int(gpu.properties().limits.maxImageDimension2D);
  while (samples > 1 && std::max(width, height) * samples > limit) --samples;
  return samples;
}

void Renderer::State::resize(int width, int height, const FramePlan& plan, int samples) {
  // What a look does not use is kept as a single pixel. Once there, images stay: looks change back and forth.
  const auto serves = [&](const Targets& t) {
    return t.width == width && t.height == height && t.samples == samples && t.eyes == plan.eyes();
  };
  const auto fits = [&](const Targets& t) {
    return serves(t) && (t.cavities || !plan.look.cavity) &&
           (t.shadowPixels == quality.shadowPixels || !plan.look.keyShadow);
  };
  if (fits(targets)) return;
  // Moving pictures and those at rest differ in their samples and take turns: the images of both are kept.
  const bool turns =
      targets.width == width && targets.height == height && targets.eyes == plan.eyes() && targets.samples != samples;
  if (turns) std::swap(targets, resting);
  if (!turns) resting = Targets();
  if (!fits(targets)) makeTargets(width, height, plan, samples);
  gpu.settle();  // frames under way read the same set
  pipelines.bind(uniforms.handle(),
                 {&targets.depth, &targets.normal, &targets.cavity, &targets.shadow, &targets.colour, &targets.albedo});
}

void Renderer::State::makeTargets(int width, int height, const FramePlan& plan, int samples) {
  const bool same =
      targets.width == width && targets.height == height && targets.samples == samples && targets.eyes == plan.eyes();
  const bool cavities = plan.look.cavity || (same && targets.cavities);
  const int shadowPixels = plan.look.keyShadow ? quality.shadowPixels : (same ? targets.shadowPixels : 1);
  targets = Targets();
  Targets made;
  made.width = width;
  made.height = height;
  made.samples = samples;
  made.eyes = plan.eyes();
  made.cavities = cavities;
  made.shadowPixels = shadowPixels;
  const auto w = uint32_t(width), h = uint32_t(height), fineW = uint32_t(width * samples),
             fineH = uint32_t(height * samples);
  const auto eyes = uint32_t(made.eyes), s = uint32_t(made.shadowPixels);
  constexpr VkImageUsageFlags sampled = VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags colour = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  constexpr VkImageUsageFlags depth = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  const auto whole = [](bool used, uint32_t edge) { return used ? edge : 1; };
  made.depth = Texture(gpu, kDepthFormat, fineW, fineH, depth | sampled, eyes);
  made.normal = Texture(gpu, kNormalFormat, fineW, fineH, colour | sampled, eyes);
  made.albedo = Texture(gpu, kAlbedoFormat, fineW, fineH, colour | sampled, eyes);
  made.cavity = Texture(gpu, kCavityFormat, whole(cavities, w), whole(cavities, h), colour | sampled, eyes);
  made.shadow = Texture(gpu, kDepthFormat, s, s, depth | sampled);
  made.colour =
      Texture(gpu, kColourFormat, whole(!made.direct(), fineW), whole(!made.direct(), fineH), colour | sampled, eyes);
  made.picture = Texture(gpu, kPictureFormat, w, h, colour | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, 0, kColourFormat);
  made.framed =
      Texture(gpu, kPictureFormat, w, h, colour | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
  targets = std::move(made);
}

void Renderer::State::bind(VkCommandBuffer commands, Pass pass) {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.get(pass, variant));
}

void Renderer::State::fullscreen(VkCommandBuffer commands, Pass pass) {
  bind(commands, pass);
  vkCmdDraw(commands, 3, 1, 0, 0);
}

std::span<const int> Renderer::State::turns() const {
  static constexpr int kOne[] = {0}, kTogether[] = {kBothEyes}, kApart[] = {0, 1};
  if (targets.eyes == 1) return kOne;
  if (eyesTogether) return kTogether;
  return kApart;
}

VkImageView Renderer::State::viewFor(const Texture& texture, int turn) const {
  if (&texture == &targets.picture) return texture.aliasView();
  return targets.eyes == 1 || turn == kBothEyes ? texture.view() : texture.layerView(uint32_t(turn));
}

void Renderer::State::drawLines(VkCommandBuffer commands, Pass pass, const OverlayConstants& constants, size_t first,
                                size_t count) {
  if (count == 0) return;
  bind(commands, pass);
  const VkBuffer buffer = frame().lines.handle();
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
  push(commands, pipelines.layout(), constants);
  vkCmdDraw(commands, 6, uint32_t(count), 0, uint32_t(first));
}

void Renderer::State::drawFills(VkCommandBuffer commands, const FramePlan& plan) {
  const VkBuffer buffer = frame().lines.handle();
  const auto draw = [&](Pass pass, float strength, const FramePlan::FillRun& run) {
    bind(commands, pass);
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &fillsAt);
    push(commands, pipelines.layout(), OverlayConstants{0, strength});
    vkCmdDraw(commands, run.count, 1, run.first, 0);
  };
  for (const FramePlan::FillRun& run : plan.fills) {
    if (run.depth == Depth::xray) draw(Pass::fillsBehind, kXray, run);
    draw(run.depth == Depth::onTop ? Pass::fillsOnTop : Pass::fills, 1, run);
  }
}

void Renderer::State::drawOverlays(VkCommandBuffer commands, const FramePlan& plan) {
  drawFills(commands, plan);
  if (plan.cursor) {
    bind(commands, Pass::shaft);
    vkCmdDraw(commands, kShaftVertices, 1, 0, 0);
  }
  const size_t hidden = plan.worldLines[size_t(Depth::hidden)].size(),
               xray = plan.worldLines[size_t(Depth::xray)].size(), onTop = plan.worldLines[size_t(Depth::onTop)].size();
  drawLines(commands, Pass::linesBehind, {0, kXray}, hidden, xray);
  drawLines(commands, Pass::lines, {}, 0, hidden + xray);
  if (plan.cursor) {
    for (const Pass pass : {Pass::ballGhost, Pass::ball}) {
      bind(commands, pass);
      push(commands, pipelines.layout(), OverlayConstants{pass == Pass::ballGhost ? 1.0f : 0.0f, 1});
      vkCmdDraw(commands, 6, 1, 0, 0);
    }
  }
  drawLines(commands, Pass::linesOnTop, {}, hidden + xray, onTop);
  drawLines(commands, Pass::linesOnTop, {1, 1}, hidden + xray + onTop, plan.screenLines.size());
}

/// Clay as depth, normals and colours; where the section cuts it, moved to the plane.
void Renderer::State::recordScene(VkCommandBuffer commands, const FramePlan& plan) {
  VkClearValue far{}, none{}, noCode{};
  far.depthStencil.depth = 0;  // reversed
  noCode.color.float32[3] = 1;
  transition(commands, targets.depth, kUnused, kDrawDepth);
  transition(commands, targets.normal, kUnused, kDrawColour);
  transition(commands, targets.albedo, kUnused, kDrawColour);
  for (const int turn : turns()) {
    variant.eye = turn;
    const uint64_t shadow = stats.shadowTriangles;
    stats = {};  // an eye alone counts like both
    stats.levelBytes = model.levelBytes();
    stats.shadowTriangles = shadow;
    const VkRenderingAttachmentInfo colours[] = {
        colourAttachment(viewFor(targets.normal, turn), VK_ATTACHMENT_LOAD_OP_CLEAR, none),
        colourAttachment(viewFor(targets.albedo, turn), VK_ATTACHMENT_LOAD_OP_CLEAR, noCode)};
    const auto depth = depthAttachment(viewFor(targets.depth, turn), VK_ATTACHMENT_LOAD_OP_CLEAR, far);
    beginPass(commands, targets.depth.extent(), turn, colours, &depth);
    drawClay(commands, plan, false);
    vkCmdEndRendering(commands);
  }
  transition(commands, targets.normal, kDrawColour, kRead);
  transition(commands, targets.albedo, kDrawColour, kRead);
  if (plan.look.section) {
    transition(commands, targets.depth, kDrawDepth, kDrawDepth);
    for (const int turn : turns()) {
      variant.eye = turn;
      const auto depth = depthAttachment(viewFor(targets.depth, turn), VK_ATTACHMENT_LOAD_OP_LOAD);
      beginPass(commands, targets.depth.extent(), turn, {}, &depth);
      fullscreen(commands, Pass::cap);
      vkCmdEndRendering(commands);
    }
  }
  transition(commands, targets.depth, kDrawDepth, kTestDepth);
}

/// Background, clay and ground, which only test depth; then what may hide each other.
void Renderer::State::recordColours(VkCommandBuffer commands, const FramePlan& plan, const Texture& target) {
  transition(commands, target, kUnused, kDrawColour);
  for (const int turn : turns()) {
    variant.eye = turn;
    const auto colour = colourAttachment(viewFor(target, turn), VK_ATTACHMENT_LOAD_OP_DONT_CARE);
    auto depth = depthAttachment(viewFor(targets.depth, turn), VK_ATTACHMENT_LOAD_OP_LOAD);
    depth.imageLayout = kTestDepth.layout;
    depth.storeOp = VK_ATTACHMENT_STORE_OP_NONE;
    beginPass(commands, target.extent(), turn, {&colour, 1}, &depth);
    fullscreen(commands, Pass::backdrop);
    fullscreen(commands, Pass::shade);
    if (plan.ground != FramePlan::Ground::none) {
      bind(commands, plan.ground == FramePlan::Ground::below ? Pass::groundBelow : Pass::ground);
      vkCmdDraw(commands, 6, 1, 0, 0);
    }
    if (const auto& box = plan.landing; !box.empty()) {
      const VkRect2D scissor{{box.left, box.top}, {uint32_t(box.right - box.left), uint32_t(box.bottom - box.top)}};
      vkCmdSetScissor(commands, 0, 1, &scissor);
      fullscreen(commands, Pass::landing);
    }
    vkCmdEndRendering(commands);
  }
  timer.mark(commands, "shade");
  transition(commands, targets.depth, kTestDepth, kDrawDepth);
  transition(commands, target, kDrawColour, kDrawColour);
  for (const int turn : turns()) {
    variant.eye = turn;
    const auto colour = colourAttachment(viewFor(target, turn), VK_ATTACHMENT_LOAD_OP_LOAD);
    const auto depth = depthAttachment(viewFor(targets.depth, turn), VK_ATTACHMENT_LOAD_OP_LOAD);
    beginPass(commands, target.extent(), turn, {&colour, 1}, &depth);
    drawOverlays(commands, plan);
    vkCmdEndRendering(commands);
  }
  timer.mark(commands, "overlays");
}

void Renderer::State::recordPicture(VkCommandBuffer commands, const FramePlan& plan) {
  const VkDescriptorSet set = pipelines.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.layout(), 0, 1, &set, 0, nullptr);
  timer.begin(commands);

  if (plan.look.keyShadow) {
    VkClearValue lit{};
    lit.depthStencil.depth = 1;
    transition(commands, targets.shadow, kUnused, kDrawDepth);
    const auto depth = depthAttachment(targets.shadow.view(), VK_ATTACHMENT_LOAD_OP_CLEAR, lit);
    beginPass(commands, targets.shadow.extent(), 0, {}, &depth);
    drawClay(commands, plan, true);
    vkCmdEndRendering(commands);
    transition(commands, targets.shadow, kDrawDepth, kRead);
  } else {
    transition(commands, targets.shadow, kUnused, kRead);
  }
  timer.mark(commands, "shadow");

  recordScene(commands, plan);
  timer.mark(commands, "clay");

  if (plan.look.cavity) {
    transition(commands, targets.cavity, kUnused, kDrawColour);
    for (const int turn : turns()) {
      variant.eye = turn;
      const auto cavity = colourAttachment(viewFor(targets.cavity, turn), VK_ATTACHMENT_LOAD_OP_DONT_CARE);
      beginPass(commands, targets.cavity.extent(), turn, {&cavity, 1}, nullptr);
      fullscreen(commands, Pass::cavity);
      vkCmdEndRendering(commands);
    }
    transition(commands, targets.cavity, kDrawColour, kRead);
  } else {
    transition(commands, targets.cavity, kUnused, kRead);
  }
  timer.mark(commands, "cavity");

  recordColours(commands, plan, targets.direct() ? targets.picture : targets.colour);
  if (targets.direct()) return;
  transition(commands, targets.colour, kDrawColour, kRead);
  transition(commands, targets.picture, kUnused, kDrawColour);
  const auto picture = colourAttachment(targets.picture.aliasView(), VK_ATTACHMENT_LOAD_OP_DONT_CARE);
  beginPass(commands, targets.picture.extent(), 0, {&picture, 1}, nullptr);
  fullscreen(commands, Pass::resolve);
  vkCmdEndRendering(commands);
  timer.mark(commands, "resolve");
}

}  // namespace argil::render
