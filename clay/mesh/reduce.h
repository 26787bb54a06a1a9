#pragma once
// Fewer triangles for the same shape.

#include <cstdint>
#include <optional>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

struct ReduceOptions {
  std::optional<uint64_t> triangles;  ///< At most so many; or
  std::optional<double> errorMm;      ///< as few as keep both deviations within this. Exactly one is given.
};

/// How far two surfaces lie apart, mm: from points spread over the one to the nearest point of the other, exact for
/// each point.
struct Deviation {
  double toReducedMm = 0;    ///< The most, from the original to the reduced.
  double fromReducedMm = 0;  ///< The most, from the reduced to the original.
  double rmsMm = 0;          ///< Of all points.
  /// Vertices, and on the triangles points between them: at least the middles and those of the edges.
  uint64_t points = 0;
  double spacingMm = 0;  ///< On the triangles that were looked at no place is farther than this from a point.
  /// Triangles of both that were not looked at, evenly spread: so many that 8 million points a side would not reach.
  uint64_t passedOver = 0;
  [[nodiscard]] double most() const { return toReducedMm > fromReducedMm ? toReducedMm : fromReducedMm; }
};

struct Reduced {
  TriangleMesh mesh;
  Deviation deviation;
};

/// A closed 2-manifold stays one, of the same bodies and genus; nothing is turned inside out. Throws Error for a target
/// that cannot be met (says what can), Cancelled.
[[nodiscard]] Reduced reduce(const TriangleMesh& mesh, const ReduceOptions& options, Job* job = nullptr);

[[nodiscard]] Deviation deviation(const TriangleMesh& original, const TriangleMesh& other, Job* job = nullptr);

}  // namespace argil::clay
