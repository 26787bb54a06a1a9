#include "haptics/scene/part_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "clay/mesh/weld.h"

namespace argil::haptics {
namespace {

constexpr double kFarthestMm = 1e9;
constexpr double kShadingShare = 0.5;  // Of the work.
// Discs and places are floats: each of some ten operations rounds by 6e-8 of the numbers that go in.
constexpr double kRounding = 1e-6;
// A triangle flatter than this, squared height against squared length, is the segments that bound it.
constexpr double kFlat = 1e-20;
// In a socket of the ball's own size every triangle is as near as any other, and all would be looked at to find the
// very nearest. So each so many that were looked at allow an answer this part of a resolution too far.
constexpr uint32_t kPatience = 128;
constexpr double kImpatience = 0.01;
constexpr double kMostImpatience = 0.1;
constexpr double kAtFeature = 1e-6;  // Of a barycentric coordinate: on an edge or at a corner.

Vec3d onSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double length2 = ab.squaredNorm();
  return length2 > 0 ? Vec3d(a + std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) * ab) : a;
}

// Ericson, Real-Time Collision Detection, 5.1.5.
Vec3d onTriangle(const Vec3d& p, const PartTriangle& t) {
  const Vec3d a = t[0].cast<double>(), b = t[1].cast<double>(), c = t[2].cast<double>();
  const Vec3d ab = b - a, ac = c - a, bc = c - b;
  const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
  if (!(ab.cross(ac).squaredNorm() > kFlat * longest2 * longest2)) {
    Vec3d best = onSegment(p, a, b);
    for (const Vec3d& other : {onSegment(p, b, c), onSegment(p, c, a)})
      if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
    return best;
  }
  const Vec3d ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + bc * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double scale = 1 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

struct Entry {
  float distance2 = 0;
  int32_t child = 0;
};

}  // namespace

PartMesh::PartMesh(const clay::TriangleMesh& mesh, Job* watched) {
  static std::atomic<uint64_t> numbers{0};
  number_ = ++numbers;
  Job unwatched;
  Job& job = watched ? *watched : unwatched;
  if (mesh.triangles.empty()) throw Error("a part without triangles cannot be touched: give it a mesh with a surface");
  if (mesh.triangles.size() > kMaxPartTriangles)
    throw Error(fmt::format("a part of {} triangles is more than touch holds ({}): reduce the mesh",
                            mesh.triangles.size(), kMaxPartTriangles));
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles)
    for (const uint32_t v : triangle) {
      if (v >= mesh.positions.size())
        throw Error(
            fmt::format("a triangle of a part names vertex {} of {}: repair the mesh", v, mesh.positions.size()));
      const Vec3d& p = mesh.positions[v];
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kFarthestMm)
        throw Error(fmt::format(
            "vertex {} of a part is not finite or farther than 1e9 mm from zero: repair the mesh or its units", v));
      box.extend(p);
    }
  middle_ = box.center();
  diagonal_ = box.diagonal().norm();

  // Formats repeat a vertex in each of its triangles: shading must know them as one. Vertices that no triangle names go
  // unchecked.
  clay::TriangleMesh welded = clay::weldExact(mesh);
  std::vector<PartTriangle> triangles(welded.triangles.size());
  double edges = 0;
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (size_t c = 0; c < 3; ++c) triangles[t][c] = (welded.positions[welded.triangles[t][c]] - middle_).cast<float>();
    for (size_t c = 0; c < 3; ++c) edges += double((triangles[t][(c + 1) % 3] - triangles[t][c]).norm());
  }
  const double size = diagonal_ > 0 ? diagonal_ : 1.0;  // A part that is a point has no size of its own.
  resolution_ = std::clamp(edges / (3.0 * double(triangles.size())), 1e-4 * size, size / 400);
  const std::vector<PartShading> shading =
      shadeTriangles(triangles, welded.triangles, welded.positions.size(), job, kShadingShare);
  welded = {};
  PartTree tree = buildPartTree(triangles, job, kShadingShare);
  nodes_ = std::move(tree.nodes);
  triangles_.reserve(triangles.size());
  shading_.reserve(triangles.size());
  for (const uint32_t t : tree.order) {
    triangles_.push_back(triangles[t]);
    shading_.push_back(shading[t]);
  }
  job.step(1);
}

