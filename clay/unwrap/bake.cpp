#include "clay/unwrap/bake.h"

#include <algorithm>
#include <cmath>

#include "clay/base/parallel.h"
#include "clay/store/sampler.h"
#include "clay/unwrap/charts.h"

namespace argil::clay {

namespace {

constexpr int kSteps = 48;       // along a normal
constexpr float kClose = 0.01f;  // voxels: met
constexpr double kReach = 1.0;   // of a quad's edge: how far a normal is followed
constexpr size_t kRows = 8;      // of pixels at once

struct Corner {
  uint32_t place = 0, vertex = 0;
};

double cross(const Vec2d& a, const Vec2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// The mesh as the triangles that it is drawn as.
struct Drawn {
  std::vector<std::array<Corner, 3>> triangles;
  std::vector<double> reachMm;
};

Drawn drawnOf(const QuadMesh& mesh, const UvMap& map) {
  Drawn out;
  for (size_t f = 0; f < mesh.quads.size(); ++f) {
    const auto& q = mesh.quads[f];
    const std::array<Vec3d, 4> corners = {mesh.positions[q[0]], mesh.positions[q[1]], mesh.positions[q[2]],
                                          mesh.positions[q[3]]};
    double edge = 0;
    for (size_t s = 0; s < 4; ++s) edge = std::max(edge, (corners[(s + 1) & 3] - corners[s]).norm());
    for (const auto& t : trianglesOf(corners)) {
      std::array<Corner, 3> triangle;
      for (size_t k = 0; k < 3; ++k) triangle[k] = {map.corners[f][t[k]], q[t[k]]};
      out.triangles.push_back(triangle);
      out.reachMm.push_back(kReach * edge);
    }
  }
  return out;
}

// Which triangle each pixel's middle lies in; UINT32_MAX: none.
std::vector<uint32_t> ownersOf(const Drawn& drawn, const UvMap& map, int pixels) {
  std::vector<uint32_t> owner(size_t(pixels) * size_t(pixels), UINT32_MAX);
  for (uint32_t i = 0; i < drawn.triangles.size(); ++i) {
    std::array<Vec2d, 3> c;
    for (size_t k = 0; k < 3; ++k) {
      const Vec2d& p = map.places[drawn.triangles[i][k].place];
      c[k] = {p.x() * pixels, (1 - p.y()) * pixels};  // rows from the top
    }
    const Vec2d low = c[0].cwiseMin(c[1]).cwiseMin(c[2]), high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
    const int x0 = std::max(0, int(low.x() - 0.5)), x1 = std::min(pixels - 1, int(high.x() + 0.5)),
              y0 = std::max(0, int(low.y() - 0.5)), y1 = std::min(pixels - 1, int(high.y() + 0.5));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const Vec2d p(x + 0.5, y + 0.5);
        // Clockwise here, as rows go down.
        if (cross(c[1] - c[0], p - c[0]) <= 0 && cross(c[2] - c[1], p - c[1]) <= 0 && cross(c[0] - c[2], p - c[2]) <= 0)
          owner[size_t(y) * size_t(pixels) + size_t(x)] = i;
      }
  }
  return owner;
}

// Each pixel that has none gets its nearest neighbour's, a ring a round.
void spread(std::vector<uint32_t>& source, int pixels, int rounds) {
  std::vector<uint32_t> rim;
  for (uint32_t i = 0; i < source.size(); ++i) {
    source[i] = source[i] == UINT32_MAX ? UINT32_MAX : i;
    if (source[i] != UINT32_MAX) rim.push_back(i);
  }
  for (int round = 0; round < rounds && !rim.empty(); ++round) {
    std::vector<uint32_t> next;
    for (const uint32_t i : rim) {
      const int x = int(i) % pixels, y = int(i) / pixels;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (x + dx < 0 || y + dy < 0 || x + dx >= pixels || y + dy >= pixels) continue;
        const uint32_t to = uint32_t((y + dy) * pixels + x + dx);
        if (source[to] == UINT32_MAX) source[to] = source[i], next.push_back(to);
      }
    }
    rim = std::move(next);
  }
}

uint8_t byteOf(double part) {
  return static_cast<uint8_t>(std::lround(std::clamp(0.5 + 0.5 * part, 0.0, 1.0) * 255));
}

}  // namespace

UvFrames framesOf(const QuadMesh& mesh, const UvMap& map) {
  UvFrames frames;
  std::vector<Vec3d> normals(mesh.positions.size(), Vec3d::Zero());
  frames.vertices.assign(map.places.size(), 0);
  frames.tangents.assign(map.places.size(), Vec3d::Zero());
  for (const auto& t : drawnOf(mesh, map).triangles) {
    const Vec3d &a = mesh.positions[t[0].vertex], b = mesh.positions[t[1].vertex] - a,
                c = mesh.positions[t[2].vertex] - a;
    const Vec2d &u = map.places[t[0].place], v = map.places[t[1].place] - u, w = map.places[t[2].place] - u;
    // Each by the area of its triangle, on the surface.
    const Vec3d area = b.cross(c), along = ((b * w.y() - c * v.y()) / cross(v, w)).normalized() * area.norm();
    for (const Corner& corner : t) {
      normals[corner.vertex] += area;
      frames.vertices[corner.place] = corner.vertex;
      frames.tangents[corner.place] += along;
    }
  }
  for (size_t i = 0; i < map.places.size(); ++i) {
    frames.normals.push_back(normals[frames.vertices[i]].normalized());
    const Vec3d& n = frames.normals.back();
    Vec3d along = frames.tangents[i] - n * n.dot(frames.tangents[i]);
    if (!(along.norm() > 0)) along = n.unitOrthogonal();
    frames.tangents[i] = along.normalized();
  }
  return frames;
}

