#pragma once
// Triangle meshes become clay, sound or not.

#include <memory>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/import/mesh_losses.h"
#include "clay/import/mesh_repair.h"
#include "clay/mesh/triangle_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

struct ImportOptions {
  Grid grid;  ///< Voxel size and band; the origin too when `placeOrigin` is false.
  /// Chooses the origin, a multiple of the voxel size, so that the mesh begins near voxel (16, 16, 16).
  bool placeOrigin = true;
  int threads = 0;  ///< 1 to 64; 0 for all cores.
};

/// What was found and what was done about it.
struct ImportReport : MeshFindings {
  bool windingUsed = false;   ///< Not one sound body: the inside is where the winding number exceeds a half.
  uint64_t closingEdges = 0;  ///< Voxel edges through the surface that closes holes; 0 when nothing was closed.
  double closedMm2 = 0;       ///< Area of that surface, about.
  /// Voxels whose nearest triangle bounds no inside: inner walls, fins, walls thinner than a voxel.
  uint64_t droppedVoxels = 0;
  uint64_t bandVoxels = 0;  ///< Voxels nearer to the surface than the band.
  MeshLosses losses;        ///< What the clay has, or has not, beside the mesh.
  double voxelMm = 0;       ///< Of the clay.

  /// For a person: what was wrong and what was done; one sentence at least.
  [[nodiscard]] std::vector<std::string> sentences() const;
};

struct Imported {
  Version version;
  ImportReport report;
};

/// The solid that the mesh (in mm) bounds, as clay: a full narrow band of distances to its surface, the interior solid.
/// Holes are closed where the winding number is a half, faces that disagree are turned, repeated ones dropped,
/// overlapping bodies united, specks that sampling leaves of something thinner than a voxel taken out; a body inside
/// out within another is a cavity. Features thinner than a voxel may go. Throws Error for a mesh without triangles, an
/// open sheet that has no inside, a voxel too fine (more than 65 536 along an axis, or 2^28 in the band) or too coarse,
/// an origin out of range; each names what would do. Cancelled when the job was. Off the real-time threads. Cost
/// follows the surface in voxels²; about 80 bytes a voxel of the band while it works.
[[nodiscard]] Imported meshToClay(std::shared_ptr<Store> store, const TriangleMesh& mesh, const ImportOptions& options,
                                  Job* job = nullptr);

/// A voxel size, in mm to three digits, with which the mesh's longest side takes about `longestInVoxels` (1 to 65 000).
/// Throws Error for a mesh without extent.
[[nodiscard]] double suggestVoxelMm(const TriangleMesh& mesh, int longestInVoxels = 256);

}  // namespace argil::clay
