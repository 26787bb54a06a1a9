#include "render/surface/part_layout.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "clay/base/error.h"

namespace argil::render {
namespace {

constexpr double kCreaseCosine = 0.766;  ///< 40°
constexpr double kUnitsAcross = double(1 << 30);
constexpr uint32_t kLeaf = 4;
constexpr double kLeastExtentMm = 1e-6;

/// Twice the area times the normal.
Vec3d facing(const clay::TriangleMesh& mesh, const std::array<uint32_t, 3>& t) {
  const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
  return (b - a).cross(c - a);
}

}  // namespace

PartLayout::PartLayout(const clay::TriangleMesh& mesh, BufferRanges& ranges, UploadSink& sink) : ranges_(ranges) {
  for (const Vec3d& p : mesh.positions) {
    if (!p.allFinite()) throw Error("a part to be drawn has a vertex that is not finite; repair the mesh");
  }
  for (const auto& t : mesh.triangles) {
    for (const uint32_t corner : t) {
      if (corner >= mesh.positions.size())
        throw Error("a part to be drawn has a triangle without a vertex; repair the mesh");
      bounds_.add(mesh.positions[corner]);
    }
  }
  if (mesh.triangles.empty()) return;
  origin_ = bounds_.centre();
  unitMm_ = std::exp2(std::ceil(std::log2(std::max(bounds_.size().maxCoeff(), kLeastExtentMm) / kUnitsAcross)));
  for (const Vec3d& p : mesh.positions) positions_.push_back((p - origin_).cast<float>());
  triangles_ = mesh.triangles;
  order_.resize(triangles_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  build(0, uint32_t(order_.size()));

  // The faces around each position.
  std::vector<Vec3d> normals;
  for (const auto& t : mesh.triangles) normals.push_back(facing(mesh, t));
  std::vector<uint32_t> start(mesh.positions.size() + 1, 0), around(mesh.triangles.size() * 3);
  for (const auto& t : mesh.triangles)
    for (const uint32_t corner : t) ++start[corner + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<uint32_t> next(start.begin(), start.end() - 1);
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const uint32_t corner : mesh.triangles[t]) around[next[corner]++] = t;

  std::vector<SurfaceVertex> vertices;
  std::vector<uint32_t> indices;
  std::map<std::pair<uint32_t, std::pair<int16_t, int16_t>>, uint32_t> known;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d own = normals[t].stableNormalized();
    for (const uint32_t corner : mesh.triangles[t]) {
      Vec3d sum = Vec3d::Zero();
      for (uint32_t i = start[corner]; i < start[corner + 1]; ++i) {
        const Vec3d& other = normals[around[i]];
        if (other.dot(own) >= kCreaseCosine * other.norm()) sum += other;
      }
      const Vec3d unit = sum.squaredNorm() > 0 ? sum.stableNormalized() : Vec3d::UnitZ();
      const clay::PackedNormal normal = clay::PackedNormal::pack(unit.cast<float>());
      const auto [at, isNew] = known.try_emplace({corner, {normal.u, normal.v}}, uint32_t(vertices.size()));
      if (isNew) {
        const Vec3d p = ((mesh.positions[corner] - origin_) / unitMm_).array().round();
        vertices.push_back({int32_t(p.x()), int32_t(p.y()), int32_t(p.z()), normal});
      }
      indices.push_back(at->second);
    }
  }
  const auto quads = uint32_t((indices.size() + kIndicesPerQuad - 1) / kIndicesPerQuad);
  ranges_.reserve(vertices.size(), quads, sink);
  vertexCount_ = uint32_t(vertices.size());
  firstVertex_ = ranges_.takeVertices(vertexCount_, sink);
  quadCount_ = quads;
  firstQuad_ = ranges_.takeQuads(quads, sink);
  for (uint32_t& index : indices) index += firstVertex_;
  sink.writeVertices(firstVertex_, vertices);
  if (ranges_.painted()) sink.writePaint(firstVertex_, std::vector<PackedPaint>(vertices.size(), kUnpainted));
  sink.writeIndices(firstQuad_ * kIndicesPerQuad, indices);
}

PartLayout::~PartLayout() {
  ranges_.releaseVertices(firstVertex_, vertexCount_);
  ranges_.releaseQuads(firstQuad_, quadCount_);
}

ChunkDraw::Range PartLayout::draw() const {
  const auto triangles = uint32_t(triangles_.size());
  return {firstQuad_ * kIndicesPerQuad, 3 * triangles, triangles, true};
}

Box PartLayout::bounds(const Eigen::Quaterniond& rotation, const Vec3d& translation) const {
  Box box;
  if (bounds_.empty()) return box;
  if (rotation.vec().isZero(0)) {
    box.add(bounds_.min + translation);
    box.add(bounds_.max + translation);
    return box;
  }
  for (const auto& triangle : triangles_)
    for (const uint32_t corner : triangle)
      box.add(Vec3d(rotation * (origin_ + positions_[corner].cast<double>()) + translation));
  return box;
}

uint32_t PartLayout::build(uint32_t first, uint32_t count) {
  const auto at = uint32_t(nodes_.size());
  nodes_.emplace_back();
  const auto centre = [&](uint32_t triangle) -> Vec3f {
    const auto& t = triangles_[triangle];
    return positions_[t[0]] + positions_[t[1]] + positions_[t[2]];
  };
  Vec3f min = positions_[triangles_[order_[first]][0]], max = min, low = centre(order_[first]), high = low;
  for (uint32_t i = first; i < first + count; ++i) {
    for (const uint32_t corner : triangles_[order_[i]]) {
      min = min.cwiseMin(positions_[corner]);
      max = max.cwiseMax(positions_[corner]);
    }
    low = low.cwiseMin(centre(order_[i]));
    high = high.cwiseMax(centre(order_[i]));
  }
  nodes_[at].min = min;
  nodes_[at].max = max;
  if (count <= kLeaf) {
    nodes_[at].first = first;
    nodes_[at].count = count;
    return at;
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const uint32_t half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](uint32_t a, uint32_t b) {
    const float ca = centre(a)[axis], cb = centre(b)[axis];
    return ca != cb ? ca < cb : a < b;
  });
  build(first, half);
  nodes_[at].right = build(first + half, count - half);
  return at;
}

std::optional<RayHit> PartLayout::raycast(const Ray& rayMm) const {
  if (nodes_.empty()) return std::nullopt;
  Ray ray = rayMm;
  ray.origin -= origin_;
  RayHit hit;
  bool any = false;
  std::vector<uint32_t> stack{0};
  while (!stack.empty()) {
    const uint32_t at = stack.back();
    stack.pop_back();
    const Node& node = nodes_[at];
    if (enterBox(ray, node.min.cast<double>(), node.max.cast<double>()) == kNever) continue;
    if (node.count == 0) {
      stack.push_back(node.right);
      stack.push_back(at + 1);
      continue;
    }
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto& triangle = triangles_[order_[i]];
      const Vec3d a = positions_[triangle[0]].cast<double>(), b = positions_[triangle[1]].cast<double>(),
                  c = positions_[triangle[2]].cast<double>();
      const double t = hitTriangle(ray, a, b, c);
      if (t == kNever || (any && t >= hit.distanceMm)) continue;
      any = true;
      ray.last = t;
      hit.distanceMm = t;
      hit.normal = (b - a).cross(c - a).normalized();
      hit.fromOutside = hit.normal.dot(ray.direction) < 0;
    }
  }
  if (!any) return std::nullopt;
  return hit;
}

}  // namespace argil::render
