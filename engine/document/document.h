#pragma once
// All that a person makes: pieces of clay, parts, guides, symmetry. A value: a change makes a new one that shares the
// clay of the old.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/mesh/triangle_mesh.h"
#include "clay/store/version.h"
#include "engine/document/quality.h"
#include "engine/document/stroke_images.h"
#include "haptics/scene/scene.h"

namespace argil::haptics {
class PartMesh;
}

namespace argil::engine {

/// Names an object for the life of its document; 0 is none, and no number is used twice.
using Id = uint32_t;

/// What every object of a document has.
struct Thing {
  Id id = 0;
  std::string name;
  bool visible = true;  ///< Hidden things are not felt either.
  bool locked = false;  ///< Neither edited nor moved; still felt.
};

/// A row of a piece's materials.
struct MaterialRow {
  std::string name;
  haptics::Material material;                  ///< Material::texture is not used here.
  std::optional<std::array<float, 3>> colour;  ///< sRGB.
  friend bool operator==(const MaterialRow&, const MaterialRow&) = default;
};
/// Of a piece: clay::Channel::material 1 to 254. 255 is unseen clay, which feels like the piece itself.
inline constexpr size_t kMaxMaterialRows = 254;

/// A clay of its own voxel size and place.
struct Piece : Thing {
  clay::Version version;
  haptics::Pose pose;                  ///< From the piece's millimetres to the world's.
  Vec3d fileOffsetMm = Vec3d::Zero();  ///< From here to where the imported file had it: export can put it back.
  std::array<float, 3> colour{0.80f, 0.62f, 0.50f};  ///< sRGB.
  haptics::Material material;                        ///< How it feels; Material::texture is not used here.
  /// How voxels feel whose clay::Channel::material is 1, 2, ...; a row that is not there feels like the piece itself.
  std::vector<MaterialRow> materials;
  bool hideMasked = false;  ///< Where the mask is above 127 clay is neither seen nor felt; see hideMasked().
};

/// sRGB bytes of a colour; and of the piece's materials, row by row, where they have one.
[[nodiscard]] std::array<uint8_t, 3> bytesOf(const std::array<float, 3>& colour);
[[nodiscard]] std::vector<std::optional<std::array<uint8_t, 3>>> materialColours(const Piece& piece);

/// The piece with its masked part (mask above 127) hidden; that part is masked whole, so no tool changes it. Half masks
/// of 127 and less stay as they are. O(masked clay).
[[nodiscard]] Piece hideMasked(Piece piece);

/// A mesh that stays as it is: seen and felt, not edited.
struct Part : Thing {
  std::shared_ptr<const clay::TriangleMesh> mesh;  ///< mm.
  /// Null until it has been built in the background: seen, not yet felt.
  std::shared_ptr<const haptics::PartMesh> felt;
  haptics::Pose pose;
  std::array<float, 3> colour{0.55f, 0.60f, 0.68f};
  haptics::Material material;
};

/// Construction geometry and measures, world mm.
struct Guide : Thing {
  enum class Kind : uint8_t {
    plane,       ///< Through the pose's place, normal to its z.
    line,        ///< Through the pose's place along its z.
    point,       ///< The pose's place.
    curve,       ///< Smooth through pointsMm.
    keepOutBox,  ///< Centred on the pose, edges sizeMm.
    ruler,       ///< From pointsMm[0] to [1]: shows the distance.
    angle,       ///< At pointsMm[1] between [0] and [2].
  };
  enum class Feel : uint8_t {
    seen,     ///< Not felt. Rulers and angles always are.
    lock,     ///< Holds the tool's centre on it.
    well,     ///< Attracts the tool within rangeMm.
    keepOut,  ///< The tool's ball may not enter (box) or go below (plane).
  };
  Kind kind = Kind::plane;
  Feel feel = Feel::seen;
  haptics::Pose pose;
  Vec3d sizeMm{40, 40, 40};        ///< What is drawn of a plane (x, y) or a line (z); edges of a box.
  std::vector<Vec3d> pointsMm;     ///< Of curve (2 at least), ruler (2), angle (3).
  bool closed = false;             ///< Of a curve.
  double rangeMm = 5, forceN = 1;  ///< Of a well.

  [[nodiscard]] Vec3d axis() const { return pose.rotation * Vec3d::UnitZ(); }
};

/// Strokes are repeated as mirror images, once for each plane, twice more for both, and so on; and around the pose's z
/// axis.
struct Symmetry {
  bool x = false, y = false, z = false;  ///< Planes normal to the pose's axes, through its place.
  haptics::Pose pose;
  int turns = 1;  ///< 1 to kMostTurns.
  [[nodiscard]] bool any() const { return x || y || z || turns > 1; }
};

struct Document {
  std::vector<Piece> pieces;  ///< In the order of the list that the person sees.
  std::vector<Part> parts;
  std::vector<Guide> guides;
  Symmetry symmetry;
  StrokeQuality quality;  ///< Of strokes to come: each has its own with its tool.
  Id active = 0;          ///< The piece that is worked on; 0: none.
  Id nextId = 1;
  /// Documents that one stroke went through have the same number and differ in the clay of their active piece alone:
  /// with a thousand pieces there is one to look at. 0: says nothing. Session's.
  uint64_t stroke = 0;

  /// Null when there is none of that id.
  [[nodiscard]] const Piece* piece(Id id) const;
  [[nodiscard]] Piece* piece(Id id);
  [[nodiscard]] const Part* part(Id id) const;
  [[nodiscard]] Part* part(Id id);
  [[nodiscard]] const Guide* guide(Id id) const;
  [[nodiscard]] Guide* guide(Id id);
  [[nodiscard]] const Thing* thing(Id id) const;
  [[nodiscard]] Thing* thing(Id id);
  /// The piece that strokes work on: active, visible and not locked; else null.
  [[nodiscard]] const Piece* workedOn() const;

  /// Give a new id and, where the name is empty, a name such as "Plane 2"; a first piece becomes the active one. Return
  /// the id.
  Id add(Piece piece);
  Id add(Part part);
  Id add(Guide guide);
  /// Whatever it is. Another piece becomes active when the active one goes. False when there was none.
  bool remove(Id id);
  /// Moves a thing up (−1) or down (+1) in its list. False at the ends.
  bool reorder(Id id, int by);

  [[nodiscard]] StrokeImages images() const;

  /// A document of one piece named "Clay".
  static Document of(clay::Version version);
};
using DocumentPtr = std::shared_ptr<const Document>;

/// Fills pieces, parts, guides and materials of a scene from a document: what is visible. Pieces that are not worked on
/// are kept out of (felt, never cut). Of more pieces than a scene holds, the first are there; with `felt` those that it
/// names by their place in the list, in its order (engine/tools/felt_pieces.h). Guides of `base` stay before the
/// document's. Throws Error for what haptics refuses.
[[nodiscard]] haptics::Scene sceneOf(const Document& document, const haptics::Scene& base,
                                     const std::vector<size_t>* felt = nullptr);

/// What a guide is to the hand, under `id`; nothing when it is only seen. Throws Error for what haptics refuses.
[[nodiscard]] std::optional<haptics::Guide> felt(const Guide& guide, uint32_t id);

}  // namespace argil::engine
