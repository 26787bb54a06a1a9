#include "clay/store/sampler.h"

#include <algorithm>
#include <cmath>

#include "clay/base/spline_weights.h"
#include "clay/store/editor.h"
#include "clay/store/tree.h"

namespace argil::clay {

namespace {

// Beyond this a voxel coordinate cannot lie in any brick; clamping there keeps the conversion to int defined for any
// input.
constexpr double kFar = 8.0 * kBrickReach + 16;
constexpr float kUnknownFar = 1e30f;

struct Cell {
  Coord base;
  float fx, fy, fz;
};

// Not-a-number and infinities land on the far side: outside, never undefined.
Cell cellOf(const Vec3d& p) noexcept {
  const auto bound = [](double v) { return v >= -kFar ? std::min(v, kFar) : -kFar; };
  const double x = bound(p.x()), y = bound(p.y()), z = bound(p.z());
  const double bx = std::floor(x), by = std::floor(y), bz = std::floor(z);
  return {{static_cast<int32_t>(bx), static_cast<int32_t>(by), static_cast<int32_t>(bz)},
          static_cast<float>(x - bx),
          static_cast<float>(y - by),
          static_cast<float>(z - bz)};
}

}  // namespace

void Sampler::reset(const Version& version) noexcept {
  root_ = version.record()->roots[kDistanceTree];
  band_ = version.record()->grid.band;
  step_ = version.record()->step;
  regionCoord_ = {INT32_MIN, 0, 0};
}

void Sampler::reset(const Editor& editor) noexcept {
  root_ = editor.trees_[kDistanceTree].root;
  band_ = editor.grid().band;
  step_ = editor.step();
  regionCoord_ = {INT32_MIN, 0, 0};
}

Slot Sampler::slot(Coord brick) noexcept {
  const Coord region = brick >> 3;
  if (region != regionCoord_) {
    if (!inReach(brick)) return Tile::outside;
    regionCoord_ = region;
    region_ = descend(root_, brick, 1);
  }
  return slotOf(isTile(region_) ? region_ : reinterpret_cast<const Node*>(region_)->child[childIndex(brick, 1)]);
}

bool Sampler::isTileRegion(Coord brick) noexcept {
  const Slot one = slot(brick);
  return one.isTile() && (!inReach(brick) || isTile(region_));
}

void Sampler::corner(Coord brick, Slot (&out)[2][2][2]) noexcept {
  out[0][0][0] = slot(brick);
  if ((brick.x & 7) < 7 && (brick.y & 7) < 7 && (brick.z & 7) < 7 && inReach(brick)) {
    // All of one region: one node, neighbouring children.
    for (int i = 1; i < 8; ++i) {
      const int dx = i >> 2, dy = (i >> 1) & 1, dz = i & 1;
      out[dx][dy][dz] = slotOf(
          isTile(region_)
              ? region_
              : reinterpret_cast<const Node*>(region_)->child[childIndex(brick, 1) + (dx << 6) + (dy << 3) + dz]);
    }
    return;
  }
  for (int i = 1; i < 8; ++i) out[i >> 2][(i >> 1) & 1][i & 1] = slot(brick + Coord{i >> 2, (i >> 1) & 1, i & 1});
}

float Sampler::voxel(Coord v) noexcept {
  return slot(v >> kBrickBits).phi(Brick::offset(v.x & 7, v.y & 7, v.z & 7), band_, step_);
}

namespace {

// `count` values along z from an offset on.
inline void copyRow(const Slot& slot, int from, int count, float band, float step, float* out) noexcept {
  if (slot.isTile())
    std::fill_n(out, count, slot.phi(0, band));
  else
    slot.brick()->read(from, count, out, step);
}

}  // namespace

// Copies n³ voxels from `first` on into out[x][y][z]; n ≤ 4, so at most eight bricks are met.
template <int n>
void Sampler::gather(Coord first, float (&out)[n][n][n]) noexcept {
  const int lx = first.x & 7, ly = first.y & 7, lz = first.z & 7;
  const Coord brick = first >> kBrickBits;
  if (lx <= 8 - n && ly <= 8 - n && lz <= 8 - n) {
    const Slot s = slot(brick);
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y) copyRow(s, Brick::offset(lx + x, ly + y, lz), n, band_, step_, out[x][y]);
    return;
  }
  Slot slots[2][2][2];
  for (int i = 0; i < 8; ++i) {
    const int ix = i >> 2, iy = (i >> 1) & 1, iz = i & 1;
    if ((ix && lx <= 8 - n) || (iy && ly <= 8 - n) || (iz && lz <= 8 - n)) continue;
    slots[ix][iy][iz] = slot(brick + Coord{ix, iy, iz});
  }
  const int here = std::min(n, kBrickEdge - lz);
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y) {
      const int vx = lx + x, vy = ly + y;
      const auto& along = slots[vx >> 3][vy >> 3];
      copyRow(along[0], Brick::offset(vx & 7, vy & 7, lz), here, band_, step_, out[x][y]);
      if (here < n) copyRow(along[1], Brick::offset(vx & 7, vy & 7, 0), n - here, band_, step_, out[x][y] + here);
    }
}

float Sampler::trilinear(const Vec3d& p) noexcept {
  Vec3f unused;
  return trilinear(p, unused);
}

