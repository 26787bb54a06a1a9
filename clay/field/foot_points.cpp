#include "clay/field/foot_points.h"

#include <algorithm>
#include <cmath>

#include "clay/base/spline_weights.h"
#include "clay/kernels/surface_kernels.h"

namespace argil::clay {

namespace {

constexpr float kLeastSlope = 0.5f;     // a gradient below that points nowhere
constexpr float kMostShift = 0.5f;      // voxels from the mean of a cell's crossings to the level set
constexpr float kMostCurvature = 0.8f;  // per voxel: what voxels can tell
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

// Of a field at `p`, at least a voxel within it, or on that rim: then of the cell before. Values that only say "beyond
// the band" are taken for what the plane through the cell's own says.
Derivatives derivativesAt(const LevelSet& set, const Vec3f& p) {
  const Coord base{std::min(static_cast<int>(p.x()), set.size.x - 3), std::min(static_cast<int>(p.y()), set.size.y - 3),
                   std::min(static_cast<int>(p.z()), set.size.z - 3)};
  const Vec3f in = p - base.toVec3d().cast<float>();
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
    const float t = in[axis];
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

}  // namespace

void FootPoints::make(const LevelSet& set, const std::vector<Coord>& blocks) {
  x_.clear(), y_.clear(), z_.clear(), shapes_.clear(), blocks_.clear();
  for (int axis = 0; axis < 3; ++axis) low_[axis].clear(), high_[axis].clear();
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
    blocks_.push_back({first, last});
    const std::vector<float>* const places[3] = {&x_, &y_, &z_};
    for (int axis = 0; axis < 3; ++axis) {
      const auto [low, high] = std::minmax_element(places[axis]->begin() + first, places[axis]->begin() + last);
      low_[axis].push_back(*low), high_[axis].push_back(*high);
    }
  }
  // Vectors read on.
  for (std::vector<float>* each : {&x_, &y_, &z_, &low_[0], &low_[1], &low_[2], &high_[0], &high_[1], &high_[2]})
    each->resize(each->size() + kBrickEdge, 0);
}

void FootPoints::addBlock(const LevelSet& set, Coord block) {
  // Cells with a voxel around them.
  const Coord from{std::max(block.x, 1), std::max(block.y, 1), std::max(block.z, 1)};
  const Coord to{std::min(block.x + kBrickEdge, set.size.x - 2), std::min(block.y + kBrickEdge, set.size.y - 2),
                 std::min(block.z + kBrickEdge, set.size.z - 2)};
  if (from.x >= to.x || from.y >= to.y || from.z >= to.z) return;
  // A bit for each voxel of a row beyond the level.
  uint32_t beyond[kBitRows * kBitRows];
  const auto stride = [&](Coord step) { return static_cast<ptrdiff_t>(voxelIndex(set.size, step)); };
  const Coord rows = to - from + Coord{1, 1, 1};
  bitsBeyond(set.phi + voxelIndex(set.size, from), stride({1, 0, 0}), stride({0, 1, 0}), {rows.x, rows.y, rows.z},
             set.side, set.level, beyond);
  const uint32_t whole = (1u << (to.z - from.z)) - 1;
  uint32_t crossed[kBrickEdge][kBrickEdge] = {};  // by the cell's place in the block
  for (int x = 0; x < to.x - from.x; ++x)
    for (int y = 0; y < to.y - from.y; ++y) {
      const uint32_t *row = beyond + x * kBitRows + y, *next = row + kBitRows;
      const uint32_t any = row[0] | row[1] | next[0] | next[1], all = row[0] & row[1] & next[0] & next[1];
      const Coord at = from - block + Coord{x, y, 0};
      crossed[at.x][at.y] = ((any | any >> 1) & ~(all & all >> 1) & whole) << (from.z - block.z);
    }
  uint16_t cells[kBrickVoxels + kCellPadding];
  PointRange ranges[kBrickVoxels / 8];
  uint32_t count = 0, groups = 0;
  for (int x = 0; x < kBrickEdge; x += 2)
    for (int y = 0; y < kBrickEdge; y += 2) {
      const uint32_t columns = crossed[x][y] | crossed[x][y + 1] | crossed[x + 1][y] | crossed[x + 1][y + 1];
      for (uint32_t left = (columns | columns >> 1) & 0x55; left; left &= left - 1) {
        const int z = __builtin_ctz(left);
        const uint32_t first = count;
        for (int c = 0; c < 8; ++c)
          if (const Coord cell{x + (c >> 2), y + (c >> 1 & 1), z + (c & 1)}; crossed[cell.x][cell.y] >> cell.z & 1)
            cells[count++] = static_cast<uint16_t>(Brick::offset(cell.x, cell.y, cell.z));
        ranges[groups++] = {first, count};
      }
    }
  if (count == 0) return;
  std::fill_n(cells + count, kCellPadding, cells[0]);
  // As the surface's own vertices, below zero beyond the level.
  float corners[kCornerCount];
  for (int x = from.x; x <= to.x; ++x)
    for (int y = from.y; y <= to.y; ++y) {
      const float* row = set.phi + voxelIndex(set.size, {x, y, from.z});
      float* out = corners + cornerOffset(x - block.x, y - block.y, from.z - block.z);
      for (int z = 0; z < rows.z; ++z) out[z] = set.level - set.side * row[z];
    }
  uint32_t patterns[kBrickVoxels + kCellPadding];
  Vec3f places[kBrickVoxels + kCellPadding];
  constexpr uint32_t kUsual[8] = {};
  cellVertices(corners, cells, static_cast<int>(count), false, kUsual, patterns, places->data(), nullptr);
  const auto start = static_cast<uint32_t>(places_.size());
  const Vec3f low = block.toVec3d().cast<float>();
  for (uint32_t i = 0; i < count; ++i) places_.push_back(places[i] + low);
  for (const PointRange& range : std::span(ranges, groups)) {
    const int cell = cells[range.begin];
    addGroup(set, block + Coord{cell >> 6, cell >> 3 & 7, cell & 7}, {start + range.begin, start + range.end});
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

void FootPoints::add(const Shape& shape) {
  const auto &p = shape.point, &n = shape.normal, &f = shape.first;
  x_.push_back(p.x()), y_.push_back(p.y()), z_.push_back(p.z());
  shapes_.push_back({{p.x(), p.y(), p.z()},
                     {n.x(), n.y(), n.z()},
                     {f.x(), f.y(), f.z()},
                     {shape.curvature[0], shape.curvature[1]},
                     shape.known ? shape.beside2 : 0});
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
    const float middle = (bend(0, 0) + bend(1, 1)) / 2, half = (bend(0, 0) - bend(1, 1)) / 2, cross = bend(0, 1);
    const float apart = std::sqrt(half * half + cross * cross);
    // The longer of two vectors along the first of the principal directions; of a sphere any is.
    const Eigen::Vector2f first =
        half > 0 ? Eigen::Vector2f(apart + half, cross) : Eigen::Vector2f(cross, apart - half);
    shape.first = apart > 0 ? Vec3f(plane * (first / first.norm())) : Vec3f(plane.col(0));
    shape.curvature[0] = std::clamp(middle + apart, -kMostCurvature, kMostCurvature);
    shape.curvature[1] = std::clamp(middle - apart, -kMostCurvature, kMostCurvature);
  }
  return shape;
}

bool FootPoints::approach(Coord low, float reach) {
  if (blocks_.empty()) return false;
  corner_ = low.toVec3d().cast<float>();
  const Vec3f middle = corner_ + Vec3f::Constant(kHalfBlock);
  const float centre[3] = {middle.x(), middle.y(), middle.z()};
  squares_.resize(blocks_.size() + kBrickEdge);
  boxSquares({low_[0].data(), low_[1].data(), low_[2].data()}, {high_[0].data(), high_[1].data(), high_[2].data()},
             blocks_.size(), centre, squares_.data());
  // The nearest box first: of the others few can hold anything nearer.
  const auto first = static_cast<size_t>(
      std::min_element(squares_.begin(), squares_.begin() + static_cast<ptrdiff_t>(blocks_.size())) - squares_.begin());
  float best = (reach + kHalfDiagonal) * (reach + kHalfDiagonal);
  middles_ = kNoPoint;
  const PointArrays points{x_.data(), y_.data(), z_.data()};
  const auto look = [&](size_t block) {
    if (squares_[block] < best) nearestOf(points, blocks_[block], centre, best, middles_);
  };
  look(first);
  for (size_t i = 0; i < blocks_.size(); ++i)
    if (i != first) look(i);
  middlesFar_ = std::sqrt(best);
  return middles_ != kNoPoint;
}

void FootPoints::measure(uint64_t rows, float (&distance)[kBrickVoxels]) {
  // The nearest point to a voxel is not farther from it than the middle's: boxes that are nearer to the block.
  const float most = middlesFar_ + kHalfDiagonal, wide = (most + kHalfDiagonal) * (most + kHalfDiagonal);
  const Vec3f last = corner_ + Vec3f::Constant(kBrickEdge - 1);
  ranges_.clear();
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (squares_[i] > wide) continue;
    const Vec3f low(low_[0][i], low_[1][i], low_[2][i]), high(high_[0][i], high_[1][i], high_[2][i]);
    if ((low - last).cwiseMax(corner_ - high).cwiseMax(0.0f).squaredNorm() <= most * most)
      ranges_.push_back(blocks_[i]);
  }
  const float from[3] = {corner_.x(), corner_.y(), corner_.z()};
  nearestPoints({x_.data(), y_.data(), z_.data()}, ranges_, middles_, from, rows, wide_, narrow_, nearest_);
  distancesToShapes(shapes_.data(), nearest_, from, rows, distance);
}

Vec3f FootPoints::nearestPlace(int voxel) const {
  const FootShape& shape = shapes_[nearest_[voxel]];
  const Vec3f point(shape.point), normal(shape.normal), first(shape.first);
  if (shape.beside2 == 0) return point;
  const Vec3f way = corner_ + Vec3f(float(voxel >> 6), float((voxel >> 3) & 7), float(voxel & 7)) - point;
  const float h = way.dot(normal), u = way.dot(first), rest = std::max(0.0f, way.squaredNorm() - h * h - u * u);
  // As distancesToShapes().
  float curvature[2], spread[2];
  for (int i = 0; i < 2; ++i) {
    curvature[i] = std::max(shape.curvature[i], -kDeepestHollow / std::max(h, 1.0f));
    spread[i] = std::max(1 + h * curvature[i], kLeastSpread);
  }
  const Vec3f second = way - normal * h - first * u;
  const float a = u / spread[0];
  return point + (first * a + second / spread[1] -
                  normal * ((curvature[0] * a * a + curvature[1] * rest / (spread[1] * spread[1])) / 2));
}

}  // namespace argil::clay
