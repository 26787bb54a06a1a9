#pragma once
// Hierarchy of discs over triangles: what makes the nearest point of a mesh part cheap.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/job.h"
#include "clay/base/vec.h"

namespace argil::haptics {

/// Corners of one triangle, mm, from the part's middle.
using PartTriangle = std::array<Vec3f, 3>;

/// Up to four children, each bounded by a disc: a cylinder of radius `radius` and half height `half` around `centre`
/// along the unit vector `axis`. On a surface a disc hugs its triangles where a box would stand off by its slope, and a
/// ball that touches the surface meets few discs but many boxes.
struct PartNode {
  using Four = Eigen::Array4f;
  std::array<Four, 3> centre, axis;
  Four half, radius;             ///< Endless distance is told by `radius` below zero: no child.
  std::array<int32_t, 4> child;  ///< At least 0: a node; below: ~(first · 4 + count − 1) of a run of triangles.
};

inline constexpr size_t kMaxPartTriangles = size_t{1} << 28;
inline constexpr int kMaxPartDepth = 72;  ///< Nodes from the root to a leaf, whatever the triangles.

/// Nodes, the root first, and the order that brings the triangles of a leaf together.
struct PartTree {
  std::vector<PartNode> nodes;
  std::vector<uint32_t> order;
};

/// At least one triangle, at most kMaxPartTriangles, finite. Binned surface area heuristic (Wald 2007), leaves of at
/// most four. Reports progress from `from` to 1 to `job`. Cost: about 0.8 µs a triangle.
[[nodiscard]] PartTree buildPartTree(const std::vector<PartTriangle>& triangles, Job& job, double from);

}  // namespace argil::haptics
