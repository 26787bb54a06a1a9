#include "clay/mould/pull_faces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clay/base/parallel.h"

namespace argil::clay {

namespace {

constexpr int kMostCells = 2048;  // along a side of the plane
constexpr size_t kBlock = 4096;
constexpr double kUpright = 0.0175;  // sine of a degree: triangles of a wall that stands upright lean by as much
constexpr double kMostLean = 0.2;    // tangent by which a triangle of a face leans, however small it is

using Vec2d = Eigen::Vector2d;

// Triangles by where they lie across the pull.
class Columns {
 public:
  Columns(const TriangleMesh& mesh, const Vec3d& pull) : mesh_(mesh) {
    const Vec3d u = pull.unitOrthogonal(), v = pull.cross(u);
    turned_.reserve(mesh.positions.size());
    Vec2d low = Vec2d::Constant(INFINITY), high = -low;
    for (const Vec3d& p : mesh.positions) {
      turned_.emplace_back(p.dot(u), p.dot(v), p.dot(pull));
      low = low.cwiseMin(turned_.back().head<2>()), high = high.cwiseMax(turned_.back().head<2>());
    }
    low_ = low;
    // About a triangle a cell, so that lists are short.
    const Vec2d size = (high - low).cwiseMax(1e-12);
    cell_ = std::max({std::sqrt(size.prod() / double(std::max<size_t>(1, mesh.triangles.size() / 2))),
                      size.maxCoeff() / kMostCells, 1e-12});
    width_ = static_cast<int>(size.x() / cell_) + 1;
    height_ = static_cast<int>(size.y() / cell_) + 1;
    starts_.assign(size_t(width_) * size_t(height_) + 1, 0);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) forEachCell(t, [&](size_t c) { ++starts_[c + 1]; });
    for (size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
    triangles_.resize(starts_.back());
    std::vector<uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) forEachCell(t, [&](size_t c) { triangles_[next[c]++] = t; });
  }

  [[nodiscard]] std::array<Vec3d, 3> corners(uint32_t t) const {
    const auto& c = mesh_.triangles[t];
    return {turned_[c[0]], turned_[c[1]], turned_[c[2]]};
  }
  // Whether a triangle lies on the line from p upwards, or downwards.
  [[nodiscard]] bool covered(const Vec3d& p, double way) const {
    const Vec2d in = (p.head<2>() - low_) / cell_;
    if (!(in.x() >= 0 && in.y() >= 0 && in.x() < width_ && in.y() < height_)) return false;
    const size_t c = size_t(in.y()) * size_t(width_) + size_t(in.x());
    for (uint32_t i = starts_[c]; i < starts_[c + 1]; ++i)
      if (lies(triangles_[i], p, way)) return true;
    return false;
  }

 private:
  template <class Visit>
  void forEachCell(uint32_t t, const Visit& visit) const {
    const auto p = corners(t);
    const auto cellOf = [&](double at, double low, int count) {
      return std::clamp(static_cast<int>((at - low) / cell_), 0, count - 1);
    };
    const auto [x0, x1] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [y0, y1] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    for (int y = cellOf(y0, low_.y(), height_); y <= cellOf(y1, low_.y(), height_); ++y)
      for (int x = cellOf(x0, low_.x(), width_); x <= cellOf(x1, low_.x(), width_); ++x)
        visit(size_t(y) * size_t(width_) + size_t(x));
  }
  [[nodiscard]] bool lies(uint32_t t, const Vec3d& p, double way) const {
    const auto [a, b, c] = corners(t);
    if (way * (std::max({way * a.z(), way * b.z(), way * c.z()}) * way - p.z()) <= 0) return false;
    const auto side = [&](const Vec3d& from, const Vec3d& to) {
      return (to.x() - from.x()) * (p.y() - from.y()) - (to.y() - from.y()) * (p.x() - from.x());
    };
    const double ab = side(a, b), bc = side(b, c), ca = side(c, a), area = ab + bc + ca;
    if (area == 0 || !((ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0))) return false;
    return way * ((bc * a.z() + ca * b.z() + ab * c.z()) / area - p.z()) > 0;
  }

