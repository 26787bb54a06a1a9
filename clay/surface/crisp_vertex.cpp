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

// A plane that is turned from its face by more than 32° is none of it: faces of tips of five voxels turn by less within
// the reach of the planes. A tenth of the weight of all planes makes a third face.
constexpr FaceTurns kTurns{.least = kLeastTurn, .most = 0.15f, .third = 0.1f};
constexpr int kLeastPlanes = 4;
// The squared length of the mean normal of a face that hardly turns (a ball of thirty voxels has less), and of a plane.
constexpr float kStraight = 0.998f, kFlatFace = 0.9998f;
// What the cell's values may differ from the faces' field, voxels, on the side where that is exact; and for each voxel
// that they are farther than kNear from the surface.
constexpr float kMisfit = 0.25f, kNear = 0.4f, kMisfitBeyond = 0.25f;
// How far the mean of a cell's crossings may be from where its one face has them, voxels: beyond an edge distances are
// too short, and what they say of the crossings is less so.
constexpr float kMostShift = 0.25f;
// A face that is so near to a corner of a cell goes through it, voxels: on a plane of the grid.
constexpr float kOn = 0.01f;
// How far beside a cell a crease is in it, voxels: one that lies on a plane of the grid is in either cell.
constexpr float kBeside = 0.07f;
// How far the faces may meet from where they were sought, voxels.
constexpr float kMostWay = 1.5f;

Vec3f cornerOf(size_t c) {
  return {static_cast<float>(c >> 2), static_cast<float>((c >> 1) & 1), static_cast<float>(c & 1)};
}

// Distances of the two faces at the cell's corners, and how they make up its field: as a maximum at a convex edge, as a
// minimum at a concave one. Nothing when neither is like the cell's values.
struct Corners {
  std::array<std::array<float, 8>, 2> at;
  bool convex = true;
  bool signsAgree = true;  // with the cell's, at each corner
};
std::optional<Corners> compare(const CreaseCell& cell, CreaseModel& model, float deeper) {
  Corners corners;
  std::array<int, 2> wrongSigns{}, exact{};
  std::array<float, 2> off{}, depth{};
  for (size_t c = 0; c < 8; ++c) {
    for (size_t k = 0; k < 2; ++k) corners.at[k][c] = model.face[k].at(cornerOf(c));
    const float phi = cell.view.corner(static_cast<int>(c));
    const float most = std::max(corners.at[0][c], corners.at[1][c]),
                least = std::min(corners.at[0][c], corners.at[1][c]);
    wrongSigns[0] += (most < 0) != (phi < 0);
    wrongSigns[1] += (least < 0) != (phi < 0);
    // A maximum is exact inside and a bound outside; a minimum the other way round.
    const float allowed = kMisfitBeyond * std::max(0.0f, std::abs(phi) - kNear);
    const size_t side = phi < 0 ? 0 : 1;
    const float apart = side == 0 ? phi - most : least - phi;
    off[side] = std::max(off[side], std::abs(apart) - allowed);
    depth[side] += apart;
    ++exact[side];
  }
  model.findTurns();
  corners.convex = wrongSigns[0] != wrongSigns[1] ? wrongSigns[0] < wrongSigns[1] : model.convex[0][1];
  const size_t side = corners.convex ? 0 : 1;
  corners.signsAgree = wrongSigns[side] == 0;
  if (off[side] > kMisfit || depth[side] > deeper * static_cast<float>(exact[side])) return std::nullopt;
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
      if (from >= kOn)
        way[k] = corners.convex ? 0.0f : -1.0f;
      else if (to <= -kOn || to <= from)
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
  return std::min({p.x(), p.y(), p.z()}) >= -kBeside && std::max({p.x(), p.y(), p.z()}) <= 1 + kBeside;
}

CreaseModel::Face faceOf(const float* normal, float offset, const float* foot) {
  return {{normal[0], normal[1], normal[2]}, offset, {foot[0], foot[1], foot[2]}};
}

