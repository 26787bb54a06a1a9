#pragma once
// Where the faces that meet near a cell cross: a corner, an edge, or beside them a face.

#include <array>
#include <cstdint>
#include <span>

#include "clay/base/vec.h"
#include "clay/kernels/crisp_kernels.h"
#include "clay/surface/crease_path.h"
#include "clay/surface/surface.h"
#include "clay/surface/tangent_plane.h"

namespace argil::clay {

/// 1 − the cosine of the angle between two unit vectors.
[[nodiscard]] inline float turn(const Vec3f& a, const Vec3f& b) {
  return 1 - a.dot(b);
}

/// A cell and what is known around it.
struct CreaseCell {
  Vec3f low;           ///< Its lowest corner, voxels.
  Vec3f draft;         ///< Its vertex in the draft.
  CellView view;       ///< Its field; `low` zero: models are in coordinates from its lowest corner.
  uint16_t edges = 0;  ///< Its crossed edges (of the vertex's loop), as clay/kernels/cell_cases.h numbers them.
  std::span<const TangentPlane> planes;  ///< Of the cells around it, in a fixed order.
};

struct CreaseVertex {
  enum class Kind { none, face, edge, corner } kind = Kind::none;
  Vec3f position;
  Vec3f normal;      ///< The mean of the faces'.
  float misfit = 0;  ///< Of the cell's values and flat faces, voxels.

  /// With the bit that says whether it stands on a crease.
  [[nodiscard]] PackedNormal packedNormal() const noexcept;
};

/// Groups the planes by normal into at most three faces, and puts the vertex where two or three of them meet in the
/// cell; if they meet outside, onto the face that it is on. `none` where fewer than two faces are told apart or where
/// the cell's own values contradict them. O(planes).
[[nodiscard]] CreaseVertex placeAtCrease(const CreaseCell& cell) noexcept;

}  // namespace argil::clay
