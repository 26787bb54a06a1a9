#include "clay/field/foot_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "clay/base/spline_weights.h"
#include "clay/kernels/cell_cases.h"

namespace argil::clay {

namespace {

constexpr float kLeastSlope = 0.5f;     // a gradient below that points nowhere
constexpr float kMostShift = 0.5f;      // voxels from the mean of a cell's crossings to the level set
constexpr float kMostCurvature = 0.8f;  // per voxel: what voxels can tell
constexpr float kDeepest = 0.6f;        // of a hollow's radius
constexpr float kLeastSpread = 0.25f;   // of normals, beside what they are at the surface: behind it too
constexpr float kBeside2 = 5;           // voxels²: from the nearest place to a point,
constexpr float kBesideBent2 = 0.6f;    // where each cell has one
constexpr float kSame = 0.005f;         // voxels: so much off, a cell needs no point of its own,
constexpr float kBent = 0.05f;          // and from so much on there is no surface of second order
constexpr float kHalfBlock = 3.5f;
constexpr float kHalfDiagonal = 6.07f;  // of the voxels of a block

using Vec4f = Eigen::Vector4f;

struct Derivatives {
  float value;
  Vec3f slope;
  Eigen::Matrix3f bend;
};

// Of a field at `p`, at least a voxel within it. Values that only say "beyond the band" are taken for what the plane
// through the cell's own says.
Derivatives derivativesAt(const LevelSet& set, const Vec3f& p) {
  const Coord base{static_cast<int>(p.x()), static_cast<int>(p.y()), static_cast<int>(p.z())};
  const float* own = set.phi + voxelIndex(set.size, base);
  const auto step = [&](Coord by) { return static_cast<ptrdiff_t>(voxelIndex(set.size, by)); };
  const ptrdiff_t sx = step({1, 0, 0}), sy = step({0, 1, 0});
  float sum = 0;
  Vec3f plane = Vec3f::Zero();
  for (int c = 0; c < 8; ++c) {
    const float value = own[(c & 4 ? sx : 0) + (c & 2 ? sy : 0) + (c & 1)];
    sum += value;
    plane += Vec3f(c & 4 ? value : -value, c & 2 ? value : -value, c & 1 ? value : -value);
  }
  sum /= 8, plane /= 4;
  float w[3][4], d[3][4], b[3][4];
  for (int axis = 0; axis < 3; ++axis) {
    const float t = p[axis] - std::floor(p[axis]);
    catmullRom(t, w[axis]), catmullRomSlope(t, d[axis]), splineBend(t, b[axis]);
  }
  Vec4f rows[4][4], most = Vec4f::Zero();
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y) {
      rows[x][y] = Eigen::Map<const Vec4f>(own + (x - 1) * sx + (y - 1) * sy - 1);
      most = most.cwiseMax(rows[x][y].cwiseAbs());
    }
  if (most.maxCoeff() >= set.band) {
    const Vec4f alongZ = plane.z() * Vec4f(-1.5f, -0.5f, 0.5f, 1.5f);
    for (int x = 0; x < 4; ++x)
      for (int y = 0; y < 4; ++y)
        rows[x][y] = (rows[x][y].array().abs() < set.band)
                         .select(rows[x][y], alongZ.array() +
                                                 (sum + plane.x() * (float(x) - 1.5f) + plane.y() * (float(y) - 1.5f)));
  }
  // First summed along y, then along x, then along themselves.
  Vec4f ww = Vec4f::Zero(), dw = ww, bw = ww, wd = ww, wb = ww, dd = ww;
  for (int x = 0; x < 4; ++x) {
    Vec4f along = Vec4f::Zero(), slope = along, bend = along;
    for (int y = 0; y < 4; ++y)
      along += w[1][y] * rows[x][y], slope += d[1][y] * rows[x][y], bend += b[1][y] * rows[x][y];
    ww += w[0][x] * along, dw += d[0][x] * along, bw += b[0][x] * along;
    wd += w[0][x] * slope, dd += d[0][x] * slope, wb += w[0][x] * bend;
  }
  const Vec4f wz(w[2]), dz(d[2]), bz(b[2]);
  Derivatives out;
  out.value = wz.dot(ww);
  out.slope = {wz.dot(dw), wz.dot(wd), dz.dot(ww)};
  const float xy = wz.dot(dd), xz = dz.dot(dw), yz = dz.dot(wd);
  out.bend << wz.dot(bw), xy, xz, xy, wz.dot(wb), yz, xz, yz, bz.dot(ww);
  return out;
}

// Between two boxes; between a place and a box.
float gapOf(const Vec3f& lowA, const Vec3f& highA, const Vec3f& lowB, const Vec3f& highB) {
  return (lowB - highA).cwiseMax(lowA - highB).cwiseMax(0.0f).norm();
}

}  // namespace

