// Distance by propagating nearest triangles from voxel to voxel (vector distance transform; Mauch, "Efficient
// Algorithms for Solving Static Hamilton-Jacobi Equations", 2003, gives the geometry).

#include "clay/field/distance_box.h"

#include <algorithm>
#include <cmath>

#include "clay/base/catmull_rom.h"
#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

constexpr float kFar = 1e18f;        // a squared distance that none has
constexpr float kLeastSlope = 0.5f;  // a gradient below that points nowhere
constexpr float kNearerBy = 1e-5f;   // voxels²: less is rounding, and would go round in circles

// Cell corners are numbered x·4 + y·2 + z; these are its edges.
constexpr int kEdges[12][2] = {{0, 4}, {1, 5}, {2, 6}, {3, 7}, {0, 2}, {1, 3},
                               {4, 6}, {5, 7}, {0, 1}, {2, 3}, {4, 5}, {6, 7}};

}  // namespace

// Ericson, Real-Time Collision Detection, 5.1.5; a triangle without area is met through its edges.
Vec3f DistanceBox::Triangle::to(const Vec3f& p, int32_t& rim) const {
  const Vec3f ap = p - a;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  rim = corner[0];
  if (d1 <= 0 && d2 <= 0) return ap;
  const float ab2 = ab.squaredNorm(), abac = ab.dot(ac), ac2 = ac.squaredNorm();
  const float d3 = d1 - ab2, d4 = d2 - abac;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && ab2 > 0) return (ap - ab * (d1 / ab2));
  const float d5 = d1 - abac, d6 = d2 - ac2;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && ac2 > 0) return (ap - ac * (d2 / ac2));
  rim = corner[1];
  if (d3 >= 0 && d4 <= d3) return (ap - ab);
  const float va = d3 * d6 - d5 * d4, e1 = d4 - d3, e2 = d5 - d6;
  if (va <= 0 && e1 >= 0 && e2 >= 0 && e1 + e2 > 0) return (ap - ab - (ac - ab) * (e1 / (e1 + e2)));
  rim = corner[2];
  if (d6 >= 0 && d5 <= d6) return (ap - ac);
  const float sum = va + vb + vc;
  if (!(sum > 0)) return ap;
  rim = -1;
  const float scale = 1 / sum;
  return (ap - ab * (vb * scale) - ac * (vc * scale));
}

bool DistanceBox::gather(const Version& version) {
  phi_.resize(static_cast<size_t>(outer_.x) * static_cast<size_t>(outer_.y) * static_cast<size_t>(outer_.z));
  Sampler sampler(version);
  const float band = version.grid().band;
  const Coord end = outerLow_ + outer_;
  const Coord first = outerLow_ >> kBrickBits, last = (end - Coord{1, 1, 1}) >> kBrickBits;
  bool surface = false;
  for (int bx = first.x; bx <= last.x; ++bx)
    for (int by = first.y; by <= last.y; ++by)
      for (int bz = first.z; bz <= last.z; ++bz) {
        const Slot slot = sampler.slot({bx, by, bz});
        const Brick* brick = slot.brick();
        surface |= brick != nullptr;
        const Coord from{std::max(bx * 8, outerLow_.x), std::max(by * 8, outerLow_.y), std::max(bz * 8, outerLow_.z)};
        const Coord to{std::min(bx * 8 + 8, end.x), std::min(by * 8 + 8, end.y), std::min(bz * 8 + 8, end.z)};
        const float constant = brick ? 0 : slot.phi(0, band);
        if (!brick) uniform_ = slot.tile();
        for (int x = from.x; x < to.x; ++x)
          for (int y = from.y; y < to.y; ++y) {
            float* row = &phi_[index(Coord{x, y, from.z} - outerLow_)];
            if (brick)
              brick->read(Brick::offset(x & 7, y & 7, from.z & 7), to.z - from.z, row);
            else
              std::fill_n(row, to.z - from.z, constant);
          }
      }
  return surface;
}