PartMesh::Hit PartMesh::nearest(const Vec3d& p, double reachMm, uint32_t hint) const ARGIL_REALTIME {
  using Four = PartNode::Four;
  const Vec3d at = p - middle_;
  Hit hit;
  double best = reachMm;
  const auto look = [&](uint32_t t) {
    ++hit.looked;
    const Vec3d point = onTriangle(at, triangles_[t]);
    const double distance = (point - at).norm();
    if (distance < best || (distance == best && hit.triangle == kNone)) {
      best = distance;
      hit.triangle = t;
      hit.point = point;
    }
  };
  if (hint < triangles_.size()) look(hint);

  const double rounding = kRounding * (at.cwiseAbs().maxCoeff() + diagonal_);
  // What is farther, squared, holds nothing better.
  const auto bound = [&] {
    const double impatience = std::min(kImpatience * double(hit.looked / kPatience), kMostImpatience) * resolution_;
    const auto most = static_cast<float>(std::max(0.0, best * (1 + kRounding) + rounding - impatience));
    return most * most;
  };
  const Four px = Four::Constant(static_cast<float>(at.x())), py = Four::Constant(static_cast<float>(at.y())),
             pz = Four::Constant(static_cast<float>(at.z()));
  std::array<Entry, 3 * kMaxPartDepth + 4> stack;
  size_t height = 0;
  stack[height++] = {0, 0};
  float most2 = bound();
  while (height > 0) {
    const Entry entry = stack[--height];
    if (entry.distance2 > most2) continue;
    if (entry.child < 0) {
      const auto run = static_cast<uint32_t>(~entry.child);
      for (uint32_t t = run / 4, end = t + run % 4 + 1; t < end; ++t) look(t);
      most2 = bound();
      continue;
    }
    ++hit.nodes;
    const PartNode& node = nodes_[size_t(entry.child)];
    // Least distance to each disc: over its flat side and beyond its rim.
    const Four vx = px - node.centre[0], vy = py - node.centre[1], vz = pz - node.centre[2];
    const Four along = vx * node.axis[0] + vy * node.axis[1] + vz * node.axis[2];
    const Four wx = vx - along * node.axis[0], wy = vy - along * node.axis[1], wz = vz - along * node.axis[2];
    const Four over = (along.abs() - node.half).max(0.0f);
    const Four beyond = ((wx * wx + wy * wy + wz * wz).sqrt() - node.radius).max(0.0f);
    const Four distance2 = over * over + beyond * beyond;
    // Nearest on top.
    const size_t base = height;
    for (int i = 0; i < 4; ++i) {
      if (!(distance2[i] <= most2) || node.radius[i] < 0) continue;
      size_t k = height++;
      for (; k > base && stack[k - 1].distance2 < distance2[i]; --k) stack[k] = stack[k - 1];
      stack[k] = {distance2[i], node.child[size_t(i)]};
    }
  }
  hit.distance = best;
  if (hit.triangle != kNone) hit.point += middle_;
  return hit;
}

Vec3d PartMesh::normal(uint32_t triangle, const Vec3d& point) const ARGIL_REALTIME {
  if (triangle >= triangles_.size()) return Vec3d::Zero();
  const PartTriangle& t = triangles_[triangle];
  const PartShading& shading = shading_[triangle];
  const Vec3d a = t[0].cast<double>(), ab = t[1].cast<double>() - a, ac = t[2].cast<double>() - a,
              ap = point - middle_ - a;
  const Vec3d n = ab.cross(ac);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0) || shading.at(0).isZero()) return Vec3d::Zero();
  const double v = std::clamp(ap.cross(ac).dot(n) / n2, 0.0, 1.0), w = std::clamp(ab.cross(ap).dot(n) / n2, 0.0, 1.0);
  const std::array<double, 3> weight = {std::max(0.0, 1 - v - w), v, w};
  for (size_t i = 0; i < 3; ++i) {
    const bool edge = weight[(i + 2) % 3] < kAtFeature && (shading.creaseEdges >> i & 1);
    const bool corner = weight[i] > 1 - kAtFeature && (shading.creaseCorners >> i & 1);
    if (edge || corner) return Vec3d::Zero();
  }
  const Vec3d sum = weight[0] * shading.at(0) + weight[1] * shading.at(1) + weight[2] * shading.at(2);
  const double length = sum.norm();
  return length > 0.1 ? Vec3d(sum / length) : Vec3d::Zero();
}

size_t PartMesh::bytes() const noexcept {
  return triangles_.capacity() * sizeof(PartTriangle) + shading_.capacity() * sizeof(PartShading) +
         nodes_.capacity() * sizeof(PartNode);
}

}  // namespace argil::haptics
