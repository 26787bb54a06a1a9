#pragma once
// Operations on whole pieces: joined, cut, hollowed, split, mirrored ..., as rows of a table that studio, scripts and
// docs are made from.

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "clay/base/job.h"
#include "engine/document/document.h"
#include "engine/document/parameter.h"
#include "engine/tools/piece_values.h"

namespace argil::engine {

/// What an operation is given. A row says which members it reads: `parameters` the values, `takes` the rest.
struct PieceArguments {
  std::vector<Id> pieces;  ///< The first is worked on; a row that takes two has the other second.
  PieceValues values;
  MirrorPlane plane;                   ///< World mm.
  std::vector<Vec3d> pointsMm;         ///< A drawn curve or control points, world mm.
  Vec3d directionMm = Vec3d::UnitZ();  ///< Along which a drawn curve is extruded, world.
  bool closed = false;                 ///< Of the curve.

  /// The values of an operation; those that it begins with where others are held.
  template <class Values>
  [[nodiscard]] const Values& get() const {
    static const Values kNone;
    const Values* held = std::get_if<Values>(&values);
    return held ? *held : kNone;
  }
  /// The same, to be changed; what else was held is gone.
  template <class Values>
  [[nodiscard]] Values& change() {
    Values* held = std::get_if<Values>(&values);
    return held ? *held : values.emplace<Values>();
  }

  friend bool operator==(const PieceArguments&, const PieceArguments&) = default;
};

/// The row of a parameter which is that member of its values: a double, an int, a bool (0 or 1) or an enumeration.
template <auto member>
[[nodiscard]] constexpr Parameter<PieceArguments> valueRow(Parameter<PieceArguments> row) {
  row.get = [](const PieceArguments& a) { return static_cast<double>(a.get<OwnerOf<member>>().*member); };
  row.set = [](PieceArguments& a, double v) {
    auto& value = a.change<OwnerOf<member>>().*member;
    using Value = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, double>)
      value = v;
    else
      value = static_cast<Value>(std::lround(v));
  };
  return row;
}

/// What an operation leads to; nothing of the document changes before applyPieceResult().
struct PieceResult {
  std::vector<Piece> changed;  ///< Take the place of those with the same id.
  std::vector<Piece> added;    ///< Get an id; their names may be empty or taken, and then get a number.
  std::vector<Id> removed;
  std::vector<std::string> notes;  ///< Sentences for the person: what was found, how large the error is.
};

struct AddedJob;  // engine/tools/added_jobs.h

/// A row of the table.
struct PieceJob {
  std::string_view id, name, help;  ///< "join", "Join", one line.
  std::string_view doing;           ///< "Joining": what the list of jobs shows.
  std::string_view group;  ///< Menu that it stands in: "Combine", "Shape", "Repair", "Cut", "Print", "Deform", "New",
                           ///< "Mask".
  int pieces = 1;          ///< 0, 1 or 2.
  bool takesPlane = false, takesCurve = false;
  std::span<const Parameter<PieceArguments>> parameters = {};
  /// Runs in the background on a document that does not change. The pieces exist. Throws Error, Cancelled.
  PieceResult (*run)(const Document& document, const PieceArguments& arguments, Job* job) = nullptr;
  bool takesBox = false;  ///< LatticeValues::boxMm.
  /// Where there is little room and its group stands above it: "Invert" for "Invert mask". Empty: the name.
  std::string_view brief = {};
  /// Of an operation that was added: what runs in place of `run`.
  const AddedJob* added = nullptr;
  bool takesAll = false;  ///< Works on all pieces that are visible and not locked; `pieces` is 0.
  /// How far the surface that is seen moves outwards all over, mm, inwards where negative: what can be shown before it
  /// is done. Null: it does something else.
  double (*growsMm)(const PieceArguments& arguments) = nullptr;
  /// It makes a piece where there was none.
  [[nodiscard]] bool makesNew() const { return pieces == 0 && !takesAll; }
};

/// All rows, in the order of the menus, those that were added behind. Any thread; what was returned stays.
[[nodiscard]] std::span<const PieceJob> pieceJobs();
/// Null for an unknown id.
[[nodiscard]] const PieceJob* findPieceJob(std::string_view id);
/// Arguments as the row begins with, for a document's active piece.
[[nodiscard]] PieceArguments standardArguments(const PieceJob& row, const Document& document);

/// What a combination of two pieces leads to.
struct CombineCost {
  double voxelMm = 0;
  uint64_t bytes = 0;  ///< Of memory, about: as if all of both surfaces stayed.
};
/// With voxels of `voxelMm`; for 0 with those that the row takes by itself: of cuts the first piece's, else the finer
/// ones of both, or as much coarser ones as keep the result within twice the memory of both.
[[nodiscard]] CombineCost combineCost(const PieceJob& row, const Piece& first, const Piece& second, double voxelMm);

/// Checks the pieces (there, not locked, so many as the row takes) and runs the row. Any thread. Throws Error,
/// Cancelled.
[[nodiscard]] PieceResult runPieceJob(const PieceJob& row, const Document& document, const PieceArguments& arguments,
                                      Job* job = nullptr);

/// Makes the result part of a document, which may have changed since `before`, the one that the job ran on, but not in
/// the clay that the job changes or removes: then it throws Error.
void applyPieceResult(const PieceResult& result, const Document& before, Document& document);

/// Rows of the other files; pieceJobs() has them all.
[[nodiscard]] std::span<const PieceJob> combineJobs();  ///< engine/tools/piece_jobs_combine.cpp
[[nodiscard]] std::span<const PieceJob> shapeJobs();    ///< engine/tools/piece_jobs_shape.cpp
[[nodiscard]] std::span<const PieceJob> printJobs();    ///< engine/tools/piece_jobs_print.cpp
[[nodiscard]] std::span<const PieceJob> placeJobs();    ///< engine/tools/piece_jobs_place.cpp
[[nodiscard]] std::span<const PieceJob> deformJobs();   ///< engine/tools/piece_jobs_deform.cpp
[[nodiscard]] std::span<const PieceJob> maskJobs();     ///< engine/tools/piece_jobs_mask.cpp

}  // namespace argil::engine
