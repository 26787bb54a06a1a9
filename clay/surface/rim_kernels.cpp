// A least-squares fit in the manner of k-planes clustering (Bradley and Mangasarian 2000), with curved faces in place
// of planes and the solid's own rule, maximum or minimum, in place of the nearest plane.

#include "clay/surface/rim_kernels.h"

#include <algorithm>
#include <cmath>

#include "clay/base/vec.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/surface/rim_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef ARGIL_CLAY_KERNELS_RIM_FACES
#define ARGIL_CLAY_KERNELS_RIM_FACES
namespace argil::clay {
namespace {

// Rounds of telling voxels apart and fitting.
constexpr int kRounds = 5;
// What a face may leave of a voxel that counts in full, voxels; what is farther off counts less and less (Cauchy), at
// first by the larger one.
constexpr float kSlack = 0.06f, kFirstSlack = 0.24f;
// Voxels that a face needs, and that its curvature needs.
constexpr float kLeastVoxels = 4, kLeastForBend = 8;
// How firmly height, tilt and curvature are held to what they are, where voxels say little of them; by parts of their
// weight.
constexpr float kHeldPlace = 1e-6f, kHeldTilt = 4e-4f, kHeldBend = 0.05f, kFirmly = 1e4f;
// A ball of three voxels and a third is as round as faces get: what is rounder may be a rounded edge.
constexpr float kMostBend = 0.3f;
// Faces that move, turn and bend by less in a round are found, voxels and radians.
constexpr float kFound = 2e-3f;

constexpr int kAtOnce = 8;

// The sums of a face's least squares over its voxels, rows 1, x, y, x²/2, xy, y²/2 along its tangents: the lower half
// of the normal equations, the right side, the feet of its voxels, and how many they are.
enum Sum { kMatrix = 0, kRight = 21, kFoot = 27, kCount = 30, kSums = 31 };

// A face with its tangents.
struct Frame {
  Vec3f origin, normal, u, v;
  Eigen::Matrix3f bend = Eigen::Matrix3f::Zero();
};

void findTangents(Frame& f) {
  // Any vector that is not along the normal.
  const Vec3f& n = f.normal;
  const Vec3f a = std::abs(n.x()) < 0.6f ? Vec3f(1, 0, 0) : std::abs(n.y()) < 0.6f ? Vec3f(0, 1, 0) : Vec3f(0, 0, 1);
  const Vec3f across = n.cross(a);
  f.u = across * (1 / std::sqrt(across.squaredNorm()));
  f.v = n.cross(f.u);
}

// Solves a symmetric positive system in place.
bool solve(float (&a)[6][6], float (&b)[6]) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) {
      float s = a[i][j];
      for (int k = 0; k < j; ++k) s -= a[i][k] * a[j][k];
      if (i != j) {
        a[i][j] = s / a[j][j];
      } else {
        if (!(s > 1e-9f)) return false;
        a[i][i] = std::sqrt(s);
      }
    }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  return true;
}

