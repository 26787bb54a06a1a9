#pragma once
// Makes the triangles of a file agree with each other on what is outside, and says what was wrong with them.

#include <cstdint>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// What was wrong with a mesh. Edges are counted after welding and after repeated faces went.
struct MeshFindings {
  uint64_t triangles = 0;   ///< As given.
  uint64_t degenerate = 0;  ///< Without area.
  /// Left out: a face again on the same three corners, or a face and its back cancelling.
  uint64_t duplicateFaces = 0;
  uint64_t boundaryEdges = 0;      ///< In one face.
  uint64_t nonManifoldEdges = 0;   ///< In more than two faces.
  uint64_t inconsistentEdges = 0;  ///< Between two faces that disagree on what is outside.
  uint64_t flippedFaces = 0;       ///< Turned around to agree with the rest of their body.
  uint64_t bodies = 0;             ///< Sets of faces that hang together through corners.
  uint64_t flippedBodies = 0;      ///< Closed bodies that were inside out (a cavity in another body is not).
  bool flippedWhole = false;       ///< All of it was inside out.
  uint64_t crossings = 0;          ///< Pairs of triangles that cross; kMostCrossings or more are not told apart.
  double backedShare = 1;  ///< Share of the area that clearly has an inside behind it: 1 when closed, 0 for a sheet.

  /// Closed, edge-manifold and consistent as given: nothing had to be decided.
  [[nodiscard]] bool sound() const {
    return !boundaryEdges && !nonManifoldEdges && !inconsistentEdges && !flippedBodies;
  }
};

/// A directed edge that the triangles run along `times` more often than against: the rim of a hole lies to its left.
struct OpenEdge {
  uint32_t from = 0, to = 0;
  uint32_t times = 1;
};

struct RepairedMesh {
  TriangleMesh mesh;                ///< Welded, faces three different corners, oriented outwards as far as it can be.
  std::vector<OpenEdge> openEdges;  ///< Empty exactly when the winding number is an integer everywhere.
  MeshFindings findings;
};

/// Steps and rules: NOTES.md, "Steps". Deterministic. O(n log n) and, for each closed body that is inside out,
/// one sum over its own triangles. Throws nothing for defective input, Cancelled when the job was; indices must be in
/// range.
[[nodiscard]] RepairedMesh repairMesh(const TriangleMesh& mesh, Job* job = nullptr);

}  // namespace argil::clay
