#pragma once
// Solids with creases whose distance is known, as clay, and how far a surface lies from them.

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/triangle_mesh.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"

namespace argil::clay::testing {

/// Clay of one voxel a millimetre around zero from distances in voxels, within `reach` voxels of zero along each axis.
inline Version clayOf(const std::shared_ptr<Store>& store, int reach,
                      const std::function<double(const Vec3d&)>& distance) {
  Grid grid;
  grid.voxelMm = 1;
  Editor editor(Version::empty(store, grid));
  const int bricks = (reach + 11) / 8;
  for (int x = -bricks; x < bricks; ++x)
    for (int y = -bricks; y < bricks; ++y)
      for (int z = -bricks; z < bricks; ++z) {
        const double middle = distance(Vec3d(8 * x + 3.5, 8 * y + 3.5, 8 * z + 3.5));
        // Values that differ by more than the distance between voxels are no distances: twice that is room for bounds.
        if (std::abs(middle) > 20) {
          editor.setTile({x, y, z}, middle < 0 ? Tile::inside : Tile::outside);
          continue;
        }
        std::array<float, kBrickVoxels> phi;
        for (int i = 0; i < kBrickVoxels; ++i)
          phi[static_cast<size_t>(i)] =
              static_cast<float>(distance(Vec3d(8 * x + (i >> 6), 8 * y + ((i >> 3) & 7), 8 * z + (i & 7))));
        editor.setVoxels({x, y, z}, phi);
      }
  return editor.commit();
}

/// A box about `centre`, turned, its edges rounded.
struct TurnedBox {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns: its axes.
  Vec3d centre = Vec3d::Zero(), half = Vec3d(12, 12, 12);
  double round = 0;

  [[nodiscard]] Vec3d local(const Vec3d& p) const { return axes.transpose() * (p - centre); }
  [[nodiscard]] double distance(const Vec3d& p) const {
    const Vec3d q = local(p).cwiseAbs() - half + Vec3d::Constant(round);
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - round;
  }
  /// As a cut by planes leaves it: exact inside and on faces, a bound beyond edges.
  [[nodiscard]] double cut(const Vec3d& p) const { return (local(p).cwiseAbs() - half).maxCoeff(); }
};

inline Eigen::Matrix3d randomTurn(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
}

/// Distances in voxels: of the surface's vertices and of points on its triangles to the shape, and of points of the
/// shape's creases to the surface.
struct SurfaceError {
  double vertexMax = 0, faceMax = 0, rms = 0;  ///< rms: over all points.
  double creaseMax = 0;
  uint64_t points = 0;
  [[nodiscard]] double most() const { return std::max({vertexMax, faceMax, creaseMax}); }
};

inline SurfaceError surfaceError(const TriangleMesh& mesh, const std::function<double(const Vec3d&)>& distance,
                                 const std::vector<Vec3d>& crease = {}) {
  SurfaceError error;
  double sum = 0;
  const auto look = [&](const Vec3d& p, double& most) {
    const double d = std::abs(distance(p));
    most = std::max(most, d);
    sum += d * d;
    ++error.points;
  };
  for (const Vec3d& p : mesh.positions) look(p, error.vertexMax);
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    for (int i = 0; i <= 4; ++i)
      for (int j = 0; i + j <= 4; ++j) look((i * a + j * b + (4 - i - j) * c) / 4, error.faceMax);
  }
  error.rms = std::sqrt(sum / static_cast<double>(std::max<uint64_t>(1, error.points)));
  if (!crease.empty()) {
    const NearestTriangle tree(mesh);
    for (const Vec3d& p : crease) error.creaseMax = std::max(error.creaseMax, std::sqrt(tree.nearest(p).squared));
  }
  return error;
}

/// Edges whose two triangles are folded onto each other by more than `degrees`.
inline uint64_t foldedEdges(const TriangleMesh& mesh, double degrees = 150) {
  struct Side {
    uint64_t edge;
    uint32_t triangle;
    bool operator<(const Side& o) const { return edge < o.edge; }
  };
  std::vector<Side> sides;
  std::vector<Vec3d> normals;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    normals.push_back((mesh.positions[v[1]] - mesh.positions[v[0]]).cross(mesh.positions[v[2]] - mesh.positions[v[0]]));
    for (size_t i = 0; i < 3; ++i) {
      const uint64_t a = v[i], b = v[(i + 1) % 3];
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), t});
    }
  }
  std::sort(sides.begin(), sides.end());
  uint64_t folded = 0;
  const double limit = std::cos(degrees * EIGEN_PI / 180);
  for (size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].edge != sides[i + 1].edge) continue;
    const Vec3d &a = normals[sides[i].triangle], &b = normals[sides[i + 1].triangle];
    // A triangle with hardly any area turns freely and is not seen.
    if (a.norm() < 1e-4 || b.norm() < 1e-4) continue;
    folded += a.dot(b) < limit * a.norm() * b.norm();
  }
  return folded;
}

inline TriangleMesh meshOf(const Version& version, Grade grade) {
  Surface surface(false, grade);
  surface.update(version);
  return surface.toMesh();
}

}  // namespace argil::clay::testing