// Moves, turns and bends a face by what its sums say; by how much at most, or a negative number where they say nothing.
float improve(Frame& f, const float (&s)[kSums], bool first) {
  const float weight = s[kMatrix];
  if (s[kCount] < kLeastVoxels || !(weight > 1e-9f)) return -1;
  const float scale = 1 / weight;
  float a[6][6], b[6];
  for (int i = 0, n = kMatrix; i < 6; ++i) {
    for (int j = 0; j <= i; ++j, ++n) a[i][j] = scale * s[n];
    b[i] = scale * s[kRight + i];
  }
  a[0][0] += kHeldPlace;
  a[1][1] += kHeldTilt, a[2][2] += kHeldTilt;
  const float held = first || s[kCount] < kLeastForBend ? kFirmly : kHeldBend;
  a[3][3] += held, a[4][4] += held, a[5][5] += held;
  if (!solve(a, b)) return -1;
  float most = 0;
  for (const float part : b) most = std::max(most, std::abs(part));
  // The face as it is at the foot of its voxels: there tilt and height become the new normal and origin.
  const Vec3f foot = scale * Vec3f(s[kFoot], s[kFoot + 1], s[kFoot + 2]), d = foot - f.origin;
  const float x = d.dot(f.u), y = d.dot(f.v);
  const Vec3f bu = f.bend * f.u, bv = f.bend * f.v;
  const auto limited = [](float bend) { return std::clamp(bend, -kMostBend, kMostBend); };
  const float uu = limited(f.u.dot(bu) + b[3]), uv = limited(f.u.dot(bv) + b[4]), vv = limited(f.v.dot(bv) + b[5]);
  const float bentX = uu * x + uv * y, bentY = uv * x + vv * y;
  const float height = d.dot(f.normal) + b[0] + b[1] * x + b[2] * y + 0.5f * (bentX * x + bentY * y);
  const Vec3f turned = f.normal + (b[1] + bentX) * f.u + (b[2] + bentY) * f.v;
  Frame g;
  g.normal = turned * (1 / std::sqrt(turned.squaredNorm()));
  g.origin = foot - height * g.normal;
  findTangents(g);
  // The curvatures along the new tangents, as they were along the old ones.
  const auto bent = [&](const Vec3f& p, const Vec3f& q) {
    const float px = p.dot(f.u), py = p.dot(f.v), qx = q.dot(f.u), qy = q.dot(f.v);
    return uu * px * qx + vv * py * qy + uv * (px * qy + py * qx);
  };
  const float guu = bent(g.u, g.u), guv = bent(g.u, g.v), gvv = bent(g.v, g.v);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      g.bend(i, j) = g.bend(j, i) =
          guu * g.u[i] * g.u[j] + gvv * g.v[i] * g.v[j] + guv * (g.u[i] * g.v[j] + g.v[i] * g.u[j]);
  f = g;
  return most;
}

}  // namespace
}  // namespace argil::clay
#endif

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A lane is a voxel. Eight voxels are looked at together on every target, so that sums are the same.
using Tag = hn::CappedTag<float, kAtOnce>;
using Floats = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag())), kParts = kAtOnce / kLanes;

HWY_INLINE Floats all(float value) {
  return hn::Set(Tag(), value);
}
HWY_INLINE Floats sum(Floats a, Floats b, Floats c) {
  return hn::Add(hn::Add(a, b), c);
}

