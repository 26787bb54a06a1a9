#pragma once
// An operation along a plane that is moved in the picture before it is done: Cut by plane, Mirror now.

#include <optional>
#include <string>
#include <vector>

#include "engine/tools/piece_jobs.h"

namespace argil::studio {

struct Context;

struct NamedPlane {
  std::string name;
  engine::MirrorPlane plane;
};
/// Returns the planes that a document offers: the selected guide first, then the planes of symmetry, those across the
/// axes through `middleMm`, the other guides.
[[nodiscard]] std::vector<NamedPlane> planesOf(const engine::Document& document, engine::Id selected,
                                               const std::optional<Vec3d>& middleMm);

/// The operation, its piece and its plane; the widget (ui3d/studio/widgets/plane_cut.cpp) moves the plane.
struct PlaneCut {
  const engine::PieceJob* job = nullptr;
  engine::PieceArguments arguments;  ///< One piece; the plane in world mm.
  Vec3d middleMm = Vec3d::Zero();    ///< Of the piece's bounding box, world.
  double halfMm = 1;                 ///< Half of that box's diagonal.
  bool apply = false, cancel = false;

  /// Begins with the selected plane guide, else across the piece's longest side through its middle.
  [[nodiscard]] static PlaneCut of(const engine::PieceJob& job, const engine::Document& document,
                                   const engine::Piece& piece, engine::Id selected);
  /// Returns whether the operation lets the user choose which side stays.
  [[nodiscard]] bool choosesSide() const;
  /// Returns the side that stays: +1 what the normal points to, −1 the other, 0 both.
  [[nodiscard]] int kept() const;
  /// Keeps the other side: turns the plane round, or what is kept of it.
  void keepOther();
  /// Distance of the plane from the middle of the piece, along its normal.
  [[nodiscard]] double offsetMm() const;
  void setOffset(double mm);
  [[nodiscard]] std::string hint() const;
};

/// Whether an operation is asked about in the picture.
[[nodiscard]] bool placesPlane(const engine::PieceJob& job);
/// Begins with the selected piece, else the one that is worked on; says so where it cannot be changed.
void beginPlaneCut(Context& context, const engine::PieceJob& job);
/// Once a turn: does or ends what was asked for. True when it ended.
bool followPlaneCut(Context& context);

}  // namespace argil::studio
