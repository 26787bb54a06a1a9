// The model that a renderer holds.

#include "render/renderer/renderer_state.h"

namespace argil::render {

UploadStats Renderer::update(PieceId piece, const clay::SurfaceDelta& delta) {
  return state_->model.update(piece, delta);
}
UploadStats Renderer::updatePart(PieceId part, const clay::TriangleMesh& mesh) {
  return state_->model.updatePart(part, mesh);
}
void Renderer::place(PieceId piece, const PieceLook& look) {
  state_->model.place(piece, look);
}
void Renderer::remove(PieceId piece) {
  state_->model.remove(piece);
}
void Renderer::clear() {
  state_->model.clear();
}

Box Renderer::bounds() const {
  return state_->model.bounds();
}
Box Renderer::bounds(PieceId piece) const {
  return state_->model.bounds(piece);
}
uint64_t Renderer::triangleCount() const {
  return state_->model.triangleCount();
}

std::optional<Renderer::Hit> Renderer::pick(const Vec3d& originMm, const Vec3d& direction,
                                            const std::optional<Section>& section) const {
  if (!originMm.allFinite() || !direction.allFinite() || direction.squaredNorm() == 0) return std::nullopt;
  return state_->model.pick(originMm, direction.normalized(), section);
}
std::optional<double> Renderer::raycast(const Vec3d& originMm, const Vec3d& direction) const {
  const auto hit = pick(originMm, direction);
  if (!hit) return std::nullopt;
  return hit->distanceMm;
}

std::vector<PassTime> Renderer::passTimes() const {
  return state_->timer.read();
}

}  // namespace argil::render