struct Vector {
  Floats x, y, z;
};
HWY_INLINE Vector everywhere(const Vec3f& v) {
  return {all(v.x()), all(v.y()), all(v.z())};
}
HWY_INLINE Vector minus(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Floats dot(const Vector& a, const Vector& b) {
  return sum(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector times(Floats s, const Vector& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}

// A face in all lanes.
struct Face {
  Vector origin, normal;
  Floats xx, yy, zz, xy, yz, zx;
  HWY_INLINE explicit Face(const Frame& f)
      : origin(everywhere(f.origin)),
        normal(everywhere(f.normal)),
        xx(all(f.bend(0, 0))),
        yy(all(f.bend(1, 1))),
        zz(all(f.bend(2, 2))),
        xy(all(f.bend(0, 1))),
        yz(all(f.bend(1, 2))),
        zx(all(f.bend(0, 2))) {}
};

struct Value {
  Floats distance;
  Vector gradient;
};
HWY_INLINE Value valueAt(const Face& f, const Vector& p) {
  const Floats one = all(1);
  const Vector d = minus(p, f.origin);
  const Vector b{sum(hn::Mul(f.xx, d.x), hn::Mul(f.xy, d.y), hn::Mul(f.zx, d.z)),
                 sum(hn::Mul(f.xy, d.x), hn::Mul(f.yy, d.y), hn::Mul(f.yz, d.z)),
                 sum(hn::Mul(f.zx, d.x), hn::Mul(f.yz, d.y), hn::Mul(f.zz, d.z))};
  const Floats h = dot(d, f.normal), q = dot(d, b), w = dot(b, b);
  const Floats k = hn::Div(hn::Mul(w, q), hn::Add(hn::Mul(q, q), all(1e-8f)));
  const Floats kh = hn::Mul(k, h), steep = hn::Add(one, kh);
  const Floats root = hn::Sqrt(hn::Max(all(0.01f), hn::Add(hn::Mul(steep, steep), w)));
  const Floats above = sum(hn::Add(h, h), hn::Mul(kh, h), q);
  const Floats inverse = hn::Div(one, root);
  const Vector g{hn::Add(hn::Mul(steep, f.normal.x), b.x), hn::Add(hn::Mul(steep, f.normal.y), b.y),
                 hn::Add(hn::Mul(steep, f.normal.z), b.z)};
  return {hn::Div(above, hn::Add(one, root)), times(inverse, g)};
}

HWY_INLINE Floats joined(bool convex, Floats a, Floats b) {
  return convex ? hn::Max(a, b) : hn::Min(a, b);
}
// The lanes in which the first of two is the one that counts.
HWY_INLINE Mask firstCounts(bool convex, Floats a, Floats b) {
  return convex ? hn::Ge(a, b) : hn::Le(a, b);
}

// The lanes' sum, in one order on all targets.
HWY_INLINE float total(const Floats* parts) {
  alignas(32) float v[kAtOnce];
  for (int part = 0; part < kParts; ++part) hn::Store(parts[part], Tag(), v + part * kLanes);
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

class Fitter {
 public:
  HWY_INLINE Fitter(RimVoxels& voxels, const RimFitRange& range, RimFit& fit)
      : voxels_(voxels), fit_(fit), near2_(range.near * range.near) {
    count_ = (voxels.count + kAtOnce - 1) / kAtOnce * kAtOnce;
    for (int i = voxels.count; i < count_; ++i) voxels.x[i] = voxels.y[i] = voxels.z[i] = voxels.phi[i] = 0;
    for (int i = 0; i < count_; i += kLanes) {
      const Vector at = place(i);
      const Floats d = hn::Add(all(1), hn::Mul(all(range.fading), dot(at, at)));
      hn::Store(hn::Div(all(1), hn::Mul(d, d)), Tag(), weight_ + i);
    }
    std::fill(weight_ + voxels.count, weight_ + count_, 0.0f);
    for (int k = 0; k < fit.faces; ++k) {
      Frame& f = frame_[k];
      f.origin = Vec3f(fit.face[k].origin[0], fit.face[k].origin[1], fit.face[k].origin[2]);
      f.normal = Vec3f(fit.face[k].normal[0], fit.face[k].normal[1], fit.face[k].normal[2]);
    }
  }

  HWY_INLINE bool run() { return fit_.faces == 2 ? fit<2>() : fit<3>(); }

 private:
  HWY_INLINE Vector place(int i) const {
    return {hn::Load(Tag(), voxels_.x + i), hn::Load(Tag(), voxels_.y + i), hn::Load(Tag(), voxels_.z + i)};
  }

  // Which rule leaves the least of the voxels, by planes; the outer face becomes face 0.
  template <int kFaces>
  HWY_INLINE void chooseRule() {
    constexpr int kOuter = kFaces == 2 ? 1 : 3, kInner = kFaces == 2 ? 1 : 2;
    Floats left[kOuter][2][kInner][kParts];
    for (auto& outer : left)
      for (auto& convex : outer)
        for (auto& inner : convex)
          for (Floats& part : inner) part = all(0);
    const Face* faces[kFaces];
    const Face held[3] = {Face(frame_[0]), Face(frame_[1]), Face(frame_[kFaces - 1])};
    for (int k = 0; k < kFaces; ++k) faces[k] = &held[k];
    for (int i = 0, part = 0; i < count_; i += kLanes, part = (part + 1) % kParts) {
      const Vector at = place(i);
      const Floats phi = hn::Load(Tag(), voxels_.phi + i), weight = hn::Load(Tag(), weight_ + i);
      Floats d[kFaces];
      for (int k = 0; k < kFaces; ++k) d[k] = dot(minus(at, faces[k]->origin), faces[k]->normal);
      for (int k = 0; k < kOuter; ++k)
        for (int inner = 0; inner < kInner; ++inner) {
          const Floats both = kFaces == 2 ? d[1] : joined(inner != 0, d[(k + 1) % kFaces], d[(k + 2) % kFaces]);
          for (int outer = 0; outer < 2; ++outer) {
            const Floats off = hn::Min(all(1), hn::Abs(hn::Sub(joined(outer != 0, d[k], both), phi)));
            left[k][outer][inner][part] = hn::Add(left[k][outer][inner][part], hn::Mul(weight, off));
          }
        }
    }
    float best = INFINITY;
    int first = 0;
    for (int k = 0; k < kOuter; ++k)
      for (int outer = 0; outer < 2; ++outer)
        for (int inner = 0; inner < kInner; ++inner)
          if (const float off = total(left[k][outer][inner]); off < best) {
            best = off, first = k;
            fit_.outerConvex = outer != 0;
            fit_.innerConvex = inner != 0;
          }
    std::rotate(frame_, frame_ + first, frame_ + kFaces);
  }

  template <int kFaces>
  HWY_INLINE bool fit() {
    chooseRule<kFaces>();
    for (int round = 0;; ++round) {
      // The last round only looks at what is left.
      const bool last = round == kRounds;
      const float slack = round == 0 ? kFirstSlack : kSlack;
      const Floats loose = all(1 / (slack * slack)), one = all(1), half = all(0.5f);
      for (int k = 0; k < kFaces; ++k) findTangents(frame_[k]);
      for (auto& face : sums_)
        for (auto& part : face) std::fill(part, part + kSums, all(0));
      Floats squares[kParts], weights[kParts];
      std::fill(squares, squares + kParts, all(0));
      std::fill(weights, weights + kParts, all(0));
      Floats worst = all(0);
      for (int i = 0, part = 0; i < count_; i += kLanes, part = (part + 1) % kParts) {
        const Vector at = place(i);
        const Floats phi = hn::Load(Tag(), voxels_.phi + i), near = hn::Load(Tag(), weight_ + i);
        Value values[kFaces];
        for (int k = 0; k < kFaces; ++k) values[k] = valueAt(Face(frame_[k]), at);
        Mask active[kFaces];
        Floats own;
        if constexpr (kFaces == 2) {
          active[0] = firstCounts(fit_.outerConvex, values[0].distance, values[1].distance);
          active[1] = hn::Not(active[0]);
          own = hn::IfThenElse(active[0], values[0].distance, values[1].distance);
        } else {
          const Mask second = firstCounts(fit_.innerConvex, values[1].distance, values[2].distance);
          const Floats inner = hn::IfThenElse(second, values[1].distance, values[2].distance);
          active[0] = firstCounts(fit_.outerConvex, values[0].distance, inner);
          active[1] = hn::AndNot(active[0], second);
          active[2] = hn::AndNot(active[0], hn::Not(second));
          own = hn::IfThenElse(active[0], values[0].distance, inner);
        }
        const Floats left = hn::Sub(phi, own), left2 = hn::Mul(left, left);
        squares[part] = hn::Add(squares[part], hn::Mul(near, hn::Min(one, left2)));
        weights[part] = hn::Add(weights[part], near);
        const Mask counts = hn::And(hn::Lt(dot(at, at), all(near2_)), hn::Gt(near, all(0)));
        worst = hn::Max(worst, hn::IfThenElseZero(counts, hn::Abs(left)));
        if (last) continue;
        const Floats weight = hn::Div(near, hn::Add(one, hn::Mul(left2, loose)));
        for (int k = 0; k < kFaces; ++k) {
          const Floats w = hn::IfThenElseZero(active[k], weight);
          const Mask some = hn::Gt(w, all(0));
          if (hn::AllFalse(Tag(), some)) continue;
          const Vector on = minus(at, times(values[k].distance, values[k].gradient)),
                       from = minus(on, everywhere(frame_[k].origin));
          const Floats x = dot(from, everywhere(frame_[k].u)), y = dot(from, everywhere(frame_[k].v));
          const Floats row[6] = {one, x, y, hn::Mul(half, hn::Mul(x, x)), hn::Mul(x, y), hn::Mul(half, hn::Mul(y, y))};
          Floats* s = sums_[k][part];
          int n = kMatrix;
          for (int m = 0; m < 6; ++m) {
            const Floats share = m == 0 ? w : hn::Mul(w, row[m]);
            for (int j = 0; j <= m; ++j, ++n) s[n] = hn::Add(s[n], j == 0 ? share : hn::Mul(share, row[j]));
            s[kRight + m] = hn::Add(s[kRight + m], hn::Mul(share, left));
          }
          s[kFoot] = hn::Add(s[kFoot], hn::Mul(w, on.x));
          s[kFoot + 1] = hn::Add(s[kFoot + 1], hn::Mul(w, on.y));
          s[kFoot + 2] = hn::Add(s[kFoot + 2], hn::Mul(w, on.z));
          s[kCount] = hn::Add(s[kCount], hn::IfThenElseZero(some, one));
        }
      }
      fit_.misfit = std::sqrt(total(squares) / std::max(1e-12f, total(weights)));
      fit_.worst = hn::GetLane(hn::MaxOfLanes(Tag(), worst));
      if (last) break;
      float moved = 0;
      for (int k = 0; k < kFaces; ++k) {
        float s[kSums];
        for (int n = 0; n < kSums; ++n) {
          Floats parts[kParts];
          for (int part = 0; part < kParts; ++part) parts[part] = sums_[k][part][n];
          s[n] = total(parts);
        }
        const float by = improve(frame_[k], s, round == 0);
        if (by < 0) return false;
        moved = std::max(moved, by);
      }
      // What was left before a small step is about what is left after it.
      if (round > 0 && moved < kFound) break;
    }
    for (int k = 0; k < kFaces; ++k) {
      RimFace& face = fit_.face[k];
      const Frame& f = frame_[k];
      for (int axis = 0; axis < 3; ++axis) face.origin[axis] = f.origin[axis], face.normal[axis] = f.normal[axis];
      const float bend[6] = {f.bend(0, 0), f.bend(1, 1), f.bend(2, 2), f.bend(0, 1), f.bend(1, 2), f.bend(0, 2)};
      std::copy(bend, bend + 6, face.bend);
    }
    return true;
  }

  RimVoxels& voxels_;
  RimFit& fit_;
  float near2_;
  int count_;
  Frame frame_[kMostRimFaces];
  alignas(64) float weight_[kMostRimVoxels];
  Floats sums_[kMostRimFaces][kParts][kSums];
};

bool FitRim(RimVoxels& voxels, const RimFitRange& range, RimFit& fit) {
  return Fitter(voxels, range, fit).run();
}

void CornerDistances(const RimFace& face, const float (&low)[3], float (&out)[8]) {
  Frame frame;
  frame.origin = Vec3f(face.origin[0], face.origin[1], face.origin[2]);
  frame.normal = Vec3f(face.normal[0], face.normal[1], face.normal[2]);
  const auto [xx, yy, zz, xy, yz, zx] = face.bend;
  frame.bend << xx, xy, zx, xy, yy, yz, zx, yz, zz;
  const Face f(frame);
  alignas(32) static constexpr float kX[8] = {0, 0, 0, 0, 1, 1, 1, 1}, kY[8] = {0, 0, 1, 1, 0, 0, 1, 1},
                                     kZ[8] = {0, 1, 0, 1, 0, 1, 0, 1};
  for (int i = 0; i < kAtOnce; i += kLanes) {
    const Vector p{hn::Add(all(low[0]), hn::Load(Tag(), kX + i)), hn::Add(all(low[1]), hn::Load(Tag(), kY + i)),
                   hn::Add(all(low[2]), hn::Load(Tag(), kZ + i))};
    hn::StoreU(valueAt(f, p).distance, Tag(), out + i);
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(FitRim);
HWY_EXPORT(CornerDistances);

bool fitRim(RimVoxels& voxels, const RimFitRange& range, RimFit& fit) noexcept {
  return HWY_DYNAMIC_DISPATCH(FitRim)(voxels, range, fit);
}

void cornerDistances(const RimFace& face, const float (&low)[3], float (&out)[8]) noexcept {
  HWY_DYNAMIC_DISPATCH(CornerDistances)(face, low, out);
}

}  // namespace argil::clay
#endif
