#include "clay/import/mesh_losses.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "clay/base/even_points.h"
#include "clay/field/loose_parts.h"
#include "clay/field/region_work.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/wall_thickness.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"
#include "clay/surface/surface_topology.h"

namespace argil::clay {

namespace {

constexpr double kFragment = 0.5;      // of its body of the mesh: what is less is a part of it
constexpr double kMostSpecks = 0.05;   // of the volume: more is what there is of a mesh of thin walls
constexpr float kNoClay = 0.75f;       // voxels from the clay where none is near
constexpr double kGone = 0.5;          // of the mesh's volume: where less is left, walls are without thickness
constexpr double kSampleArea = 1;      // voxels² for which one point is looked at
constexpr int kMostSamples = 1 << 16;  // of one triangle
constexpr double kRecounted = 20;      // voxels² that are lost at first sight
constexpr int kThreads = 2;

// Volume in voxels³ of the body of the mesh that each triangle belongs to.
class BodiesOfMesh {
 public:
  explicit BodiesOfMesh(const TriangleMesh& mesh) : parent_(mesh.positions.size()), volume_(mesh.positions.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    for (const auto& [a, b, c] : mesh.triangles) unite(a, b), unite(a, c);
    for (const auto& [a, b, c] : mesh.triangles)
      volume_[find(a)] += mesh.positions[a].dot(mesh.positions[b].cross(mesh.positions[c])) / 6;
  }
  [[nodiscard]] double volumeAt(uint32_t vertex) { return std::abs(volume_[find(vertex)]); }
  [[nodiscard]] double sum() const { return std::accumulate(volume_.begin(), volume_.end(), 0.0); }

 private:
  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(uint32_t a, uint32_t b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<uint32_t> parent_;
  std::vector<double> volume_;
};

// Some hundreds of any number of places, evenly out of their order.
class EvenlyKept {
 public:
  void add(const SurfacePlace& place) {
    if (count_++ % every_ != 0) return;
    kept_.push_back(place);
    if (kept_.size() < kMost) return;
    for (size_t i = 1; 2 * i < kept_.size(); ++i) kept_[i] = kept_[2 * i];
    kept_.resize(kept_.size() / 2);
    every_ *= 2;
  }
  [[nodiscard]] std::span<const SurfacePlace> kept() const { return kept_; }

 private:
  static constexpr size_t kMost = 512;
  std::vector<SurfacePlace> kept_;
  uint64_t count_ = 0, every_ = 1;
};

}  // namespace

MeshLosses takeSpecks(Version& version, const RepairedMesh& repaired, const WorkPart& part) {
  const TriangleMesh& mesh = repaired.mesh;
  const double edge = version.grid().voxelMm;
  MeshLosses found;
  BodiesOfMesh bodies(mesh);
  std::optional<NearestTriangle> nearest;
  const SpeckTest isSpeck = [&](Coord voxel, double voxels) {
    if (!nearest) nearest.emplace(mesh);
    const uint32_t vertex = nearest->corners(nearest->nearest(voxel.toVec3d()).triangle)[0];
    return voxels < kFragment * bodies.volumeAt(vertex);
  };
  for (const Tile side : {Tile::inside, Tile::outside}) {
    Specks taken = removeSpecks(version, side, kSpeckVoxels, isSpeck,
                                side == Tile::inside ? part.part(0, 0.4) : part.part(0.4, 0.8));
    uint64_t& left = side == Tile::inside ? found.bodies : found.cavities;
    left = taken.left;
    if (taken.volumeMm3 > kMostSpecks * volumeOf(version) * edge * edge * edge) {
      left += taken.count;
      continue;
    }
    version = std::move(taken.version);
    found.specks += taken.count;
    found.speckMm3 += taken.volumeMm3;
  }
  if (repaired.findings.sound() && repaired.findings.bodies == 1) found.meshMm3 = bodies.sum() * edge * edge * edge;

  Sampler clay(version);
  EvenlyKept places;
  double lost = 0, all = 0;
  Vec3d sum = Vec3d::Zero(), allSum = Vec3d::Zero();
  const auto count = [&](const auto& isLost) {
    places = {};
    lost = all = 0;
    sum = allSum = Vec3d::Zero();
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (t % 65536 == 0) part.step(0.8 + 0.2 * double(t) / double(mesh.triangles.size()));
      const auto& [i, j, k] = mesh.triangles[t];
      const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
      const double area = (b - a).cross(c - a).norm() / 2;
      all += area;
      allSum += area / 3 * (a + b + c);
      const int samples = std::clamp(int(area / kSampleArea), 1, kMostSamples);
      for (int s = 0; s < samples; ++s) {
        const Vec3d p = evenPoint(a, b, c, s);
        if (!isLost(p)) continue;
        places.add({p, (b - a).cross(c - a), area / samples});
        lost += area / samples;
        sum += p * (area / samples);
      }
    }
  };
  count([&](const Vec3d& p) { return clay.trilinear(p) > kNoClay; });
  // The clay's volume is that within the surface which users see and files get. Sums over voxels are off by a quarter
  // of a voxel² for each voxel of an edge, and take layers of distances that are about zero for clay.
  if (found.meshMm3 > 0) {
    Surface surface(false, Grade::fine);
    surface.update(version, kThreads);
    found.clayMm3 = std::max(0.0, surfaceTopology(surface).volume);
    if (TriangleMesh skin; lost > kRecounted && !(skin = surface.toMesh()).triangles.empty()) {
      // Layers of distances about zero look like clay: what counts is the surface.
      for (Vec3d& p : skin.positions) p = version.grid().toVoxel(p);
      const NearestTriangle tree(skin);
      count([&](const Vec3d& p) {
        // Leaves out places deep in the clay, as those of triangles that cross others: they are no walls.
        return clay.trilinear(p) > -kNoClay && tree.nearerThan(p, double(kNoClay), UINT32_MAX).triangle == UINT32_MAX;
      });
    }
    const double gone = all * (1 - found.clayMm3 / found.meshMm3);
    if (found.clayMm3 < kGone * found.meshMm3 && gone > lost && !repaired.findings.crossings) {
      lost = gone;
      sum = allSum * (gone / all);
      places = {};
      for (const auto& [i, j, k] : mesh.triangles) {
        const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
        if (const Vec3d out = (b - a).cross(c - a); !out.isZero(0)) places.add({(a + b + c) / 3, out, out.norm()});
      }
    }
  }
  part.step(1);
  if (lost > 0) {
    found.lostMm2 = lost * edge * edge;
    found.lostThickMm = medianThickness(mesh, places.kept()) * edge;
    found.lostAtMm = version.grid().toWorld(sum / lost);
  }
  return found;
}

}  // namespace argil::clay
