#pragma once
// Smooth normals of a mesh part, for force shading: what each corner of a triangle adds.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/job.h"
#include "haptics/scene/part_tree.h"

namespace argil::haptics {

/// Of one triangle: a unit normal at each corner, scaled to 16 bits (steps of 0.002°), and which of its edges and
/// corners are creases.
struct PartShading {
  static constexpr double kOne = 32767;
  std::array<std::array<int16_t, 3>, 3> normal{};  ///< All zero: a triangle without area.
  uint8_t creaseEdges = 7;                         ///< Bit i: the edge from corner i to the next.
  uint8_t creaseCorners = 7;  ///< Bit i: an edge around corner i is a crease, of this triangle or of another.

  [[nodiscard]] Vec3d at(size_t corner) const noexcept {
    return Vec3d(normal[corner][0], normal[corner][1], normal[corner][2]) / kOne;
  }
};

/// Normals at a corner are those of the triangles around it, weighted by their angles (Thürmer & Wüthrich 1998), as far
/// as they follow from one another over edges of exactly two triangles that meet at 40° or less. Every other edge is a
/// crease: sharper ones, borders, edges of three triangles and more. `corner[i]` names the vertices of triangle i:
/// equal places, equal names below `vertices`. Flipped neighbours count as if they were not. Reports progress up to
/// `to`. Cost: about 0.3 µs a triangle.
[[nodiscard]] std::vector<PartShading> shadeTriangles(const std::vector<PartTriangle>& triangles,
                                                      const std::vector<std::array<uint32_t, 3>>& corner,
                                                      size_t vertices, Job& job, double to);

}  // namespace argil::haptics
