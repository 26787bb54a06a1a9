#include "clay/import/mesh_colours.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "clay/base/parallel.h"
#include "clay/field/region_work.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/editor.h"

namespace argil::clay {

namespace {

constexpr size_t kSlice = 1024;       // bricks between two looks at the job
constexpr size_t kBricksABlock = 64;  // that a thread takes at a time
constexpr double kSearching = 0.1;    // share of the work that building the tree of triangles is, about

using Painted = std::array<std::array<uint8_t, kBrickVoxels>, kColourChannels.size()>;

// Shares of the corners in a point of the triangle; of one without area the nearest corner alone.
Vec3d sharesOf(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  Vec3d shares((b - p).cross(c - p).dot(normal), (c - p).cross(a - p).dot(normal), (a - p).cross(b - p).dot(normal));
  shares = (shares / area2).cwiseMax(0);
  if (shares.allFinite() && shares.sum() > 0.5) return shares / shares.sum();
  const Vec3d far((p - a).squaredNorm(), (p - b).squaredNorm(), (p - c).squaredNorm());
  Eigen::Index corner = 0;
  far.minCoeff(&corner);
  return Vec3d::Unit(corner);
}

}  // namespace

Version withMeshColours(const Version& version, const TriangleMesh& mesh, const MeshColours& colours,
                        const WorkPart& part, int threads) {
  threads = threadCount(threads);
  const bool ofTriangles = !colours.triangles.empty(), ofPoints = colours.at != nullptr;
  const size_t given = ofTriangles ? colours.triangles.size() : colours.vertices.size();
  const size_t wanted = ofTriangles ? mesh.triangles.size() : mesh.positions.size();
  if (!ofPoints && given != wanted)
    throw Error(fmt::format("{} colours for {} {}", given, wanted, ofTriangles ? "triangles" : "vertices"));
  part.step(0);
  const NearestTriangle nearest(mesh);
  part.step(kSearching);

  const Grid& grid = version.grid();
  const auto paint = [&](const Brick& brick, Painted& painted) {
    for (auto& channel : painted) channel.fill(0);
    uint32_t hint = UINT32_MAX;
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (!(std::abs(brick.phi(i)) < grid.band)) continue;
      const Coord voxel = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      const Vec3d p = grid.toWorld(voxel.toVec3d());
      hint = nearest.nearest(p, hint).triangle;
      Vec3d colour = Vec3d::Zero();
      uint8_t cover = 255;
      if (ofPoints) {
        const auto& corners = nearest.corners(hint);
        const Vec3d &a = mesh.positions[corners[0]], &b = mesh.positions[corners[1]], &c = mesh.positions[corners[2]];
        const auto own = colours.at(nearest.indexOf(hint), sharesOf(nearestOnTriangle(p, a, b, c), a, b, c));
        colour = Vec3d(own[0], own[1], own[2]);
        cover = own[3];
      } else if (ofTriangles) {
        const MeshColour& own = colours.triangles[nearest.indexOf(hint)];
        colour = Vec3d(own[0], own[1], own[2]);
      } else {
        const auto& corners = nearest.corners(hint);
        const Vec3d &a = mesh.positions[corners[0]], &b = mesh.positions[corners[1]], &c = mesh.positions[corners[2]];
        const Vec3d shares = sharesOf(nearestOnTriangle(p, a, b, c), a, b, c);
        for (int k = 0; k < 3; ++k) {
          const MeshColour& own = colours.vertices[corners[size_t(k)]];
          colour += shares[k] * Vec3d(own[0], own[1], own[2]);
        }
      }
      for (size_t k = 0; k < 3; ++k)
        painted[k][size_t(i)] = static_cast<uint8_t>(std::clamp(colour[Eigen::Index(k)] + 0.5, 0.0, 255.0));
      painted[3][size_t(i)] = cover;
    }
  };

  std::vector<const Brick*> bricks;
  bricks.reserve(version.stats().bricks);
  version.forEachBrick([&](const Brick& brick) { bricks.push_back(&brick); });
  Editor editor(version);
  std::vector<Painted> painted;
  for (size_t begin = 0; begin < bricks.size(); begin += kSlice) {
    part.step(kSearching + (1 - kSearching) * double(begin) / double(bricks.size()));
    const size_t count = std::min(kSlice, bricks.size() - begin);
    painted.resize(count);
    parallelBlocks(
        count, threads,
        [&](size_t from, size_t to) {
          for (size_t i = from; i < to; ++i) paint(*bricks[begin + i], painted[i]);
        },
        kBricksABlock);
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < kColourChannels.size(); ++k)
        editor.setChannel(kColourChannels[k], bricks[begin + i]->coord, painted[i][k]);
    }
  }
  part.step(1);
  return editor.commit();
}

}  // namespace argil::clay