float Sampler::trilinear(const Vec3d& p, Vec3f& gradient) noexcept {
  const Cell c = cellOf(p);
  float v[2][2][2];
  gather<2>(c.base, v);
  const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
  float value[2][2], slopeZ[2][2];
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y) {
      value[x][y] = mix(v[x][y][0], v[x][y][1], c.fz);
      slopeZ[x][y] = v[x][y][1] - v[x][y][0];
    }
  const float x0 = mix(value[0][0], value[0][1], c.fy), x1 = mix(value[1][0], value[1][1], c.fy);
  gradient = {x1 - x0, mix(value[0][1] - value[0][0], value[1][1] - value[1][0], c.fx),
              mix(mix(slopeZ[0][0], slopeZ[0][1], c.fy), mix(slopeZ[1][0], slopeZ[1][1], c.fy), c.fx)};
  return mix(x0, x1, c.fx);
}

float Sampler::tricubic(const Vec3d& p, Vec3f& gradient) noexcept {
  const Cell c = cellOf(p);
  float v[4][4][4];
  gather<4>(c.base - Coord{1, 1, 1}, v);
  float wx[4], dx[4], wy[4], dy[4], wz[4], dz[4];
  catmullRom(c.fx, wx), catmullRomSlope(c.fx, dx);
  catmullRom(c.fy, wy), catmullRomSlope(c.fy, dy);
  catmullRom(c.fz, wz), catmullRomSlope(c.fz, dz);
  float value = 0, gx = 0, gy = 0, gz = 0;
  for (int x = 0; x < 4; ++x) {
    float planeValue = 0, planeY = 0, planeZ = 0;
    for (int y = 0; y < 4; ++y) {
      float row = 0, rowZ = 0;
      for (int z = 0; z < 4; ++z) {
        row += wz[z] * v[x][y][z];
        rowZ += dz[z] * v[x][y][z];
      }
      planeValue += wy[y] * row;
      planeY += dy[y] * row;
      planeZ += wy[y] * rowZ;
    }
    value += wx[x] * planeValue;
    gx += dx[x] * planeValue;
    gy += wx[x] * planeY;
    gz += wx[x] * planeZ;
  }
  gradient = {gx, gy, gz};
  return value;
}

namespace {

// Four values in a row and which of them (bits) are not known. Ends go on as the other three do, so that what is known
// counts; the weighted sum, and whether it is known.
float rowSum(float (&v)[4], unsigned unknown, const float (&w)[4], bool& known) noexcept {
  if (unknown == 8) v[3] = 3 * (v[2] - v[1]) + v[0], unknown = 0;
  if (unknown == 1) v[0] = 3 * (v[1] - v[2]) + v[3], unknown = 0;
  known = unknown == 0;
  return (w[0] * v[0] + w[1] * v[1]) + (w[2] * v[2] + w[3] * v[3]);
}

}  // namespace

float Sampler::distance(const Vec3d& p) noexcept {
  const Cell c = cellOf(p);
  float v[4][4][4], wx[4], wy[4], wz[4];
  gather<4>(c.base - Coord{1, 1, 1}, v);
  catmullRom(c.fx, wx), catmullRom(c.fy, wy), catmullRom(c.fz, wz);
  // A distance changes by no more than the way to each of the eight voxels around.
  float least = -kUnknownFar, most = kUnknownFar;
  for (int i = 0; i < 8; ++i) {
    const int x = i >> 2, y = (i >> 1) & 1, z = i & 1;
    const float dx = c.fx - float(x), dy = c.fy - float(y), dz = c.fz - float(z);
    const float way = std::sqrt((dx * dx + dy * dy) + dz * dz), value = v[x + 1][y + 1][z + 1];
    least = std::max(least, value - way);
    most = std::min(most, value + way);
  }
  bool allKnown = true;
  for (int i = 0; i < 16; ++i)
    for (const float value : v[i >> 2][i & 3]) allKnown &= std::abs(value) < band_;
  if (allKnown) {
    using Vec4f = Eigen::Vector4f;
    Vec4f rows = Vec4f::Zero();  // along z, summed over the others
    for (int x = 0; x < 4; ++x)
      for (int y = 0; y < 4; ++y) rows += wx[x] * wy[y] * Eigen::Map<const Vec4f>(v[x][y]);
    return std::max(least, std::min(most, rows.dot(Eigen::Map<const Vec4f>(wz))));
  }
  float planes[4];
  unsigned unknownPlanes = 0;
  for (int x = 0; x < 4; ++x) {
    float rows[4];
    unsigned unknownRows = 0;
    for (int y = 0; y < 4; ++y) {
      float(&row)[4] = v[x][y];
      unsigned unknown = 0;
      for (unsigned z = 0; z < 4; ++z) unknown |= unsigned{std::abs(row[z]) >= band_} << z;
      bool known;
      rows[y] = rowSum(row, unknown, wz, known);
      unknownRows |= unsigned{!known} << y;
    }
    bool known;
    planes[x] = rowSum(rows, unknownRows, wy, known);
    unknownPlanes |= unsigned{!known} << x;
  }
  bool known;
  return std::max(least, std::min(most, rowSum(planes, unknownPlanes, wx, known)));
}

}  // namespace argil::clay
