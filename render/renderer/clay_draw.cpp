// The model's draw calls: which chunks are in the picture, and how fine.

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "render/renderer/model.h"
#include "render/renderer/renderer_state.h"

namespace argil::render {
namespace {

/// Quads that one picture reads to make levels of detail: about 15 ms on one core;
constexpr size_t kQuadsAPicture = 250'000;
/// or more where pictures are slow for want of them: this part of the triangles that the last one drew, a small part of
/// its time.
constexpr double kQuadsATriangle = 0.5;
/// Where the device makes them: its own part is small, telling it which bricks there are takes some 5 ms.
constexpr size_t kQuadsOnDevice = 2'000'000;

}  // namespace

/// A sight in the voxels of one piece (in its mm, for a part): chunks are tested as they are.
struct Model::Local {
  struct Side {
    Vec3d normal;
    double offset;
  };
  std::vector<Side> sides;
  Vec3d eye, forward;
  std::vector<std::pair<Vec3d, Vec3d>> eyes;
  double reach = 0, detail = 0;  // largest group of cells, at distance 1 in perspective
  double grown = 0;              // what is drawn may stand so far out of its chunk
  bool perspective = true, backsSeen = false;

  // Depths along `forward` and distances of sides are the world's, over `unitMm`.
  Local(const Sight& sight, const PieceLook& look, double unitMm, const Vec3d& originMm) {
    const Eigen::Quaterniond back = look.rotation.conjugate();
    const auto place = [&](const Vec3d& world) {
      return Vec3d((back * (world - look.translationMm).cwiseQuotient(look.scale) - originMm) / unitMm);
    };
    eye = place(sight.eye);
    forward = back * sight.forward.cwiseProduct(look.scale);
    for (const FramePlan::Side& side : sight.sides)
      sides.push_back({back * side.normal.cwiseProduct(look.scale), side.offset / unitMm});
    for (const auto& [at, ahead] : sight.eyes) {
      eyes.emplace_back(place(at), (back * ahead.cwiseQuotient(look.scale)).normalized());
      reach = std::max(reach, (at - sight.eye).norm() / unitMm);
    }
    detail = sight.detailPixels * sight.mmPerPixel / (sight.perspective ? 1 : unitMm) / look.scale.maxCoeff();
    perspective = sight.perspective;
    backsSeen = sight.backsSeen;
    grown = look.grownMm / unitMm;
  }

