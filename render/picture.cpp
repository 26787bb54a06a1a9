// Pictures: from what was asked for to what the passes need, and back as bytes.

#include <algorithm>
#include <cstring>

#include "clay/error.h"
#include "render/renderer_state.h"

namespace argil::render {
namespace {

constexpr int kLeastEdge = 16, kMostEdge = 8192;

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
  if (!shot.overlays.cursor || !shot.look.beam) return subject;
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
  if (lines.size() < bytes) lines = Buffer(gpu, bytes + bytes / 2, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Buffer::Memory::upload);
  auto* out = reinterpret_cast<LineInstance*>(lines.mapped());
  for (const auto& each : plan.worldLines) out = std::copy(each.begin(), each.end(), out);
  std::copy(plan.screenLines.begin(), plan.screenLines.end(), out);
  std::copy(plan.fillVertices.begin(), plan.fillVertices.end(), reinterpret_cast<FillVertex*>(lines.mapped() + fillsAt));
}

FramePlan Renderer::State::prepare(const Shot& shot, int width, int height) {
  shot.view.check();
  check(shot.look);
  check(shot.stereo);
  check(shot.overlays);
  if (std::min(width, height) < kLeastEdge || std::max(width, height) > kMostEdge) {
    throw Error("a picture of " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels cannot be drawn; choose 16 to 8192 along each side");
  }
  Quality used = quality;
  used.supersample = samplesOf(width, height);
  FramePlan plan = planFrame(shot, subject(shot), used, width, height);
  resize(width, height, plan, used.supersample);
  std::memcpy(uniforms.mapped(), &plan.uniforms, sizeof plan.uniforms);
  uploadOverlays(plan);
  variant = variantOf(plan, used.supersample);
  stats = {};
  model.prepare(sight(plan));
  return plan;
}

Image Renderer::State::readback() const {
  Image image{targets.width, targets.height, {}};
  const auto* bytes = reinterpret_cast<const uint8_t*>(targets.readback.mapped());
  image.rgba.assign(bytes, bytes + size_t(image.width) * size_t(image.height) * 4);
  return image;
}

Image Renderer::render(const Shot& shot, int width, int height, const UiFrame*) {
  State& s = *state_;
  const FramePlan plan = s.prepare(shot, width, height);
  s.gpu.run([&](VkCommandBuffer commands) {
    s.recordPicture(commands, plan);
    s.recordReadback(commands);
  });
  return s.readback();
}

Image Renderer::render(const View& view, const Overlays& overlays, int width, int height) {
  return render(Shot{view, {}, {}, overlays}, width, height);
}

}  // namespace argil::render
