// Pictures: from what was asked for to what the passes need, and back as bytes.

#include <algorithm>
#include <chrono>

#include "clay/base/error.h"
#include "render/renderer/renderer_state.h"

namespace argil::render {
namespace {

constexpr int kLeastEdge = 16, kMostEdge = 8192;

constexpr ImageUse kDrawn{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                          VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
constexpr ImageUse kWanted{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, 0, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr ImageUse kCopyTo{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
constexpr ImageUse kCopyFrom{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};

Variant variantOf(const FramePlan& plan, int samples) {
  const Look& look = plan.look;
  Variant v;
  v.perspective = plan.perspective;
  v.shading = int32_t(look.shading);
  v.matcap = look.shading == Shading::matcap ? int32_t(look.matcap) : 0;
  v.keyShadow = look.keyShadow;
  v.cavity = look.cavity;
  v.cursorShadow = plan.cursor && look.cursorShadow;
  v.depthFade = look.depthFade;
  v.section = look.section.has_value();
  v.ground = int32_t(plan.ground);
  v.stereoMode = plan.eyes() == 2 ? int32_t(plan.stereo) : 0;
  v.samples = samples;
  return v;
}

}  // namespace

Subject Renderer::State::subject(const Shot& shot) const {
  Subject subject;
  subject.bounds = model.bounds();
  if (!shot.overlays.cursor || shot.overlays.cursor->flat || !shot.look.beam) return subject;
  const Cursor& cursor = *shot.overlays.cursor;
  const Vec3d drop = cursor.drop.normalized(), from = cursor.positionMm;
  const auto hit = model.pick(from, drop, shot.look.section);
  if (hit) {
    // From within the clay there is nothing to fall onto.
    if (hit->fromOutside) subject.beamLengthMm = hit->distanceMm;
  } else if (shot.look.grid && drop.z() < -1e-3) {
    const double length = (groundHeight(subject.bounds) - from.z()) / drop.z();
    if (length > 0) subject.beamLengthMm = length;
  }
  return subject;
}

void Renderer::State::uploadOverlays(const FramePlan& plan) {
  size_t count = plan.screenLines.size();
  for (const auto& each : plan.worldLines) count += each.size();
  fillsAt = count * sizeof(LineInstance);
  const VkDeviceSize bytes = fillsAt + plan.fillVertices.size() * sizeof(FillVertex);
  if (bytes == 0) return;
  Buffer& lines = frame().lines;
  if (lines.size() < bytes)
    lines = Buffer(gpu, bytes + bytes / 2, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Buffer::Memory::upload);
  auto* out = reinterpret_cast<LineInstance*>(lines.mapped());
  for (const auto& each : plan.worldLines) out = std::copy(each.begin(), each.end(), out);
  std::copy(plan.screenLines.begin(), plan.screenLines.end(), out);
  std::copy(plan.fillVertices.begin(), plan.fillVertices.end(),
            reinterpret_cast<FillVertex*>(lines.mapped() + fillsAt));
}

void Renderer::State::takeSlot() {
  slot = (slot + 1) % kFramesInFlight;
  const auto begin = std::chrono::steady_clock::now();
  gpu.wait(frame().ticket);
  waitedNs = std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
}

FramePlan Renderer::State::prepare(const Shot& shot, int width, int height, const UiFrame* panels) {
  shot.view.check();
  check(shot.look);
  check(shot.stereo);
  check(shot.overlays);
  if (std::min(width, height) < kLeastEdge || std::max(width, height) > kMostEdge) {
    throw Error("a picture of " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels cannot be drawn; choose 16 to 8192 along each side");
  }
  if (panels) ui.check(*panels);
  takeSlot();
  showing = false;
  Quality used = quality;
  used.supersample = samplesOf(width, height);
  FramePlan plan = planFrame(shot, subject(shot), used, width, height);
  resize(width, height, plan, used.supersample);
  uploadOverlays(plan);
  if (panels) ui.upload(*panels, slot);
  variant = variantOf(plan, used.supersample);
  stats = {};
  return plan;
}

void Renderer::State::recordFrame(VkCommandBuffer commands, const FramePlan& plan, const UiFrame* panels) {
  // Written by the device itself, in order: the frame before may still read them.
  static_assert(sizeof plan.uniforms <= 65536 && sizeof plan.uniforms % 4 == 0);
  vkCmdUpdateBuffer(commands, uniforms.handle(), 0, sizeof plan.uniforms, &plan.uniforms);
  barrier(
      commands, {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT},
      {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_UNIFORM_READ_BIT});
  recordPicture(commands, plan);
  ++pictures;
  transition(commands, targets.picture, kDrawn, kCopyFrom);
  if (!panels) return;
  recordPanels(commands, *panels);
  timer.mark(commands, "panels");
}

void Renderer::State::recordPanels(VkCommandBuffer commands, const UiFrame& panels) {
  transition(commands, targets.framed, kWanted, kCopyTo);
  const VkExtent2D extent = targets.picture.extent();
  VkImageCopy copy{};
  copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.extent = {extent.width, extent.height, 1};
  vkCmdCopyImage(commands, targets.picture.image(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, targets.framed.image(),
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  transition(commands, targets.framed, kCopyTo, kDrawn);
  ui.draw(commands, panels, slot, targets.framed);
  transition(commands, targets.framed, kDrawn, kCopyFrom);
}

void Renderer::State::reserveReadBack() {
  const VkDeviceSize bytes = 4 * VkDeviceSize(targets.width) * VkDeviceSize(targets.height);
  if (targets.readback.size() >= bytes) return;
  targets.readback = Buffer(gpu, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Buffer::Memory::readback);
}

Image Renderer::State::readBack(const Texture& source) {
  static_assert(kPictureFormat == VK_FORMAT_B8G8R8A8_UNORM);
  const VkExtent2D extent = source.extent();
  Image image{int(extent.width), int(extent.height), {}};
  image.rgba.resize(4 * size_t(extent.width) * extent.height);
  reserveReadBack();
  gpu.run([&](VkCommandBuffer commands) {
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyImageToBuffer(commands, source.image(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, targets.readback.handle(), 1,
                           &copy);
    barrier(commands, {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT},
            {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT});
  });
  const auto* bgra = reinterpret_cast<const uint8_t*>(targets.readback.mapped());
  for (size_t i = 0; i < image.rgba.size(); i += 4) {
    image.rgba[i] = bgra[i + 2];
    image.rgba[i + 1] = bgra[i + 1];
    image.rgba[i + 2] = bgra[i];
    image.rgba[i + 3] = bgra[i + 3];
  }
  return image;
}

Image Renderer::render(const Shot& shot, int width, int height, const UiFrame* panels) {
  State& s = *state_;
  s.keepShown();
  const FramePlan plan = s.prepare(shot, width, height, panels);
  s.reserveReadBack();
  s.model.prepare(s.sight(plan));
  s.frame().ticket = s.gpu.submit([&](VkCommandBuffer commands) { s.recordFrame(commands, plan, panels); });
  return s.readBack(panels ? s.targets.framed : s.targets.picture);
}

Image Renderer::render(const View& view, const Overlays& overlays, int width, int height) {
  return render(Shot{view, {}, {}, overlays}, width, height);
}

}  // namespace argil::render