// The level set side·phi = level of the box: a vertex for each cell that it crosses, two triangles for each edge.
void DistanceBox::makeTriangles(float side, float level) {
  vertices_.clear();
  triangles_.clear();
  nearest_.assign(phi_.size(), -1);
  const size_t sx = static_cast<size_t>(outer_.y) * static_cast<size_t>(outer_.z), sy = static_cast<size_t>(outer_.z);
  const size_t corner[8] = {0, 1, sy, sy + 1, sx, sx + 1, sx + sy, sx + sy + 1};
  const auto beyond = [&](size_t i) { return side * phi_[i] > level; };
  for (int x = 0; x + 1 < outer_.x; ++x)
    for (int y = 0; y + 1 < outer_.y; ++y) {
      const size_t row = index({x, y, 0});
      int before = beyond(row) + beyond(row + sy) + beyond(row + sx) + beyond(row + sx + sy);
      for (int z = 0; z + 1 < outer_.z; ++z) {
        const size_t at = row + static_cast<size_t>(z);
        const int after = beyond(at + 1) + beyond(at + sy + 1) + beyond(at + sx + 1) + beyond(at + sx + sy + 1);
        const int count = before + after;
        before = after;
        if (count == 0 || count == 8) continue;
        float v[8];
        for (int c = 0; c < 8; ++c) v[c] = side * phi_[at + corner[c]] - level;
        Vec3f sum = Vec3f::Zero();
        int crossings = 0;
        for (const auto& [a, b] : kEdges) {
          if ((v[a] > 0) == (v[b] > 0)) continue;
          const Vec3f pa(float(a >> 2), float((a >> 1) & 1), float(a & 1)),
              pb(float(b >> 2), float((b >> 1) & 1), float(b & 1));
          sum += pa + (pb - pa) * (v[a] / (v[a] - v[b]));
          ++crossings;
        }
        nearest_[at] = static_cast<int32_t>(vertices_.size());
        vertices_.push_back(sum / float(crossings) + Vec3f(float(x), float(y), float(z)));
      }
    }
  const auto triangle = [&](int32_t a, int32_t b, int32_t c) {
    const Vec3f& p = vertices_[static_cast<size_t>(a)];
    triangles_.push_back({p, vertices_[static_cast<size_t>(b)] - p, vertices_[static_cast<size_t>(c)] - p, {a, b, c}});
  };
  const auto quad = [&](size_t cellA, size_t cellB, size_t cellC, size_t cellD) {
    const int32_t a = nearest_[cellA], b = nearest_[cellB], c = nearest_[cellC], d = nearest_[cellD];
    const auto apart = [&](int32_t i, int32_t k) {
      return (vertices_[static_cast<size_t>(i)] - vertices_[static_cast<size_t>(k)]).squaredNorm();
    };
    if (apart(a, c) <= apart(b, d)) {
      triangle(a, b, c);
      triangle(a, c, d);
    } else {
      triangle(b, c, d);
      triangle(b, d, a);
    }
  };
  // Around an edge the four cells that hold it; edges on the rim of the box lack some.
  for (int x = 1; x + 1 < outer_.x; ++x)
    for (int y = 1; y + 1 < outer_.y; ++y)
      for (int z = 1; z + 1 < outer_.z; ++z) {
        const size_t at = index({x, y, z});
        if (nearest_[at] < 0) continue;
        const bool here = beyond(at);
        if (here != beyond(at + sx)) quad(at, at - sy, at - sy - 1, at - 1);
        if (here != beyond(at + sy)) quad(at, at - 1, at - sx - 1, at - sx);
        if (here != beyond(at + 1)) quad(at, at - sx, at - sx - sy, at - sy);
      }
}

void DistanceBox::makeFans() {
  fanBegin_.assign(vertices_.size() + 1, 0);
  for (const Triangle& t : triangles_)
    for (const int32_t v : t.corner) ++fanBegin_[static_cast<size_t>(v)];
  uint32_t sum = 0;
  for (uint32_t& at : fanBegin_) at = sum += at;
  fan_.resize(sum);
  for (size_t t = triangles_.size(); t-- > 0;)
    for (const int32_t v : triangles_[t].corner) fan_[--fanBegin_[static_cast<size_t>(v)]] = static_cast<uint32_t>(t);
}

float DistanceBox::descend(const Vec3f& p, int32_t& triangle) const {
  int32_t rim;
  float best = triangles_[static_cast<size_t>(triangle)].squaredTo(p, rim);
  while (rim >= 0) {
    const float before = best;
    int32_t nextRim = -1;
    for (uint32_t i = fanBegin_[static_cast<size_t>(rim)]; i < fanBegin_[static_cast<size_t>(rim) + 1]; ++i) {
      int32_t otherRim;
      const float d = triangles_[fan_[i]].squaredTo(p, otherRim);
      if (!(d < best - kNearerBy)) continue;
      best = d;
      triangle = static_cast<int32_t>(fan_[i]);
      nextRim = otherRim;
    }
    if (!(best < before)) break;
    rim = nextRim;
  }
  return best;
}

