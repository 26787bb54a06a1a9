#pragma once
// Fits two or three curved faces to the distances around a rim.

namespace argil::clay {

inline constexpr int kMostRimVoxels = 320, kMostRimFaces = 3;

/// Voxels beside the surface around a rim: positions in voxels from a place near it, and signed distances.
struct RimVoxels {
  int count = 0;
  alignas(64) float x[kMostRimVoxels], y[kMostRimVoxels], z[kMostRimVoxels], phi[kMostRimVoxels];
};

/// A plane, cylinder or ball near a place, or what lies between them. With d = p − origin, h = d · normal, b = bend · d
/// (a symmetric matrix whose null space is the normal), q = d · b, w = b · b and k = w / q, the signed distance of p is
/// (2h + kh² + q) / (1 + √((1 + kh)² + w)).
struct RimFace {
  float origin[3] = {}, normal[3] = {};  ///< A point on the face; unit, outwards.
  float bend[6] = {};                    ///< xx, yy, zz, xy, yz, zx, per voxel.
};

/// The solid beside a rim: its distance is `outer`(face 0, `inner`(face 1, face 2)), where outer and inner are a
/// maximum (a convex rim) or a minimum (a concave one). With two faces it is `outer`(face 0, face 1).
struct RimFit {
  int faces = 2;  ///< 2 or 3.
  RimFace face[kMostRimFaces];
  bool outerConvex = false, innerConvex = false;
  float misfit = 0;  ///< Weighted RMS of what the faces leave of the voxels, voxels.
  float worst = 0;   ///< The most that they leave of those near the place, voxels.
};

/// How far from the place voxels count.
struct RimFitRange {
  float near;    ///< RimFit::worst looks up to here, voxels.
  float fading;  ///< A voxel d voxels away counts 1 / (1 + fading · d²)².
};

/// Fits the faces by weighted least squares, from planes (`fit.face`: origin and normal). A voxel belongs to the face
/// whose distance the solid has there; faces move, turn and bend until that holds. False where a face has too few
/// voxels. Writes behind the last voxel. Equal bits on all targets. O(voxels) a round, at most five rounds.
[[nodiscard]] bool fitRim(RimVoxels& voxels, const RimFitRange& range, RimFit& fit) noexcept;

/// The distances of a face at the eight corners of a cell (corner c at low + (c >> 2, c >> 1 & 1, c & 1)).
void cornerDistances(const RimFace& face, const float (&low)[3], float (&out)[8]) noexcept;

}  // namespace argil::clay
