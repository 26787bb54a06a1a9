#include "haptics/scene.h"

#include <cmath>
#include <string>

#include "clay/error.h"

namespace argil::haptics {
namespace {

void require(bool good, const char* what) {
  if (!good) throw Error(std::string("scene for the servo: ") + what);
}

bool rigid(const Pose& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6;
}

bool positive(double value, double most) { return std::isfinite(value) && value > 0 && value <= most; }

}  // namespace

void Scene::check() const {
  require(pieces.size() <= kMaxPieces, "more than 64 pieces");
  for (const Piece& piece : pieces) {
    require(static_cast<bool>(piece.version), "a piece holds no clay");
    require(rigid(piece.pose), "the pose of a piece is not finite or its quaternion not of unit length");
    require(piece.material < materials.size(), "a piece names a material that is not there");
  }
  for (const Material& m : materials) {
    require(positive(m.stiffnessNmm, 1e4), "a stiffness must be above 0 and at most 10 000 N/mm");
    require(positive(m.hardnessNmm2, 1e6), "a hardness must be above 0 and at most 1e6 N/mm²");
    require(positive(m.viscosityNsmm, 1e6), "a viscosity must be above 0 and at most 1e6 N·s/mm");
    require(std::isfinite(m.dragNsmm) && m.dragNsmm >= 0, "drag must not be negative");
    require(std::isfinite(m.friction) && m.friction >= 0, "friction must not be negative");
  }
  require(positive(tool.radiusMm, 1e6), "the tool's radius must be above 0");
  require(rigid(workspace.pose) && positive(workspace.scale, 1e6), "the workspace mapping is not finite");
}

}  // namespace argil::haptics