void FootPoints::make(const LevelSet& set, const std::vector<Coord>& blocks) {
  x_.clear(), y_.clear(), z_.clear(), shapes_.clear(), blocks_.clear();
  places_.clear(), groups_.clear();
  // With one around, so that each has neighbours.
  across_ = Coord{set.size.x / 2, set.size.y / 2, set.size.z / 2} + Coord{7, 7, 7};
  bent_.assign(voxelIndex(across_, {across_.x, 0, 0}), 0);
  std::vector<uint32_t> ends;
  for (const Coord block : blocks) {
    addBlock(set, block);
    ends.push_back(static_cast<uint32_t>(groups_.size()));
  }
  uint32_t group = 0;
  for (const uint32_t end : ends) {
    const auto first = static_cast<uint32_t>(shapes_.size());
    for (; group < end; ++group) addPoints(set, groups_[group]);
    const auto last = static_cast<uint32_t>(shapes_.size());
    if (last == first) continue;
    Block found{shapes_[first].point, shapes_[first].point, {first, last}};
    for (uint32_t i = first + 1; i < last; ++i) {
      found.low = found.low.cwiseMin(shapes_[i].point);
      found.high = found.high.cwiseMax(shapes_[i].point);
    }
    blocks_.push_back(found);
  }
  for (std::vector<float>* each : {&x_, &y_, &z_}) each->resize(each->size() + kBrickEdge, 0);  // vectors read on
}

void FootPoints::addBlock(const LevelSet& set, Coord block) {
  // Cells with a voxel around them.
  const Coord from{std::max(block.x, 1), std::max(block.y, 1), std::max(block.z, 1)};
  const Coord to{std::min(block.x + kBrickEdge, set.size.x - 2), std::min(block.y + kBrickEdge, set.size.y - 2),
                 std::min(block.z + kBrickEdge, set.size.z - 2)};
  if (from.x >= to.x || from.y >= to.y || from.z >= to.z) return;
  // A bit for each voxel of a row beyond the level.
  uint32_t beyond[kBrickEdge + 1][kBrickEdge + 1];
  for (int x = from.x; x <= to.x; ++x)
    for (int y = from.y; y <= to.y; ++y) {
      const float* row = set.phi + voxelIndex(set.size, {x, y, from.z});
      uint32_t bits = 0;
      for (int z = 0; z <= to.z - from.z; ++z) bits |= uint32_t(set.side * row[z] > set.level) << z;
      beyond[x - from.x][y - from.y] = bits;
    }
  const uint32_t cells = (1u << (to.z - from.z)) - 1;
  uint32_t crossed[kBrickEdge][kBrickEdge] = {};  // by the cell's place in the block
  for (int x = 0; x < to.x - from.x; ++x)
    for (int y = 0; y < to.y - from.y; ++y) {
      const uint32_t rows[4] = {beyond[x][y], beyond[x][y + 1], beyond[x + 1][y], beyond[x + 1][y + 1]};
      const uint32_t any = rows[0] | rows[1] | rows[2] | rows[3], all = rows[0] & rows[1] & rows[2] & rows[3];
      const Coord at = from - block + Coord{x, y, 0};
      crossed[at.x][at.y] = ((any | any >> 1) & ~(all & all >> 1) & cells) << (from.z - block.z);
    }
  for (int x = 0; x < kBrickEdge; x += 2)
    for (int y = 0; y < kBrickEdge; y += 2) {
      const uint32_t columns = crossed[x][y] | crossed[x][y + 1] | crossed[x + 1][y] | crossed[x + 1][y + 1];
      for (uint32_t left = (columns | columns >> 1) & 0x55; left; left &= left - 1) {
        const int z = __builtin_ctz(left);
        const auto first = static_cast<uint32_t>(places_.size());
        for (int c = 0; c < 8; ++c)
          if (const Coord cell{x + (c >> 2), y + (c >> 1 & 1), z + (c & 1)}; crossed[cell.x][cell.y] >> cell.z & 1)
            places_.push_back(crossingOf(set, block + cell));
        addGroup(set, block + Coord{x, y, z}, {first, static_cast<uint32_t>(places_.size())});
      }
    }
}

