#include "clay/kernels/cell_cases.h"

#include <bit>
#include <cstddef>

namespace argil::clay {

namespace {

// Corner at value a, u, v on `axis`, the axis after it and the one after that.
constexpr int cornerAt(int axis, int a, int u, int v) {
  int at[3] = {};
  at[axis] = a;
  at[(axis + 1) % 3] = u;
  at[(axis + 2) % 3] = v;
  return at[0] * 4 + at[1] * 2 + at[2];
}

constexpr std::array<CellEdge, 12> makeEdges() {
  std::array<CellEdge, 12> edges{};
  for (int axis = 0; axis < 3; ++axis)
    for (int u = 0; u < 2; ++u)
      for (int v = 0; v < 2; ++v)
        edges[static_cast<std::size_t>(axis * 4 + u * 2 + v)] = {static_cast<uint8_t>(cornerAt(axis, 0, u, v)),
                                                                 static_cast<uint8_t>(cornerAt(axis, 1, u, v)),
                                                                 static_cast<uint8_t>(axis)};
  return edges;
}

constexpr int edgeBetween(int a, int b) {
  const auto edges = makeEdges();
  for (int e = 0; e < 12; ++e)
    if ((edges[static_cast<std::size_t>(e)].from == a && edges[static_cast<std::size_t>(e)].to == b) ||
        (edges[static_cast<std::size_t>(e)].from == b && edges[static_cast<std::size_t>(e)].to == a))
      return e;
  return -1;
}

// Follows the segments that the faces put between crossed edges. `joinedFace` reads that ambiguous face the other way.
CellCase trace(int pattern, int joinedFace) {
  const auto inside = [pattern](int corner) { return ((pattern >> corner) & 1) != 0; };
  CellCase result;
  int links[12][2];
  int count[12] = {};
  const auto link = [&](int a, int b) {
    links[a][count[a]++] = b;
    links[b][count[b]++] = a;
  };
  struct Folded {
    int face, a, b;
  };
  Folded ambiguous[6];
  int ambiguousCount = 0;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face & 1;
    const int corner[4] = {cornerAt(axis, side, 0, 0), cornerAt(axis, side, 1, 0), cornerAt(axis, side, 1, 1),
                           cornerAt(axis, side, 0, 1)};
    int edge[4], crossed[4], n = 0;  // edge[i] between corners i and i + 1
    for (int i = 0; i < 4; ++i) {
      edge[i] = edgeBetween(corner[i], corner[(i + 1) & 3]);
      if (inside(corner[i]) != inside(corner[(i + 1) & 3])) crossed[n++] = edge[i];
    }
    if (n == 2) link(crossed[0], crossed[1]);
    if (n == 4) {
      // A segment cuts off each inside corner, or each outside corner where the face is joined.
      const bool cutInside = face != joinedFace;
      for (int i = 0; i < 4; ++i)
        if (inside(corner[i]) == cutInside) link(edge[i], edge[(i + 3) & 3]);
      ambiguous[ambiguousCount++] = {face, edge[0], edge[2]};
    }
  }
  for (int e = 0; e < 12; ++e)
    if (count[e] > 0) result.edges = static_cast<uint16_t>(result.edges | (1 << e));
  uint16_t left = result.edges;
  while (left != 0) {
    int at = std::countr_zero(left), before = -1;
    while ((left >> at) & 1) {
      left = static_cast<uint16_t>(left & ~(1 << at));
      result.loopOfEdge[at] = result.loops;
      const int next = links[at][0] != before ? links[at][0] : links[at][1];
      before = at;
      at = next;
    }
    ++result.loops;
  }
  // Opposite edges of an ambiguous face lie on different segments.
  for (int i = 0; i < ambiguousCount; ++i)
    if (result.loopOfEdge[ambiguous[i].a] == result.loopOfEdge[ambiguous[i].b])
      result.foldedFace = static_cast<int8_t>(ambiguous[i].face);
  return result;
}

}  // namespace

const std::array<CellEdge, 12> kCellEdges = makeEdges();

const CellCases& cellCases() {
  static const CellCases cases = [] {
    CellCases made;
    for (int pattern = 0; pattern < 256; ++pattern) {
      const auto i = static_cast<std::size_t>(pattern);
      made.separated[i] = trace(pattern, -1);
      made.joined[i] =
          made.separated[i].foldedFace >= 0 ? trace(pattern, made.separated[i].foldedFace) : made.separated[i];
    }
    return made;
  }();
  return cases;
}

}  // namespace argil::clay
