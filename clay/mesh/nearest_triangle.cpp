#include "clay/mesh/nearest_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace argil::clay {

namespace {

constexpr uint32_t kLeaf = 4;  ///< Triangles.
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

float below(double x) {
  const auto rounded = static_cast<float>(x);
  return double(rounded) > x ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
}
Eigen::Array3f below(const Vec3d& p) {
  return {below(p.x()), below(p.y()), below(p.z())};
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

  const size_t used = (triangles_.size() + kLeaf - 1) / kLeaf;
  while (leaves_ < used) leaves_ *= 2;
  const Box nothing{Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()),
                    Eigen::Array3f::Constant(-std::numeric_limits<float>::infinity())};
  boxes_.assign(leaves_ + used, nothing);
  for (size_t k = 0; k < used; ++k) {
    Box& leaf = boxes_[leaves_ + k];
    for (size_t i = k * kLeaf; i < std::min((k + 1) * kLeaf, triangles_.size()); ++i)
      for (const uint32_t v : triangles_[i]) {
        const Vec3d p = mesh.positions[v] - middle_;
        leaf.low = leaf.low.min(below(p));
        leaf.high = leaf.high.max(-below(-p));
      }
  }
  for (size_t i = leaves_ - 1; i >= 1; --i)
    for (const size_t child : {2 * i, 2 * i + 1})
      if (child < boxes_.size()) {
        boxes_[i].low = boxes_[i].low.min(boxes_[child].low);
        boxes_[i].high = boxes_[i].high.max(boxes_[child].high);
      }
  addSlabs();
}

void NearestTriangle::addSlabs() {
  // Twice the area times the normal, of all triangles below.
  std::vector<Vec3d> normals(boxes_.size(), Vec3d::Zero());
  for (size_t i = 0; i < triangles_.size(); ++i) {
    const auto& [a, b, c] = triangles_[i];
    const Vec3d& corner = mesh_.positions[a];
    normals[leaves_ + i / kLeaf] += (mesh_.positions[b] - corner).cross(mesh_.positions[c] - corner);
  }
  for (size_t i = boxes_.size() - 1; i >= 2; --i) normals[i / 2] += normals[i];
  slabs_.resize(boxes_.size());
  for (size_t i = 1; i < boxes_.size(); ++i) {
    const double length = normals[i].norm();
    const Vec3d unit = length > 0 && std::isfinite(length) ? Vec3d(normals[i] / length) : Vec3d::UnitZ();
    constexpr double kNoLonger = 1 - 2e-7;  // than 1, once it is rounded to float
    slabs_[i] = {(kNoLonger * unit).cast<float>().array(), std::numeric_limits<float>::infinity(),
                 -std::numeric_limits<float>::infinity()};
  }
  for (size_t i = 0; i < triangles_.size(); ++i)
    for (const uint32_t v : triangles_[i]) {
      const Vec3d p = mesh_.positions[v] - middle_;
      for (size_t node = leaves_ + i / kLeaf; node >= 1; node /= 2) {
        Slab& slab = slabs_[node];
        const double along = slab.normal.cast<double>().matrix().dot(p);
        slab.low = std::min(slab.low, below(along));
        slab.high = std::max(slab.high, -below(-along));
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
  const Eigen::Array3d at = (p - middle_).array();
  const auto squaredToBox = [&](size_t node) {
    if (node >= boxes_.size()) return std::numeric_limits<double>::infinity();
    const Box& box = boxes_[node];
    return (box.low.cast<double>() - at).max(at - box.high.cast<double>()).max(0.0).square().sum();
  };
  // Whether the slab shows that all of a node is at least so far.
  const auto beyond = [&](size_t node, double squared) {
    const Slab& slab = slabs_[node];
    const double along = (slab.normal.cast<double>() * at).sum();
    const double gap = std::max(double(slab.low) - along, along - double(slab.high));
    return gap > 0 && gap * gap >= squared;
  };
  struct Entry {
    double squared;
    size_t node;
  };
  std::array<Entry, 40> stack;  // The tree is at most 31 deep, and each level leaves one entry.
  size_t depth = 0;
  stack[depth++] = {squaredToBox(1), 1};
  while (depth > 0) {
    Entry entry = stack[--depth];
    if (entry.squared >= best.squared || beyond(entry.node, best.squared)) continue;
    while (entry.node < leaves_) {
      Entry near{squaredToBox(2 * entry.node), 2 * entry.node},
          far{squaredToBox(2 * entry.node + 1), 2 * entry.node + 1};
      if (far.squared < near.squared) std::swap(near, far);
      if (far.squared < best.squared) stack[depth++] = far;
      entry = near;
      if (entry.squared >= best.squared || beyond(entry.node, best.squared)) break;
    }
    if (entry.node < leaves_ || entry.squared >= best.squared) continue;
    const auto first = static_cast<uint32_t>((entry.node - leaves_) * kLeaf);
    const auto end = static_cast<uint32_t>(std::min<size_t>(first + kLeaf, triangles_.size()));
    for (uint32_t i = first; i < end; ++i) {
      const double squared = squaredTo(i, p);
      if (squared < best.squared) best = {i, squared};
      if (squared <= enough) return best;
    }
  }
  return best;
}

}  // namespace argil::clay
