#pragma once
// Planes, axes and middles of a CAD model's faces as construction guides.

#include <string>
#include <vector>

#include "clay/mesh/triangle_mesh.h"
#include "engine/document/document.h"
#include "io/models/model_file.h"

namespace argil::engine {

/// Guides are seen and snapped to, and felt only where the user says so later. Of faces that share a plane, an axis or
/// a middle the largest gives it.
class FaceGuides {
 public:
  static constexpr size_t kMost = 24;  ///< Of a model: those of the largest faces. More would hide what they are for.

  /// The faces of all objects, in their units.
  explicit FaceGuides(const std::vector<io::ModelObject>& objects);
  /// Places to be moved, turned and scaled along with the objects' vertices; no triangles.
  [[nodiscard]] clay::TriangleMesh& places() { return places_; }

  struct Made {
    std::vector<Guide> guides;  ///< World mm; "bracket: plane 1", the largest first.
    std::string note;           ///< A sentence for the person.
  };
  /// As the places are now. Cost: of the faces, each beside a thousand others at most.
  [[nodiscard]] Made make() const;

 private:
  struct Face {
    io::ModelFace face;
    std::string object;
  };
  std::vector<Face> faces_;
  clay::TriangleMesh places_;  // of each: at, a unit along, a unit across
};

}  // namespace argil::engine
