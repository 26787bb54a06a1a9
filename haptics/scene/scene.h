#pragma once
// All that the servo reads in a tick: published whole, never changed.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "clay/store/version.h"
#include "haptics/base/pose.h"
#include "haptics/scene/guide.h"
#include "haptics/scene/workspace.h"

namespace argil::haptics {

class PartMesh;  // haptics/scene/part_mesh.h
class Texture;   // haptics/scene/texture.h

/// How a piece of clay feels. A row of a table.
struct Material {
  double stiffnessNmm = 1.0;       ///< Of the surface, N/mm; never rendered above the device's own limit.
  double hardnessNmm2 = 0.05;      ///< σ: pressure at which it yields to a cut, N/mm².
  double viscosityNsmm = 0.01;     ///< η: how slowly it yields, N·s/mm.
  double dragNsmm = 0.002;         ///< Against the motion of a tool that cuts, N·s/mm at full engagement.
  double staticFriction = 0;       ///< μ_s: a ball at rest stays while |f_t| ≤ μ_s |f_n|. 0 to 4.
  double dynamicFriction = 0;      ///< μ_d of a ball that slides; at most μ_s.
  double viscousFrictionNsmm = 0;  ///< b: drag of sliding on top, N·s/mm.
  int32_t texture = -1;            ///< Index into Scene::textures; none below zero.

  friend bool operator==(const Material&, const Material&) = default;
};

/// Which of Scene::materials each value of clay::Channel::material is.
using MaterialRows = std::array<uint16_t, 256>;

/// A clay model at its place in the world.
struct Piece {
  clay::Version version;  ///< Held by the scene: it lives as long as a reader can see it.
  Pose pose;              ///< From the version's millimetres to the world's.
  uint32_t material = 0;  ///< Index into Scene::materials.
  /// Clay whose mask is above 127 is not felt; from within, what is left of the surface is felt from behind.
  bool hideMasked = false;
  /// Null: all of it feels like `material`. Never read in clay without that channel.
  std::shared_ptr<const MaterialRows> rows = nullptr;
};

/// A mesh that is touched as it is, without being clay.
struct Part {
  std::shared_ptr<const PartMesh> mesh;  ///< Held by the scene; the publisher frees it.
  Pose pose;                             ///< From the mesh's millimetres to the world's.
  uint32_t material = 0;                 ///< Index into Scene::materials; hardness and viscosity mean nothing here.
};

/// How a tool that works on clay feels.
enum class Work : uint8_t {
  cut,  ///< Clay yields to it and is gone.
  lay,  ///< Clay grows behind it: nothing holds it back.
  rub,  ///< It works on the clay that it touches, the deeper the harder it is pressed.
};

/// What the hand holds: a ball.
struct Tool {
  uint32_t id = 0;  ///< Comes back in StylusSample::tool.
  double radiusMm = 3;
  std::optional<Work> work;  ///< None: only touches.
  uint32_t buttons = 1;      ///< It works while one of these buttons is down.
};

/// Where touch trades accuracy for speed.
struct Quality {
  int contactSteps = 8;  ///< Straight parts of the proxy's way in a tick, 1 to 64.
  /// Nearest-point searches in a tick, 4 to 200: bounds its cost; what is left is done in the next.
  int contactSearches = 20;
  /// Force directions from smooth normals instead of the facets between voxels or of triangles.
  bool smoothNormals = true;
  friend bool operator==(const Quality&, const Quality&) = default;
};

struct Scene {
  std::vector<Piece> pieces;
  /// So many pieces, counted from the first, are changed by the tool; the others are felt and never cut.
  size_t workedOn = SIZE_MAX;
  std::vector<Part> parts;
  std::vector<Guide> guides;
  std::vector<Material> materials{1};
  std::vector<std::shared_ptr<const Texture>> textures;
  Tool tool;
  Workspace workspace;
  Quality quality;
  /// Every sample with a smaller index was carved into the pieces as they stand here (StylusSample::index).
  uint64_t samplesApplied = 0;
  /// The oldest sample that waited when clay was changed to what stands here; UINT64_MAX when no sample changed it.
  /// From edit to feel.
  uint64_t editedFrom = UINT64_MAX;

  /// Throws Error when a number is not finite or out of range, or an index points nowhere. Call before publishing.
  void check() const;
};

inline constexpr size_t kMaxPieces = 64;  ///< In one scene.
inline constexpr size_t kMaxParts = 64;
inline constexpr size_t kMaxGuides = 64;

}  // namespace argil::haptics
