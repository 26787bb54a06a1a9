#include "clay/mesh/nearest_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace argil::clay {

namespace {

constexpr uint32_t kLeaf = 2;  ///< Triangles.
/// A triangle flatter than this, squared height against squared length, is the segments that bound it.
constexpr double kFlat = 1e-24;
constexpr int kMortonBits = 16;  ///< An axis.

Vec3d onSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double length2 = ab.squaredNorm();
  return length2 > 0 ? Vec3d(a + std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) * ab) : a;
}

/// Each of 21 bits followed by two zeros.
uint64_t spread(uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

float roundedDown(double x) {
  const auto rounded = static_cast<float>(x);
  return double(rounded) > x ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
}
float roundedUp(double x) {
  return -roundedDown(-x);
}

}  // namespace

Vec3d nearestOnTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const Vec3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double longest2 = std::max(ab.squaredNorm(), ac.squaredNorm());
  if (!(ab.cross(ac).squaredNorm() > kFlat * longest2 * longest2)) {
    Vec3d best = onSegment(p, a, b);
    for (const Vec3d& other : {onSegment(p, b, c), onSegment(p, c, a)})
      if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
    return best;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double scale = 1 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

NearestTriangle::NearestTriangle(const TriangleMesh& mesh) : mesh_(mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t) box.extend(mesh.positions[v]);
  middle_ = box.center();
  const double side = std::max(box.sizes().maxCoeff(), std::numeric_limits<double>::min());
  scale_ = 2 / side;
  const double scale = ((1 << kMortonBits) - 1) / side;

  struct Place {
    uint64_t code;
    uint32_t triangle;
  };
  std::vector<Place> places(mesh.triangles.size());
  for (size_t i = 0; i < places.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vec3d at = ((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3 - box.min()) * scale;
    places[i] = {spread(static_cast<uint64_t>(at.x())) << 2 | spread(static_cast<uint64_t>(at.y())) << 1 |
                     spread(static_cast<uint64_t>(at.z())),
                 static_cast<uint32_t>(i)};
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.code != b.code ? a.code < b.code : a.triangle < b.triangle;
  });
  triangles_.reserve(places.size());
  indices_.reserve(places.size());
  for (const Place& place : places) {
    triangles_.push_back(mesh.triangles[place.triangle]);
    indices_.push_back(place.triangle);
  }
  std::vector<Place>().swap(places);

  // Twice the area times the normal, of the triangles of each lane; a level's are summed for the one above.
  std::vector<Vec3d> normals((triangles_.size() + kLeaf - 1) / kLeaf, Vec3d::Zero());
  for (size_t i = 0; i < triangles_.size(); ++i) {
    const auto& [a, b, c] = triangles_[i];
    const Vec3d& corner = mesh.positions[a];
    normals[i / kLeaf] += (mesh.positions[b] - corner).cross(mesh.positions[c] - corner);
  }
  size_t total = 0;
  for (size_t lanes = normals.size(), nodes = 0; nodes != 1; lanes = nodes) {
    nodes = (lanes + kBoxes - 1) / kBoxes;
    levels_.push_back(total);
    total += nodes;
  }
  nodes_.resize(total);
  for (size_t level = 0; level < levels_.size(); ++level) {
    addBoxes(normals, level);
    std::vector<Vec3d> sums((normals.size() + kBoxes - 1) / kBoxes, Vec3d::Zero());
    for (size_t i = 0; i < normals.size(); ++i) sums[i / kBoxes] += normals[i];
    normals.swap(sums);
  }
}

