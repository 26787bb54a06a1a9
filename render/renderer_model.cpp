// The model that a renderer holds.

#include "render/renderer_state.h"

namespace argil::render {

UploadStats Renderer::update(PieceId, const clay::SurfaceDelta& delta) {
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

}  // namespace argil::render
