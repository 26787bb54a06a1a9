// After Kobbelt, Botsch, Schwanecke and Seidel, Feature sensitive surface extraction from volume data (2001): the
// vertex of a cell with a crease goes to where the tangent planes of its faces meet. These planes touch curved faces
// away from the crease, so each face is followed to it by second order.

#include "clay/surface/crisp_vertex.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "clay/kernels/cell_cases.h"

namespace argil::clay {

namespace {

// 1 − cos 32°: a plane that is turned so far from its face is none of it. Faces of tips of five voxels turn by less
// within the reach of the planes.
constexpr float kMostTurn = 0.15f;
// Of the weight of all planes: what has to be turned away from two faces for a third one.
constexpr float kThirdWeight = 0.1f;
// What the cell's values may differ from the faces' field, voxels, on the side where that is exact; and for each voxel
// that they are farther than kNear from the surface.
constexpr float kMisfit = 0.25f, kNear = 0.4f, kMisfitBeyond = 0.25f;
// How far the faces may meet from where they were sought, voxels.
constexpr float kMostWay = 2;
// Keeps the slope of normals along a face from being read out of planes that stand side by side.
constexpr float kHeld = 0.05f;

// A plane's place on the surface, in coordinates from the cell's low corner.
struct Sample {
  Vec3f foot, normal;
  float quality, weight;
};

// Far samples count little: the nearest ones know a curved face best.
float weightOf(float quality, float squared) {
  const float d2 = 0.25f + squared;
  return quality / (d2 * d2);
}

struct Faces {
  std::array<std::array<Sample, kMostCrispPlanes>, 2> samples;
  std::array<size_t, 2> count{};
  bool third = false;  // Some planes are turned away from both.
};

// The planes in two groups by their normals: those of the heaviest plane, and of the heaviest one turned from it.
bool split(const CreaseCell& cell, Faces& faces) {
  const size_t n = cell.planes.size();
  std::array<float, kMostCrispPlanes> weight;
  size_t first = 0, other = n;
  for (size_t i = 0; i < n; ++i) {
    weight[i] = weightOf(cell.planes[i].quality, (cell.planes[i].centre - cell.draft).squaredNorm());
    if (weight[i] > weight[first]) first = i;
  }
  float best = 0;
  for (size_t i = 0; i < n; ++i) {
    const float t = turn(cell.planes[i].normal, cell.planes[first].normal);
    if (t > kLeastTurn && weight[i] * t > best) {
      best = weight[i] * t;
      other = i;
    }
  }
  if (other == n) return false;
  std::array<Vec3f, 2> normal{cell.planes[first].normal, cell.planes[other].normal};
  for (int round = 0; round < 2; ++round) {
    std::array<Vec3f, 2> sum{Vec3f::Zero(), Vec3f::Zero()};
    for (size_t i = 0; i < n; ++i) {
      const Vec3f& each = cell.planes[i].normal;
      sum[each.dot(normal[1]) > each.dot(normal[0]) ? 1 : 0] += weight[i] * each;
    }
    for (size_t k = 0; k < 2; ++k) {
      const float length = std::sqrt(sum[k].squaredNorm());
      if (!(length > 1e-6f)) return false;
      normal[k] = sum[k] * (1 / length);
    }
  }
  if (turn(normal[0], normal[1]) < kLeastTurn) return false;
  float all = 0, away = 0;
  for (size_t i = 0; i < n; ++i) {
    const TangentPlane& plane = cell.planes[i];
    const float t0 = turn(plane.normal, normal[0]), t1 = turn(plane.normal, normal[1]);
    all += weight[i];
    if (std::min(t0, t1) > kMostTurn) {
      away += weight[i];
      continue;
    }
    const size_t k = t1 < t0 ? 1 : 0;
    faces.samples[k][faces.count[k]++] = {plane.centre - plane.distance * plane.normal - cell.low, plane.normal,
                                          plane.quality, weight[i]};
  }
  faces.third = away > kThirdWeight * all;
  return faces.count[0] != 0 && faces.count[1] != 0;
}

// The mean plane of a face's samples.
CreaseModel::Face meanFace(std::span<const Sample> samples) {
  CreaseModel::Face face;
  float sum = 0;
  for (const Sample& s : samples) {
    sum += s.weight;
    face.gradient += s.weight * s.normal;
    face.foot += s.weight * s.foot;
  }
  const float inverse = 1 / sum;
  face.gradient *= inverse;
  face.foot *= inverse;
  face.offset = -face.gradient.dot(face.foot);
  return face;
}

// A face as it is at p. Between two points of a smooth surface the chord is perpendicular to the mean of their normals,
// but for an error of third order; so each sample says where the face is at p as soon as the normal there is known, and
// that follows from how the normals turn towards p.
CreaseModel::Face faceAt(std::span<Sample> samples, const Vec3f& p) {
  float sum = 0;
  for (Sample& s : samples) {
    s.weight = weightOf(s.quality, (s.foot - p).squaredNorm());
    sum += s.weight;
  }
  const CreaseModel::Face mean = meanFace(samples);
  const Vec3f towards = p - mean.foot;
  const float length2 = towards.squaredNorm();
  float spread = 0;
  Vec3f bend = Vec3f::Zero();
  for (const Sample& s : samples) {
    const float along = towards.dot(s.foot - mean.foot);
    spread += s.weight * along * along;
    bend += (s.weight * along) * (s.normal - mean.gradient);
  }
  Vec3f there = mean.gradient + bend * (length2 / (spread + kHeld * sum * length2 + 1e-12f));
  there *= 1 / std::sqrt(std::max(there.squaredNorm(), 1e-12f));
  float value = 0;
  for (const Sample& s : samples) value += s.weight * (s.normal + there).dot(p - s.foot);
  return {there, 0.5f * value / sum - there.dot(p), mean.foot};
}

Vec3f cornerOf(size_t c) {
  return {static_cast<float>(c >> 2), static_cast<float>((c >> 1) & 1), static_cast<float>(c & 1)};
}

// Distances of the two faces at the cell's corners, and how they make up its field: as a maximum at a convex edge, as a
// minimum at a concave one. Nothing when neither is like the cell's values.
struct Corners {
  std::array<std::array<float, 8>, 2> at;
  bool convex = true;
};
std::optional<Corners> compare(const CreaseCell& cell, CreaseModel& model) {
  Corners corners;
  std::array<int, 2> wrongSigns{};
  std::array<float, 2> off{};
  for (size_t c = 0; c < 8; ++c) {
    for (size_t k = 0; k < 2; ++k) corners.at[k][c] = model.face[k].at(cornerOf(c));
    const float phi = cell.view.corner(static_cast<int>(c));
    const float most = std::max(corners.at[0][c], corners.at[1][c]),
                least = std::min(corners.at[0][c], corners.at[1][c]);
    wrongSigns[0] += (most < 0) != (phi < 0);
    wrongSigns[1] += (least < 0) != (phi < 0);
    // A maximum is exact inside and a bound outside; a minimum the other way round.
    const float allowed = kMisfitBeyond * std::max(0.0f, std::abs(phi) - kNear);
    if (phi < 0)
      off[0] = std::max(off[0], std::abs(phi - most) - allowed);
    else
      off[1] = std::max(off[1], std::abs(phi - least) - allowed);
  }
  model.findTurns();
  corners.convex = wrongSigns[0] != wrongSigns[1] ? wrongSigns[0] < wrongSigns[1] : model.convex[0][1];
  if (off[corners.convex ? 0 : 1] > kMisfit) return std::nullopt;
  return corners;
}

// Where the cell's edges cross the faces: the mean of the crossings, and a bit for each face that is crossed.
struct Met {
  Vec3f middle = Vec3f::Zero();
  unsigned faces = 0;
};
Met crossingsOf(const CreaseCell& cell, const Corners& corners) {
  Met met;
  for (unsigned left = cell.edges; left != 0; left &= left - 1) {
    const CellEdge edge = kCellEdges[static_cast<size_t>(std::countr_zero(left))];
    const bool upwards = cell.view.corner(edge.from) < 0;
    const size_t in = upwards ? edge.from : edge.to, out = upwards ? edge.to : edge.from;
    // On the way out of the solid the first face ends a convex one, the last face a concave one. One that the edge does
    // not cross is before it or after it.
    std::array<float, 2> way;
    for (size_t k = 0; k < 2; ++k) {
      const float from = corners.at[k][in], to = corners.at[k][out];
      if (from >= 0)
        way[k] = corners.convex ? 0.0f : -1.0f;
      else if (to <= 0)
        way[k] = corners.convex ? 2.0f : 1.0f;
      else
        way[k] = from / (from - to);
    }
    const size_t face = (corners.convex ? way[1] < way[0] : way[1] > way[0]) ? 1 : 0;
    met.faces |= 1u << face;
    Vec3f crossing = cornerOf(edge.from);
    const float t = std::clamp(way[face], 0.0f, 1.0f);
    crossing[edge.axis] += upwards ? t : 1 - t;
    met.middle += crossing;
  }
  met.middle *= 1 / static_cast<float>(std::popcount(cell.edges));
  return met;
}

bool inCell(const Vec3f& p) {
  return std::min({p.x(), p.y(), p.z()}) >= 0 && std::max({p.x(), p.y(), p.z()}) <= 1;
}

// By two faces alone.
CreaseVertex placeOnTwo(const CreaseCell& cell, Faces& faces) {
  const std::array<std::span<Sample>, 2> samples{std::span(faces.samples[0].data(), faces.count[0]),
                                                 std::span(faces.samples[1].data(), faces.count[1])};
  CreaseModel model;
  model.count = 2;
  for (size_t k = 0; k < 2; ++k) model.face[k] = meanFace(samples[k]);
  const Vec3f draft = cell.draft - cell.low;
  const auto about = model.line(0, 1, draft);
  if (!about || (about->start - draft).squaredNorm() > kMostWay * kMostWay) return {};
  for (size_t k = 0; k < 2; ++k) model.face[k] = faceAt(samples[k], about->start);
  const std::optional<Corners> corners = compare(cell, model);
  if (!corners) return {};
  const Met met = crossingsOf(cell, *corners);
  const auto line = model.line(0, 1, met.middle);
  if (!line) return {};
  CreaseVertex found;
  if (met.faces == 3 || inCell(line->start)) {
    found = {CreaseVertex::Kind::edge, line->start, model.face[0].gradient + model.face[1].gradient};
  } else {
    const CreaseModel::Face& face = model.face[met.faces >> 1];
    found = {CreaseVertex::Kind::face, face.nearest(met.middle), face.gradient};
  }
  for (int axis = 0; axis < 3; ++axis)
    found.position[axis] = std::clamp(found.position[axis], -kCrispReach, 1 + kCrispReach);
  found.position += cell.low;
  return found;
}

}  // namespace

CreaseVertex placeCrisply(const CreaseCell& cell) noexcept {
  Faces faces;
  if (cell.planes.size() < 4 || !split(cell, faces)) return {};
  const CreaseVertex found = placeOnTwo(cell, faces);
  if (found.kind != CreaseVertex::Kind::none || !faces.third) return found;
  return placeAtCrease(cell);
}

}  // namespace argil::clay