// Places of cells that lie together, and how far they are off the surface of second order at one of them.
void FootPoints::addGroup(const LevelSet& set, Coord cell, PointRange range) {
  const std::span places(places_.data() + range.begin, range.end - range.begin);
  const uint32_t one = (range.begin + range.end) / 2;
  Group group{range, one, shapeAt(set, places_[one]), voxelIndex(across_, (cell + Coord{8, 8, 8}) >> 1), kBent};
  if (group.shape.known) {
    group.off = 0;
    const Shape& shape = group.shape;
    for (const Vec3f& place : places) {
      const Vec3f way = place - shape.point;
      const float h = way.dot(shape.normal), u = way.dot(shape.first),
                  rest = std::max(0.0f, way.squaredNorm() - h * h - u * u);
      group.off = std::max(group.off, std::abs(h + (shape.curvature[0] * u * u + shape.curvature[1] * rest) / 2));
    }
  }
  bent_[group.at] = group.off >= kBent;
  groups_.push_back(group);
}

// One point stands for a group that is smooth, with smooth ones around it.
void FootPoints::addPoints(const LevelSet& set, const Group& group) {
  const auto bentBeside = [&] {
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (bent_[group.at + static_cast<size_t>((x * across_.y + y) * across_.z + z)]) return true;
    return false;
  };
  if (group.off < kSame && !bentBeside()) return add(group.shape);
  for (uint32_t i = group.places.begin; i < group.places.end; ++i) {
    Shape shape = i == group.one ? group.shape : shapeAt(set, places_[i]);
    if (group.off >= kBent) shape.beside2 = kBesideBent2;
    add(shape);
  }
}

// The mean of the crossings of the cell's edges.
Vec3f FootPoints::crossingOf(const LevelSet& set, Coord cell) {
  float v[8];
  for (int c = 0; c < 8; ++c)
    v[c] = set.side * set.phi[voxelIndex(set.size, cell + Coord{c >> 2, (c >> 1) & 1, c & 1})] - set.level;
  Vec3f sum = Vec3f::Zero();
  int crossings = 0;
  for (const auto& [a, b, axis] : kCellEdges) {
    if ((v[a] > 0) == (v[b] > 0)) continue;
    sum += Vec3f(float(a >> 2), float((a >> 1) & 1), float(a & 1));
    sum[axis] += v[a] / (v[a] - v[b]);
    ++crossings;
  }
  return sum / float(crossings) + cell.toVec3d().cast<float>();
}

void FootPoints::add(const Shape& shape) {
  x_.push_back(shape.point.x()), y_.push_back(shape.point.y()), z_.push_back(shape.point.z());
  shapes_.push_back(shape);
}

FootPoints::Shape FootPoints::shapeAt(const LevelSet& set, const Vec3f& place) {
  const Derivatives at = derivativesAt(set, place);
  const float length = at.slope.norm();
  Shape shape{place, Vec3f::Zero(), Vec3f::Zero(), {0, 0}, kBeside2, length > kLeastSlope};
  if (shape.known) {
    const Vec3f n = at.slope * (set.side / length);
    shape.point += n * std::clamp((set.level - set.side * at.value) / length, -kMostShift, kMostShift);
    shape.normal = n;
    // Curvatures: the bend within the tangent plane, by its slope.
    Eigen::Matrix<float, 3, 2> plane;
    plane.col(0) = n.unitOrthogonal();
    plane.col(1) = n.cross(plane.col(0));
    const Eigen::Matrix2f bend = plane.transpose() * at.bend * plane * (set.side / length);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> principal;
    principal.computeDirect(bend);
    shape.first = plane * principal.eigenvectors().col(1);
    for (int i = 0; i < 2; ++i)
      shape.curvature[i] = std::clamp(principal.eigenvalues()[1 - i], -kMostCurvature, kMostCurvature);
  }
  return shape;
}

