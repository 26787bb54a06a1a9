#pragma once
// The deform box: what the person has set about a piece that is being deformed. Plain state; deforming.h does the work.

#include <memory>
#include <string>
#include <vector>

#include "clay/store/version.h"
#include "clay/whole/lattice.h"
#include "engine/document/document.h"

namespace argil::studio {

struct DeformBox {
  enum class Kind : uint8_t { lattice, bend, twist, taper };

  engine::Id piece = 0;
  haptics::Pose pose;  ///< Of the piece.
  clay::Version base;  ///< The clay as it was when the box was put around it: everything is done to this one.
  clay::BoxMm bounds;  ///< Of that clay, mm of the piece.
  Kind kind = Kind::lattice;
  clay::Lattice lattice;  ///< mm of the piece.
  /// For each point of the lattice the place of the clay below it, towards the middle of the box: what a drag of the
  /// point is to move.
  std::vector<Vec3d> clayPlaces;

  // Of bend, twist and taper
  int axis = 2;                             ///< x, y, z of the piece.
  double fromPercent = 0, toPercent = 100;  ///< Of the piece's extent along the axis.
  double bendDegrees = 0, bendTowards = 0;  ///< Below a full turn; direction about the axis, 0 to 360.
  double twistDegrees = 0;
  double taperPercent = 100;  ///< Width at the end.

  // Between panel, widget and worker
  bool held = false;                   ///< A slider is in the hand: the clay waits.
  bool apply = false, cancel = false;  ///< Asked for.
  double progress = -1;                ///< Of the clay that is on its way; below 0: none is.
  std::string trouble = {};            ///< Why the clay does not follow; empty: it does.

  /// Around a piece of the document, nothing moved. The piece exists and holds clay.
  [[nodiscard]] static DeformBox around(const engine::Piece& piece);
  /// As many points along each axis; those that were moved go back to their places.
  void setCounts(const std::array<int, 3>& counts);
  /// All back to where it was.
  void rest();
  /// What all of its tabs do together, the lattice first; null where nothing is moved.
  [[nodiscard]] std::shared_ptr<const clay::Warp> warp() const;
  /// The same without the lattice: what is done to a point of it after that.
  [[nodiscard]] std::shared_ptr<const clay::Warp> warpAfterLattice() const;
  /// It asks for the same clay.
  [[nodiscard]] bool sameShape(const DeformBox& other) const;
};

}  // namespace argil::studio
