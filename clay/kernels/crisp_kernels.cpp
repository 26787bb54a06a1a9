// After Kobbelt, Botsch, Schwanecke and Seidel, Feature sensitive surface extraction from volume data (2001): the
// vertex of a cell with a crease goes to where the tangent planes of its faces meet. These planes touch curved faces
// away from the crease, so each face is followed to it by second order.

#include "clay/kernels/crisp_kernels.h"

#include <algorithm>
#include <bit>

#include "clay/kernels/cell_cases.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/crisp_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/corner_planes.h"
#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A lane is a cell: what is added up is added in the order of its planes, whatever the target.
using Tag = hn::CappedTag<float, kCrispCells>;
using IntTag = hn::RebindToSigned<Tag>;
using Floats = hn::Vec<Tag>;
using Ints = hn::Vec<IntTag>;
using Mask = hn::Mask<Tag>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag()));

// A field much flatter than a distance says little of where the surface is.
constexpr float kSteep = 0.5f;
// Cells farther from the surface than this, in voxels, see other faces too.
constexpr float kFar = 1.5f;
// Keeps the slope of normals along a face from being read out of planes that stand side by side.
constexpr float kHeld = 0.05f;
// A plane through the corners of a cell on a ball is off by this part of the curvature, at first order: an eighth of
// the sum of both. On balls of four voxels and less, of which the first order knows little, it is taken to be less.
constexpr float kCutOff = 0.25f, kBall = 4;
// A plane that is turned from its face by more than 32° is none of it: faces of tips of five voxels turn by less within
// the reach of the planes. A tenth of the weight of all planes makes a third face.
constexpr float kMostTurn = 0.15f, kThird = 0.1f;
constexpr float kLeastPlanes = 4;
// The squared length of the mean normal of a face that hardly turns (a ball of thirty voxels has less), and of a plane.
constexpr float kStraight = 0.998f, kFlatFace = 0.9998f;
// How much deeper than the cell's values two faces may be on the side where they are exact, in the mean (voxels): where
// a rounding of two voxels may be and where none is.
constexpr float kDeeper = 0.03f, kDeeperAtCrease = 0.08f;
// Limit by how much the cell's values may differ from the faces' field on the side where that is exact, voxels: where
// the faces explain the cell, and at all; and for each voxel that they are farther than kNear from the surface.
constexpr float kClose = 0.1f, kMisfit = 0.25f, kNear = 0.4f, kMisfitBeyond = 0.25f;
// Voxels from a crease to those that tell whether it is rounded, and voxels along it that count with both its ways.
constexpr float kBesideCrease = 1, kAlongBoth = 0.25f;
// Less weight of them tells nothing.
constexpr float kTold = 0.05f;
// Lets one way along a crease count alone where the faces are exact there within the first, voxels, and in part up to
// the second; or where the surface is farther from them the other way than the third, and in part less than the fourth:
// another face is there.
constexpr float kExact = 0.005f, kInexact = 0.03f, kOther = 0.4f, kSurelyOther = 0.5f;
// Bounds of how far the tip of two faces stands off a rounding, beside that of a right angle.
constexpr float kLeastTip = 0.3f, kMostTip = 2.5f, kRightTip = 0.41421356f;
// The cosine of 37°: a rounding between faces that meet flatter takes less off than the voxels tell.
constexpr float kFlatter = 0.8f;
// How far the mean of a cell's crossings may be from where its one face has them, voxels: beyond an edge distances are
// too short, and what they say of the crossings is less so.
constexpr float kMostShift = 0.25f;
// A face that is so near to a corner of a cell goes through it, voxels: on a plane of the grid.
constexpr float kOn = 0.01f;
// A sign says nothing where the faces come so near to the cell's value, voxels.
constexpr float kSame = 0.03f;
// How far beside a cell a crease is in it, voxels: one that lies on a plane of the grid is in either cell.
constexpr float kBeside = 0.07f;
// How far the faces may meet from where they were sought, voxels.
constexpr float kMostWay = 1.5f;
// The squared sine of 8°: planes that meet flatter have no line.
constexpr float kLine = 0.02f;

HWY_INLINE Floats all(float value) {
  return hn::Set(Tag(), value);
}
HWY_INLINE Mask noLane() {
  return hn::FirstN(Tag(), 0);
}
HWY_INLINE Floats only(Mask m, Floats v) {
  return hn::IfThenElseZero(m, v);
}

