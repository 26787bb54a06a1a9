#pragma once
// A curve that is drawn over the picture, for the operations that take one: cut by curve, mask by lasso.

#include <array>
#include <string>
#include <vector>

#include "clay/whole/deform.h"
#include "engine/tools/piece_jobs.h"
#include "ui3d/studio/view/camera.h"

namespace argil::studio {

struct Context;

/// What lies on either side of a curve, on the sheet on which it was drawn: as the cut will have it, smoothed and with
/// its ends going straight on.
struct CurveSides {
  /// The inside of a closed curve, the left of an open one; and the rest.
  struct Side {
    std::vector<Vec3d> trianglesMm;
    Vec3d middleMm = Vec3d::Zero();  ///< A place well within; of no use where there are no triangles.
  };
  std::array<Side, 2> sides;
};

/// In work from the moment that the operation is asked for until it is begun or given up. Plain state with the rules of
/// drawing; followDrawnCurve() does the work.
struct DrawnCurve {
  const engine::PieceJob* job = nullptr;  ///< Takes a curve.
  engine::PieceArguments arguments;       ///< Piece and numbers; the curve is put in when it is begun.
  /// Masks: done with each curve that is drawn, and ready for the next. Else it waits for `apply`.
  bool atOnce = false;
  bool hadPerspective = false;  ///< Comes back at the end: the curve goes straight through, so it is drawn without.
  clay::BoxMm box;              ///< Of the piece, in its millimetres,
  haptics::Pose pose;           ///< and where it stands.

  std::vector<Vec3d> pointsMm;          ///< World, on a sheet before the piece.
  Vec3d directionMm = -Vec3d::UnitZ();  ///< Of sight, length one.
  bool closed = false;  ///< By its end, which came back to its beginning; the person may choose otherwise.
  bool held = false;    ///< Being drawn.
  CurveSides sides;     ///< Of a curve that is drawn and not held.

  bool apply = false, cancel = false;  ///< Asked for.

  /// For a piece that exists and holds clay.
  [[nodiscard]] static DrawnCurve of(const engine::PieceJob& job, const engine::Document& document,
                                     const engine::Piece& piece);
  /// The button goes down: a new curve. False while the last one waits to be worked on.
  bool press(const Camera& camera, float x, float y, float width, float height);
  /// `straight`: one line from where it began.
  void move(const Camera& camera, float x, float y, float width, float height, bool straight);
  /// The button comes up. What is too short is no curve.
  void release(const Camera& camera, float width, float height);
  /// Nothing is drawn.
  void clear();
  [[nodiscard]] bool drawn() const { return !held && pointsMm.size() >= 2; }
  /// After a change of `closed` or of a number.
  void findSides();
  /// Whether the operation keeps, or masks, one side: +1 the first, −1 the second, 0 both.
  [[nodiscard]] int kept() const { return arguments.get<engine::CutValues>().keep; }
  [[nodiscard]] bool cuts() const { return !atOnce; }
  /// What to do next.
  [[nodiscard]] std::string hint() const;
};

/// Begins to draw for an operation on the selected piece, else on the active one; the view loses its perspective.
/// Nothing where there is no such piece.
void beginDrawnCurve(Context& context, const engine::PieceJob& job);
/// Once a turn: begins the operation when that is asked for, ends when it is given up or the piece has gone. True when
/// something that is seen changed.
bool followDrawnCurve(Context& context);

}  // namespace argil::studio