CreaseModel::Face faceThere(NearPlanes& planes, size_t which, const Vec3f& p) {
  const FaceThere there = faceAt(planes, static_cast<int>(which), p.data());
  return faceOf(there.normal, there.offset, there.foot);
}

// Whether one of the faces turns within the reach of its planes.
bool turns(const SplitFaces& faces, float straight) {
  return std::any_of(std::begin(faces.face), std::end(faces.face), [straight](const FacePlane& face) {
    const float* n = face.normal;
    return (n[0] * n[0] + n[1] * n[1]) + n[2] * n[2] < straight;
  });
}

// By two faces alone.
CreaseVertex placeOnTwo(const CreaseCell& cell, const SplitFaces& faces, NearPlanes& planes, float deeper) {
  CreaseModel model;
  model.count = 2;
  for (size_t k = 0; k < 2; ++k) {
    model.face[k] = faceOf(faces.face[k].normal, 0, faces.face[k].foot);
    model.face[k].offset = -model.face[k].gradient.dot(model.face[k].foot);
  }
  const Vec3f draft = cell.draft - cell.low;
  const auto about = model.line(0, 1, draft);
  if (!about || (about->start - draft).squaredNorm() > kMostWay * kMostWay) return {};
  for (size_t k = 0; k < 2; ++k) model.face[k] = faceThere(planes, k, about->start);
  // Faces of a rounding have the same normal where they meet.
  if (turn(model.face[0].gradient, model.face[1].gradient) < kLeastTurn) return {};
  const std::optional<Corners> corners = compare(cell, model, deeper);
  if (!corners) return {};
  const Met met = crossingsOf(cell, *corners);
  const auto line = model.line(0, 1, met.middle);
  if (!line) return {};
  CreaseVertex found;
  if (met.faces == 3 || inCell(line->start)) {
    found = {CreaseVertex::Kind::edge, line->start, model.face[0].gradient + model.face[1].gradient};
  } else {
    if ((met.middle - draft).squaredNorm() > kMostShift * kMostShift) return {};
    CreaseModel::Face face = model.face[met.faces >> 1];
    // As it is here, not where it meets the other one.
    if (turns(faces, kFlatFace)) face = faceThere(planes, met.faces >> 1, met.middle);
    found = {CreaseVertex::Kind::face, face.nearest(met.middle), face.gradient};
  }
  for (int axis = 0; axis < 3; ++axis)
    found.position[axis] = std::clamp(found.position[axis], -kCrispReach, 1 + kCrispReach);
  found.position += cell.low;
  found.explained = corners->signsAgree;
  return found;
}

// By three faces.
CreaseVertex placeOnThree(CreaseCell cell, const NearPlanes& planes) {
  std::array<TangentPlane, kMostNearPlanes> all;
  size_t count = 0;
  for (int i = 0; i < planes.count; ++i) {
    if (planes.quality[i] <= 0) continue;
    const auto at = [i](const float(&rows)[3][kMostNearPlanes]) { return Vec3f(rows[0][i], rows[1][i], rows[2][i]); };
    all[count++] = {at(planes.foot) + cell.low, at(planes.normal), 0, planes.quality[i]};
  }
  cell.planes = {all.data(), count};
  return placeAtCrease(cell);
}

}  // namespace

CreaseVertex placeCrisply(const CreaseCell& cell, NearPlanes& planes, float deeper, int least) noexcept {
  const Vec3f draft = cell.draft - cell.low;
  const SplitFaces faces = splitPlanes(planes, draft.data(), kTurns);
  if (!faces.found || faces.planes < kLeastPlanes || std::min(faces.count[0], faces.count[1]) < least) return {};
  CreaseVertex found = placeOnTwo(cell, faces, planes, deeper);
  found.curved = turns(faces, kStraight);
  if (found.kind != CreaseVertex::Kind::none || !faces.third) return found;
  return placeOnThree(cell, planes);
}

}  // namespace argil::clay