  [[nodiscard]] bool outside(const Vec3d& min, const Vec3d& max) const {
    return std::any_of(sides.begin(), sides.end(), [&](const Side& side) {
      // The corner that lies farthest inwards.
      const Vec3d corner = (side.normal.array() > 0).select(min, max);
      return side.normal.dot(corner - eye) > side.offset + grown * side.normal.norm();
    });
  }
  /// The coarsest level whose groups of cells are small enough at the nearest point of a chunk.
  [[nodiscard]] int level(const ChunkDraw& draw) const {
    const Vec3d half = 0.5 * (draw.max - draw.min);
    const double nearest =
        perspective ? forward.dot(draw.min + half - eye) - forward.cwiseAbs().dot(half) - reach - grown * forward.norm()
                    : 1;
    const double group = detail * nearest;
    int level = kLevels - 1;
    while (level > 0 && group < kGroupCells[size_t(level)]) --level;
    return level;
  }
  [[nodiscard]] bool facesAway(const ChunkDraw& draw) const {
    if (backsSeen) return false;
    const Vec3d half = 0.5 * (draw.max - draw.min);
    return std::all_of(eyes.begin(), eyes.end(), [&](const auto& e) {
      return perspective ? draw.cone.facesAway(draw.min + half, half.norm() + grown, e.first)
                         : draw.cone.facesAway(e.second);
    });
  }
};

Model::Local Model::toLocal(const Piece& piece, const PieceLook& look, const Sight& sight) const {
  return piece.clay ? Local(sight, look, piece.clay->grid().voxelMm, piece.clay->grid().originMm)
                    : Local(sight, look, 1, Vec3d::Zero());
}

std::vector<Model::Wish> Model::wishesOf(const Sight& sight) {
  std::vector<Wish> wishes;
  for (auto& [id, piece] : pieces_) {
    if (!piece.clay) continue;
    piece.clay->nextPicture();
    if (!lookOf(id).visible || sight.detailPixels <= 0) continue;
    const Local local = toLocal(piece, lookOf(id), sight);
    const std::vector<ChunkDraw>& draws = piece.clay->draws();
    for (size_t i = 0; i < draws.size(); ++i) {
      if (!piece.clay->atRest(i) || local.outside(draws[i].min, draws[i].max)) continue;
      const int level = local.level(draws[i]);
      if (!draws[i].levels[size_t(level)].made || !draws[i].coned) wishes.push_back({piece.clay.get(), i, level});
    }
  }
  return wishes;
}

void Model::prepare(const Sight& sight) {
  size_t draws = 0;
  for (const auto& [id, piece] : pieces_)
    draws += !lookOf(id).visible ? 0 : piece.clay ? piece.clay->draws().size() : 1;
  list_.nextPicture(draws);
  levelBytes_ = 0;
  const std::vector<Wish> wishes = wishesOf(sight);
  if (wishes.empty()) return;
  try {
    if (kernel_ && kernel_->reachesAll())
      makeOnDevice(wishes);
    else
      makeHere(wishes);
  } catch (const Error&) {  // no memory left for what only saves time
    if (kernel_) kernel_->release();
  }
}

void Model::makeHere(std::span<const Wish> wishes) {
  size_t left = std::max(kQuadsAPicture, size_t(kQuadsATriangle * double(drawn_)));
  const UploadStats stats = buffers_.update([&](UploadSink& sink) {
    for (const Wish& wish : wishes) {
      try {
        const size_t cost = wish.clay->prepareChunk(wish.chunk, wish.level, sink);
        if (cost >= left) return;
        left -= cost;
      } catch (const Error&) {
        return;  // what was made before is sent
      }
    }
  });
  levelBytes_ = stats.bytes;
}

void Model::makeOnDevice(std::span<const Wish> wishes) {
  size_t left = kQuadsOnDevice;
  LevelBatch batch;
  size_t first = 0;
  for (size_t i = 0; i < wishes.size() && left > 0; ++i) {
    left -= std::min(left, wishes[i].clay->describeLevel(wishes[i].chunk, wishes[i].level, batch));
    if (!LevelKernel::full(batch) && left > 0 && i + 1 < wishes.size()) continue;
    makeBatch(batch, wishes.subspan(first, i + 1 - first));
    first = i + 1;
    batch = {};
  }
}

/// Throws Error where there is no memory for some; those that were placed are there.
void Model::makeBatch(LevelBatch& batch, std::span<const Wish> wishes) {
  const std::span<const LevelSize> sizes = kernel_->measure(batch);
  size_t placed = 0;
  try {
    buffers_.update([&](UploadSink& sink) {
      try {
        for (; placed < wishes.size(); ++placed) {
          const Wish& wish = wishes[placed];
          wish.clay->takeLevel(wish.chunk, wish.level, sizes[placed], batch.chunks[placed], sink);
        }
      } catch (const Error&) {  // what fits is made
      }
    });
    kernel_->write(batch, placed);
  } catch (...) {
    for (const Wish& wish : wishes.first(placed)) wish.clay->dropLevels(wish.chunk);
    throw;
  }
  levelBytes_ += batch.bricks.size() * sizeof(LevelBrick) + batch.chunks.size() * sizeof(LevelChunk);
  if (placed < wishes.size()) throw Error("no memory is left for levels of detail", Error::Kind::work);
}

void Model::draw(VkCommandBuffer commands, VkPipelineLayout layout, const Sight& sight, Kind kind,
                 Renderer::DrawStats& stats, const Sight* seen) {
  const uint64_t before = stats.trianglesDrawn;
  if (pieces_.empty() || !buffers_.vertices()) return;
  const VkBuffer vertices[] = {buffers_.vertices(), buffers_.paint()};
  const VkDeviceSize offsets[] = {0, 0};
  vkCmdBindVertexBuffers(commands, 0, 2, vertices, offsets);
  vkCmdBindIndexBuffer(commands, buffers_.indices(), 0, VK_INDEX_TYPE_UINT32);
  for (const auto& [id, piece] : pieces_) {
    const PieceLook& look = lookOf(id);
    if (!look.visible || (kind == Kind::clay) != (piece.clay != nullptr)) continue;
    const Local local = toLocal(piece, look, sight);
    const auto fromEye = seen ? std::optional(toLocal(piece, look, *seen)) : std::nullopt;
    commands_.clear();
    const auto add = [&](const ChunkDraw::Range& range) {
      if (range.indexCount == 0) return;
      commands_.push_back({range.indexCount, 1, range.firstIndex, 0, 0});
      ++stats.chunksDrawn;
      stats.trianglesDrawn += range.triangles;
    };
    if (piece.part) {
      if (const Box& box = piece.part->bounds(); !box.empty() && !local.outside(box.min, box.max)) {
        add(piece.part->draw());
      } else {
        ++stats.chunksCulled;
      }
    } else {
      for (const ChunkDraw& chunk : piece.clay->draws()) {
        if (local.outside(chunk.min, chunk.max) || local.facesAway(chunk)) {
          ++stats.chunksCulled;
          continue;
        }
        const int level = std::max(local.level(chunk), fromEye ? fromEye->level(chunk) : 0);
        add(chunk.at(sight.detailPixels > 0 ? level : 0));
      }
    }
    if (commands_.empty()) continue;

    push(commands, layout, constants(piece, look, sight));
    stats.drawCalls += list_.draw(commands, commands_);
  }
  if (!seen && kind == Kind::clay) drawn_ = stats.trianglesDrawn - before;
}

PieceConstants Model::constants(const Piece& piece, const PieceLook& look, const Sight& sight) const {
  const double unit = piece.unitMm();
  const Vec3d origin = piece.originMm();
  const Eigen::Quaterniond& turn = look.rotation;
  // The point of the piece's box nearest to the eye: differences to it fit 32 bits, and what is near keeps its digits.
  const Box box = piece.clay ? piece.clay->looseBounds() : piece.part->bounds();
  const Vec3d eye = turn.conjugate() * (sight.eye - look.translationMm).cwiseQuotient(look.scale);
  const Vec3d anchor = ((eye.cwiseMax(box.min).cwiseMin(box.max) - origin) / unit).array().round();
  const Vec3d rel = look.scale.cwiseProduct(turn * (origin + anchor * unit)) + (look.translationMm - sight.eye);
  PieceConstants c{};
  for (int i = 0; i < 3; ++i) {
    c.anchor[i] = int32_t(std::clamp(anchor[i], double(INT32_MIN), double(INT32_MAX)));
    c.anchorRel[i] = float(rel[i]);
    c.scale[i] = float(look.scale[i]);
  }
  c.unit = float(unit);
  c.grown = piece.clay ? float(look.grownMm) : 0;
  for (int i = 0; i < 4; ++i) c.rotation[i] = float(turn.coeffs()[i]);
  c.surface = surfaceOf(look, piece.part != nullptr);
  return c;
}

Sight Renderer::State::sight(const FramePlan& plan) const {
  const auto vec = [](const FrameUniforms::Vec4& v) { return Vec3d(double(v[0]), double(v[1]), double(v[2])); };
  const FrameUniforms& u = plan.uniforms;
  Sight sight;
  sight.eye = plan.eye;
  sight.forward = vec(u.cameraForward);
  sight.perspective = plan.perspective;
  for (size_t i = 0; i < size_t(plan.eyes()); ++i) {
    sight.eyes.emplace_back(plan.eye + vec(u.eyes[i].place), vec(u.eyes[i].forward));
  }
  sight.mmPerPixel = double(u.scale[3]) * double(u.size[2]);
  sight.detailPixels = quality.detailPixels;
  sight.backsSeen = plan.look.section.has_value();
  sight.sides = plan.sides;
  return sight;
}

void Renderer::State::drawClay(VkCommandBuffer commands, const FramePlan& plan, bool intoShadow) {
  const Sight seen = sight(plan);
  Sight from = seen;
  if (intoShadow) {
    // Parallel rays from the light; all of the clay is in the map. A texel holds what a pixel may, and what is in the
    // picture casts the shadow of the level that the picture shows.
    const auto& x = plan.uniforms.shadowX;
    const double reach = 1 / std::hypot(double(x[0]), double(x[1]), double(x[2]));
    from.perspective = false;
    from.mmPerPixel = 2 * reach / double(targets.shadow.extent().width);
    from.detailPixels = std::min(from.detailPixels, 1.0);
    from.backsSeen = true;
    from.sides.clear();
  }
  using Kind = Model::Kind;
  variant.painted = model.painted();
  DrawStats shadow;
  for (const Kind kind : {Kind::clay, Kind::parts}) {
    bind(commands, intoShadow ? Pass::shadow : kind == Kind::clay ? Pass::clay : Pass::part);
    model.draw(commands, pipelines.layout(), from, kind, intoShadow ? shadow : stats, intoShadow ? &seen : nullptr);
  }
  stats.shadowTriangles += shadow.trianglesDrawn;
}

}  // namespace argil::render
