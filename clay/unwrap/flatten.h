#pragma once
// A piece of surface laid flat.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "clay/base/vec.h"
#include "clay/base/work_part.h"

namespace argil::clay {

using Vec2d = Eigen::Vector2d;

/// A disk of triangles: connected, no handles, one boundary that passes each vertex once.
struct SurfaceDisk {
  std::vector<Vec3d> positions;                    ///< mm.
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Counter-clockwise seen from outside.
  std::vector<uint32_t> boundary;                  ///< Vertices in order, the surface on their left.
};

struct FlatDisk {
  std::vector<Vec2d> places;  ///< mm; all triangles counter-clockwise, together of the surface's area.
  /// How much longer than on the flat a length on the surface is, as RMS over the surface and all directions: 1 where
  /// nothing is stretched or squeezed (Sander and others 2001, L2).
  double stretch = 1;
  [[nodiscard]] bool operator==(const FlatDisk&) const = default;
};

/// Lays a disk flat without a fold: first inside a circle (Tutte 1963), then as near to its lengths as it comes
/// (symmetric Dirichlet energy; Rabinovich and others 2017). None where numbers do not suffice: parts that are long and
/// thin vanish in the circle. Cost: about 1 µs a triangle and round. One thread.
[[nodiscard]] std::optional<FlatDisk> laidFlat(const SurfaceDisk& disk, int rounds);

/// Does the outline pass over itself? An outline that does not, around triangles without a fold, has nothing that lies
/// on anything else.
[[nodiscard]] bool crossesItself(const std::vector<Vec2d>& places, const std::vector<uint32_t>& boundary);

}  // namespace argil::clay