struct Vector {
  Floats x, y, z;
};
HWY_INLINE Vector operator+(const Vector& a, const Vector& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vector operator-(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector operator*(Floats s, const Vector& v) {
  return {hn::Mul(s, v.x), hn::Mul(s, v.y), hn::Mul(s, v.z)};
}
HWY_INLINE Floats dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vector select(Mask m, const Vector& a, const Vector& b) {
  return {hn::IfThenElse(m, a.x, b.x), hn::IfThenElse(m, a.y, b.y), hn::IfThenElse(m, a.z, b.z)};
}
HWY_INLINE Vector none() {
  return {all(0), all(0), all(0)};
}
HWY_INLINE Vector load(const float (&rows)[3][kCrispCells], int lane) {
  const Tag d;
  return {hn::LoadU(d, rows[0] + lane), hn::LoadU(d, rows[1] + lane), hn::LoadU(d, rows[2] + lane)};
}
// Not for one without length: the mask says which have one.
HWY_INLINE Vector normalized(const Vector& v, Mask& known) {
  const Floats length = hn::Sqrt(dot(v, v));
  known = hn::And(known, hn::Gt(length, all(1e-6f)));
  return hn::Div(all(1), hn::Max(length, all(1e-6f))) * v;
}

// The corners of cells in a block of voxels; address(lane) is the lowest one's.
template <class Address>
HWY_INLINE void loadCorners(const Address& address, int stepX, int stepY, Floats (&v)[8]) {
  const auto pair = [&](int offset, Floats& lower, Floats& upper) {
    loadPairs(
        Tag(), [&](int lane) { return address(lane) + offset; }, lower, upper);
  };
  pair(0, v[0], v[1]), pair(stepY, v[2], v[3]), pair(stepX, v[4], v[5]), pair(stepX + stepY, v[6], v[7]);
}

void CellPlanes(const float* phi, int stepX, int stepY, int margin, const BlockCell* cells, int count,
                BlockPlanes& out) {
  const Tag d;
  const IntTag di;
  const hn::Rebind<uint16_t, Tag> d16;
  const Ints low4 = hn::Set(di, 15);
  const Floats shift = all(0.5f - static_cast<float>(margin));
  for (int i = 0; i < count; i += kLanes) {
    const Ints cell = hn::PromoteTo(di, hn::LoadU(d16, cells + i));
    const Ints x = hn::ShiftRight<8>(cell), y = hn::And(hn::ShiftRight<4>(cell), low4), z = hn::And(cell, low4);
    Floats v[8];
    loadCorners(
        [&](int lane) {
          const int one = cells[i + lane];
          return phi + (one >> 8) * stepX + (one >> 4 & 15) * stepY + (one & 15);
        },
        stepX, stepY, v);
    const CornerPlane<Floats> w = cornerPlane(v);
    const Vector slope = all(0.25f) * Vector{w.slopeX, w.slopeY, w.slopeZ};
    const Floats length = hn::Sqrt(dot(slope, slope));
    const Floats scale = hn::Div(all(1), hn::Max(length, all(kSteep)));
    const Vector normal = scale * slope;
    const Floats distance = hn::Mul(w.sum, hn::Mul(all(0.125f), scale));
    const auto known = hn::And(hn::Ge(length, all(kSteep)), hn::Lt(hn::Abs(distance), all(kFar)));
    const auto foot = [&](Ints place, Floats n) {
      return hn::Sub(hn::Add(hn::ConvertTo(d, place), shift), hn::Mul(distance, n));
    };
    hn::StoreInterleaved4(foot(x, normal.x), foot(y, normal.y), foot(z, normal.z),
                          hn::IfThenElse(known, w.bend, all(kNoPlane)), d, out.foot[i]);
    hn::StoreInterleaved4(normal.x, normal.y, normal.z, hn::Abs(hn::Sub(length, all(1))), d, out.normal[i]);
  }
  for (int k = 0; k < 4; ++k) out.foot[count][k] = out.normal[count][k] = 0;
  out.foot[count][BlockPlanes::bend] = kNoPlane;
}

// Far planes count little: the nearest ones know a curved face best.
HWY_INLINE Floats weightOf(Floats quality, Floats squared) {
  const Floats d2 = hn::Add(all(0.25f), squared);
  return hn::Div(quality, hn::Mul(d2, d2));
}

// The planes around each cell, from its lowest corner.
class Near {
 public:
  // `quality` is how much a plane counts, by its own face once that is known; `second` is 1 where that is the second.
  enum Row { footX, footY, footZ, normalX, normalY, normalZ, quality, second, weight, kRows };
  int count = 0;
  [[nodiscard]] HWY_INLINE Floats get(int i, int row) const { return hn::Load(Tag(), at_[i][row]); }
  HWY_INLINE void set(int i, int row, Floats v) { hn::Store(v, Tag(), at_[i][row]); }
  [[nodiscard]] HWY_INLINE Vector foot(int i) const { return {get(i, footX), get(i, footY), get(i, footZ)}; }
  [[nodiscard]] HWY_INLINE Vector normal(int i) const { return {get(i, normalX), get(i, normalY), get(i, normalZ)}; }
  [[nodiscard]] HWY_INLINE Mask isSecond(int i) const { return hn::Gt(get(i, second), all(0)); }

 private:
  alignas(64) float at_[kMostNearPlanes][kRows][kLanes];
};

struct Face {
  Vector normal;
  Floats offset;  // distance at the cell's lowest corner
  Vector foot;
  [[nodiscard]] HWY_INLINE Floats at(const Vector& p) const { return hn::Add(dot(normal, p), offset); }
};

// A face as it is at `place`; hasFace(i) says whether plane i is of it. By second order: between two points of a smooth
// surface the chord is perpendicular to the mean of their normals, but for an error of third order, and the normal at
// `place` follows from how normals turn towards it. Planes cut off what a face curves within their cells: the face
// stands out of them by that.
template <class HasFace>
HWY_INLINE Face follow(Near& near, const Vector& place, const HasFace& hasFace) {
  Floats sum = all(0);
  Vector mean = none(), foot = none();
  for (int i = 0; i < near.count; ++i) {
    const Vector at = near.foot(i), to = at - place;
    const Floats w = only(hasFace(i), weightOf(near.get(i, Near::quality), dot(to, to)));
    near.set(i, Near::weight, w);
    sum = hn::Add(sum, w);
    mean = mean + w * near.normal(i);
    foot = foot + w * at;
  }
  const Floats inverse = hn::Div(all(1), hn::Max(sum, all(1e-30f))), least = all(1e-12f);
  mean = inverse * mean;
  foot = inverse * foot;
  const Vector way = place - foot;
  Floats spreads = all(0), apart = all(0), turned = all(0);
  Vector bends = none();
  for (int i = 0; i < near.count; ++i) {
    const Vector from = near.foot(i) - foot, bend = near.normal(i) - mean;
    const Floats w = near.get(i, Near::weight), along = dot(way, from), part = hn::Mul(w, along);
    spreads = hn::Add(spreads, hn::Mul(part, along));
    bends = bends + part * bend;
    apart = hn::Add(apart, hn::Mul(w, dot(from, from)));
    turned = hn::Add(turned, hn::Mul(w, dot(from, bend)));
  }
  const Floats loose = hn::Mul(all(kHeld), sum), length2 = dot(way, way),
               curvature = hn::Div(turned, hn::Add(hn::Add(apart, loose), least));
  // Planes that lie across the way say little of how the face turns along it: as a ball, then.
  const Floats held = hn::Mul(loose, length2), ball = hn::Mul(loose, curvature);
  Face face;
  face.foot = foot;
  face.normal = mean + hn::Div(length2, hn::Add(hn::Add(spreads, held), least)) * (bends + ball * way);
  face.normal = hn::Div(all(1), hn::Sqrt(hn::Max(dot(face.normal, face.normal), least))) * face.normal;
  Floats values = all(0);
  for (int i = 0; i < near.count; ++i)
    values =
        hn::Add(values, hn::Mul(near.get(i, Near::weight), dot(near.normal(i) + face.normal, place - near.foot(i))));
  const Floats balls = hn::Mul(hn::Mul(all(kBall * kBall), curvature), curvature);
  face.offset = hn::Sub(hn::Sub(hn::Mul(hn::Mul(all(0.5f), values), inverse), dot(face.normal, place)),
                        hn::Div(hn::Mul(all(kCutOff), curvature), hn::Add(all(1), balls)));
  return face;
}

// The point nearest to p where the planes of two faces meet; not where they hardly turn.
HWY_INLINE Vector meeting(const Face (&faces)[2], const Vector& p, Mask& known) {
  const Vector &a = faces[0].normal, &b = faces[1].normal, along = cross(a, b);
  const Floats length2 = dot(along, along);
  known = hn::And(known, hn::Ge(length2, all(kLine)));
  const Floats inverse = hn::Div(all(1), hn::Max(length2, all(kLine)));
  const Floats aa = dot(a, a), bb = dot(b, b), ab = dot(a, b), da = faces[0].at(p), db = faces[1].at(p);
  return p + (hn::Mul(hn::Sub(hn::Mul(ab, db), hn::Mul(bb, da)), inverse) * a +
              hn::Mul(hn::Sub(hn::Mul(ab, da), hn::Mul(aa, db)), inverse) * b);
}

// What the planes around each cell say: two faces, as means over their planes.
struct Split {
  Face faces[2];
  Mask found, third;
  Mask curved, turned;  // one of them turns more than a straight face does, more than a plane
};
struct FaceSum {
  Floats weight, count;
  Vector normal, foot;
  static HWY_INLINE FaceSum nothing() { return {all(0), all(0), none(), none()}; }
  HWY_INLINE void add(Floats w, const Vector& n, const Vector& f) {
    count = hn::Add(count, only(hn::Gt(w, all(0)), all(1)));
    weight = hn::Add(weight, w);
    normal = normal + w * n;
    foot = foot + w * f;
  }
};

HWY_INLINE Split split(const CrispCells& cells, int lane, const BlockPlanes& planes, const Vector& draft, Near& near) {
  const Tag d;
  const Vector low = load(cells.low, lane);
  const auto rule = [&](float CrispRule::*part) {
    return loadEach(d, [&](int k) { return &(cells.rule[lane + k]->*part); });
  };
  const Floats most = rule(&CrispRule::most), inverse = hn::Div(all(1), hn::Mul(most, most)),
               blurred = rule(&CrispRule::blurred), zero = all(0), one = all(1);
  near.count = *std::max_element(cells.planes + lane, cells.planes + lane + kLanes);
  Floats counted = zero, smooth = zero, heaviest = zero;
  Vector first = none();
  for (int i = 0; i < near.count; ++i) {
    Floats a[4], b[4];
    loadFours(
        d, [&](int k) { return planes.foot[cells.plane[lane + k][i]]; }, a);
    loadFours(
        d, [&](int k) { return planes.normal[cells.plane[lane + k][i]]; }, b);
    const Vector foot = Vector{a[0], a[1], a[2]} - low, normal{b[0], b[1], b[2]}, to = foot - draft;
    const Floats bent = hn::Add(a[3], hn::Mul(b[3], blurred));
    const Floats quality = hn::Max(zero, hn::Sub(one, hn::Mul(bent, inverse))), weight = weightOf(quality, dot(to, to));
    counted = hn::Add(counted, only(hn::Gt(quality, zero), one));
    smooth = hn::Add(smooth, only(hn::Lt(bent, all(kCurvedPlane * kCurvedPlane)), one));
    const Mask heavier = hn::Gt(weight, heaviest);
    heaviest = hn::IfThenElse(heavier, weight, heaviest);
    first = select(heavier, normal, first);
    near.set(i, Near::footX, foot.x), near.set(i, Near::footY, foot.y), near.set(i, Near::footZ, foot.z);
    near.set(i, Near::normalX, normal.x), near.set(i, Near::normalY, normal.y), near.set(i, Near::normalZ, normal.z);
    near.set(i, Near::quality, quality), near.set(i, Near::weight, weight);
  }
  Split split;
  split.found = hn::And(hn::Ge(counted, all(kLeastPlanes)), hn::Ge(counted, hn::Mul(rule(&CrispRule::share), smooth)));
  if (hn::AllFalse(d, split.found)) return split;

  // The heaviest plane's normal, and that of the heaviest plane turned from it; then the means of those nearest to
  // each.
  Floats farthest = zero;
  Vector other = none();
  for (int i = 0; i < near.count; ++i) {
    const Vector normal = near.normal(i);
    const Floats turn = hn::Sub(one, dot(normal, first)), size = hn::Mul(near.get(i, Near::weight), turn);
    const Mask better = hn::And(hn::Gt(turn, all(kLeastTurn)), hn::Gt(size, farthest));
    farthest = hn::IfThenElse(better, size, farthest);
    other = select(better, normal, other);
  }
  split.found = hn::And(split.found, hn::Gt(farthest, zero));
  if (hn::AllFalse(d, split.found)) return split;
  Vector means[2] = {none(), none()};
  for (int i = 0; i < near.count; ++i) {
    const Vector normal = near.normal(i), part = near.get(i, Near::weight) * normal;
    const Mask second = hn::Gt(dot(normal, other), dot(normal, first));
    means[0] = means[0] + select(second, none(), part);
    means[1] = means[1] + select(second, part, none());
  }
  for (Vector& mean : means) mean = normalized(mean, split.found);
  split.found = hn::And(split.found, hn::Ge(hn::Sub(one, dot(means[0], means[1])), all(kLeastTurn)));

  Floats total = zero, away = zero;
  FaceSum sums[2] = {FaceSum::nothing(), FaceSum::nothing()};
  for (int i = 0; i < near.count; ++i) {
    const Vector normal = near.normal(i), foot = near.foot(i);
    const Floats weight = near.get(i, Near::weight), t0 = hn::Sub(one, dot(normal, means[0])),
                 t1 = hn::Sub(one, dot(normal, means[1]));
    const Mask neither = hn::Gt(hn::Min(t0, t1), all(kMostTurn)), second = hn::Lt(t1, t0);
    total = hn::Add(total, weight);
    away = hn::Add(away, only(neither, weight));
    near.set(i, Near::second, only(second, one));
    near.set(i, Near::quality, hn::IfThenZeroElse(neither, near.get(i, Near::quality)));
    const Floats own = hn::IfThenZeroElse(neither, weight);
    sums[0].add(hn::IfThenZeroElse(second, own), normal, foot);
    sums[1].add(only(second, own), normal, foot);
  }
  const Floats least = rule(&CrispRule::least);
  split.third = hn::Gt(away, hn::Mul(all(kThird), total));
  split.curved = split.turned = noLane();
  for (int k = 0; k < 2; ++k) {
    const FaceSum& sum = sums[k];
    split.found = hn::And(split.found, hn::And(hn::Gt(sum.weight, zero), hn::Ge(sum.count, least)));
    const Floats scale = hn::Div(one, hn::Max(sum.weight, all(1e-30f)));
    Face& face = split.faces[k];
    face.normal = scale * sum.normal;
    face.foot = scale * sum.foot;
    face.offset = hn::Neg(dot(face.normal, face.foot));
    const Floats length2 = dot(face.normal, face.normal);
    split.curved = hn::Or(split.curved, hn::Lt(length2, all(kStraight)));
    split.turned = hn::Or(split.turned, hn::Lt(length2, all(kFlatFace)));
  }
  return split;
}

// How two faces make up the field of a cell: as a maximum at a convex edge, as a minimum at a concave one.
struct Corners {
  Floats at[2][8];  // their distances at the cell's corners
  Mask convex;
  Mask agree;      // neither contradicts the cell's values
  Mask explained;  // nor a sign of them
};
HWY_INLINE Corners compare(const Floats (&phi)[8], const Face (&faces)[2], Floats deeper) {
  const Floats zero = all(0), one = all(1);
  Corners corners;
  Floats wrong[2] = {zero, zero}, inside = zero, off[2] = {zero, zero}, depth[2] = {zero, zero};
  for (int c = 0; c < 8; ++c) {
    for (int k = 0; k < 2; ++k) {
      Floats at = faces[k].offset;
      if (c & 4) at = hn::Add(at, faces[k].normal.x);
      if (c & 2) at = hn::Add(at, faces[k].normal.y);
      if (c & 1) at = hn::Add(at, faces[k].normal.z);
      corners.at[k][c] = at;
    }
    const Floats most = hn::Max(corners.at[0][c], corners.at[1][c]), few = hn::Min(corners.at[0][c], corners.at[1][c]);
    const Mask in = hn::Lt(phi[c], zero);
    const auto differs = [&](Floats value) {
      return hn::And(hn::Xor(hn::Lt(value, zero), in), hn::Gt(hn::Abs(hn::Sub(value, phi[c])), all(kSame)));
    };
    wrong[0] = hn::Add(wrong[0], only(differs(most), one));
    wrong[1] = hn::Add(wrong[1], only(differs(few), one));
    inside = hn::Add(inside, only(in, one));
    // A maximum is exact inside and a bound outside; a minimum the other way round.
    const Floats allowed = hn::Mul(all(kMisfitBeyond), hn::Max(zero, hn::Sub(hn::Abs(phi[c]), all(kNear))));
    const Floats apart = hn::IfThenElse(in, hn::Sub(phi[c], most), hn::Sub(few, phi[c])),
                 beyond = hn::Sub(hn::Abs(apart), allowed);
    off[0] = hn::IfThenElse(in, hn::Max(off[0], beyond), off[0]);
    off[1] = hn::IfThenElse(in, off[1], hn::Max(off[1], beyond));
    depth[0] = hn::Add(depth[0], only(in, apart));
    depth[1] = hn::Add(depth[1], hn::IfThenZeroElse(in, apart));
  }
  // Two faces meet in a convex edge if each one's foot lies behind the other.
  const Mask behind = hn::Lt(hn::Add(faces[0].at(faces[1].foot), faces[1].at(faces[0].foot)), zero);
  corners.convex = hn::Or(hn::Lt(wrong[0], wrong[1]), hn::And(hn::Eq(wrong[0], wrong[1]), behind));
  const auto side = [&](const Floats(&of)[2]) { return hn::IfThenElse(corners.convex, of[0], of[1]); };
  const Floats exact = hn::IfThenElse(corners.convex, inside, hn::Sub(all(8), inside));
  corners.explained = hn::And(hn::Eq(side(wrong), zero), hn::Le(side(off), all(kClose)));
  corners.agree = hn::And(hn::Le(side(off), all(kMisfit)), hn::Le(side(depth), hn::Mul(deeper, exact)));
  return corners;
}

// Tells how far the tip of two faces stands off the surface, by voxels beside it: a rounding fills a valley and takes
// an edge off. In voxels, in the mean, as it would at a right angle. `at`: a point of the crease; `along`: its
// direction; `third`: planes of neither face are near.
HWY_INLINE Floats roundingOf(const CrispCells& cells, int lane, const Face (&faces)[2], Mask convex, Mask third,
                             const Vector& at, Vector& along) {
  const Tag d;
  const Floats zero = all(0), one = all(1), turn = hn::IfThenElse(convex, all(-1), one);
  Mask known = hn::FirstN(d, kLanes);
  along = normalized(cross(faces[0].normal, faces[1].normal), known);
  const Floats cosine = dot(faces[0].normal, faces[1].normal);
  // Distances two voxels around the cell, turned so that the crease is a valley.
  constexpr int kWide = 6, kNext[3] = {kWide * kWide, kWide, 1};
  Floats wide[kWide * kWide * kWide];
  for (int i = 0; i < kWide * kWide * kWide; ++i) {
    const int offset = (i / 36 - 2) * cells.stepX + (i / 6 % 6 - 2) * cells.stepY + i % 6 - 2;
    wide[i] = hn::Mul(turn, loadEach(d, [&](int k) { return cells.phi[lane + k] + offset; }));
  }
  Floats weights[2] = {zero, zero}, sums[2] = {zero, zero};
  for (int x = 1; x < kWide - 1; ++x)
    for (int y = 1; y < kWide - 1; ++y)
      for (int z = 1; z < kWide - 1; ++z) {
        const Vector p{all(static_cast<float>(x - 2)), all(static_cast<float>(y - 2)), all(static_cast<float>(z - 2))},
            to = p - at;
        const Floats far = dot(to, along), aside = hn::Max(zero, hn::Sub(dot(to, to), hn::Mul(far, far)));
        Floats weight = hn::Max(zero, hn::Sub(one, hn::Mul(aside, all(1 / (kBesideCrease * kBesideCrease)))));
        if (hn::AllFalse(d, hn::Gt(weight, zero))) continue;
        // Outside the nearer face counts, inside the nearest place of the faces as far as they reach; but only beside a
        // voxel of the other side is a distance one to where the faces meet.
        const int here = (x * kWide + y) * kWide + z;
        const Floats phi = wide[here], a = hn::Mul(turn, faces[0].at(p)), b = hn::Mul(turn, faces[1].at(p)),
                     few = hn::Min(a, b);
        Mask exact = hn::Gt(hn::Max(few, phi), zero);
        for (const int step : kNext) exact = hn::Or(exact, hn::Gt(hn::Max(wide[here - step], wide[here + step]), zero));
        weight = only(exact, weight);
        const auto reach = [&](Floats own, Floats other) {
          return hn::IfThenElse(hn::Ge(other, hn::Mul(own, cosine)), hn::Neg(hn::Abs(own)), all(-1e3f));
        };
        const Floats depth = hn::Max(hn::Neg(hn::Sqrt(aside)), hn::Max(reach(a, b), reach(b, a))),
                     wedge = hn::IfThenElse(hn::Gt(few, zero), few, depth);
        // One way along the crease and the other: where a third face is, one of them has none.
        for (int way = 0; way < 2; ++way) {
          const Floats own = only(way == 0 ? hn::Lt(far, all(kAlongBoth)) : hn::Gt(far, all(-kAlongBoth)), weight);
          weights[way] = hn::Add(weights[way], own);
          sums[way] = hn::Add(sums[way], hn::Mul(own, hn::Sub(wedge, phi)));
        }
      }
  const auto meanOf = [](Floats sum, Floats weight) {
    return hn::IfThenElse(hn::Gt(weight, all(kTold)), hn::Div(sum, hn::Max(weight, all(kTold))), all(1));
  };
  const Floats whole = hn::Add(weights[0], weights[1]), one0 = meanOf(sums[0], weights[0]),
               one1 = meanOf(sums[1], weights[1]),
               both = only(hn::Gt(whole, all(kTold)), meanOf(hn::Add(sums[0], sums[1]), whole)),
               least = hn::Min(both, hn::Min(one0, one1));
  const auto ramp = [&](Floats value, float from, float to) {
    return hn::Min(one, hn::Max(zero, hn::Div(hn::Sub(value, all(from)), all(to - from))));
  };
  const Floats alone = hn::Max(ramp(hn::Abs(least), kInexact, kExact), ramp(hn::Max(one0, one1), kOther, kSurelyOther));
  const Floats mean = hn::IfThenElse(third, least, hn::Add(both, hn::Mul(alone, hn::Sub(least, both))));
  const Floats half = hn::Sqrt(hn::Max(all(0.01f), hn::Mul(all(0.5f), hn::Add(one, cosine)))),
               tip = hn::Mul(all(1 / kRightTip), hn::Sub(hn::Div(one, half), one));
  return only(hn::Lt(cosine, all(kFlatter)), hn::Div(mean, hn::Min(all(kMostTip), hn::Max(all(kLeastTip), tip))));
}

// Where the crossed edges of a cell cross the faces: the mean of the crossings, and whether each face is crossed.
struct Met {
  Vector middle;
  Mask faces[2];
};
HWY_INLINE Met crossingsOf(const uint32_t* edges, const Floats (&phi)[8], const Corners& corners) {
  const Tag d;
  const Floats zero = all(0), one = all(1);
  const Ints bits = hn::BitCast(IntTag(), hn::LoadU(hn::RebindToUnsigned<Tag>(), edges));
  const Floats behind = hn::IfThenElse(corners.convex, zero, all(-1)),
               ahead = hn::IfThenElse(corners.convex, all(2), one);
  Met met;
  met.faces[0] = met.faces[1] = noLane();
  Floats crossed = zero, sum[3] = {zero, zero, zero};
  for (size_t e = 0; e < kCellEdges.size(); ++e) {
    const Mask some = hn::RebindMask(d, hn::TestBit(bits, hn::Set(IntTag(), 1 << e)));
    if (hn::AllFalse(d, some)) continue;
    const CellEdge edge = kCellEdges[e];
    const Mask upwards = hn::Lt(phi[edge.from], zero);
    // On the way out of the solid the first face ends a convex one, the last face a concave one. One that the edge does
    // not cross is before it or after it.
    Floats way[2];
    for (int k = 0; k < 2; ++k) {
      const Floats from = hn::IfThenElse(upwards, corners.at[k][edge.from], corners.at[k][edge.to]),
                   to = hn::IfThenElse(upwards, corners.at[k][edge.to], corners.at[k][edge.from]);
      const Mask beyond = hn::Or(hn::Le(to, all(-kOn)), hn::Le(to, from));
      way[k] = hn::IfThenElse(hn::Ge(from, all(kOn)), behind,
                              hn::IfThenElse(beyond, ahead, hn::Div(from, hn::Sub(from, to))));
    }
    const Mask other =
        hn::Or(hn::And(corners.convex, hn::Lt(way[1], way[0])), hn::AndNot(corners.convex, hn::Gt(way[1], way[0])));
    met.faces[0] = hn::Or(met.faces[0], hn::AndNot(other, some));
    met.faces[1] = hn::Or(met.faces[1], hn::And(other, some));
    const Floats t = hn::Min(hn::Max(hn::IfThenElse(other, way[1], way[0]), zero), one);
    const Floats along = hn::IfThenElse(upwards, t, hn::Sub(one, t));
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == edge.axis)
        sum[axis] = hn::Add(sum[axis], only(some, along));
      else if (edge.from >> (2 - axis) & 1)
        sum[axis] = hn::Add(sum[axis], only(some, one));
    }
    crossed = hn::Add(crossed, only(some, one));
  }
  const Floats inverse = hn::Div(one, hn::Max(crossed, one));
  met.middle = inverse * Vector{sum[0], sum[1], sum[2]};
  return met;
}

