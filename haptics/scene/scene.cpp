#include "haptics/scene/scene.h"

#include <cmath>
#include <string>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

void require(bool good, const char* what) {
  if (!good) throw Error(std::string("scene for the servo: ") + what);
}

bool rigid(const Pose& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite() &&
         std::abs(pose.rotation.norm() - 1) < 1e-6;
}

bool positive(double value, double most) {
  return std::isfinite(value) && value > 0 && value <= most;
}

}  // namespace

void Scene::check() const {
  require(pieces.size() <= kMaxPieces, "more than 64 pieces");
  for (const Piece& piece : pieces) {
    require(static_cast<bool>(piece.version), "a piece holds no clay");
    require(rigid(piece.pose), "the pose of a piece is not finite or its quaternion not of unit length");
    require(piece.material < materials.size(), "a piece names a material that is not there");
    if (!piece.rows) continue;
    for (const uint16_t row : *piece.rows)
      require(row < materials.size(), "a row of a piece's materials names one that is not there");
  }
  require(parts.size() <= kMaxParts, "more than 64 parts");
  for (const Part& part : parts) {
    require(part.mesh != nullptr, "a part holds no mesh");
    require(rigid(part.pose), "the pose of a part is not finite or its quaternion not of unit length");
    require(part.material < materials.size(), "a part names a material that is not there");
  }
  require(guides.size() <= kMaxGuides, "more than 64 guides");
  size_t atPieces = 0;
  for (size_t i = 0; i < guides.size(); ++i) {
    guides[i].check();
    require(guides[i].piece() < static_cast<int64_t>(pieces.size()), "a guide names a piece that is not there");
    atPieces += guides[i].piece() >= 0;
    require(atPieces <= kMaxPieceGuides, "more than 4 guides name a piece");
    for (size_t j = 0; j < i; ++j) require(guides[j].id != guides[i].id, "two guides have the same id");
  }
  for (const Material& m : materials) {
    require(positive(m.stiffnessNmm, 1e4), "a stiffness must be above 0 and at most 10 000 N/mm");
    require(positive(m.hardnessNmm2, 1e6), "a hardness must be above 0 and at most 1e6 N/mm²");
    require(positive(m.viscosityNsmm, 1e6), "a viscosity must be above 0 and at most 1e6 N·s/mm");
    require(std::isfinite(m.dragNsmm) && m.dragNsmm >= 0, "drag must not be negative");
    require(m.dynamicFriction >= 0 && m.dynamicFriction <= m.staticFriction && m.staticFriction <= 4,
            "friction must be 0 to 4, sliding no more than sticking");
    require(std::isfinite(m.viscousFrictionNsmm) && m.viscousFrictionNsmm >= 0,
            "viscous friction must not be negative");
    require(m.texture < static_cast<int64_t>(textures.size()) && (m.texture < 0 || textures[size_t(m.texture)]),
            "a material names a texture that is not there");
  }
  require(quality.contactSteps >= 1 && quality.contactSteps <= 64, "contact steps must be 1 to 64");
  require(quality.contactSearches >= 4 && quality.contactSearches <= 200, "contact searches must be 4 to 200");
  require(positive(tool.radiusMm, 1e6), "the tool's radius must be above 0");
  workspace.check();
}

}  // namespace argil::haptics
