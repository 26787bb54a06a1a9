#pragma once
// A mesh of triangles as files hold it: no promise about topology.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// Positions in mm (or in file units until a unit was chosen). Triangles index `positions`, counter-clockwise seen from
/// outside. Who fills it promises finite positions and indices in range, nothing more: holes, duplicates and flipped
/// faces are allowed.
struct TriangleMesh {
  std::vector<Vec3d> positions;
  std::vector<std::array<uint32_t, 3>> triangles;
};

}  // namespace argil::clay
