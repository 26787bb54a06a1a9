#include <array>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/cut.h"
#include "clay/whole/deform.h"
#include "clay/whole/lattice.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/thin_notes.h"

namespace argil::engine {
namespace {

using Row = Parameter<PieceArguments>;

constexpr double kDegree = 0.017453292519943295;

const Piece& theFirst(const Document& document, const PieceArguments& arguments) {
  return *document.piece(arguments.pieces.at(0));
}

// Cuts

constexpr Row kKeep = valueRow<&CutValues::keep>({
    .id = "keep",
    .name = "Keep",
    .help = "1: what the plane faces, or what lies within or to the left of the curve; −1: the rest; 0: both, as two "
            "pieces.",
    .unit = "",
    .low = -1,
    .high = 1,
    .standard = 1,
});
constexpr std::array kPlane{kKeep};
constexpr std::array kCurve{
    kKeep,
    valueRow<&CutValues::smoothMm>({
        .id = "smooth",
        .name = "Smooth",
        .help = "Details of the curve below this size go; 0 takes it as it is.",
        .unit = "mm",
        .low = 0,
        .high = 50,
        .standard = 1,
        .zero = "as it is",
    }),
};

PieceResult cutBy(const Piece& piece, const clay::Divider& divider, int keep, bool oneIsFirst, Job* job) {
  PieceResult result;
  clay::ThinParts gone;
  const auto part = [&](bool first, const std::shared_ptr<clay::Store>& store) {
    clay::Version version = clay::cut(piece.version, divider, first, store, job, 0, &gone);
    if (version.stats().bricks == 0) {
      const char* side = keep == 0 ? "one" : "that";
      if (gone.betweenVoxels >= kLeastBetween)
        throw Error(
            fmt::format("what {} has on {} side of the cut is thinner than a voxel ({:.3g} mm): move the "
                        "cut, or make the voxels finer",
                        piece.name, side, piece.version.grid().voxelMm));
      throw Error(fmt::format("nothing of {} lies on {} side of the cut: move the cut", piece.name, side));
    }
    return version;
  };
  const bool first = (keep >= 0) == oneIsFirst;
  Piece kept = piece;
  kept.version = part(first, piece.version.store());
  if (kept.version == piece.version) throw Error(fmt::format("the cut does not meet {}: move the cut", piece.name));
  if (keep == 0) {
    Piece other = piece;
    other.version = part(!first, clay::Store::make(piece.version.store()->precision()));
    other.name = fmt::format("{}, other side", piece.name);
    result.added.push_back(std::move(other));
  }
  addThinNotes(result.notes, piece, gone);
  result.changed.push_back(std::move(kept));
  return result;
}

PieceResult cutPlane(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  const clay::PlaneDivider plane(piece.pose.applyInverse(arguments.plane.pointMm),
                                 piece.pose.rotation.conjugate() * arguments.plane.normal);
  return cutBy(piece, plane, arguments.get<CutValues>().keep, false, job);
}

PieceResult cutCurve(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  clay::CurveDivider::Curve curve{{},
                                  piece.pose.rotation.conjugate() * arguments.directionMm,
                                  arguments.closed,
                                  arguments.get<CutValues>().smoothMm};
  for (const Vec3d& p : arguments.pointsMm) curve.pointsMm.push_back(piece.pose.applyInverse(p));
  return cutBy(piece, clay::CurveDivider(curve), arguments.get<CutValues>().keep, true, job);
}

// Deformations

constexpr Row kAxis = valueRow<&AlongValues::axis>({
    .id = "axis",
    .name = "Axis",
    .help = "Of the piece: 1 x, 2 y, 3 z.",
    .unit = "",
    .low = 1,
    .high = 3,
    .standard = 3,
});
constexpr Row kFrom = valueRow<&AlongValues::from>({
    .id = "from",
    .name = "From",
    .help = "Where it begins along the axis, in percent of the piece; what lies before stays.",
    .unit = "%",
    .low = 0,
    .high = 99,
    .standard = 0,
});
constexpr Row kTo = valueRow<&AlongValues::to>({
    .id = "to",
    .name = "To",
    .help = "Where it ends; what lies behind follows as it is.",
    .unit = "%",
    .low = 1,
    .high = 100,
    .standard = 100,
});
constexpr std::array kBend{
    kAxis,
    kFrom,
    kTo,
    valueRow<&AlongValues::angle>({
        .id = "angle",
        .name = "Angle",
        .help = "How far the end is turned.",
        .unit = "°",
        .low = -350,
        .high = 350,
        .standard = 45,
    }),
    valueRow<&AlongValues::towards>({
        .id = "towards",
        .name = "Towards",
        .help = "Direction across the axis.",
        .unit = "°",
        .low = 0,
        .high = 360,
        .standard = 0,
    }),
};
constexpr std::array kTwist{
    kAxis,
    kFrom,
    kTo,
    valueRow<&AlongValues::angle>({
        .id = "angle",
        .name = "Angle",
        .help = "How far the end is turned.",
        .unit = "°",
        .low = -3600,
        .high = 3600,
        .standard = 90,
    }),
};
constexpr std::array kTaper{
    kAxis,
    kFrom,
    kTo,
    valueRow<&AlongValues::width>({
        .id = "width",
        .name = "Width",
        .help = "At the end, of what it is at the beginning.",
        .unit = "%",
        .low = 13,
        .high = 800,
        .standard = 50,
        .logarithmic = true,
    }),
};

// How many control points there are along an axis.
template <size_t axis>
constexpr Row countRow(Row row) {
  row.low = 2;
  row.high = 8;
  row.standard = 4;
  row.get = [](const PieceArguments& a) { return double(a.get<LatticeValues>().counts[axis]); };
  row.set = [](PieceArguments& a, double v) {
    a.change<LatticeValues>().counts[axis] = static_cast<int>(std::lround(v));
  };
  return row;
}
constexpr std::array kLattice{
    countRow<0>({.id = "points-x", .name = "Points x", .help = "Control points along x.", .unit = ""}),
    countRow<1>({.id = "points-y", .name = "Points y", .help = "Control points along y.", .unit = ""}),
    countRow<2>({.id = "points-z", .name = "Points z", .help = "Control points along z.", .unit = ""}),
};

// A little less than clay::kMostStretch, so that rounding refuses nothing.
constexpr double kLeastPercent = 13, kMostPercent = 790;
static_assert(kMostPercent < 100 * clay::kMostStretch && kLeastPercent > 100 / clay::kMostStretch);
constexpr std::array kStretch{
    valueRow<&ScaleValues::percent>({
        .id = "length",
        .name = "Length",
        .help =
            "Length after it, in percent of the length before: 200 makes the piece twice as long square to the plane.",
        .unit = "%",
        .low = kLeastPercent,
        .high = kMostPercent,
        .standard = 100,
        .logarithmic = true,
    }),
};

int axisOf(const PieceArguments& arguments) {
  return std::clamp(arguments.get<AlongValues>().axis - 1, 0, 2);
}

clay::WarpAxis alongOf(const Piece& piece, const PieceArguments& arguments) {
  const double from = arguments.get<AlongValues>().from, to = arguments.get<AlongValues>().to;
  if (!(from < to)) throw Error(fmt::format("from {:g} % to {:g} %: give an end behind the beginning", from, to));
  const clay::BoxMm box = clay::boundsOf(piece.version);
  const int axis = axisOf(arguments);
  const double size = box.high[axis] - box.low[axis];
  return {(box.low + box.high) / 2, Vec3d::Unit(axis), size * (from / 100 - 0.5), size * (to / 100 - 0.5)};
}

PieceResult deformed(const Piece& piece, const clay::Warp& warp, Job* job) {
  Piece changed = piece;
  changed.version = clay::deform(piece.version, warp, clay::Store::make(piece.version.store()->precision()), job);
  PieceResult result;
  result.changed.push_back(std::move(changed));
  return result;
}

void requireClay(const Piece& piece) {
  if (piece.version.stats().bricks == 0) throw Error(fmt::format("{} is empty: add clay first", piece.name));
}

PieceResult bend(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  const int axis = axisOf(arguments);
  const clay::Turn towards = clay::turnBy(arguments.get<AlongValues>().towards * kDegree);
  const Vec3d across = towards.cosine * Vec3d::Unit((axis + 1) % 3) + towards.sine * Vec3d::Unit((axis + 2) % 3);
  return deformed(piece, clay::Bend(alongOf(piece, arguments), across, arguments.get<AlongValues>().angle * kDegree),
                  job);
}

PieceResult twist(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  return deformed(piece, clay::Twist(alongOf(piece, arguments), arguments.get<AlongValues>().angle * kDegree), job);
}

PieceResult taper(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  return deformed(piece, clay::Taper(alongOf(piece, arguments), arguments.get<AlongValues>().width / 100), job);
}

PieceResult lattice(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  const auto& [counts, boxMm] = arguments.get<LatticeValues>();
  clay::Lattice box = boxMm ? clay::Lattice({(*boxMm)[0], (*boxMm)[1]}, counts)
                            : clay::Lattice::around(clay::brickBoundsOf(piece.version), counts);
  if (arguments.pointsMm.size() != box.points().size())
    throw Error(fmt::format("lattice of {} × {} × {} with {} points: give all {}", counts[0], counts[1], counts[2],
                            arguments.pointsMm.size(), box.points().size()));
  for (size_t i = 0; i < box.points().size(); ++i) box.setPoint(i, piece.pose.applyInverse(arguments.pointsMm[i]));
  return deformed(piece, box, job);
}

// A lattice of its corners alone is an affine map.
PieceResult stretch(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  const double more = arguments.get<ScaleValues>().percent / 100 - 1;
  if (more == 0) return {};
  const Vec3d about = piece.pose.applyInverse(arguments.plane.pointMm),
              along = (piece.pose.rotation.conjugate() * arguments.plane.normal).normalized();
  clay::Lattice box = clay::Lattice::around(clay::brickBoundsOf(piece.version), {2, 2, 2});
  for (size_t i = 0; i < box.points().size(); ++i) {
    const Vec3d p = box.restPoint(i);
    box.setPoint(i, p + more * along.dot(p - about) * along);
  }
  PieceResult result = deformed(piece, box, job);
  result.notes.push_back(fmt::format("{}: {:.4g} times as long, with voxels of {:.4g} mm as before.", piece.name,
                                     1 + more, piece.version.grid().voxelMm));
  return result;
}

// New pieces, about the world's origin

constexpr Row kVoxel = valueRow<&SolidValues::voxelMm>({
    .id = "voxel",
    .name = "Voxel",
    .help = "Edge of a voxel.",
    .unit = "mm",
    .low = 0.001,
    .high = 1000,
    .standard = 0.5,
    .logarithmic = true,
});
constexpr std::array kCylinder{
    valueRow<&SolidValues::radiusMm>({
        .id = "radius",
        .name = "Radius",
        .help = "Of the cylinder.",
        .unit = "mm",
        .low = 0.01,
        .high = 10000,
        .standard = 20,
        .logarithmic = true,
    }),
    valueRow<&SolidValues::heightMm>({
        .id = "height",
        .name = "Height",
        .help = "Along z.",
        .unit = "mm",
        .low = 0.01,
        .high = 20000,
        .standard = 50,
        .logarithmic = true,
    }),
    valueRow<&SolidValues::roundMm>({
        .id = "round",
        .name = "Rounding",
        .help = "Radius of the rims.",
        .unit = "mm",
        .low = 0,
        .high = 1000,
        .standard = 1,
    }),
    kVoxel,
};
constexpr std::array kCone{
    valueRow<&SolidValues::radiusMm>({
        .id = "radius",
        .name = "Radius",
        .help = "At the bottom.",
        .unit = "mm",
        .low = 0,
        .high = 10000,
        .standard = 25,
    }),
    valueRow<&SolidValues::topMm>({
        .id = "top",
        .name = "Top radius",
        .help = "0 makes a tip.",
        .unit = "mm",
        .low = 0,
        .high = 10000,
        .standard = 0,
    }),
    valueRow<&SolidValues::heightMm>({
        .id = "height",
        .name = "Height",
        .help = "Along z.",
        .unit = "mm",
        .low = 0.01,
        .high = 20000,
        .standard = 50,
        .logarithmic = true,
    }),
    kVoxel,
};
constexpr std::array kRing{
    valueRow<&SolidValues::radiusMm>({
        .id = "radius",
        .name = "Radius",
        .help = "From the middle to that of the tube.",
        .unit = "mm",
        .low = 0.01,
        .high = 10000,
        .standard = 25,
        .logarithmic = true,
    }),
    valueRow<&SolidValues::tubeMm>({
        .id = "tube",
        .name = "Tube",
        .help = "Radius of the tube.",
        .unit = "mm",
        .low = 0.01,
        .high = 10000,
        .standard = 8,
        .logarithmic = true,
    }),
    kVoxel,
};
constexpr std::array kEllipsoid{
    valueRow<&SolidValues::radiusXMm>({
        .id = "radius-x",
        .name = "Radius x",
        .help = "Along x.",
        .unit = "mm",
        .low = 0.01,
        .high = 10000,
        .standard = 30,
        .logarithmic = true,
    }),
    valueRow<&SolidValues::radiusYMm>({
        .id = "radius-y",
        .name = "Radius y",
        .help = "Along y.",
        .unit = "mm",
        .low = 0.01,
        .high = 10000,
        .standard = 20,
        .logarithmic = true,
    }),
    valueRow<&SolidValues::radiusZMm>({
        .id = "radius-z",
        .name = "Radius z",
        .help = "Along z.",
        .unit = "mm",
        .low = 0.01,
        .high = 10000,
        .standard = 15,
        .logarithmic = true,
    }),
    kVoxel,
};

PieceResult added(std::string name, clay::Version version) {
  Piece piece;
  piece.name = std::move(name);
  piece.version = std::move(version);
  PieceResult result;
  result.added.push_back(std::move(piece));
  return result;
}
clay::Grid gridOf(const SolidValues& solid) {
  clay::Grid grid;
  grid.voxelMm = solid.voxelMm;
  return grid;
}

PieceResult cylinder(const Document&, const PieceArguments& arguments, Job* job) {
  const auto& solid = arguments.get<SolidValues>();
  return added("Cylinder", clay::makeCylinder(clay::Store::make(), gridOf(solid), Vec3d::Zero(), solid.radiusMm,
                                              solid.heightMm, solid.roundMm, job));
}
PieceResult cone(const Document&, const PieceArguments& arguments, Job* job) {
  const auto& solid = arguments.get<SolidValues>();
  return added("Cone", clay::makeCone(clay::Store::make(), gridOf(solid), Vec3d::Zero(), solid.radiusMm, solid.topMm,
                                      solid.heightMm, job));
}
PieceResult ring(const Document&, const PieceArguments& arguments, Job* job) {
  const auto& solid = arguments.get<SolidValues>();
  return added("Ring",
               clay::makeTorus(clay::Store::make(), gridOf(solid), Vec3d::Zero(), solid.radiusMm, solid.tubeMm, job));
}
PieceResult ellipsoid(const Document&, const PieceArguments& arguments, Job* job) {
  const auto& solid = arguments.get<SolidValues>();
  return added("Ellipsoid", clay::makeEllipsoid(clay::Store::make(), gridOf(solid), Vec3d::Zero(),
                                                {solid.radiusXMm, solid.radiusYMm, solid.radiusZMm}, job));
}

constexpr std::array kRows{
    PieceJob{
        .id = "cut-plane",
        .name = "Cut by plane",
        .help = "Cuts the clay along a plane.",
        .doing = "Cutting",
        .group = "Cut",
        .takesPlane = true,
        .parameters = kPlane,
        .run = cutPlane,
    },
    PieceJob{
        .id = "cut-curve",
        .name = "Cut by curve",
        .help = "Cuts the clay along a drawn curve, as a wire does.",
        .doing = "Cutting",
        .group = "Cut",
        .takesCurve = true,
        .parameters = kCurve,
        .run = cutCurve,
    },
    PieceJob{
        .id = "bend",
        .name = "Bend",
        .help = "Bends the piece into an arc.",
        .doing = "Bending",
        .group = "Deform",
        .parameters = kBend,
        .run = bend,
    },
    PieceJob{
        .id = "twist",
        .name = "Twist",
        .help = "Turns one end against the other.",
        .doing = "Twisting",
        .group = "Deform",
        .parameters = kTwist,
        .run = twist,
    },
    PieceJob{
        .id = "taper",
        .name = "Taper",
        .help = "Makes the piece thinner or wider towards one end.",
        .doing = "Tapering",
        .group = "Deform",
        .parameters = kTaper,
        .run = taper,
    },
    PieceJob{
        .id = "stretch",
        .name = "Stretch",
        .help = "Makes the piece longer or shorter square to a plane, which stays where it is.",
        .doing = "Stretching",
        .group = "Deform",
        .takesPlane = true,
        .parameters = kStretch,
        .run = stretch,
    },
    PieceJob{
        .id = "lattice",
        .name = "Lattice",
        .help = "The piece follows the control points around it.",
        .doing = "Deforming",
        .group = "Deform",
        .takesCurve = true,
        .parameters = kLattice,
        .run = lattice,
        .takesBox = true,
    },
    PieceJob{
        .id = "cylinder",
        .name = "Cylinder",
        .help = "A cylinder about the z axis.",
        .doing = "Making a cylinder",
        .group = "New",
        .pieces = 0,
        .parameters = kCylinder,
        .run = cylinder,
    },
    PieceJob{
        .id = "cone",
        .name = "Cone",
        .help = "A cone about the z axis, with a tip or without.",
        .doing = "Making a cone",
        .group = "New",
        .pieces = 0,
        .parameters = kCone,
        .run = cone,
    },
    PieceJob{
        .id = "ring",
        .name = "Ring",
        .help = "A torus about the z axis.",
        .doing = "Making a ring",
        .group = "New",
        .pieces = 0,
        .parameters = kRing,
        .run = ring,
    },
    PieceJob{
        .id = "ellipsoid",
        .name = "Ellipsoid",
        .help = "An ellipsoid.",
        .doing = "Making an ellipsoid",
        .group = "New",
        .pieces = 0,
        .parameters = kEllipsoid,
        .run = ellipsoid,
    },
};

}  // namespace

std::span<const PieceJob> deformJobs() {
  return kRows;
}

}  // namespace argil::engine