// `normals`: of the level's lanes.
void NearestTriangle::addBoxes(const std::vector<Vec3d>& normals, size_t level) {
  BoxNode* const nodes = nodes_.data() + levels_[level];
  const BoxNode* const below = level > 0 ? nodes_.data() + levels_[level - 1] : nullptr;
  const size_t ends = level + 1 < levels_.size() ? levels_[level + 1] : nodes_.size();
  const size_t each = size_t(kLeaf) << (3 * level);  // triangles a lane
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  constexpr double kNoLonger = 1 - 2e-7;  // than 1, once it is rounded to float
  for (size_t i = 0; i < (ends - levels_[level]) * kBoxes; ++i) {
    BoxNode& node = nodes[i / kBoxes];
    const size_t lane = i % kBoxes;
    const double length = i < normals.size() ? normals[i].norm() : 0;
    const Vec3d unit = length > 0 && std::isfinite(length) ? Vec3d(normals[i] / length) : Vec3d::UnitZ();
    const Eigen::Vector3f normal = (kNoLonger * unit).cast<float>();
    const Vec3d exact = normal.cast<double>();
    double from = kInfinite, to = -kInfinite;
    Vec3d low = Vec3d::Constant(kInfinite), high = -low;
    for (size_t t = i * each; t < std::min((i + 1) * each, triangles_.size()); ++t)
      for (const uint32_t v : triangles_[t]) {
        const Vec3d p = inTree(mesh_.positions[v]);
        const double along = exact.dot(p);
        from = std::min(from, along);
        to = std::max(to, along);
        if (below) continue;
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    node.from[lane] = roundedDown(from);
    node.to[lane] = roundedUp(to);
    for (int axis = 0; axis < 3; ++axis) {
      node.normal[axis][lane] = normal[axis];
      node.low[axis][lane] = roundedDown(low[axis]);
      node.high[axis][lane] = roundedUp(high[axis]);
      if (!below || i >= normals.size()) continue;
      node.low[axis][lane] = *std::min_element(below[i].low[axis], below[i].low[axis] + kBoxes);
      node.high[axis][lane] = *std::max_element(below[i].high[axis], below[i].high[axis] + kBoxes);
    }
  }
}

double NearestTriangle::squaredTo(uint32_t triangle, const Vec3d& p) const {
  const auto& [a, b, c] = triangles_[triangle];
  return (nearestOnTriangle(p, mesh_.positions[a], mesh_.positions[b], mesh_.positions[c]) - p).squaredNorm();
}

NearestTriangle::Hit NearestTriangle::nearest(const Vec3d& p, uint32_t hint) const {
  Hit best{0, std::numeric_limits<double>::infinity()};
  if (hint < triangles_.size()) best = {hint, squaredTo(hint, p)};
  return search(p, best, -1);
}

NearestTriangle::Hit NearestTriangle::nearEnough(const Vec3d& p, double enough, uint32_t hint) const {
  Hit best{0, std::numeric_limits<double>::infinity()};
  if (hint < triangles_.size()) best = {hint, squaredTo(hint, p)};
  return best.squared <= enough * enough ? best : search(p, best, enough * enough);
}

NearestTriangle::Hit NearestTriangle::nearerThan(const Vec3d& p, double distance, uint32_t hint) const {
  Hit best{UINT32_MAX, distance * distance};
  if (hint < triangles_.size())
    if (const double squared = squaredTo(hint, p); squared < best.squared) best = {hint, squared};
  return search(p, best, -1);
}

bool NearestTriangle::within(const Vec3d& p, double distance) const {
  const double squared = distance * distance;
  return search(p, {UINT32_MAX, std::nextafter(squared, std::numeric_limits<double>::infinity())}, squared).triangle !=
         UINT32_MAX;
}

NearestTriangle::Hit NearestTriangle::search(const Vec3d& p, Hit best, double enough) const {
  // No bound would exclude anything, and all triangles would be looked at in vain.
  if (!p.allFinite()) return best;
  const Vec3d place = inTree(p);
  // Beyond any float the bounds say nothing, and every triangle is looked at.
  constexpr double kFarthest = 1e18;
  const Vec3d near = place.cwiseMax(-kFarthest).cwiseMin(kFarthest);
  const float at[3] = {static_cast<float>(near.x()), static_cast<float>(near.y()), static_cast<float>(near.z())};
  // What rounding `at` and the sums of three products of floats take off or add.
  const auto slack = static_cast<float>(1e-6 * (near.cwiseAbs().maxCoeff() + 1));
  const bool bounded = place == near;
  // In the tree's units, rounded up.
  const auto bestBound = [&] {
    const double squared = best.squared * scale_ * scale_ * (1 + 1e-6);
    constexpr float kMost = std::numeric_limits<float>::max();
    return bounded && squared < double(kMost) ? roundedUp(squared) : kMost;
  };

  struct Entry {
    float bound;
    uint32_t level;
    size_t node;
  };
  std::array<Entry, 80> stack;  // At most 11 levels of 8, and each leaves seven.
  size_t depth = 0;
  float most = bestBound();
  stack[depth++] = {0, static_cast<uint32_t>(levels_.size() - 1), 0};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (entry.bound > most) continue;
    float bounds[kBoxes];
    uint32_t lanes = boundsOf(nodes_[levels_[entry.level] + entry.node], at, slack, most, bounds);
    if (entry.level > 0) {
      // The nearest on top.
      const size_t bottom = depth;
      for (; lanes; lanes &= lanes - 1) {
        const auto lane = static_cast<uint32_t>(std::countr_zero(lanes));
        const Entry child{bounded ? bounds[lane] : 0, entry.level - 1, kBoxes * entry.node + lane};
        size_t slot = depth++;
        for (; slot > bottom && stack[slot - 1].bound < child.bound; --slot) stack[slot] = stack[slot - 1];
        stack[slot] = child;
      }
      continue;
    }
    while (lanes) {
      uint32_t lane = static_cast<uint32_t>(std::countr_zero(lanes));
      for (uint32_t rest = lanes & (lanes - 1); rest; rest &= rest - 1) {
        const auto other = static_cast<uint32_t>(std::countr_zero(rest));
        if (bounds[other] < bounds[lane]) lane = other;
      }
      lanes &= ~(1u << lane);
      if (bounded && bounds[lane] > most) break;  // and so are the others
      const auto first = static_cast<uint32_t>((kBoxes * entry.node + lane) * kLeaf);
      const auto end = static_cast<uint32_t>(std::min<size_t>(first + kLeaf, triangles_.size()));
      for (uint32_t i = first; i < end; ++i) {
        const double squared = squaredTo(i, p);
        if (squared <= enough) return {i, squared};
        const bool tie = squared == best.squared && best.triangle != UINT32_MAX && i < best.triangle;
        if (!(squared < best.squared) && !tie) continue;
        best = {i, squared};
        most = bestBound();
      }
    }
  }
  return best;
}

}  // namespace argil::clay
