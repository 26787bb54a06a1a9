#include "haptics/scene/part_shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace argil::haptics {
namespace {

constexpr double kCreaseCosine = 0.76604;  // 40°.
constexpr size_t kReportEvery = 65536;     // Vertices.

Vec3d unitNormal(const PartTriangle& t) {
  const Vec3d a = t[0].cast<double>(), ab = t[1].cast<double>() - a, ac = t[2].cast<double>() - a;
  const Vec3d n = ab.cross(ac);
  const double length = n.norm();
  // Below rounding of the coordinates a normal has no direction.
  return length > 1e-12 * std::max(ab.squaredNorm(), ac.squaredNorm()) ? Vec3d(n / length) : Vec3d::Zero();
}

double angleAt(const PartTriangle& t, size_t i) {
  const Vec3d at = t[i].cast<double>(), u = t[(i + 1) % 3].cast<double>() - at, v = t[(i + 2) % 3].cast<double>() - at;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

// One vertex: the triangles around it and which of them shade into one another.
class Fan {
 public:
  Fan(const std::vector<PartTriangle>& triangles, const std::vector<std::array<uint32_t, 3>>& corner,
      const std::vector<Vec3d>& face, std::vector<PartShading>& out)
      : triangles_(triangles), corner_(corner), face_(face), out_(out) {}

  // `corners`: triangle · 3 + corner, of every triangle with area at one vertex.
  void shade(const uint32_t* corners, size_t count) {
    spokes_.clear();
    group_.resize(count);
    turned_.assign(count, false);
    size_.assign(count, 1);
    sum_.assign(count, Vec3d::Zero());
    std::iota(group_.begin(), group_.end(), 0u);
    for (size_t i = 0; i < count; ++i) {
      const size_t t = corners[i] / 3, c = corners[i] % 3;
      spokes_.push_back({corner_[t][(c + 1) % 3], static_cast<uint32_t>(i), true});
      spokes_.push_back({corner_[t][(c + 2) % 3], static_cast<uint32_t>(i), false});
    }
    std::sort(spokes_.begin(), spokes_.end(), [](const Spoke& a, const Spoke& b) {
      return a.to != b.to ? a.to < b.to : a.fan != b.fan ? a.fan < b.fan : a.outgoing < b.outgoing;
    });
    bool crease = false;
    for (size_t i = 0; i < spokes_.size();) {
      size_t end = i + 1;
      while (end < spokes_.size() && spokes_[end].to == spokes_[i].to) ++end;
      if (end - i == 2 && join(spokes_[i], spokes_[i + 1], corners)) {
        for (size_t k = i; k < end; ++k)
          if (spokes_[k].outgoing) smoothEdge(corners[spokes_[k].fan]);
      } else {
        crease = true;
      }
      i = end;
    }
    for (size_t i = 0; i < count; ++i) {
      const auto [root, turned] = find(static_cast<uint32_t>(i));
      const size_t t = corners[i] / 3;
      sum_[root] += (turned ? -1.0 : 1.0) * angleAt(triangles_[t], corners[i] % 3) * face_[t];
    }
    for (size_t i = 0; i < count; ++i) {
      const auto [root, turned] = find(static_cast<uint32_t>(i));
      const size_t t = corners[i] / 3, c = corners[i] % 3;
      Vec3d normal = (turned ? -1.0 : 1.0) * sum_[root];
      const double length = normal.norm();
      normal = length > 1e-6 ? Vec3d(normal / length) : face_[t];
      for (int k = 0; k < 3; ++k)
        out_[t].normal[c][size_t(k)] = static_cast<int16_t>(std::lround(normal[k] * PartShading::kOne));
      if (!crease) out_[t].creaseCorners = static_cast<uint8_t>(out_[t].creaseCorners & ~(1u << c));
    }
  }

 private:
  struct Spoke {
    uint32_t to = 0, fan = 0;
    bool outgoing = false;  // The triangle runs from the vertex to `to`.
  };
  struct Root {
    uint32_t root = 0;
    bool turned = false;
  };

  // Two triangles at an edge: one surface if they meet gently, told from a fold by the way they run along it.
  bool join(const Spoke& a, const Spoke& b, const uint32_t* corners) {
    if (a.fan == b.fan) return false;
    const bool flipped = a.outgoing == b.outgoing;
    const double cosine = face_[corners[a.fan] / 3].dot(face_[corners[b.fan] / 3]);
    if ((flipped ? -cosine : cosine) < kCreaseCosine) return false;
    Root ra = find(a.fan), rb = find(b.fan);
    if (ra.root == rb.root) return true;
    if (size_[ra.root] < size_[rb.root]) std::swap(ra, rb);
    size_[ra.root] += size_[rb.root];
    group_[rb.root] = ra.root;
    turned_[rb.root] = (ra.turned != rb.turned) != flipped;
    return true;
  }

  // Joined by size: short whatever the fan.
  Root find(uint32_t i) const {
    bool turned = false;
    while (group_[i] != i) {
      turned = turned != turned_[i];
      i = group_[i];
    }
    return {i, turned};
  }

  void smoothEdge(uint32_t corner) {
    PartShading& s = out_[corner / 3];
    s.creaseEdges = static_cast<uint8_t>(s.creaseEdges & ~(1u << (corner % 3)));
  }

  const std::vector<PartTriangle>& triangles_;
  const std::vector<std::array<uint32_t, 3>>& corner_;
  const std::vector<Vec3d>& face_;
  std::vector<PartShading>& out_;
  std::vector<Spoke> spokes_;
  std::vector<uint32_t> group_, size_;
  std::vector<bool> turned_;
  std::vector<Vec3d> sum_;
};

}  // namespace

std::vector<PartShading> shadeTriangles(const std::vector<PartTriangle>& triangles,
                                        const std::vector<std::array<uint32_t, 3>>& corner, size_t vertices, Job& job,
                                        double to) {
  std::vector<Vec3d> face(triangles.size());
  std::vector<uint32_t> first(vertices + 1, 0);
  for (size_t t = 0; t < triangles.size(); ++t) {
    face[t] = unitNormal(triangles[t]);
    if (face[t].isZero()) continue;
    for (const uint32_t v : corner[t]) ++first[v + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<uint32_t> around(first.back()), next(first.begin(), first.end() - 1);
  for (size_t t = 0; t < triangles.size(); ++t) {
    if (face[t].isZero()) continue;
    for (size_t c = 0; c < 3; ++c) around[next[corner[t][c]]++] = static_cast<uint32_t>(t * 3 + c);
  }
  std::vector<PartShading> out(triangles.size());
  Fan fan(triangles, corner, face, out);
  for (size_t v = 0; v < vertices; ++v) {
    if (v % kReportEvery == 0) job.step(to * double(v) / double(vertices));
    if (first[v + 1] > first[v]) fan.shade(&around[first[v]], first[v + 1] - first[v]);
  }
  return out;
}

}  // namespace argil::haptics
