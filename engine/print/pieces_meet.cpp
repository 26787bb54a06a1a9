#include "engine/print/pieces_meet.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "clay/mesh/nearest_triangle.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"

namespace argil::engine {

namespace {

constexpr double kTouchVoxels = 0.1;  // what two surfaces on one plane differ by, and more
constexpr double kFieldEnds = 0.5;    // voxels before the band's end, where distances are cut off
constexpr int kThreads = 2;
constexpr size_t kLookEvery = 4096;  // vertices between two looks at the job

struct Box {
  Vec3d low = Vec3d::Constant(INFINITY), high = Vec3d::Constant(-INFINITY);
  void add(const Vec3d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  [[nodiscard]] bool holds(const Vec3d& p, double margin) const {
    return ((p - low).array() >= -margin).all() && ((high - p).array() >= -margin).all();
  }
  [[nodiscard]] bool isNear(const Box& other, double margin) const {
    return ((other.low - high).array() <= margin).all() && ((low - other.high).array() <= margin).all();
  }
};

// A piece, and what is made of it when something is near.
class Placed {
 public:
  explicit Placed(const PlacedClay& clay) : clay_(clay), field_(clay.version) {
    const clay::Grid& grid = clay.version.grid();
    clay.version.forEachBrick([&](const clay::Brick& brick) {
      const Vec3d first = (brick.coord * clay::kBrickEdge).toVec3d();
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3d in = first + clay::kBrickEdge * Vec3d(corner & 1, corner >> 1 & 1, corner >> 2);
        box_.add(clay.pose.apply(grid.toWorld(in)));
      }
    });
  }
  [[nodiscard]] const Box& box() const { return box_; }
  [[nodiscard]] double voxelMm() const { return clay_.version.grid().voxelMm; }
  // In the world.
  [[nodiscard]] const std::vector<Vec3d>& vertices() {
    prepare();
    return mesh_.positions;
  }
  // From its surface, negative inside; what is farther outside than `most` is infinite. Beside the surface the field
  // knows it, which cuts no crease off; beyond that triangles do.
  [[nodiscard]] double distance(const Vec3d& p, double most) {
    const clay::Grid& grid = clay_.version.grid();
    const double voxels = field_.trilinear(grid.toVoxel(clay_.pose.applyInverse(p)));
    if (std::abs(voxels) < double(grid.band) - kFieldEnds) return voxels * grid.voxelMm;
    if (voxels > 0 && most < (double(grid.band) - kFieldEnds) * grid.voxelMm) return INFINITY;
    const auto hit = voxels < 0 ? tree().nearest(p, hint_) : tree().nearerThan(p, most, hint_);
    if (hit.triangle == UINT32_MAX) return INFINITY;
    hint_ = hit.triangle;
    return std::copysign(std::sqrt(hit.squared), voxels);
  }
  // A voxel deeper in its clay than a vertex.
  [[nodiscard]] Vec3d below(const Vec3d& p) {
    const clay::Grid& grid = clay_.version.grid();
    const Vec3d voxel = grid.toVoxel(clay_.pose.applyInverse(p));
    Vec3f gradient;
    field_.trilinear(voxel, gradient);
    return clay_.pose.apply(grid.toWorld(voxel - gradient.cast<double>().normalized()));
  }
  [[nodiscard]] const clay::NearestTriangle& tree() {
    prepare();
    if (!tree_) tree_ = std::make_unique<clay::NearestTriangle>(mesh_);
    return *tree_;
  }

 private:
  void prepare() {
    if (!mesh_.positions.empty()) return;
    clay::Surface surface(false);
    surface.update(clay_.version, kThreads);
    mesh_ = surface.toMesh();
    for (Vec3d& p : mesh_.positions) p = clay_.pose.apply(p);
  }

  const PlacedClay& clay_;
  clay::Sampler field_;
  Box box_;
  clay::TriangleMesh mesh_;
  std::unique_ptr<clay::NearestTriangle> tree_;
  uint32_t hint_ = UINT32_MAX;  // of the triangle that was nearest last
};

// The vertices of one against the other.
void measure(Placed& one, Placed& other, double gapMm, PiecesMeet& meet, Job* job) {
  const double touch = kTouchVoxels * std::max(one.voxelMm(), other.voxelMm());
  size_t looked = 0;
  for (const Vec3d& p : one.vertices()) {
    if (!other.box().holds(p, gapMm)) continue;
    if (++looked % kLookEvery == 0 && job) job->step(0);
    double away = other.distance(p, meet.mm);
    // Of one piece that stands exactly in another's place no vertex is inside.
    if (std::abs(away) <= touch) away = std::min(away, other.distance(one.below(p), touch));
    if (away < -touch && !(meet.overlap && -away <= meet.mm)) meet = {meet.first, meet.second, true, -away, p};
    if (meet.overlap) continue;
    away = away <= touch ? 0 : away;
    if (away >= meet.mm) continue;
    meet.mm = away;
    meet.atMm = p;
  }
}

}  // namespace

std::vector<PiecesMeet> piecesThatMeet(std::span<const PlacedClay> pieces, double gapMm, Job* job,
                                       std::optional<size_t> only) {
  std::vector<std::unique_ptr<Placed>> placed;
  for (const PlacedClay& each : pieces) placed.push_back(std::make_unique<Placed>(each));
  std::vector<PiecesMeet> all;
  for (size_t i = 0; i < pieces.size(); ++i)
    for (size_t k = i + 1; k < pieces.size(); ++k) {
      if (only && i != *only && k != *only) continue;
      if (!placed[i]->box().isNear(placed[k]->box(), gapMm)) continue;
      if (job) job->step(double(i) / double(pieces.size()));
      PiecesMeet meet{i, k, false, gapMm, Vec3d::Zero()};
      measure(*placed[i], *placed[k], gapMm, meet, job);
      measure(*placed[k], *placed[i], gapMm, meet, job);
      if (meet.overlap || meet.mm < gapMm) all.push_back(meet);
    }
  return all;
}

}  // namespace argil::engine