void DistanceBox::measure(float side, float level, float reach) {
  makeTriangles(side, level);
  makeFans();
  squared_.assign(phi_.size(), kFar);
  nearest_.assign(phi_.size(), -1);
  queued_.assign(phi_.size(), 0);
  front_.clear();
  const float most = (reach - level) * (reach - level);
  const size_t strideX = static_cast<size_t>(outer_.y) * static_cast<size_t>(outer_.z),
               strideY = static_cast<size_t>(outer_.z);
  // A nearest triangle that no neighbour has is found by the way along the surface.
  const auto offer = [&](size_t at, const Vec3f& p, int32_t triangle, std::vector<uint32_t>& queue) {
    if (!(side * phi_[at] > level)) return;
    int32_t rim;
    const float d = triangles_[static_cast<size_t>(triangle)].squaredTo(p, rim);
    if (!(d < squared_[at] - kNearerBy && d <= most)) return;
    squared_[at] = rim < 0 ? d : descend(p, triangle);
    nearest_[at] = triangle;
    if (queued_[at]) return;
    queued_[at] = 1;
    queue.push_back(static_cast<uint32_t>(at));
  };
  // Both triangles of a quad start at the voxels around the quad: those of one alone may all lie on this side of the
  // level.
  for (size_t t = 0; t < triangles_.size(); t += 2) {
    Vec3f low = triangles_[t].a, high = low;
    for (const Triangle& each : {triangles_[t], triangles_[t + 1]}) {
      low = low.cwiseMin(each.a).cwiseMin(each.a + each.ab).cwiseMin(each.a + each.ac);
      high = high.cwiseMax(each.a).cwiseMax(each.a + each.ab).cwiseMax(each.a + each.ac);
    }
    const auto from = [](float v) { return std::max(0, static_cast<int>(std::floor(v))); };
    const auto to = [](float v, int size) { return std::min(size - 1, static_cast<int>(std::ceil(v))); };
    for (int x = from(low.x()); x <= to(high.x(), outer_.x); ++x)
      for (int y = from(low.y()); y <= to(high.y(), outer_.y); ++y)
        for (int z = from(low.z()); z <= to(high.z(), outer_.z); ++z)
          for (const size_t each : {t, t + 1})
            offer(index({x, y, z}), Vec3f(float(x), float(y), float(z)), static_cast<int32_t>(each), front_);
  }
  while (!front_.empty()) {
    next_.clear();
    for (const uint32_t at : front_) {
      queued_[at] = 0;
      const int x = static_cast<int>(at / strideX), y = static_cast<int>(at / strideY) % outer_.y,
                z = static_cast<int>(at % strideY);
      const Vec3f p{float(x), float(y), float(z)};
      const int32_t triangle = nearest_[at];
      if (x > 0) offer(at - strideX, p - Vec3f::UnitX(), triangle, next_);
      if (x + 1 < outer_.x) offer(at + strideX, p + Vec3f::UnitX(), triangle, next_);
      if (y > 0) offer(at - strideY, p - Vec3f::UnitY(), triangle, next_);
      if (y + 1 < outer_.y) offer(at + strideY, p + Vec3f::UnitY(), triangle, next_);
      if (z > 0) offer(at - 1, p - Vec3f::UnitZ(), triangle, next_);
      if (z + 1 < outer_.z) offer(at + 1, p + Vec3f::UnitZ(), triangle, next_);
    }
    front_.swap(next_);
  }
  // Triangles are chords of the level set: the field at the nearest point says how far off they lie and where the
  // surface is.
  size_t at = 0;
  for (int x = 0; x < outer_.x; ++x)
    for (int y = 0; y < outer_.y; ++y)
      for (int z = 0; z < outer_.z; ++z, ++at) {
        if (!(squared_[at] < kFar)) continue;
        const Vec3f p{float(x), float(y), float(z)};
        int32_t rim;
        const Vec3f way = triangles_[static_cast<size_t>(nearest_[at])].to(p, rim), foot = p - way;
        const bool known = foot.minCoeff() >= 1 && foot.x() < float(outer_.x - 2) && foot.y() < float(outer_.y - 2) &&
                           foot.z() < float(outer_.z - 2);
        if (!known) {
          squared_[at] = way.norm() + level;
          if (feet_) foot_[at] = static_cast<int32_t>(index(voxelNear(foot)));
          continue;
        }
        // On to the surface itself, along the field's own direction there.
        Vec3f gradient;
        const float value = spline(foot, &gradient);
        const float slope = gradient.norm();
        squared_[at] = slope > kLeastSlope ? (way + gradient * (value / slope)).norm() : way.norm() + side * value;
        if (feet_)
          foot_[at] =
              static_cast<int32_t>(index(voxelNear(slope > kLeastSlope ? foot - gradient * (value / slope) : foot)));
      }
  for (size_t i = 0; i < phi_.size(); ++i)
    if (side * phi_[i] > level) phi_[i] = side * std::min(squared_[i], reach);
}

