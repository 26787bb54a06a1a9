#include "clay/brush/stamp_shape.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"

namespace argil::clay {

namespace {

constexpr int kCells = 96;   // along the longest side
constexpr int kMargin = 16;  // cells around the box: two of the coarsest
constexpr float kBand = 8;   // cells: known from the mesh
constexpr int kLeast = 12;   // no coarser than this many samples a side

// Fills |phi| beyond the band: upwind |∇u| = 1, swept once in each of the eight orders of the axes.
void widen(StampShape::Level& level) {
  const int nx = level.size[0], ny = level.size[1], nz = level.size[2];
  auto& phi = level.distance;
  const auto at = [&](int x, int y, int z) {
    return (static_cast<size_t>(x) * static_cast<size_t>(ny) + static_cast<size_t>(y)) * static_cast<size_t>(nz) +
           static_cast<size_t>(z);
  };
  const float far = static_cast<float>(nx + ny + nz);
  std::vector<float> u(phi.size());
  for (size_t i = 0; i < phi.size(); ++i) u[i] = std::abs(phi[i]) < kBand ? std::abs(phi[i]) : far;
  for (int order = 0; order < 8; ++order) {
    const bool fx = order & 1, fy = order & 2, fz = order & 4;
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j)
        for (int k = 0; k < nz; ++k) {
          const int x = fx ? nx - 1 - i : i, y = fy ? ny - 1 - j : j, z = fz ? nz - 1 - k : k;
          if (std::abs(phi[at(x, y, z)]) < kBand) continue;
          float near[3] = {std::min(x > 0 ? u[at(x - 1, y, z)] : far, x + 1 < nx ? u[at(x + 1, y, z)] : far),
                           std::min(y > 0 ? u[at(x, y - 1, z)] : far, y + 1 < ny ? u[at(x, y + 1, z)] : far),
                           std::min(z > 0 ? u[at(x, y, z - 1)] : far, z + 1 < nz ? u[at(x, y, z + 1)] : far)};
          std::sort(near, near + 3);
          float best = near[0] + 1;
          if (best > near[1]) {
            const float difference = near[0] - near[1];
            best = 0.5f * (near[0] + near[1] + std::sqrt(std::max(2 - difference * difference, 0.0f)));
            if (best > near[2]) {
              const float sum = near[0] + near[1] + near[2],
                          squares = near[0] * near[0] + near[1] * near[1] + near[2] * near[2];
              best = (sum + std::sqrt(std::max(sum * sum - 3 * (squares - 1), 0.0f))) / 3;
            }
          }
          float& mine = u[at(x, y, z)];
          mine = std::min(mine, best);
        }
  }
  for (size_t i = 0; i < phi.size(); ++i)
    if (std::abs(phi[i]) >= kBand) phi[i] = std::copysign(u[i], phi[i]);
}

StampShape::Level halved(const StampShape::Level& fine) {
  StampShape::Level coarse;
  for (int i = 0; i < 3; ++i) coarse.size[i] = fine.size[i] / 2;
  coarse.cell = 2 * fine.cell;
  coarse.middle = (fine.middle - Vec3f::Constant(0.5f)) / 2;
  coarse.distance.reserve(fine.distance.size() / 8);
  const auto at = [&](int x, int y, int z) {
    return fine.distance[(static_cast<size_t>(x) * static_cast<size_t>(fine.size[1]) + static_cast<size_t>(y)) *
                             static_cast<size_t>(fine.size[2]) +
                         static_cast<size_t>(z)];
  };
  for (int x = 0; x < coarse.size[0]; ++x)
    for (int y = 0; y < coarse.size[1]; ++y)
      for (int z = 0; z < coarse.size[2]; ++z) {
        float sum = 0;
        for (int i = 0; i < 8; ++i) sum += at(2 * x + (i >> 2), 2 * y + ((i >> 1) & 1), 2 * z + (i & 1));
        coarse.distance.push_back(sum / 16);  // the mean, in cells twice as large
      }
  return coarse;
}

}  // namespace

std::shared_ptr<const StampShape> StampShape::of(const TriangleMesh& mesh, Job* job) {
  if (mesh.positions.empty() || mesh.triangles.empty())
    throw Error("the shape of a stamp is empty: give a mesh or clay with something in it");
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t) {
      low = low.cwiseMin(mesh.positions[v]);
      high = high.cwiseMax(mesh.positions[v]);
    }
  const Vec3d middle = 0.5 * (low + high);
  double radius = 0;
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t) radius = std::max(radius, (mesh.positions[v] - middle).norm());
  const double longest = (high - low).maxCoeff();
  if (!(longest > 0)) throw Error("the shape of a stamp has no size: give a solid");
  // In a space of its own, where one unit is a cell: whatever its size in mm.
  TriangleMesh scaled = mesh;
  const double cells = kCells / longest;
  for (Vec3d& p : scaled.positions) p = (p - middle) * cells;
  ImportOptions options;
  options.grid.voxelMm = 1;
  options.grid.band = kBand;
  options.placeOrigin = false;
  const Version solid = meshToClay(Store::make(), scaled, options, job).version;
  Level level;
  Coord first{0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    const double half = 0.5 * (high - low)[i] * cells;
    const int begin = static_cast<int>(std::floor(-half)) - kMargin, end = static_cast<int>(std::ceil(half)) + kMargin;
    (i == 0 ? first.x : i == 1 ? first.y : first.z) = begin;
    level.size[i] = end - begin + 1;
    level.middle[i] = static_cast<float>(-begin);
  }
  level.cell = static_cast<float>(1 / (radius * cells));
  Sampler field(solid);
  bool any = false;
  for (int x = 0; x < level.size[0]; ++x)
    for (int y = 0; y < level.size[1]; ++y)
      for (int z = 0; z < level.size[2]; ++z) {
        level.distance.push_back(field.voxel(first + Coord{x, y, z}));
        any = any || level.distance.back() < 0;
      }
  if (!any) throw Error("the shape of a stamp has no inside at 96 cells along its longest side: give a thicker solid");
  widen(level);
  auto shape = std::make_shared<StampShape>();
  shape->levels_.push_back(std::move(level));
  while (*std::min_element(shape->levels_.back().size, shape->levels_.back().size + 3) >= 2 * kLeast)
    shape->levels_.push_back(halved(shape->levels_.back()));
  return shape;
}

std::shared_ptr<const StampShape> StampShape::of(const Version& version, Job* job) {
  Surface surface(false);
  surface.update(version);
  return of(surface.toMesh(), job);
}

const StampShape::Level& StampShape::level(double radius) const {
  size_t best = 0;
  while (best + 1 < levels_.size() && levels_[best + 1].cell * radius <= 0.5) ++best;
  return levels_[best];
}

}  // namespace argil::clay
