#include "clay/mesh/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace argil::clay {

namespace {

constexpr uint32_t kLeafTriangles = 6;

/// Indices of the components of a symmetric tensor of third order, in the order in which Node holds them.
constexpr int kThird[10][3] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {0, 0, 1}, {0, 0, 2},
                               {0, 1, 1}, {1, 1, 2}, {0, 2, 2}, {1, 2, 2}, {0, 1, 2}};

/// Sum of angles in (−π, π], held as a product of complex numbers and a count of turns: one arc tangent for any number
/// of triangles.
class AngleSum {
 public:
  void add(double real, double imaginary) noexcept {
    const double size = std::max(std::abs(real), std::abs(imaginary));
    if (size == 0) return;  // a corner of the triangle is the point itself: no angle
    const double r = real / size, i = imaginary / size;
    const double newReal = real_ * r - imaginary_ * i;
    const double newImaginary = real_ * i + imaginary_ * r;
    // Two angles of one sign whose sum has the other sign went through ±π.
    if (imaginary_ >= 0 && i >= 0 && newImaginary < 0) ++turns_;
    if (imaginary_ < 0 && i < 0 && newImaginary >= 0) --turns_;
    // Keeps the product far from overflow and underflow.
    const double scale = 1 / std::max(std::abs(newReal), std::abs(newImaginary));
    real_ = newReal * scale;
    imaginary_ = newImaginary * scale;
  }
  [[nodiscard]] double total() const noexcept { return std::atan2(imaginary_, real_) + 2 * std::numbers::pi * turns_; }

 private:
  double real_ = 1, imaginary_ = 0;
  int turns_ = 0;
};

/// Adds half of the solid angle of a triangle (van Oosterom and Strackee 1983).
void addTriangle(AngleSum& sum, const std::array<Vec3d, 3>& triangle, const Vec3d& point) noexcept {
  const Vec3d a = triangle[0] - point, b = triangle[1] - point, c = triangle[2] - point;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  sum.add(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb, a.dot(b.cross(c)));
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& mesh, double accuracy) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    triangles.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  if (triangles.empty()) return;

  std::vector<uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(triangles.size());
  build(order, triangles, 0, uint32_t(triangles.size()), accuracy);
  triangles_.reserve(triangles.size());
  for (const uint32_t t : order) triangles_.push_back(triangles[t]);
}

