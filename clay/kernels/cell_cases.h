#pragma once
// Which vertices a dual cell has, for each of its 256 corner patterns.

#include <array>
#include <cstdint>

namespace argil::clay {

/// Corner c of a cell lies at (c >> 2, (c >> 1) & 1, c & 1); bit c of a pattern says that it is inside.
/// Edge axis·4 + u·2 + v runs along `axis` at u on the axis after it and v on the one after that (x → y → z → x).
struct CellEdge {
  uint8_t from, to;  ///< Corners; `to` is one step along `axis`.
  uint8_t axis;
};
extern const std::array<CellEdge, 12> kCellEdges;

/// Where the surface crosses a cell: each closed loop of crossed edges, linked through the cell's faces, is one vertex.
struct CellCase {
  uint16_t edges = 0;           ///< Bit e: edge e is crossed.
  uint8_t loops = 0;            ///< 0 to 4.
  uint8_t loopOfEdge[12] = {};  ///< For crossed edges.
  /// The ambiguous face whose two segments belong to one loop, as axis·2 + side; −1 when there is none. If the cell
  /// beyond that face has the same trouble there, both read the face the other way (`joined`), or an edge would get
  /// four quads.
  int8_t foldedFace = -1;

  /// The crossed edges of a loop, as bits.
  [[nodiscard]] constexpr uint16_t edgesOf(int loop) const noexcept {
    unsigned of = 0;
    for (int e = 0; e < 12; ++e) of |= static_cast<unsigned>(loopOfEdge[e] == loop) << e;
    return static_cast<uint16_t>(edges & of);
  }
};

/// The rule for ambiguous faces: inside corners are separated (`separated`), except for a face folded on both sides.
struct CellCases {
  std::array<CellCase, 256> separated;
  std::array<CellCase, 256> joined;  ///< With foldedFace read the other way; meaningful where separated has one.
};
/// Built once, from the rule. Thread-safe.
const CellCases& cellCases();

}  // namespace argil::clay