bool DistanceBox::fill(const Version& version, Coord low, Coord size, Reach reach) {
  const float band = version.grid().band, level = kOwnDistance;
  const float farthest = std::max(reach.inside, reach.outside);
  const int margin = farthest <= band ? 0 : static_cast<int>(std::ceil(farthest - level)) + 2;
  outerLow_ = low - Coord{margin, margin, margin};
  outer_ = size + Coord{2 * margin, 2 * margin, 2 * margin};
  feet_ = reach.feet;
  if (!gather(version)) return false;
  if (feet_) foot_.assign(phi_.size(), -1);
  if (reach.outside > band) measure(1, level, reach.outside);
  if (reach.inside > band) measure(-1, level, reach.inside);
  for (float& phi : phi_) phi = std::clamp(phi, -reach.inside, reach.outside);
  return true;
}

Coord DistanceBox::voxelNear(const Vec3f& p) const {
  const auto near = [](float v, int size) { return std::clamp(static_cast<int>(std::floor(v + 0.5f)), 0, size - 1); };
  return {near(p.x(), outer_.x), near(p.y(), outer_.y), near(p.z(), outer_.z)};
}

Coord DistanceBox::foot(Coord voxel) const {
  const Coord v = voxel - outerLow_;
  if (const int32_t known = foot_[index(v)]; known >= 0) {
    const int z = known % outer_.z, rest = known / outer_.z;
    return outerLow_ + Coord{rest / outer_.y, rest % outer_.y, z};
  }
  Vec3f gradient;
  const int place[3] = {v.x, v.y, v.z}, size[3] = {outer_.x, outer_.y, outer_.z};
  for (int axis = 0; axis < 3; ++axis) {
    Coord before = v, after = v;
    int32_t* const ends[2] = {axis == 0   ? &before.x
                              : axis == 1 ? &before.y
                                          : &before.z,
                              axis == 0   ? &after.x
                              : axis == 1 ? &after.y
                                          : &after.z};
    *ends[0] = std::max(place[axis] - 1, 0);
    *ends[1] = std::min(place[axis] + 1, size[axis] - 1);
    const int apart = *ends[1] - *ends[0];
    gradient[axis] = apart > 0 ? (phi_[index(after)] - phi_[index(before)]) / static_cast<float>(apart) : 0;
  }
  const float length = gradient.norm();
  if (!(length > kLeastSlope)) return voxel;
  return outerLow_ + voxelNear(v.toVec3d().cast<float>() - gradient * (phi_[index(v)] / length));
}

float DistanceBox::spline(const Vec3f& p, Vec3f* gradient) const {
  const Coord base{static_cast<int>(p.x()), static_cast<int>(p.y()), static_cast<int>(p.z())};
  const Vec3f f = p - base.toVec3d().cast<float>();
  float w[3][4], d[3][4];
  for (int axis = 0; axis < 3; ++axis) {
    catmullRom(f[axis], w[axis]);
    if (gradient) catmullRomSlope(f[axis], d[axis]);
  }
  if (gradient) gradient->setZero();
  float value = 0, low = kFar, high = -kFar;
  for (int x = 0; x < 4; ++x) {
    float plane = 0, planeY = 0, planeZ = 0;
    for (int y = 0; y < 4; ++y) {
      const float* row = &phi_[index(base + Coord{x - 1, y - 1, -1})];
      const float along = w[2][0] * row[0] + w[2][1] * row[1] + w[2][2] * row[2] + w[2][3] * row[3];
      plane += w[1][y] * along;
      if (gradient) {
        planeY += d[1][y] * along;
        planeZ += w[1][y] * (d[2][0] * row[0] + d[2][1] * row[1] + d[2][2] * row[2] + d[2][3] * row[3]);
      }
      if ((x == 1 || x == 2) && (y == 1 || y == 2)) {
        const float fx = x == 1 ? f.x() : 1 - f.x(), fy = y == 1 ? f.y() : 1 - f.y();
        for (int z = 1; z < 3; ++z) {
          const float fz = z == 1 ? f.z() : 1 - f.z();
          // A distance changes by no more than the way.
          const float way = std::sqrt(fx * fx + fy * fy + fz * fz);
          low = std::min(low, row[z] + way);
          high = std::max(high, row[z] - way);
        }
      }
    }
    value += w[0][x] * plane;
    if (gradient) {
      gradient->x() += d[0][x] * plane;
      gradient->y() += w[0][x] * planeY;
      gradient->z() += w[0][x] * planeZ;
    }
  }
  return std::max(high, std::min(low, value));
}

float DistanceBox::sample(const Vec3d& p) const {
  return spline((p - outerLow_.toVec3d()).cast<float>());
}

}  // namespace argil::clay
