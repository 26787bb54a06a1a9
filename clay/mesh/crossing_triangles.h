#pragma once
// Triangles of a mesh that cross each other.

#include <cstdint>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

inline constexpr uint64_t kMostCrossings = 1'000'000;  ///< Counting ends there.

/// Counts the pairs of triangles that have a line in common which is no edge of both: each has corners on both sides of
/// the other's plane. Triangles that only touch, or lie in one plane, do not count, nor does what rounding the
/// coordinates to 32 bits would explain. At most kMostCrossings. Deterministic. Indices must be in range. Takes a tree
/// of boxes: about 1 µs a triangle and 0.2 µs a pair whose boxes meet, on all cores. Throws Cancelled.
[[nodiscard]] uint64_t countCrossings(const TriangleMesh& mesh, Job* job = nullptr);

}  // namespace argil::clay
