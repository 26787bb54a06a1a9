#pragma once
// Fewer triangles for the same shape.

#include <cstdint>
#include <optional>

#include "clay/job.h"
#include "clay/triangle_mesh.h"

namespace argil::clay {

struct ReduceOptions {
  std::optional<uint64_t> triangles;  ///< At most so many; or
  std::optional<double> errorMm;      ///< as few as keep both deviations within this. Exactly one is given.
};

/// How far two surfaces lie apart, mm: measured from vertices, edges' and triangles' inner points of the one to the nearest point of the other.
struct Deviation {
  double toReducedMm = 0;     ///< The most, from the original to the reduced.
  double fromReducedMm = 0;   ///< The most, from the reduced to the original.
  double rmsMm = 0;           ///< Of both.
  uint64_t points = 0;
  [[nodiscard]] double most() const { return toReducedMm > fromReducedMm ? toReducedMm : fromReducedMm; }
};

struct Reduced {
  TriangleMesh mesh;
  Deviation deviation;
};

/// A closed 2-manifold stays one, of the same bodies and genus; nothing is turned inside out. Throws Error for a target that cannot be met (says what can), Cancelled.
[[nodiscard]] Reduced reduce(const TriangleMesh& mesh, const ReduceOptions& options, Job* job = nullptr);

[[nodiscard]] Deviation deviation(const TriangleMesh& original, const TriangleMesh& other, Job* job = nullptr);

}  // namespace argil::clay
