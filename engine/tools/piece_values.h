#pragma once
// What each operation on whole pieces is given beside the pieces: a struct of its own, whose members the rows of its
// parameters name.

#include <array>
#include <optional>
#include <variant>

#include "clay/base/vec.h"
#include "clay/field/infill.h"
#include "clay/kernels/brick.h"

namespace argil::engine {

struct CombineValues {
  double blendMm = 0;  ///< Width over which the surfaces run into each other.
  bool keepsSecond = false;
  double voxelMm = 0;  ///< 0: as suits both pieces.
  friend bool operator==(const CombineValues&, const CombineValues&) = default;
};
struct OffsetValues {
  double distanceMm = 1;
  friend bool operator==(const OffsetValues&, const OffsetValues&) = default;
};
/// Walls to both sides of the surface.
struct ShellValues {
  double innerMm = 2, outerMm = 0, narrowMm = 2;
  friend bool operator==(const ShellValues&, const ShellValues&) = default;
};
struct SmoothValues {
  int passes = 3;
  friend bool operator==(const SmoothValues&, const SmoothValues&) = default;
};
struct ScaleValues {
  double percent = 100;
  /// World mm, a place that stays where it is; none: the middle of the piece's lower side.
  std::optional<Vec3d> aboutMm;
  friend bool operator==(const ScaleValues&, const ScaleValues&) = default;
};
struct ResampleValues {
  double voxelMm = 0.5;
  friend bool operator==(const ResampleValues&, const ResampleValues&) = default;
};
struct PrecisionValues {
  clay::Precision precision = clay::Precision::fixed16;
  friend bool operator==(const PrecisionValues&, const PrecisionValues&) = default;
};
/// Bodies of a lesser volume go.
struct CrumbValues {
  double belowMm3 = 10;
  friend bool operator==(const CrumbValues&, const CrumbValues&) = default;
};
struct CutValues {
  int keep = 1;         ///< +1 what the plane faces or the curve encloses, −1 the other side, 0 both, as two pieces.
  double smoothMm = 1;  ///< Details of a curve below this size go.
  friend bool operator==(const CutValues&, const CutValues&) = default;
};
struct InfillValues {
  clay::Infill kind = clay::Infill::gyroid;
  double percent = 15, wallMm = 1;
  friend bool operator==(const InfillValues&, const InfillValues&) = default;
};
struct DrainValues {
  double diameterMm = 3;
  bool vents = true, plugs = false;
  double clearanceMm = 0.1;
  friend bool operator==(const DrainValues&, const DrainValues&) = default;
};
struct PegValues {
  int pegs = 2;
  double diameterMm = 0, depthMm = 0;  ///< 0: as suits the cut.
  double clearanceMm = 0.15;
  bool loose = false;
  friend bool operator==(const PegValues&, const PegValues&) = default;
};
/// Under a piece that stands as it is in the world.
struct BaseValues {
  bool square = false;  ///< Else round.
  double heightMm = 5, marginMm = 3, sunkMm = 1;
  int dots = 0;
  friend bool operator==(const BaseValues&, const BaseValues&) = default;
};
struct MouldValues {
  int pull = 0;  ///< 0 where it comes off best, else an axis of the world: 1 x, 2 y, 3 z.
  double wallMm = 8;
  bool keys = true;
  double clearanceMm = 0.15, sprueMm = 6;  ///< 0: no sprue.
  bool vents = true;
  double ventMm = 1.5;
  friend bool operator==(const MouldValues&, const MouldValues&) = default;
};
struct NestValues {
  double widthMm = 250, depthMm = 210, gapMm = 3;
  int turns = 8;
  friend bool operator==(const NestValues&, const NestValues&) = default;
};
/// Bend, twist and taper: a part of the piece along one of its axes, and what becomes of its end.
struct AlongValues {
  int axis = 3;                   ///< Of the piece: 1 x, 2 y, 3 z.
  double from = 0, to = 100;      ///< Percent of the piece along it.
  double angle = 0, towards = 0;  ///< Degrees: how far the end is turned, and where to across the axis.
  double width = 50;              ///< Percent, of the end.
  friend bool operator==(const AlongValues&, const AlongValues&) = default;
};
struct LatticeValues {
  std::array<int, 3> counts{4, 4, 4};  ///< Of control points.
  /// Low and high corner that they begin as, mm of the piece; none: around the piece.
  std::optional<std::array<Vec3d, 2>> boxMm;
  friend bool operator==(const LatticeValues&, const LatticeValues&) = default;
};
/// A new solid about the z axis. Which of them it reads is in its rows.
struct SolidValues {
  double radiusMm = 20, topMm = 0, heightMm = 50, roundMm = 1, tubeMm = 8;
  double radiusXMm = 30, radiusYMm = 20, radiusZMm = 15;
  double voxelMm = 0.5;
  friend bool operator==(const SolidValues&, const SolidValues&) = default;
};
struct MaskBlurValues {
  int passes = 4;
  friend bool operator==(const MaskBlurValues&, const MaskBlurValues&) = default;
};
struct MaskCavityValues {
  double radiusMm = 3;
  bool ridges = false, adds = false;
  friend bool operator==(const MaskCavityValues&, const MaskCavityValues&) = default;
};
struct MaskLassoValues {
  bool frontOnly = true, frees = false;
  friend bool operator==(const MaskLassoValues&, const MaskLassoValues&) = default;
};

/// Numbers of an operation that was added (engine/tools/added_jobs.h), in the order of its rows.
struct AddedValues {
  std::array<double, 8> own{};
  friend bool operator==(const AddedValues&, const AddedValues&) = default;
};

/// Those of one operation; none where it has no parameters.
using PieceValues = std::variant<std::monostate, CombineValues, OffsetValues, ShellValues, SmoothValues, ScaleValues,
                                 ResampleValues, PrecisionValues, CrumbValues, CutValues, InfillValues, DrainValues,
                                 PegValues, BaseValues, MouldValues, NestValues, AlongValues, LatticeValues,
                                 SolidValues, MaskBlurValues, MaskCavityValues, MaskLassoValues, AddedValues>;

/// The struct that a member belongs to.
template <class Member>
struct OwnerOfMember;
template <class Owner, class Value>
struct OwnerOfMember<Value Owner::*> {
  using Type = Owner;
};
template <auto member>
using OwnerOf = typename OwnerOfMember<decltype(member)>::Type;

}  // namespace argil::engine
