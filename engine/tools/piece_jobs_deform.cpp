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

namespace argil::engine {
namespace {

using std::string_view;
using Row = Parameter<PieceArguments>;

constexpr double kDegree = 0.017453292519943295;

// A number of PieceArguments::numbers.
template <size_t index>
constexpr Row number(string_view id, string_view name, string_view help, string_view unit, double low, double high,
                     double standard, bool logarithmic = false) {
  return {id,
          name,
          help,
          unit,
          low,
          high,
          standard,
          logarithmic,
          [](const PieceArguments& a) { return index < a.numbers.size() ? a.numbers[index] : 0.0; },
          [](PieceArguments& a, double v) {
            if (a.numbers.size() <= index) a.numbers.resize(index + 1);
            a.numbers[index] = v;
          }};
}

const Piece& theFirst(const Document& document, const PieceArguments& arguments) {
  return *document.piece(arguments.pieces.at(0));
}

// Cuts

constexpr Row kKeep{
    "keep",
    "Keep",
    "1: what the plane faces, or what lies within or to the left of the curve; −1: the rest; 0: both, as two pieces.",
    "",
    -1,
    1,
    1,
    false,
    [](const PieceArguments& a) { return double(a.keep); },
    [](PieceArguments& a, double v) { a.keep = static_cast<int>(std::lround(v)); }};
constexpr std::array kPlane{kKeep};
constexpr std::array kCurve{
    kKeep,
    number<0>("smooth", "Smooth", "Details of the curve below this size go; 0 takes it as it is.", "mm", 0, 50, 1)};

PieceResult cutBy(const Piece& piece, const clay::Divider& divider, int keep, bool oneIsFirst, Job* job) {
  PieceResult result;
  const auto part = [&](bool first, const std::shared_ptr<clay::Store>& store) {
    clay::Version version = clay::cut(piece.version, divider, first, store, job);
    if (version.stats().bricks == 0)
      throw Error(fmt::format("nothing of {} lies on {} side of the cut: move the cut", piece.name,
                              keep == 0 ? "one" : "that"));
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
  result.changed.push_back(std::move(kept));
  return result;
}

PieceResult cutPlane(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  const clay::PlaneDivider plane(piece.pose.applyInverse(arguments.plane.pointMm),
                                 piece.pose.rotation.conjugate() * arguments.plane.normal);
  return cutBy(piece, plane, arguments.keep, false, job);
}

PieceResult cutCurve(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  clay::CurveDivider::Curve curve{
      {}, piece.pose.rotation.conjugate() * arguments.directionMm, arguments.closed, kCurve[1].get(arguments)};
  for (const Vec3d& p : arguments.pointsMm) curve.pointsMm.push_back(piece.pose.applyInverse(p));
  return cutBy(piece, clay::CurveDivider(curve), arguments.keep, true, job);
}

// Deformations

// How far along which axis of the piece: numbers 0 to 2.
constexpr Row kAxis = number<0>("axis", "Axis", "Of the piece: 1 x, 2 y, 3 z.", "", 1, 3, 3);
constexpr Row kFrom = number<1>(
    "from", "From", "Where it begins along the axis, in percent of the piece; what lies before stays.", "%", 0, 99, 0);
constexpr Row kTo = number<2>("to", "To", "Where it ends; what lies behind follows as it is.", "%", 1, 100, 100);
constexpr std::array kBend{kAxis, kFrom, kTo,
                           number<3>("angle", "Angle", "How far the end is turned.", "°", -350, 350, 45),
                           number<4>("towards", "Towards", "Direction across the axis.", "°", 0, 360, 0)};
constexpr std::array kTwist{kAxis, kFrom, kTo,
                            number<3>("angle", "Angle", "How far the end is turned.", "°", -3600, 3600, 90)};
constexpr std::array kTaper{
    kAxis, kFrom, kTo,
    number<3>("width", "Width", "At the end, of what it is at the beginning.", "%", 13, 800, 50, true)};
// Counts are numbers 0 to 2; numbers 3 to 8, where there are any, the box's low and high corner in mm of the piece.
constexpr std::array kLattice{number<0>("points-x", "Points x", "Control points along x.", "", 2, 8, 4),
                              number<1>("points-y", "Points y", "Control points along y.", "", 2, 8, 4),
                              number<2>("points-z", "Points z", "Control points along z.", "", 2, 8, 4)};

int axisOf(const PieceArguments& arguments) {
  return std::clamp(static_cast<int>(std::lround(kAxis.get(arguments))) - 1, 0, 2);
}

clay::WarpAxis alongOf(const Piece& piece, const PieceArguments& arguments) {
  const double from = kFrom.get(arguments), to = kTo.get(arguments);
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
  const clay::Turn towards = clay::turnBy(kBend[4].get(arguments) * kDegree);
  const Vec3d across = towards.cosine * Vec3d::Unit((axis + 1) % 3) + towards.sine * Vec3d::Unit((axis + 2) % 3);
  return deformed(piece, clay::Bend(alongOf(piece, arguments), across, kBend[3].get(arguments) * kDegree), job);
}

PieceResult twist(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  return deformed(piece, clay::Twist(alongOf(piece, arguments), kTwist[3].get(arguments) * kDegree), job);
}

PieceResult taper(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  return deformed(piece, clay::Taper(alongOf(piece, arguments), kTaper[3].get(arguments) / 100), job);
}

PieceResult lattice(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  requireClay(piece);
  std::array<int, 3> counts;
  for (size_t i = 0; i < 3; ++i) counts[i] = static_cast<int>(std::lround(kLattice[i].get(arguments)));
  const std::vector<double>& n = arguments.numbers;
  clay::Lattice box = n.size() >= 9 ? clay::Lattice({{n[3], n[4], n[5]}, {n[6], n[7], n[8]}}, counts)
                                    : clay::Lattice::around(clay::brickBoundsOf(piece.version), counts);
  if (arguments.pointsMm.size() != box.points().size())
    throw Error(fmt::format("lattice of {} × {} × {} with {} points: give all {}", counts[0], counts[1], counts[2],
                            arguments.pointsMm.size(), box.points().size()));
  for (size_t i = 0; i < box.points().size(); ++i) box.setPoint(i, piece.pose.applyInverse(arguments.pointsMm[i]));
  return deformed(piece, box, job);
}

// New pieces, about the world's origin

constexpr Row kVoxel{"voxel",
                     "Voxel",
                     "Edge of a voxel.",
                     "mm",
                     0.001,
                     1000,
                     0.5,
                     true,
                     [](const PieceArguments& a) { return a.voxelMm; },
                     [](PieceArguments& a, double v) { a.voxelMm = v; }};
constexpr std::array kCylinder{number<0>("radius", "Radius", "Of the cylinder.", "mm", 0.01, 10000, 20, true),
                               number<1>("height", "Height", "Along z.", "mm", 0.01, 20000, 50, true),
                               number<2>("round", "Rounding", "Radius of the rims.", "mm", 0, 1000, 1), kVoxel};
constexpr std::array kCone{number<0>("radius", "Radius", "At the bottom.", "mm", 0, 10000, 25),
                           number<1>("top", "Top radius", "0 makes a tip.", "mm", 0, 10000, 0),
                           number<2>("height", "Height", "Along z.", "mm", 0.01, 20000, 50, true), kVoxel};
constexpr std::array kRing{
    number<0>("radius", "Radius", "From the middle to that of the tube.", "mm", 0.01, 10000, 25, true),
    number<1>("tube", "Tube", "Radius of the tube.", "mm", 0.01, 10000, 8, true), kVoxel};
constexpr std::array kEllipsoid{number<0>("radius-x", "Radius x", "Along x.", "mm", 0.01, 10000, 30, true),
                                number<1>("radius-y", "Radius y", "Along y.", "mm", 0.01, 10000, 20, true),
                                number<2>("radius-z", "Radius z", "Along z.", "mm", 0.01, 10000, 15, true), kVoxel};

PieceResult added(std::string name, clay::Version version) {
  Piece piece;
  piece.name = std::move(name);
  piece.version = std::move(version);
  PieceResult result;
  result.added.push_back(std::move(piece));
  return result;
}
clay::Grid gridOf(const PieceArguments& arguments) {
  clay::Grid grid;
  grid.voxelMm = arguments.voxelMm;
  return grid;
}
template <const auto& rows, size_t index>
double of(const PieceArguments& arguments) {
  return rows[index].get(arguments);
}

PieceResult cylinder(const Document&, const PieceArguments& a, Job* job) {
  return added("Cylinder", clay::makeCylinder(clay::Store::make(), gridOf(a), Vec3d::Zero(), of<kCylinder, 0>(a),
                                              of<kCylinder, 1>(a), of<kCylinder, 2>(a), job));
}
PieceResult cone(const Document&, const PieceArguments& a, Job* job) {
  return added("Cone", clay::makeCone(clay::Store::make(), gridOf(a), Vec3d::Zero(), of<kCone, 0>(a), of<kCone, 1>(a),
                                      of<kCone, 2>(a), job));
}
PieceResult ring(const Document&, const PieceArguments& a, Job* job) {
  return added("Ring",
               clay::makeTorus(clay::Store::make(), gridOf(a), Vec3d::Zero(), of<kRing, 0>(a), of<kRing, 1>(a), job));
}
PieceResult ellipsoid(const Document&, const PieceArguments& a, Job* job) {
  return added("Ellipsoid",
               clay::makeEllipsoid(clay::Store::make(), gridOf(a), Vec3d::Zero(),
                                   {of<kEllipsoid, 0>(a), of<kEllipsoid, 1>(a), of<kEllipsoid, 2>(a)}, job));
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
