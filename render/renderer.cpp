#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "clay/error.h"
#include "render/frame.h"
#include "render/pipelines.h"
#include "render/surface_buffers.h"

namespace argil::render {
namespace {

constexpr int kLeastEdge = 16, kMostEdge = 8192;
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
constexpr ImageUse kCopyFrom{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};

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

RendererOptions checked(RendererOptions options) {
  const Quality& q = options.quality;
  if (q.supersample < 1 || q.supersample > 4 || q.shadowPixels < 256 || q.shadowPixels > 8192) {
    throw Error("render quality: supersample must lie between 1 and 4, shadowPixels between 256 and 8192");
  }
  if (options.device.empty()) {
    if (const char* wanted = std::getenv("ARGIL_GPU")) options.device = wanted;
  }
  return options;
}

bool outside(const FramePlan& plan, const Vec3d& min, const Vec3d& max) {
  for (const FramePlan::Side& side : plan.sides) {
    // The corner that lies farthest inwards.
    const Vec3d corner = (side.normal.array() > 0).select(min, max);
    if (side.normal.dot(corner - plan.eye) > side.offset) return true;
  }
  return false;
}

}  // namespace

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

namespace {

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

template <class Constants>
void push(VkCommandBuffer commands, VkPipelineLayout layout, const Constants& constants) {
  vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                     &constants);
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
  made.readback = Buffer(gpu, VkDeviceSize(w) * h * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Buffer::Memory::readback);
  targets = std::move(made);
  pipelines.bind(uniforms.handle(),
                 {&targets.depth, &targets.normal, &targets.cavity, &targets.shadow, &targets.colour});
}

void Renderer::State::uploadLines(const FramePlan& plan) {
  const VkDeviceSize bytes = (plan.worldLines.size() + plan.screenLines.size()) * sizeof(LineInstance);
  if (bytes == 0) return;
  if (lines.size() < bytes) {
    lines = Buffer(gpu, bytes + bytes / 2, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Buffer::Memory::upload);
  }
  auto* out = reinterpret_cast<LineInstance*>(lines.mapped());
  out = std::copy(plan.worldLines.begin(), plan.worldLines.end(), out);
  std::copy(plan.screenLines.begin(), plan.screenLines.end(), out);
}

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

void Renderer::State::drawClay(VkCommandBuffer commands, const FramePlan& plan, bool intoShadow) {
  const SurfaceLayout& layout = surface.layout();
  if (layout.draws().empty()) return;
  bind(commands, intoShadow ? Pass::shadow : Pass::clay);
  const VkBuffer vertices = surface.vertices();
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &offset);
  vkCmdBindIndexBuffer(commands, surface.indices(), 0, VK_INDEX_TYPE_UINT32);
  const clay::Grid& grid = layout.grid();
  for (const ChunkDraw& draw : layout.draws()) {
    if (!intoShadow) {
      if (outside(plan, grid.toWorld(draw.min), grid.toWorld(draw.max))) {
        ++stats.chunksCulled;
        continue;
      }
      ++stats.chunksDrawn;
      stats.trianglesDrawn += draw.indexCount / 3;
    }
    const Vec3f rel = (grid.toWorld(draw.firstVoxel.toVec3d()) - plan.eye).cast<float>();
    const Coord corner = draw.firstVoxel * kUnitsPerVoxel;
    const ChunkConstants constants{
        {corner.x, corner.y, corner.z}, float(grid.voxelMm / kUnitsPerVoxel), {rel.x(), rel.y(), rel.z()}};
    push(commands, pipelines.layout(), constants);
    vkCmdDrawIndexed(commands, draw.indexCount, 1, draw.firstIndex, 0, 0);
  }
}

void Renderer::State::drawOverlays(VkCommandBuffer commands, const FramePlan& plan, bool cursor) {
  if (cursor) {
    bind(commands, Pass::shaft);
    vkCmdDraw(commands, kShaftVertices, 1, 0, 0);
  }
  const auto drawLines = [&](Pass pass, uint32_t first, size_t count) {
    if (count == 0) return;
    bind(commands, pass);
    const VkBuffer buffer = lines.handle();
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

void Renderer::State::record(VkCommandBuffer commands, const FramePlan& plan, bool cursor) {
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
  transition(commands, targets.picture, kDrawColour, kCopyFrom);

  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.imageExtent = {targets.picture.extent().width, targets.picture.extent().height, 1};
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
}

Renderer::Renderer(const RendererOptions& options) : state_(std::make_unique<State>(checked(options))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

UploadStats Renderer::update(const clay::SurfaceDelta& delta) {
  return state_->surface.update(delta);
}
void Renderer::clear() {
  state_->surface.clear();
}
Box Renderer::bounds() const {
  return state_->surface.layout().bounds();
}
uint64_t Renderer::triangleCount() const {
  return state_->surface.layout().triangleCount();
}

std::optional<double> Renderer::raycast(const Vec3d& originMm, const Vec3d& direction) const {
  if (!originMm.allFinite() || !direction.allFinite() || direction.squaredNorm() == 0) return std::nullopt;
  const auto hit = state_->surface.layout().raycast(originMm, direction.normalized());
  if (!hit) return std::nullopt;
  return hit->distanceMm;
}

Image Renderer::render(const View& view, const Overlays& overlays, int width, int height) {
  view.check();
  checkFinite(overlays);
  if (std::min(width, height) < kLeastEdge || std::max(width, height) > kMostEdge) {
    throw Error("a picture of " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels cannot be drawn; choose 16 to 8192 along each side");
  }
  State& s = *state_;
  s.resize(width, height);
  Quality quality = s.quality;
  quality.supersample = s.targets.samples;
  const FramePlan plan = planFrame(view, overlays, s.subject(overlays), quality, width, height);
  std::memcpy(s.uniforms.mapped(), &plan.uniforms, sizeof plan.uniforms);
  s.uploadLines(plan);
  s.stats = {};
  s.gpu.run([&](VkCommandBuffer commands) { s.record(commands, plan, overlays.cursor.has_value()); });

  Image image{width, height, {}};
  const auto* bytes = reinterpret_cast<const uint8_t*>(s.targets.readback.mapped());
  image.rgba.assign(bytes, bytes + size_t(width) * size_t(height) * 4);
  return image;
}

const std::string& Renderer::deviceName() const {
  return state_->name;
}
uint64_t Renderer::deviceBytes() const {
  return state_->surface.bytes() + state_->targets.bytes();
}
Renderer::DrawStats Renderer::drawStats() const {
  return state_->stats;
}
bool Renderer::validating() const {
  return state_->gpu.validating();
}
std::vector<std::string> Renderer::validationMessages() const {
  return state_->gpu.validationMessages();
}

}  // namespace argil::render