void WindingNumber::build(std::vector<uint32_t>& order, const std::vector<Triangle>& triangles, uint32_t first,
                          uint32_t count, double accuracy) {
  const auto centroid = [&](uint32_t t) -> Vec3d { return (triangles[t][0] + triangles[t][1] + triangles[t][2]) / 3; };
  const auto areaNormal = [&](uint32_t t) -> Vec3d {
    return (triangles[t][1] - triangles[t][0]).cross(triangles[t][2] - triangles[t][0]) / 2;
  };

  Node node{};
  node.first = first;
  node.count = count;
  node.leaf = count <= kLeafTriangles;
  double area = 0;
  Vec3d weighted = Vec3d::Zero(), plain = Vec3d::Zero();
  Vec3d low = centroid(order[first]), high = low;
  for (uint32_t i = first; i < first + count; ++i) {
    const Vec3d c = centroid(order[i]), n = areaNormal(order[i]);
    area += n.norm();
    weighted += n.norm() * c;
    plain += c;
    node.dipole += n;
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  }
  node.centre = area > 0 ? Vec3d(weighted / area) : Vec3d(plain / count);
  double radiusSquared = 0;
  for (uint32_t i = first; i < first + count; ++i) {
    const Triangle& t = triangles[order[i]];
    const Vec3d n = areaNormal(order[i]);
    const Vec3d v[3] = {t[0] - node.centre, t[1] - node.centre, t[2] - node.centre};
    const Vec3d sum = v[0] + v[1] + v[2];
    const Vec3d d = sum / 3;
    auto& q = node.quadrupole;
    for (int k = 0; k < 3; ++k) q[k] += n[k] * d[k];
    q[3] += (n.x() * d.y() + n.y() * d.x()) / 2;
    q[4] += (n.x() * d.z() + n.z() * d.x()) / 2;
    q[5] += (n.y() * d.z() + n.z() * d.y()) / 2;
    // Mean of x ⊗ x over the triangle.
    Eigen::Matrix3d m = sum * sum.transpose();
    for (const Vec3d& corner : v) m += corner * corner.transpose();
    m /= 12;
    const auto third = [&](int x, int y, int z) { return (n[x] * m(y, z) + n[y] * m(x, z) + n[z] * m(x, y)) / 3; };
    auto& o = node.octupole;
    for (int k = 0; k < 10; ++k) o[k] += third(kThird[k][0], kThird[k][1], kThird[k][2]);
    for (const Vec3d& corner : v) radiusSquared = std::max(radiusSquared, corner.squaredNorm());
  }
  const auto& o = node.octupole;
  node.octupoleTrace = {o[0] + o[5] + o[7], o[3] + o[1] + o[8], o[4] + o[6] + o[2]};
  node.farSquared = radiusSquared * accuracy * accuracy;

  const size_t at = nodes_.size();
  nodes_.push_back(node);
  if (!node.leaf) {
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const uint32_t half = count / 2;
    const auto begin = order.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [&](uint32_t l, uint32_t r) {
      const double cl = centroid(l)[axis], cr = centroid(r)[axis];
      return cl != cr ? cl < cr : l < r;
    });
    build(order, triangles, first, half, accuracy);
    build(order, triangles, first + half, count - half, accuracy);
  }
  nodes_[at].next = uint32_t(nodes_.size());
}

double WindingNumber::at(const Vec3d& point) const noexcept {
  AngleSum near;
  double far = 0;
  for (uint32_t i = 0; i < nodes_.size();) {
    const Node& node = nodes_[i];
    const Vec3d d = node.centre - point;
    const double squared = d.squaredNorm();
    if (squared > node.farSquared) {
      // Taylor series of (x − p) / |x − p|³ about the centre, contracted with the moments.
      const double inverse = 1 / std::sqrt(squared);
      const double inverse2 = inverse * inverse;
      const double x = d.x(), y = d.y(), z = d.z();
      const auto& q = node.quadrupole;
      const double second =
          q[0] * x * x + q[1] * y * y + q[2] * z * z + 2 * (q[3] * x * y + q[4] * x * z + q[5] * y * z);
      const auto& o = node.octupole;
      const double third = o[0] * x * x * x + o[1] * y * y * y + o[2] * z * z * z + 6 * o[9] * x * y * z +
                           3 * (o[3] * x * x * y + o[4] * x * x * z + o[5] * x * y * y + o[6] * y * y * z +
                                o[7] * x * z * z + o[8] * y * z * z);
      far += inverse * inverse2 *
             (node.dipole.dot(d) + q[0] + q[1] + q[2] - 3 * second * inverse2 +
              inverse2 * (7.5 * third * inverse2 - 4.5 * node.octupoleTrace.dot(d)));
      i = node.next;
    } else if (node.leaf) {
      for (uint32_t t = node.first; t < node.first + node.count; ++t) addTriangle(near, triangles_[t], point);
      i = node.next;
    } else {
      ++i;
    }
  }
  // Solid angle is twice the sum of half angles; a full sphere is 4π.
  return near.total() / (2 * std::numbers::pi) + far / (4 * std::numbers::pi);
}

double WindingNumber::exact(const Vec3d& point) const noexcept {
  return exact(triangles_, point);
}

double WindingNumber::exact(std::span<const Triangle> triangles, const Vec3d& point) noexcept {
  AngleSum sum;
  for (const Triangle& triangle : triangles) addTriangle(sum, triangle, point);
  return sum.total() / (2 * std::numbers::pi);
}

}  // namespace argil::clay
