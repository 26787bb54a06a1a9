#include "clay/surface/crease_path.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "clay/kernels/cell_cases.h"

namespace argil::clay {

namespace {

// Edges around each face of a cell, and the edge that starts at a corner along an axis.
struct Tables {
  uint16_t around[6] = {};
  int8_t edge[8][3] = {};
  Tables() {
    for (int e = 0; e < 12; ++e) {
      const CellEdge at = kCellEdges[static_cast<size_t>(e)];
      edge[at.from][at.axis] = static_cast<int8_t>(e);
      for (int face = 0; face < 6; ++face) {
        const auto on = [&](int corner) { return ((corner >> (2 - face / 2)) & 1) == (face & 1); };
        if (on(at.from) && on(at.to)) around[face] = static_cast<uint16_t>(around[face] | 1 << e);
      }
    }
  }
};
const Tables& tables() {
  static const Tables made;
  return made;
}

// The faces of a cell through which the crease between a and b leaves it: one of their two crossings is on a, the other
// on b. Bit per face.
unsigned doorsOf(const Crossings& crossings, int a, int b) {
  unsigned doors = 0;
  for (int face = 0; face < 6; ++face) {
    unsigned met = 0;
    for (unsigned edges = tables().around[face] & crossings.edges; edges != 0; edges &= edges - 1)
      met |= 1u << crossings.of[static_cast<size_t>(std::countr_zero(edges))];
    if (met == (1u << a | 1u << b)) doors |= 1u << face;
  }
  return doors;
}

}  // namespace

unsigned CellView::pattern() const {
  unsigned found = 0;
  for (int c = 0; c < 8; ++c) found |= static_cast<unsigned>(corner(c) < 0) << c;
  return found;
}

CellView CellView::beyond(int face) const {
  const int axis = face / 2, step = face & 1 ? 1 : -1;
  CellView next = *this;
  next.phi += step * (axis == 0 ? stepX : axis == 1 ? stepY : 1);
  next.low[axis] += static_cast<float>(step);
  return next;
}

namespace {

// Crossings nearer than this to each other, voxels, are the same, whatever rounding says.
constexpr float kSame = 0.002f;
// Decides between faces that an edge passes through equally: by direction, for the cells around it see them in any
// order.
const Vec3f kAnyTilt(0.02f, 0.012f, 0.006f);

}  // namespace

Crossings crossingsOf(const CellView& cell, uint16_t edges, const CreaseModel& model, float tie) {
  unsigned atCorner = 0;
  const auto count = static_cast<size_t>(model.count);
  Crossings found;
  found.edges = edges;
  found.of.fill(-1);
  // Along an edge the faces' distances are linear.
  std::array<std::array<float, 3>, 8> corners{};
  for (size_t c = 0; c < 8; ++c) {
    const Vec3f p =
        cell.low + Vec3f(static_cast<float>(c >> 2), static_cast<float>(c >> 1 & 1), static_cast<float>(c & 1));
    for (size_t k = 0; k < count; ++k) corners[c][k] = model.face[k].at(p);
  }
  for (unsigned left = edges; left != 0; left &= left - 1) {
    const auto e = static_cast<size_t>(std::countr_zero(left));
    const CellEdge edge = kCellEdges[e];
    const std::array<float, 3>&from = corners[edge.from], &to = corners[edge.to];
    std::array<float, 3> way, off;
    size_t best = 0;
    for (size_t k = 0; k < count; ++k) {
      const float slope = from[k] - to[k];
      way[k] = std::abs(slope) > 1e-6f ? std::clamp(from[k] / slope, 0.0f, 1.0f) : 0.5f;
      std::array<float, 3> there;
      for (size_t j = 0; j < 3; ++j) there[j] = from[j] + way[k] * (to[j] - from[j]);
      off[k] = std::abs(model.joined(there));
      if (off[k] < off[best]) best = k;
    }
    // Grids often put a face on a plane of voxels: there an edge within the face has its crossing anywhere. It belongs
    // to the face that it passes through, with all the cells around it.
    const float least = off[best];
    float across = -1;
    for (size_t k = 0; k < count; ++k) {
      const Vec3f& g = model.face[k].gradient;
      const float passes = std::abs(g[edge.axis]) + g.dot(kAnyTilt);
      if (off[k] <= least + kSame && passes > across) {
        across = passes;
        best = k;
      }
    }
    bool firm = true;
    for (size_t k = 0; k < count; ++k) {
      if (off[k] <= off[best] + std::max(tie, kCornerTie)) atCorner |= 1u << k;
      if (k != best && off[k] <= off[best] + tie) firm = false;
    }
    found.faces |= 1u << best;
    if (firm) found.firm |= 1u << best;
    found.of[e] = static_cast<int8_t>(best);
    found.at[e] = cell.low + Vec3f(static_cast<float>(edge.from >> 2), static_cast<float>((edge.from >> 1) & 1),
                                   static_cast<float>(edge.from & 1));
    found.at[e][edge.axis] += way[best];
    found.middle += found.at[e];
  }
  if (atCorner == 7) found.faces = 7;
  found.middle *= 1 / static_cast<float>(std::popcount(edges));
  return found;
}

Crossings crossingsBeyond(CellView& cell, const Crossings& crossings, int door, const CreaseModel& model, float tie) {
  const auto e = static_cast<size_t>(std::countr_zero(static_cast<unsigned>(tables().around[door] & crossings.edges)));
  const int shared = tables().edge[kCellEdges[e].from ^ (4 >> (door / 2))][kCellEdges[e].axis];
  cell = cell.beyond(door);
  // A folded face read the other way is rare enough to be taken as it is not.
  const CellCase& c = cellCases().separated[cell.pattern()];
  uint16_t edges = 0;
  for (int other = 0; other < 12; ++other)
    if (((c.edges >> other) & 1) && c.loopOfEdge[other] == c.loopOfEdge[shared])
      edges = static_cast<uint16_t>(edges | 1 << other);
  return crossingsOf(cell, edges, model, tie);
}

unsigned contested(const CellView& cell, const Crossings& crossings, const CreaseModel& model, float tie) {
  unsigned others = 0;
  for (int door = 0; door < 6; ++door) {
    if ((tables().around[door] & crossings.edges) == 0) continue;
    CellView next = cell;
    const Crossings there = crossingsBeyond(next, crossings, door, model, tie);
    if ((there.firm & crossings.faces) == 0) others |= there.firm;
  }
  return others;
}

float placeAlong(const CellView& cell, const Crossings& crossings, const CreaseModel& model,
                 const CreaseModel::Line& line, int a, int b) {
  const auto placeOf = [&](const Crossings& c) { return line.along.dot(c.middle - line.start); };
  const float here = placeOf(crossings);
  const unsigned doors = doorsOf(crossings, a, b);
  if (std::popcount(doors) != 2) return here;
  // The mean over two cells before and two after it on the crease's way; where that ends, the last counts for the rest.
  float sum = here;
  for (unsigned first = doors; first != 0; first &= first - 1) {
    int door = std::countr_zero(first);
    CellView at = cell;
    Crossings now = crossings;
    for (int step = 0; step < 2; ++step) {
      if (door >= 0) {
        now = crossingsBeyond(at, now, door, model, 0);
        const unsigned on = doorsOf(now, a, b) & ~(1u << (door ^ 1));
        door = std::popcount(on) == 1 ? std::countr_zero(on) : -1;
      }
      sum += placeOf(now);
    }
  }
  return sum * 0.2f;
}

}  // namespace argil::clay
