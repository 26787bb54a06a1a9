#pragma once
// A mesh part of a scene as something to touch.

#include <array>
#include <cstdint>

#include "haptics/scene/part_mesh.h"
#include "haptics/scene/touchable.h"

namespace argil::haptics {

/// The nearest point on the triangles, from both faces: distances are never negative. Gaps narrower than a ball hold
/// it, because its centre is never let nearer to the rims than its radius. Servo thread only.
class TouchablePart final : public Touchable {
 public:
  /// Reads `part` from now on, touched by a ball of that radius; the scene that holds it is held by the caller. True
  /// when it is not the mesh that was read before. Where it is felt is for move() to say: the part's own pose is not
  /// looked at.
  bool reset(const Part& part, double radiusMm) ARGIL_REALTIME;
  /// It goes there as a rigid body: what is known of it goes along.
  void move(const Pose& to) ARGIL_REALTIME;
  /// Whether that part is the mesh that is read now.
  [[nodiscard]] bool reads(const Part& part) const ARGIL_REALTIME;
  Nearest nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME override;

  /// Zero at a crease (edges sharper than 40°, borders, edges of more than two triangles).
  Vec3d normal(const Vec3d& point) ARGIL_REALTIME override;
  /// The mesh's, but no more than an eighth of the ball's radius: a small ball on a large coarse part sinks in no
  /// deeper for it.
  [[nodiscard]] double resolutionMm() const ARGIL_REALTIME override { return resolution_; }

 private:
  const PartMesh* mesh_ = nullptr;
  uint64_t number_ = 0;  // Addresses of meshes are reused.
  Pose pose_;
  double resolution_ = 1;
  // The triangles of the last answers. The very last is a better hint than any point, and contacts ask for the normal
  // of what was found some searches ago.
  struct Answer {
    Vec3d point = Vec3d::Zero();
    uint32_t triangle = PartMesh::kNone;
  };
  std::array<Answer, 16> answers_;
  size_t last_ = 0;
};

}  // namespace argil::haptics
