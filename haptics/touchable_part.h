#pragma once
// A mesh part of a scene as something to touch.

#include <cstdint>

#include "haptics/part_mesh.h"
#include "haptics/touchable.h"

namespace argil::haptics {

/// The nearest point on the triangles, from both faces: distances are never negative. Gaps narrower than a ball hold it, because
/// its centre is never let nearer to the rims than its radius. Servo thread only.
class TouchablePart final : public Touchable {
 public:
  /// Reads `part` from now on; the scene that holds it is held by the caller. True when it is not what was read before.
  bool reset(const Part& part) ARGIL_REALTIME;
  Nearest nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME override;

  /// Zero at a crease (edges sharper than 40°, borders, edges of more than two triangles).
  Vec3d normal(const Vec3d& point) ARGIL_REALTIME override;
  [[nodiscard]] double resolutionMm() const ARGIL_REALTIME override { return mesh_ ? mesh_->resolutionMm() : 1.0; }

 private:
  const PartMesh* mesh_ = nullptr;
  uint64_t number_ = 0;  // Addresses of meshes are reused.
  Pose pose_;
  uint32_t last_ = PartMesh::kNone;  // The triangle of the last answer: a better hint than any point.
};

}  // namespace argil::haptics