BakedPictures baked(const Version& version, const TriangleMesh& surface, const NearestTriangle& tree,
                    const QuadMesh& mesh, const UvMap& map, int pixels,
                    const std::function<std::array<uint8_t, 3>(uint32_t triangle, const Vec3d& at)>& colourAt,
                    int threads, const WorkPart& part) {
  const Grid& grid = version.grid();
  const Drawn drawn = drawnOf(mesh, map);
  const UvFrames frames = framesOf(mesh, map);
  std::vector<uint32_t> owner = ownersOf(drawn, map, pixels);
  const size_t side = size_t(pixels), count = side * side;
  BakedPictures out;
  out.pixels = pixels;
  out.normals.assign(3 * count, 0);
  out.heights.assign(count, 0);
  if (colourAt) out.colours.assign(3 * count, 0);
  std::vector<float> heights(count, 0);
  std::vector<uint32_t> missedOf(side, 0), metOf(side, 0);
  std::atomic<size_t> done{0};
  parallelBlocks(
      side, threads,
      [&](size_t begin, size_t end) {
        Sampler field(version);
        uint32_t hint = UINT32_MAX;
        for (size_t y = begin; y < end; ++y) {
          part.step(0.95 * double(done++) / double(side));
          for (size_t x = 0; x < side; ++x) {
            const size_t i = y * side + x;
            if (owner[i] == UINT32_MAX) continue;
            const auto& t = drawn.triangles[owner[i]];
            const Vec2d p((double(x) + 0.5) / pixels, 1 - (double(y) + 0.5) / pixels);
            const Vec2d &a = map.places[t[0].place], b = map.places[t[1].place] - a, c = map.places[t[2].place] - a;
            const double whole = cross(b, c), second = cross(p - a, c) / whole, third = cross(b, p - a) / whole;
            const std::array<double, 3> weights = {1 - second - third, second, third};
            Vec3d at = Vec3d::Zero(), normal = at, tangent = at;
            for (size_t k = 0; k < 3; ++k) {
              at += weights[k] * mesh.positions[t[k].vertex];
              normal += weights[k] * frames.normals[t[k].place];
              tangent += weights[k] * frames.tangents[t[k].place];
            }
            normal.normalize();
            tangent = (tangent - normal * normal.dot(tangent)).normalized();
            // A step as long as the clay is far cannot pass it.
            double along = 0;
            bool met = false;
            for (int step = 0; step < kSteps && !met; ++step) {
              const float phi = field.trilinear(grid.toVoxel(at + along * normal));
              met = std::abs(phi) < kClose;
              along -= double(phi) * grid.voxelMm;
              if (std::abs(along) > drawn.reachMm[owner[i]]) break;
            }
            Vec3d place = at + along * normal;
            ++metOf[y];
            if (!met) {
              hint = tree.nearest(at, hint).triangle;
              const auto& n = tree.corners(hint);
              place = nearestOnTriangle(at, surface.positions[n[0]], surface.positions[n[1]], surface.positions[n[2]]);
              along = (place - at).dot(normal);
              ++missedOf[y];
            }
            heights[i] = static_cast<float>(along);
            Vec3f gradient;
            field.tricubic(grid.toVoxel(place), gradient);
            const Vec3d facing = gradient.norm() > 0 ? Vec3d(gradient.cast<double>().normalized()) : normal;
            out.normals[3 * i] = byteOf(facing.dot(tangent));
            out.normals[3 * i + 1] = byteOf(facing.dot(normal.cross(tangent)));
            out.normals[3 * i + 2] = byteOf(facing.dot(normal));
            if (colourAt) {
              hint = tree.nearest(place, hint).triangle;
              const std::array<uint8_t, 3> colour = colourAt(tree.indexOf(hint), place);
              std::copy(colour.begin(), colour.end(), out.colours.begin() + std::ptrdiff_t(3 * i));
            }
          }
        }
      },
      kRows);
  double missed = 0, met = 0;
  for (size_t y = 0; y < side; ++y) missed += missedOf[y], met += metOf[y];
  out.missed = met > 0 ? missed / met : 0;
  float most = 0;
  for (const float each : heights) most = std::max(most, std::abs(each));
  out.heightMm = double(most);
  spread(owner, pixels, std::max(2, pixels / 256));
  for (size_t i = 0; i < count; ++i) {
    const size_t from = owner[i] == UINT32_MAX ? i : owner[i];
    const bool nothing = owner[i] == UINT32_MAX;
    for (size_t k = 0; k < 3; ++k) {
      out.normals[3 * i + k] = nothing ? (k < 2 ? 128 : 255) : out.normals[3 * from + k];
      if (colourAt) out.colours[3 * i + k] = nothing ? 128 : out.colours[3 * from + k];
    }
    const double height = most > 0 ? double(heights[from]) / double(most) : 0;
    out.heights[i] = static_cast<uint16_t>(std::lround((0.5 + 0.5 * height) * 65535));
  }
  return out;
}

}  // namespace argil::clay
