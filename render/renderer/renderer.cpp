#include "render/renderer/renderer.h"

#include <cstdlib>

#include "clay/base/error.h"
#include "render/renderer/renderer_state.h"

namespace argil::render {
namespace {

void check(const Quality& q) {
  if (q.supersample < 1 || q.supersample > 4 || q.shadowPixels < 256 || q.shadowPixels > 8192 ||
      !(q.detailPixels >= 0 && q.detailPixels <= 8)) {
    throw Error(
        "render quality: supersample must lie between 1 and 4, shadowPixels between 256 and 8192, detailPixels between "
        "0 and 8");
  }
}

RendererOptions checked(RendererOptions options) {
  check(options.quality);
  if (options.device.empty()) {
    if (const char* wanted = std::getenv("ARGIL_GPU")) options.device = wanted;
  }
  return options;
}

}  // namespace

Renderer::Renderer(const RendererOptions& options) : state_(std::make_unique<State>(checked(options))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::setQuality(const Quality& quality) {
  check(quality);
  state_->quality = quality;
}

const std::string& Renderer::deviceName() const {
  return state_->name;
}
uint64_t Renderer::deviceBytes() const {
  return state_->gpu.allocatedBytes();
}
Renderer::DrawStats Renderer::drawStats() const {
  DrawStats stats = state_->stats;
  stats.pictures = state_->pictures;
  return stats;
}
bool Renderer::validating() const {
  return state_->gpu.validating();
}
std::vector<std::string> Renderer::validationMessages() const {
  return state_->log->all();
}

}  // namespace argil::render
