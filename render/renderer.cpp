#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "clay/error.h"
#include "render/renderer_state.h"

namespace argil::render {
namespace {

constexpr int kLeastEdge = 16, kMostEdge = 8192;

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
