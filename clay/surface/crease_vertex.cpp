// After Ju, Losasso, Schaefer and Warren, Dual contouring of Hermite data (2002), with faces found by grouping instead
// of one least-squares fit.

#include "clay/surface/crease_vertex.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "clay/kernels/cell_cases.h"
#include "clay/surface/bent_vertex.h"
#include "clay/surface/crease_model.h"
#include "clay/surface/crease_path.h"
#include "clay/surface/rounded_wedge.h"
#include "clay/surface/sharp_vertices.h"

namespace argil::clay {

namespace {

// Scatter of the normals within faces, against the turn between them: above it the surface is bent all over, without a
// crease.
constexpr float kMostScatter = 0.012f;
// What the cell's values may differ from the faces' field, voxels.
constexpr float kMisfit = 0.09f;
// Below it the faces are known well enough for ties to count.
constexpr float kSure = 0.07f;

// What they may differ from the field of a rounded edge, voxels.
constexpr float kRoundMisfit = 0.05f;
// A model that fits so well needs no rival.
constexpr float kCertain = 0.015f;
// Sharp faces that fit better than this, and better than their rounding, are sharp.
constexpr float kUnsure = 0.03f;
// Radii of edges, voxels: below the first they are sharp; above the second the surface turns over several cells, and
// each vertex goes by where its own edges cross it.
constexpr float kLeastRadius = 0.03f;
constexpr float kSmallRadius = 0.4f;
// Above it the surface is bent rather than creased, even where a cell's own values fit a face.
constexpr float kLargeRadius = 1.4f;
// A vertex stays outside of a rounded edge by half of what it stands out, so that the triangles between cut it as
// little; but by no more than this, voxels.
constexpr float kStandOut = 0.12f;
// 1 − cos 53°: a vertex on more of a turn is a crease for the triangles beside it.
constexpr float kCreaseTurn = 0.4f;

// 1 − cos 6°: a plane turned by so much from its group counts half.
constexpr float kTurned = 0.0055f;

struct Group {
  Vec3f normal;
  float weight = 0;
  int count = 0;
};

float weightAt(const TangentPlane& plane, const Vec3f& p) {
  // Steep: on curved faces the nearest planes are the best ones. The foot of the cell's centre is what lies on the
  // face.
  const float d2 = 0.25f + (plane.centre - p).squaredNorm();
  return plane.quality / (d2 * d2);
}

constexpr size_t kMostPlanes = 125;

struct Grouping {
  std::array<Group, 3> groups;
  int count = 0;
  std::array<int8_t, kMostPlanes> of;
  std::array<float, kMostPlanes> weight;  // at the draft's vertex
  // less for a plane that is turned away from its group: it may have seen the rounding beyond the crease
  std::array<float, kMostPlanes> trust;
};

// Greedy seeds, the farthest next, then three rounds of k-means.
void group(const CreaseCell& cell, Grouping& out) {
  const size_t n = cell.planes.size();
  std::array<float, kMostPlanes>& weight = out.weight;
  for (size_t i = 0; i < n; ++i) weight[i] = weightAt(cell.planes[i], cell.draft);
  std::array<float, kMostPlanes> score = weight;
  out.count = 0;
  for (size_t k = 0; k < 3; ++k) {
    float best = 0;
    size_t chosen = n;
    for (size_t i = 0; i < n; ++i) {
      if (k > 0) {
        const float t = turn(cell.planes[i].normal, out.groups[k - 1].normal);
        score[i] = t < kLeastTurn ? 0.0f : std::min(score[i], weight[i] * t);
      }
      if (score[i] > best) {
        best = score[i];
        chosen = i;
      }
    }
    if (chosen == n) break;
    out.groups[k].normal = cell.planes[chosen].normal;
    out.count = static_cast<int>(k) + 1;
  }
  if (out.count < 2) return;
  std::fill_n(out.of.begin(), n, int8_t{-1});
  for (int round = 0; round < 3; ++round) {
    bool changed = false;
    std::array<Vec3f, 3> sum;
    sum.fill(Vec3f::Zero());
    for (int k = 0; k < out.count; ++k)
      out.groups[static_cast<size_t>(k)].weight = 0, out.groups[static_cast<size_t>(k)].count = 0;
    for (size_t i = 0; i < n; ++i) {
      int nearest = 0;
      float least = turn(cell.planes[i].normal, out.groups[0].normal);
      for (int k = 1; k < out.count; ++k)
        if (const float t = turn(cell.planes[i].normal, out.groups[static_cast<size_t>(k)].normal); t < least)
          nearest = k, least = t;
      changed |= out.of[i] != nearest;
      out.of[i] = static_cast<int8_t>(nearest);
      sum[static_cast<size_t>(nearest)] += weight[i] * cell.planes[i].normal;
      out.groups[static_cast<size_t>(nearest)].weight += weight[i];
      ++out.groups[static_cast<size_t>(nearest)].count;
    }
    if (!changed) break;
    for (int k = 0; k < out.count; ++k) {
      const Vec3f& s = sum[static_cast<size_t>(k)];
      const float length = std::sqrt(s.squaredNorm());
      if (length > 0) out.groups[static_cast<size_t>(k)].normal = s * (1 / length);
    }
  }
  for (size_t i = 0; i < n; ++i) {
    const float away = turn(cell.planes[i].normal, out.groups[static_cast<size_t>(out.of[i])].normal) * (1 / kTurned);
    out.trust[i] = 1 / (1 + away * away);
  }
}

// The faces of the groups `chosen`, as they are at p. Coordinates from the cell's low corner.
CreaseModel modelAt(const CreaseCell& cell, const Grouping& grouping, std::span<const int> chosen, const Vec3f& p) {
  CreaseModel model;
  model.count = static_cast<int>(chosen.size());
  std::array<int8_t, 3> place{-1, -1, -1};
  for (size_t k = 0; k < chosen.size(); ++k) place[static_cast<size_t>(chosen[k])] = static_cast<int8_t>(k);
  std::array<float, 3> sum{};
  for (size_t i = 0; i < cell.planes.size(); ++i) {
    const int8_t at = place[static_cast<size_t>(grouping.of[i])];
    if (at < 0) continue;
    const auto k = static_cast<size_t>(at);
    const TangentPlane& plane = cell.planes[i];
    const float w = grouping.trust[i] * weightAt(plane, p);
    CreaseModel::Face& face = model.face[k];
    face.gradient += w * plane.normal;
    face.offset += w * (plane.distance + plane.normal.dot(cell.low - plane.centre));
    face.foot += w * (plane.centre - plane.distance * plane.normal - cell.low);
    sum[k] += w;
  }
  for (size_t k = 0; k < chosen.size(); ++k) {
    CreaseModel::Face& face = model.face[k];
    const float inverse = 1 / sum[k];
    face = {face.gradient * inverse, face.offset * inverse, face.foot * inverse};
  }
  model.findTurns();
  return model;
}

// How far p lies outside of the unit cell, along the worst axis.
float outsideBy(const Vec3f& p) {
  float most = 0;
  for (int axis = 0; axis < 3; ++axis) most = std::max({most, -p[axis], p[axis] - 1});
  return most;
}

// A place on the edge between faces a and b for the cell's vertex. Along the crease the vertices must stand in the
// order of their cells, or triangles would fold; the crease goes from one cell to the next through the face that has
// crossings of both on it, so halfway between where the line meets the planes of two such faces keeps the order, even
// where the line passes outside of the cell.
std::optional<Vec3f> edgePoint(const CreaseCell& cell, const CreaseModel& model, const Crossings& crossings, int a,
                               int b) {
  const std::optional<CreaseModel::Line> line = model.line(a, b, crossings.middle);
  if (!line) return std::nullopt;
  const auto& [start, along] = *line;
  float low = -1, high = 1;
  if (model.count == 3) {
    // Beyond the corner the line goes on inside the solid or outside of it.
    const CreaseModel::Face& third = model.face[static_cast<size_t>(3 - a - b)];
    const float side = model.sideOfThird(a, b), slope = side * third.gradient.dot(along),
                value = side * third.at(start);
    if (slope > 1e-3f) low = std::clamp(-value / slope, low, high);
    if (slope < -1e-3f) high = std::clamp(-value / slope, low, high);
  }
  return Vec3f(start + std::clamp(placeAlong(cell.view, crossings, model, *line, a, b), low, high) * along);
}

struct Placed {
  CreaseVertex::Kind kind = CreaseVertex::Kind::none;
  Vec3f p;
  unsigned faces = 0;
};

// `near`: about there will do.
Placed place(const CreaseCell& cell, const CreaseModel& model, float tie, bool near = false) {
  const Crossings crossings = crossingsOf(cell.view, cell.edges, model, tie);
  Placed placed{CreaseVertex::Kind::none, crossings.middle, crossings.faces};
  if (tie >= kSure) {
    if (crossings.firm != 0) placed.faces = crossings.firm;
  } else if (!near && std::has_single_bit(placed.faces)) {
    placed.faces |= contested(cell.view, crossings, model, tie);
  }
  std::optional<Vec3f> p;
  const int a = std::countr_zero(placed.faces), b = 31 - std::countl_zero(placed.faces);
  if (placed.faces == 7) {
    placed.kind = CreaseVertex::Kind::corner;
    p = model.corner();
  } else if (a != b) {
    placed.kind = CreaseVertex::Kind::edge;
    p = edgePoint(cell, model, crossings, a, b);
  } else {
    placed.kind = CreaseVertex::Kind::face;
    p = model.face[static_cast<size_t>(a)].nearest(crossings.middle);
  }
  if (!p || outsideBy(*p) > kSharpReach) return {};
  placed.p = *p;
  return placed;
}

// How far the cell's own values are from what the faces allow: anything between a cut by max or min and the true
// distance.
float misfitOf(const CreaseCell& cell, const CreaseModel& model) {
  float most = 0;
  for (int c = 0; c < 8; ++c) {
    const Vec3f p(static_cast<float>(c >> 2), static_cast<float>((c >> 1) & 1), static_cast<float>(c & 1));
    const float cut = model.at(p), far = model.distance(p), sign = cut < 0 ? -1.0f : 1.0f,
                phi = sign * cell.view.corner(c);
    // Nearer to a surface than the faces say, and well away from them: that is another sheet, behind a thin wall.
    const float slack = 1 / (1 + 2 * std::max(0.0f, std::abs(phi) - 0.4f));
    most = std::max({most, slack * (std::min(sign * cut, far) - phi), phi - std::max(sign * cut, far)});
  }
  return most;
}

Vec3f pulledIn(const RoundedWedge& wedge, const Vec3f& p) {
  const RoundedWedge::Value there = wedge.at(p);
  return p - (there.distance - std::clamp(0.5f * there.distance, -kStandOut, kStandOut)) * there.gradient;
}

// From where the cell's edges cross a rounded edge.
CreaseVertex placeOnWedge(const CreaseCell& cell, const RoundedWedge& wedge) {
  std::array<SurfacePoint, 12> points;
  size_t count = 0;
  Vec3f mean = Vec3f::Zero();
  for (unsigned left = cell.edges; left != 0; left &= left - 1) {
    const auto e = static_cast<size_t>(std::countr_zero(left));
    const CellEdge edge = kCellEdges[e];
    const float from = cell.view.corner(edge.from), to = cell.view.corner(edge.from | 4 >> edge.axis);
    SurfacePoint& p = points[count++];
    p.at = Vec3f(static_cast<float>(edge.from >> 2), static_cast<float>((edge.from >> 1) & 1),
                 static_cast<float>(edge.from & 1));
    const float start = p.at[edge.axis];
    float t = from / (from - to);
    for (int i = 0; i < 4; ++i) {
      p.at[edge.axis] = start + t;
      const RoundedWedge::Value v = wedge.at(p.at);
      p.normal = v.gradient;
      if (std::abs(v.gradient[edge.axis]) > 0.05f) t = std::clamp(t - v.distance / v.gradient[edge.axis], 0.0f, 1.0f);
    }
    p.at[edge.axis] = start + t;
    mean += p.at;
  }
  mean *= 1 / static_cast<float>(count);
  const Vec3f p = pulledIn(wedge, meetingPoint({points.data(), count}, mean));
  if (outsideBy(p) > kSharpReach) return {};
  float least = 1;
  for (size_t i = 0; i < count; ++i)
    for (size_t j = 0; j < i; ++j) least = std::min(least, points[i].normal.dot(points[j].normal));
  return {1 - least > kCreaseTurn ? CreaseVertex::Kind::edge : CreaseVertex::Kind::face, p + cell.low,
          wedge.at(p).gradient};
}

// From the faces, as if the edge were sharp; pulled in where there is a `wedge`.
CreaseVertex placeSharply(const CreaseCell& cell, const CreaseModel& model, const RoundedWedge* wedge, float misfit) {
  const Placed placed = place(cell, model, misfit);
  if (placed.kind == CreaseVertex::Kind::none) return {};
  CreaseVertex found;
  found.kind = placed.kind;
  Vec3f normal = Vec3f::Zero();
  for (size_t k = 0; k < static_cast<size_t>(model.count); ++k)
    if ((placed.faces >> k) & 1) normal += model.face[k].gradient;
  const float length = std::sqrt(normal.squaredNorm());
  found.normal = length > 1e-6f ? Vec3f(normal * (1 / length)) : Vec3f(0, 0, 1);
  const Vec3f p = wedge ? pulledIn(*wedge, placed.p) : placed.p;
  if (outsideBy(p) > kSharpReach) return {};
  found.position = p + cell.low;
  return found;
}

}  // namespace

PackedNormal CreaseVertex::packedNormal() const noexcept {
  PackedNormal packed = PackedNormal::pack(normal);
  if (kind == Kind::edge || kind == Kind::corner) packed.v = static_cast<int16_t>(packed.v | 1);
  return packed;
}

CreaseVertex placeAtCrease(const CreaseCell& cell) noexcept {
  if (cell.planes.size() < 2) return {};
  Grouping grouping;
  group(cell, grouping);
  if (grouping.count < 2) return {};
  constexpr std::array<std::array<int, 3>, 4> kSets = {{{0, 1, 2}, {0, 1, 0}, {0, 2, 0}, {1, 2, 0}}};
  CreaseVertex found;
  float best = 1;
  for (size_t set = grouping.count == 3 ? 0 : 1; set < (grouping.count == 3 ? 4 : 2); ++set) {
    const std::span<const int> chosen(kSets[set].data(), set == 0 ? 3 : 2);
    bool apart = true;
    float least = 2;
    for (const int a : chosen)
      for (const int b : chosen)
        if (a < b) {
          const float t =
              turn(grouping.groups[static_cast<size_t>(a)].normal, grouping.groups[static_cast<size_t>(b)].normal);
          least = std::min(least, t);
          apart = apart && t > kLeastTurn && t < 1.95f;
        }
    for (const int k : chosen) apart = apart && grouping.groups[static_cast<size_t>(k)].count >= 2;
    if (!apart) continue;
    float scatter = 0, weights = 0;
    for (size_t i = 0; i < cell.planes.size(); ++i)
      if (std::find(chosen.begin(), chosen.end(), grouping.of[i]) != chosen.end()) {
        const float w = grouping.weight[i];
        scatter += w * turn(cell.planes[i].normal, grouping.groups[static_cast<size_t>(grouping.of[i])].normal);
        weights += w;
      }
    if (scatter > kMostScatter * least * weights) continue;

    CreaseModel model = modelAt(cell, grouping, chosen, cell.draft);
    Placed placed = place(cell, model, 0, true);
    // Once more with the planes nearest to that place: on curved faces they are the right ones.
    if (placed.kind != CreaseVertex::Kind::none) model = modelAt(cell, grouping, chosen, placed.p + cell.low);
    std::optional<RoundedWedge> wedge = RoundedWedge::of(model);
    if (wedge) wedge->fit(cell.view);
    const float sharpMisfit = misfitOf(cell, model), roundMisfit = wedge ? wedge->misfit(cell.view) : 1.0f;
    const bool rounded =
        wedge && wedge->radius() > kLeastRadius && (sharpMisfit > kUnsure || roundMisfit < sharpMisfit + kLeastRadius);
    if (wedge && wedge->radius() > kLargeRadius) continue;
    const float misfit = rounded ? roundMisfit : sharpMisfit;
    if (misfit > (rounded ? kRoundMisfit : kMisfit) || misfit > best) continue;
    const CreaseVertex now = rounded && wedge->radius() > kSmallRadius
                                 ? placeOnWedge(cell, *wedge)
                                 : placeSharply(cell, model, rounded ? &*wedge : nullptr, misfit);
    if (now.kind == CreaseVertex::Kind::none) continue;
    found = now;
    found.misfit = best = misfit;
    if (misfit < kCertain) break;
  }
  return found;
}

}  // namespace argil::clay
