#pragma once
// Brick meshes of any field, made by the plainest dual contouring: tests of the renderer that need no clay.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "clay/surface/surface.h"

namespace argil::render::test {

/// Signed distance in voxels at a voxel coordinate, negative inside.
using Field = std::function<double(const Vec3d&)>;

/// Octahedral, 16 bits an axis: written here again so that the shader's decoding is checked against a second author.
inline clay::PackedNormal packNormal(const Vec3d& normal) {
  const Vec3d n = normal / (std::abs(normal.x()) + std::abs(normal.y()) + std::abs(normal.z()));
  double u = n.x(), v = n.y();
  if (n.z() < 0) {
    const double fold = (1 - std::abs(n.y())) * (n.x() >= 0 ? 1 : -1);
    v = (1 - std::abs(n.x())) * (n.y() >= 0 ? 1 : -1);
    u = fold;
  }
  // Even: on no crease.
  return {int16_t(std::lround(u * 32767)), int16_t(2 * std::clamp(std::lround(v * 16383.5), -16383L, 16383L))};
}

struct OwnedMesh {
  clay::BrickMesh mesh;
  std::vector<Vec3f> positions;
  std::vector<clay::PackedNormal> normals;
  std::vector<std::array<clay::VertexRef, 4>> quads;
};

class FieldSurface {
 public:
  /// The surface of `field` within the bricks lo … hi. Successive calls give what changed between them.
  clay::SurfaceDelta update(const clay::Grid& grid, Coord lo, Coord hi, const Field& field) {
    clay::SurfaceDelta delta;
    delta.grid = grid;
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) {
          const Coord brick{x, y, z};
          auto made = extract(brick, field);
          const auto known = bricks_.find(brick);
          if (known == bricks_.end()) {
            if (made->positions.empty() && made->quads.empty()) continue;
          } else if (known->second->positions == made->positions && known->second->quads == made->quads) {
            continue;
          }
          made->mesh.serial = made->mesh.vertexSerial = ++serial_;
          bricks_[brick] = made;
          delta.changed.emplace_back(made, &made->mesh);
        }
      }
    }
    return delta;
  }

  /// All triangles in voxel coordinates, sorted: what any drawing of the surface must consist of.
  [[nodiscard]] std::vector<std::array<std::array<double, 3>, 3>> triangles() const {
    std::vector<std::array<std::array<double, 3>, 3>> all;
    for (const auto& [coord, owned] : bricks_) {
      for (const auto& quad : owned->quads) {
        std::array<std::array<double, 3>, 4> corner;
        for (int i = 0; i < 4; ++i) {
          const int n = quad[i] >> clay::kVertexRefBits;
          const Coord owner = coord - Coord{n & 1, (n >> 1) & 1, n >> 2};
          const Vec3f p = bricks_.at(owner)->positions[quad[i] & clay::kVertexRefIndex];
          corner[i] = {owner.x * 8 + double(p.x()), owner.y * 8 + double(p.y()), owner.z * 8 + double(p.z())};
        }
        all.push_back({corner[0], corner[1], corner[2]});
        all.push_back({corner[0], corner[2], corner[3]});
      }
    }
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  static Vec3d at(Coord voxel) { return voxel.toVec3d(); }

  static std::shared_ptr<OwnedMesh> extract(Coord brick, const Field& field) {
    // Samples from one voxel below the brick to one above it.
    constexpr int kEdge = 11;
    std::vector<double> samples(kEdge * kEdge * kEdge);
    const Coord base = brick * 8;
    const auto sample = [&](int x, int y, int z) -> double& {
      return samples[size_t(((x + 1) * kEdge + y + 1) * kEdge + z + 1)];
    };
    for (int x = -1; x < 10; ++x) {
      for (int y = -1; y < 10; ++y) {
        for (int z = -1; z < 10; ++z) sample(x, y, z) = field(at(base + Coord{x, y, z}));
      }
    }
    auto owned = std::make_shared<OwnedMesh>();
    owned->mesh.brick = brick;
    const auto corners = [&](Coord c, auto&& visit) {
      for (int n = 0; n < 8; ++n) visit(c + Coord{n & 1, (n >> 1) & 1, n >> 2});
    };
    const auto mixed = [&](Coord c) {
      int inside = 0;
      corners(c, [&](Coord v) { inside += sample(v.x, v.y, v.z) < 0; });
      return inside > 0 && inside < 8;
    };
    // A cell's vertex among those of the brick that owns the cell, counted there once for all cells.
    std::array<std::vector<clay::VertexRef>, 8> counted;
    const auto indexOf = [&](Coord cell) {
      const int owner = (cell.x < 0) | (cell.y < 0) << 1 | (cell.z < 0) << 2;
      const Coord start{cell.x < 0 ? -8 : 0, cell.y < 0 ? -8 : 0, cell.z < 0 ? -8 : 0};
      if (counted[size_t(owner)].empty()) counted[size_t(owner)] = count(base + start, field);
      const Coord in = cell - start;
      return clay::VertexRef(counted[size_t(owner)][size_t(clay::Brick::offset(in.x, in.y, in.z))] |
                             owner << clay::kVertexRefBits);
    };
    for (int x = 0; x < 8; ++x) {
      for (int y = 0; y < 8; ++y) {
        for (int z = 0; z < 8; ++z) {
          const Coord cell{x, y, z};
          if (mixed(cell)) addVertex(*owned, base, cell, field);
          for (int axis = 0; axis < 3; ++axis) {
            Coord next = cell;
            (axis == 0 ? next.x : axis == 1 ? next.y : next.z) += 1;
            const bool a = sample(x, y, z) < 0, b = sample(next.x, next.y, next.z) < 0;
            if (a == b) continue;
            const Coord u = axis == 0 ? Coord{0, 1, 0} : axis == 1 ? Coord{0, 0, 1} : Coord{1, 0, 0};
            const Coord v = axis == 0 ? Coord{0, 0, 1} : axis == 1 ? Coord{1, 0, 0} : Coord{0, 1, 0};
            std::array<clay::VertexRef, 4> quad{indexOf(cell - u - v), indexOf(cell - v), indexOf(cell),
                                                indexOf(cell - u)};
            if (b) std::reverse(quad.begin(), quad.end());
            owned->quads.push_back(quad);
          }
        }
      }
    }
    owned->mesh.positions = owned->positions;
    owned->mesh.normals = owned->normals;
    owned->mesh.quads = owned->quads;
    return owned;
  }

  /// For each cell of a brick, how many cells before it have a vertex.
  static std::vector<clay::VertexRef> count(Coord base, const Field& field) {
    std::vector<char> inside;
    for (int x = 0; x < 9; ++x) {
      for (int y = 0; y < 9; ++y) {
        for (int z = 0; z < 9; ++z) inside.push_back(field(at(base + Coord{x, y, z})) < 0);
      }
    }
    std::vector<clay::VertexRef> before;
    clay::VertexRef next = 0;
    for (int x = 0; x < 8; ++x) {
      for (int y = 0; y < 8; ++y) {
        for (int z = 0; z < 8; ++z) {
          int sum = 0;
          for (int n = 0; n < 8; ++n)
            sum += inside[size_t(((x + (n & 1)) * 9 + y + ((n >> 1) & 1)) * 9 + z + (n >> 2))];
          before.push_back(next);
          next = clay::VertexRef(next + (sum > 0 && sum < 8));
        }
      }
    }
    return before;
  }

  static void addVertex(OwnedMesh& owned, Coord base, Coord cell, const Field& field) {
    Vec3d sum = Vec3d::Zero();
    int count = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int n = 0; n < 4; ++n) {
        Vec3d p = at(cell);
        p[(axis + 1) % 3] += n & 1;
        p[(axis + 2) % 3] += n >> 1;
        Vec3d q = p;
        q[axis] += 1;
        const double a = field(at(base) + p), b = field(at(base) + q);
        if ((a < 0) == (b < 0)) continue;
        sum += p + (q - p) * (a / (a - b));
        ++count;
      }
    }
    const Vec3d p = sum / count;
    Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d step = Vec3d::Zero();
      step[axis] = 0.5;
      gradient[axis] = field(at(base) + p + step) - field(at(base) + p - step);
    }
    owned.positions.push_back(p.cast<float>());
    owned.normals.push_back(packNormal(gradient.normalized()));
  }

  std::map<Coord, std::shared_ptr<OwnedMesh>> bricks_;
  uint64_t serial_ = 0;
};

}  // namespace argil::render::test