FootPoints::Foot FootPoints::footOn(const Shape& shape, const Vec3f& p, bool place) const {
  const Vec3f way = p - shape.point;
  const float square = way.squaredNorm(), far = std::sqrt(square);
  if (!shape.known) return {far, shape.point};
  const float h = way.dot(shape.normal), u = way.dot(shape.first), rest = std::max(0.0f, square - h * h - u * u);
  // Nothing is nearest beyond the middle of its own hollow: curvatures that say so come from a crease.
  const float hollow = -kDeepest / std::max(h, 1.0f);
  const float curvature[2] = {std::max(shape.curvature[0], hollow), std::max(shape.curvature[1], hollow)};
  // A parallel surface at h has curvatures κ/(1 + hκ).
  const float spread[2] = {std::max(1 + h * curvature[0], kLeastSpread), std::max(1 + h * curvature[1], kLeastSpread)};
  const float bent = h + (curvature[0] * u * u / spread[0] + curvature[1] * rest / spread[1]) / 2;
  // Points lie so close together that one is beside the nearest place, as it looks from afar.
  const float least = std::sqrt(std::max(0.0f, square - shape.beside2 * std::max(1.0f, spread[0])));
  Foot foot{std::clamp(bent, least, far), shape.point};
  if (place) {
    const Vec3f second = way - shape.normal * h - shape.first * u;
    const float a = u / spread[0];
    foot.place += shape.first * a + second / spread[1] -
                  shape.normal * ((curvature[0] * a * a + curvature[1] * rest / (spread[1] * spread[1])) / 2);
  }
  return foot;
}

bool FootPoints::approach(Coord low, float reach) {
  corner_ = low.toVec3d().cast<float>();
  const Vec3f middle = corner_ + Vec3f::Constant(kHalfBlock);
  near_.clear();
  for (uint32_t i = 0; i < blocks_.size(); ++i)
    if (const float gap = gapOf(middle, middle, blocks_[i].low, blocks_[i].high); gap < reach + kHalfDiagonal)
      near_.push_back({gap, i});
  std::sort(near_.begin(), near_.end(), [](const Near& a, const Near& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.block < b.block;
  });
  const PointArrays points{x_.data(), y_.data(), z_.data()};
  const float centre[3] = {middle.x(), middle.y(), middle.z()};
  float best = (reach + kHalfDiagonal) * (reach + kHalfDiagonal);
  middles_ = kNoPoint;
  for (const Near& each : near_) {
    if (each.distance * each.distance >= best) break;
    nearestOf(points, blocks_[each.block].points, centre, best, middles_);
  }
  middlesFar_ = std::sqrt(best);
  return middles_ != kNoPoint;
}

void FootPoints::measure(const std::array<bool, kBrickVoxels>& wanted, bool places,
                         std::array<Foot, kBrickVoxels>& feet) {
  // The nearest point to a voxel is not farther from it than the middle's.
  const float most = middlesFar_ + kHalfDiagonal;
  const Vec3f last = corner_ + Vec3f::Constant(kBrickEdge - 1);
  ranges_.clear();
  for (const Near& each : near_)
    if (gapOf(corner_, last, blocks_[each.block].low, blocks_[each.block].high) <= most)
      ranges_.push_back(blocks_[each.block].points);
  const float from[3] = {corner_.x(), corner_.y(), corner_.z()};
  uint32_t nearest[kBrickVoxels];
  nearestPoints({x_.data(), y_.data(), z_.data()}, ranges_, middles_, from, wide_, narrow_, nearest);
  for (int v = 0; v < kBrickVoxels; ++v)
    if (wanted[static_cast<size_t>(v)])
      feet[static_cast<size_t>(v)] =
          footOn(shapes_[nearest[v]], corner_ + Vec3f(float(v >> 6), float((v >> 3) & 7), float(v & 7)), places);
}

}  // namespace argil::clay
