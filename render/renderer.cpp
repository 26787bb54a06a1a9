#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "clay/error.h"
#include "render/renderer_state.h"

namespace argil::render {
namespace {

constexpr int kLeastEdge = 16, kMostEdge = 8192;

constexpr ImageUse kDrawn{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                          VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
constexpr ImageUse kCopyFrom{VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_BLIT_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};

void checkFinite(const Overlays& overlays) {
  if (overlays.cursor) {
    const Cursor& c = *overlays.cursor;
    if (!c.positionMm.allFinite() || !c.shaft.allFinite() || !c.drop.allFinite() || c.shaft.squaredNorm() == 0 ||
        c.drop.squaredNorm() == 0 || !(c.radiusMm > 0) || !std::isfinite(c.radiusMm)) {
      throw Error(
          "the cursor's position, shaft, drop or radius is not a finite length above zero; leave the cursor out "
          "instead");
    }
  }
  for (const Polyline& path : overlays.polylines) {
    for (const Vec3d& p : path.pointsMm) {
      if (!p.allFinite()) throw Error("a path to be drawn holds a point that is not finite; leave that point out");
    }
  }
}

void checkQuality(const Quality& q) {
  if (q.supersample < 1 || q.supersample > 4 || q.shadowPixels < 256 || q.shadowPixels > 8192 || !(q.detailPixels >= 0) ||
      q.detailPixels > 8) {
    throw Error(
        "render quality: supersample must lie between 1 and 4, shadowPixels between 256 and 8192, detailPixels between 0 and 8");
  }
}

RendererOptions checked(RendererOptions options) {
  checkQuality(options.quality);
  if (options.device.empty()) {
    if (const char* wanted = std::getenv("ARGIL_GPU")) options.device = wanted;
  }
  return options;
}

}  // namespace

Subject Renderer::State::subject(const Overlays& overlays) const {
  Subject subject;
  subject.bounds = surface.layout().bounds();
  if (!overlays.cursor) return subject;
  const Vec3d drop = overlays.cursor->drop.normalized(), from = overlays.cursor->positionMm;
  const auto hit = surface.layout().raycast(from, drop);
  if (hit) {
    // From within the clay there is nothing to fall onto.
    if (hit->fromOutside) subject.beamLengthMm = hit->distanceMm;
  } else if (overlays.grid && drop.z() < -1e-3) {
    const double length = (groundHeight(subject.bounds) - from.z()) / drop.z();
    if (length > 0) subject.beamLengthMm = length;
  }
  return subject;
}

Renderer::Renderer(const RendererOptions& options) : state_(std::make_unique<State>(checked(options))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::setQuality(const Quality& quality) {
  checkQuality(quality);
  state_->quality = quality;
}

FramePlan Renderer::State::begin(const Shot& shot, int width, int height, const UiFrame* panels) {
  shot.view.check();
  checkFinite(shot.overlays);
  if (panels) ui.check(*panels);
  slot = (slot + 1) % kFramesInFlight;
  gpu.wait(frame().ticket);
  showing = false;
  resize(width, height);
  Quality now = quality;
  now.supersample = targets.samples;
  FramePlan plan = planFrame(shot.view, shot.overlays, subject(shot.overlays), now, width, height);
  uploadLines(plan);
  if (panels) ui.upload(*panels, slot);
  return plan;
}

void Renderer::State::recordFrame(VkCommandBuffer commands, const Shot& shot, const FramePlan& plan, const UiFrame* panels) {
  stats = {};
  // Written by the device itself, in order: the frame before may still read them.
  static_assert(sizeof plan.uniforms <= 65536 && sizeof plan.uniforms % 4 == 0);
  vkCmdUpdateBuffer(commands, uniforms.handle(), 0, sizeof plan.uniforms, &plan.uniforms);
  auto written = structure<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  written.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
  written.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  written.dstStageMask = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
  written.dstAccessMask = VK_ACCESS_2_UNIFORM_READ_BIT;
  auto dependency = structure<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &written;
  vkCmdPipelineBarrier2(commands, &dependency);

  recordPicture(commands, plan, shot.overlays.cursor.has_value());
  if (panels && !panels->empty()) {
    transition(commands, targets.picture, kDrawn, kDrawn);
    ui.draw(commands, *panels, slot, targets.picture);
  }
  transition(commands, targets.picture, kDrawn, kCopyFrom);
}

Image Renderer::State::readBack() {
  const VkExtent2D extent = targets.picture.extent();
  const VkDeviceSize bytes = VkDeviceSize(extent.width) * extent.height * 4;
  if (targets.readback.size() < bytes) {
    targets.readback = Buffer(gpu, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Buffer::Memory::readback);
  }
  gpu.run([&](VkCommandBuffer commands) {
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyImageToBuffer(commands, targets.picture.image(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           targets.readback.handle(), 1, &copy);
    auto toHost = structure<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    toHost.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    toHost.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    toHost.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
    toHost.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
    auto dependency = structure<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
    dependency.memoryBarrierCount = 1;
    dependency.pMemoryBarriers = &toHost;
    vkCmdPipelineBarrier2(commands, &dependency);
  });
  Image image{int(extent.width), int(extent.height), {}};
  const auto* pixels = reinterpret_cast<const uint8_t*>(targets.readback.mapped());
  image.rgba.assign(pixels, pixels + bytes);
  return image;
}

Image Renderer::render(const Shot& shot, int width, int height, const UiFrame* panels) {
  if (std::min(width, height) < kLeastEdge || std::max(width, height) > kMostEdge) {
    throw Error("a picture of " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels cannot be drawn; choose 16 to 8192 along each side");
  }
  State& s = *state_;
  s.keepShown();
  const FramePlan plan = s.begin(shot, width, height, panels);
  s.frame().ticket = s.gpu.submit([&](VkCommandBuffer commands) { s.recordFrame(commands, shot, plan, panels); });
  return s.readBack();
}

Image Renderer::render(const View& view, const Overlays& overlays, int width, int height) {
  Shot shot;
  shot.view = view;
  shot.overlays = overlays;
  return render(shot, width, height);
}

const std::string& Renderer::deviceName() const {
  return state_->name;
}
uint64_t Renderer::deviceBytes() const {
  return state_->gpu.allocatedBytes();
}
Renderer::DrawStats Renderer::drawStats() const {
  return state_->stats;
}
bool Renderer::validating() const {
  return state_->gpu.validating();
}
std::vector<std::string> Renderer::validationMessages() const {
  std::vector<std::string> all = state_->earlierMessages;
  for (std::string& message : state_->gpu.validationMessages()) all.push_back(std::move(message));
  return all;
}

}  // namespace argil::render