// In the cell or a little beside it.
HWY_INLINE Mask inCell(const Vector& p) {
  return hn::And(hn::Ge(hn::Min(hn::Min(p.x, p.y), p.z), all(-kBeside)),
                 hn::Le(hn::Max(hn::Max(p.x, p.y), p.z), all(1 + kBeside)));
}
HWY_INLINE Mask isWithin(const Vector& v, float length) {
  return hn::Le(dot(v, v), all(length * length));
}

void Place(const CrispCells& cells, const BlockPlanes& planes, CrispVertices& out) {
  const Tag d;
  out.kinked = out.edge = out.face = out.third = out.curved = out.explained = 0;
  Near near;
  for (int lane = 0; lane < cells.count; lane += kLanes) {
    const auto add = [lane](unsigned& bits, Mask mask) {
      uint8_t some[8] = {};
      hn::StoreMaskBits(Tag(), mask, some);
      bits |= unsigned{some[0]} << lane;
    };
    Floats phi[8];
    loadCorners([&](int k) { return cells.phi[lane + k]; }, cells.stepX, cells.stepY, phi);
    const CornerPlane<Floats> plane = cornerPlane(phi);
    const Vector slope{plane.slopeX, plane.slopeY, plane.slopeZ};
    const Mask kinked = hn::Or(hn::Gt(plane.bend, all(kCreaseBend * kCreaseBend)),
                               hn::Lt(dot(slope, slope), all(16 * kCreaseSlope * kCreaseSlope)));
    add(out.kinked, kinked);

    const Vector draft = load(cells.draft, lane);
    const Split faces = split(cells, lane, planes, draft, near);
    Mask found = faces.found;
    if (hn::AllFalse(d, found)) continue;
    add(out.curved, hn::And(found, faces.curved));
    const Vector about = meeting(faces.faces, draft, found);
    found = hn::And(found, isWithin(about - draft, kMostWay));
    const Face there[2] = {follow(near, about, [&](int i) { return hn::Not(near.isSecond(i)); }),
                           follow(near, about, [&](int i) { return near.isSecond(i); })};
    // Faces of a rounding have the same normal where they meet.
    found = hn::And(found, hn::Ge(hn::Sub(all(1), dot(there[0].normal, there[1].normal)), all(kLeastTurn)));
    const Corners corners = compare(phi, there, hn::IfThenElse(kinked, all(kDeeperAtCrease), all(kDeeper)));
    found = hn::And(found, corners.agree);
    const Met met = crossingsOf(cells.edges + lane, phi, corners);
    Vector place = meeting(there, met.middle, found), normal = there[0].normal + there[1].normal;
    const Mask edge = hn::And(found, hn::Or(hn::And(met.faces[0], met.faces[1]), inCell(place)));
    const Mask beside = hn::And(hn::AndNot(edge, found), isWithin(met.middle - draft, kMostShift));
    hn::StoreU(place.x, d, out.crease[0] + lane);
    hn::StoreU(place.y, d, out.crease[1] + lane);
    hn::StoreU(place.z, d, out.crease[2] + lane);
    if (!hn::AllFalse(d, hn::Or(edge, beside))) {
      Vector along;
      hn::StoreU(roundingOf(cells, lane, there, corners.convex, faces.third, place, along), d, out.rounding + lane);
      hn::StoreU(along.x, d, out.along[0] + lane);
      hn::StoreU(along.y, d, out.along[1] + lane);
      hn::StoreU(along.z, d, out.along[2] + lane);
    }
    if (!hn::AllFalse(d, beside)) {
      const Mask second = met.faces[1];
      Face face{select(second, there[1].normal, there[0].normal),
                hn::IfThenElse(second, there[1].offset, there[0].offset), none()};
      // As it is here, not where it meets the other one.
      if (const Mask turned = hn::And(beside, faces.turned); !hn::AllFalse(d, turned)) {
        const Face here = follow(near, met.middle, [&](int i) { return hn::Not(hn::Xor(near.isSecond(i), second)); });
        face.normal = select(turned, here.normal, face.normal);
        face.offset = hn::IfThenElse(turned, here.offset, face.offset);
      }
      const Floats height = hn::Div(face.at(met.middle), dot(face.normal, face.normal));
      place = select(beside, met.middle - height * face.normal, place);
      normal = select(beside, face.normal, normal);
    }
    add(out.edge, edge);
    add(out.face, beside);
    add(out.third, hn::And(faces.found, faces.third));
    add(out.explained, corners.explained);
    const auto kept = [](Floats v) { return hn::Min(hn::Max(v, all(-kCrispReach)), all(1 + kCrispReach)); };
    hn::StoreU(kept(place.x), d, out.position[0] + lane);
    hn::StoreU(kept(place.y), d, out.position[1] + lane);
    hn::StoreU(kept(place.z), d, out.position[2] + lane);
    hn::StoreU(normal.x, d, out.normal[0] + lane);
    hn::StoreU(normal.y, d, out.normal[1] + lane);
    hn::StoreU(normal.z, d, out.normal[2] + lane);
  }
  const unsigned counted = (1u << cells.count) - 1;
  for (unsigned* bits : {&out.kinked, &out.edge, &out.face, &out.third, &out.curved, &out.explained}) *bits &= counted;
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(CellPlanes);
HWY_EXPORT(Place);

void cellPlanes(const float* phi, int stepX, int stepY, int margin, const BlockCell* cells, int count,
                BlockPlanes& out) noexcept {
  HWY_DYNAMIC_DISPATCH(CellPlanes)(phi, stepX, stepY, margin, cells, count, out);
  out.count = count;
}

float planeQuality(float bend, float blur, const CrispRule& rule) noexcept {
  return std::max(0.0f, 1 - (bend + blur * rule.blurred) * (1 / (rule.most * rule.most)));
}

void placeCrisply(CrispCells& cells, const BlockPlanes& planes, CrispVertices& out) noexcept {
  const auto none = static_cast<uint16_t>(planes.count);
  const int most = *std::max_element(cells.planes, cells.planes + cells.count);
  for (int k = 0; k < kCrispCells; ++k) {
    if (k >= cells.count) {
      cells.phi[k] = cells.phi[0];
      cells.rule[k] = cells.rule[0];
      cells.edges[k] = 0;
      cells.planes[k] = 0;
      for (int axis = 0; axis < 3; ++axis) cells.low[axis][k] = cells.draft[axis][k] = 0;
    }
    std::fill(cells.plane[k] + cells.planes[k], cells.plane[k] + most, none);
  }
  HWY_DYNAMIC_DISPATCH(Place)(cells, planes, out);
}

}  // namespace argil::clay
#endif
