#include "render/renderer/model.h"

#include <malloc.h>

#include <cmath>

#include "clay/base/error.h"

namespace argil::render {
namespace {

/// What a section leaves of a ray; nothing when it cuts all of it away.
std::optional<Ray> kept(const Ray& whole, const std::optional<Section>& section) {
  Ray ray = whole;
  if (!section) return ray;
  const double away = section->normal.dot(ray.origin - section->pointMm), slope = section->normal.dot(ray.direction);
  if (slope > 0) ray.last = -away / slope;
  if (slope < 0) ray.first = std::max(0.0, -away / slope);
  if (slope == 0 && away > 0) return std::nullopt;
  if (ray.last < ray.first) return std::nullopt;
  return ray;
}

/// A software driver takes memory for every picture and gives it back: kept by the process, a picture of 200 k
/// triangles costs a third less. What is as large as an image of the window goes back all the same, or a window that
/// changes its size would leave the heap in pieces. For the whole process: that is how malloc is told.
void keepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

}  // namespace

Model::Model(Gpu& gpu, RendererOptions::Levels levels)
    : gpu_(gpu),
      onDevice_(
          LevelKernel::possibleOn(gpu) &&
          (levels == RendererOptions::Levels::automatic ? !gpu.software() : levels == RendererOptions::Levels::device)),
      buffers_(gpu, onDevice_),
      list_(gpu) {
  if (gpu.software())
    keepFreedMemory();
  else
    buffers_.ranges().leaveRoom();
  buffers_.ranges().onFull([this] {
    bool any = false;
    for (auto& [id, piece] : pieces_) any |= piece.clay && piece.clay->dropKept();
    return any;
  });
}

void Model::makeKernel() {
  if (!onDevice_ || kernel_) return;
  try {
    kernel_.emplace(gpu_, buffers_);
  } catch (const Error&) {  // a driver that refuses them draws all the same
    onDevice_ = false;
  }
}

UploadStats Model::update(PieceId id, const clay::SurfaceDelta& delta) {
  makeKernel();  // here, rather than while the picture moves
  Piece& piece = pieces_[id];
  piece.part.reset();
  if (!piece.clay) piece.clay = std::make_unique<SurfaceLayout>(buffers_.ranges());
  piece.bounds.reset();
  try {
    return buffers_.update([&](UploadSink& sink) {
      piece.clay->hideMasked(lookOf(id).hideMasked, sink);
      piece.clay->colourMaterials(lookOf(id).materials, sink);
      piece.clay->apply(delta, sink);
    });
  } catch (...) {
    // Half of an update is worse than none: the piece goes, the others stay.
    if (!piece.clay->whole() || piece.clay->brickCount() == 0) pieces_.erase(id);
    throw;
  }
}

UploadStats Model::updatePart(PieceId id, const clay::TriangleMesh& mesh) {
  std::unique_ptr<PartLayout> part;
  const UploadStats stats =
      buffers_.update([&](UploadSink& sink) { part = std::make_unique<PartLayout>(mesh, buffers_.ranges(), sink); });
  Piece piece;
  piece.part = std::move(part);
  pieces_[id] = std::move(piece);
  return stats;
}

void Model::place(PieceId id, const PieceLook& look) {
  const auto& c = look.colour;
  const double length = look.rotation.norm();
  if (!look.translationMm.allFinite() || !look.rotation.coeffs().allFinite() || !(length > 1e-6) ||
      !std::isfinite(c.r) || !std::isfinite(c.g) || !std::isfinite(c.b) || !std::isfinite(look.roughness) ||
      !std::isfinite(look.gloss) || !(look.grownMm >= 0 && std::isfinite(look.grownMm)) ||
      !(look.scale.minCoeff() > 0 && look.scale.allFinite())) {
    throw Error("the place, colour or finish of a piece holds a number that is not finite; give finite numbers");
  }
  PieceLook& kept = looks_[id];
  kept = look;
  kept.rotation.normalize();
  const auto it = pieces_.find(id);
  if (it == pieces_.end()) return;
  it->second.bounds.reset();
  if (!it->second.clay) return;
  buffers_.update([&](UploadSink& sink) {
    it->second.clay->hideMasked(look.hideMasked, sink);
    it->second.clay->colourMaterials(look.materials, sink);
  });
}

void Model::remove(PieceId id) {
  pieces_.erase(id);
  looks_.erase(id);
}

void Model::clear() {
  pieces_.clear();
  looks_.clear();
  buffers_.clear();
}

const PieceLook& Model::lookOf(PieceId id) const {
  static const PieceLook plain;
  const auto it = looks_.find(id);
  return it == looks_.end() ? plain : it->second;
}

const Box& Model::boundsOf(PieceId id, const Piece& piece) const {
  if (piece.bounds) return *piece.bounds;
  const PieceLook& look = lookOf(id);
  const Vec3d unscaled = look.translationMm.cwiseQuotient(look.scale);
  piece.bounds = piece.clay ? piece.clay->bounds(look.rotation, unscaled) : piece.part->bounds(look.rotation, unscaled);
  if (!piece.bounds->empty()) {
    piece.bounds->min = piece.bounds->min.cwiseProduct(look.scale);
    piece.bounds->max = piece.bounds->max.cwiseProduct(look.scale);
  }
  if (piece.clay && look.grownMm > 0 && !piece.bounds->empty()) {
    piece.bounds->min -= Vec3d::Constant(look.grownMm);
    piece.bounds->max += Vec3d::Constant(look.grownMm);
  }
  return *piece.bounds;
}

Box Model::bounds() const {
  Box box;
  for (const auto& [id, piece] : pieces_)
    if (lookOf(id).visible) box.add(boundsOf(id, piece));
  return box;
}

Box Model::bounds(PieceId id) const {
  const auto it = pieces_.find(id);
  return it == pieces_.end() || !lookOf(id).visible ? Box() : boundsOf(id, it->second);
}

uint64_t Model::triangleCount() const {
  uint64_t sum = 0;
  for (const auto& [id, piece] : pieces_)
    sum += piece.clay ? piece.clay->triangleCount() : piece.part->draw().triangles;
  return sum;
}

std::optional<Renderer::Hit> Model::pick(const Vec3d& originMm, const Vec3d& unit,
                                         const std::optional<Section>& section) const {
  auto ray = kept({originMm, unit}, section);
  std::optional<Renderer::Hit> best;
  if (!ray) return best;
  for (const auto& [id, piece] : pieces_) {
    const PieceLook& look = lookOf(id);
    if (!look.visible) continue;
    const Box& box = boundsOf(id, piece);
    if (box.empty() || enterBox(*ray, box.min, box.max) == kNever) continue;
    const Eigen::Quaterniond back = look.rotation.conjugate();
    const Vec3d direction = back * ray->direction.cwiseQuotient(look.scale);
    const double shrunk = direction.norm();
    const Ray own{back * (ray->origin - look.translationMm).cwiseQuotient(look.scale), direction / shrunk,
                  ray->first * shrunk, ray->last * shrunk};
    const auto hit = piece.clay ? piece.clay->raycast(own) : piece.part->raycast(own);
    if (!hit) continue;
    const double distance = hit->distanceMm / shrunk;
    if (best && distance >= best->distanceMm) continue;
    best = Renderer::Hit{id, distance, hit->fromOutside,
                         (look.rotation * hit->normal).cwiseQuotient(look.scale).normalized()};
    ray->last = distance;
  }
  return best;
}

}  // namespace argil::render