  const TriangleMesh& mesh_;
  std::vector<Vec3d> turned_;  // across, across, along the pull
  Vec2d low_;
  double cell_ = 1;
  int width_ = 0, height_ = 0;
  std::vector<uint32_t> starts_, triangles_;
};

Vec3d areaOf(const TriangleMesh& mesh, const std::array<uint32_t, 3>& t) {
  return (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]) / 2;
}

// The draft of each triangle, degrees, by its normal and those of the triangles around its corners that may be of the
// same face. Corners lie up to `slackMm` off the face, so a triangle leans by up to slack over its height: triangles of
// voxels by degrees, which the mean takes away, and large ones by nothing, so that caps and chamfers do not count.
std::vector<float> draftsOf(const TriangleMesh& mesh, const Vec3d& pull, double slackMm, int threads) {
  const size_t count = mesh.triangles.size();
  std::vector<Vec3d> areas(count);
  std::vector<double> leans(count);  // tangents
  std::vector<uint32_t> starts(mesh.positions.size() + 1, 0), around(3 * count);
  for (size_t t = 0; t < count; ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    areas[t] = areaOf(mesh, mesh.triangles[t]);
    const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double height = 2 * areas[t].norm() / std::max(longest, 1e-300);
    leans[t] = height > 0 ? std::min(kMostLean, slackMm / height) : kMostLean;
    for (const uint32_t v : mesh.triangles[t]) ++starts[v + 1];
  }
  for (size_t v = 1; v < starts.size(); ++v) starts[v] += starts[v - 1];
  std::vector<uint32_t> next(starts.begin(), starts.end() - 1);
  for (uint32_t t = 0; t < count; ++t)
    for (const uint32_t v : mesh.triangles[t]) around[next[v]++] = t;
  std::vector<float> drafts(count);
  parallelBlocks(
      count, threads,
      [&](size_t begin, size_t end) {
        for (size_t t = begin; t < end; ++t) {
          Vec3d sum = areas[t];
          for (const uint32_t v : mesh.triangles[t])
            for (uint32_t n = starts[v]; n < starts[v + 1]; ++n) {
              const uint32_t other = around[n];
              const double along = areas[t].dot(areas[other]);
              const double tangent = (leans[t] + leans[other]) / (1 - leans[t] * leans[other]);
              if (along > 0 && areas[t].cross(areas[other]).squaredNorm() <= tangent * tangent * along * along)
                sum += areas[other];
            }
          drafts[t] = static_cast<float>(draftDegrees(sum, pull));
        }
      },
      kBlock);
  return drafts;
}

}  // namespace

double draftDegrees(const Vec3d& normal, const Vec3d& pull) {
  // By both sides of the angle: exact near 0 and near 90 alike.
  return std::atan2(normal.dot(pull), normal.cross(pull).norm()) * 180 / std::numbers::pi;
}

PullFaces pullFaces(const TriangleMesh& mesh, const Vec3d& pull, double slackMm, double least, int threads) {
  PullFaces faces;
  faces.sides.resize(mesh.triangles.size());
  if (mesh.triangles.empty()) return faces;
  const Columns columns(mesh, pull);
  parallelBlocks(
      mesh.triangles.size(), threads,
      [&](size_t begin, size_t end) {
        for (size_t t = begin; t < end; ++t) {
          const auto p = columns.corners(static_cast<uint32_t>(t));
          const Vec3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
          const double way = normal.z() < 0 ? -1 : 1, length = normal.norm();
          const Vec3d from = (p[0] + p[1] + p[2]) / 3 + (length > 0 ? slackMm / length : 0) * normal;
          const bool upright = std::abs(normal.z()) <= kUpright * length;
          faces.sides[t] = !columns.covered(from, way)               ? (way < 0 ? PullSide::lower : PullSide::upper)
                           : upright && !columns.covered(from, -way) ? (way < 0 ? PullSide::upper : PullSide::lower)
                                                                     : PullSide::undercut;
        }
      },
      kBlock);
  faces.drafts = draftsOf(mesh, pull, slackMm, threads);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area = areaOf(mesh, mesh.triangles[t]).norm();
    (faces.sides[t] == PullSide::upper   ? faces.upperMm2
     : faces.sides[t] == PullSide::lower ? faces.lowerMm2
                                         : faces.undercutMm2) += area;
    if (faces.sides[t] != PullSide::undercut && std::abs(double(faces.drafts[t])) < least) faces.steepMm2 += area;
  }
  return faces;
}

}  // namespace argil::clay
