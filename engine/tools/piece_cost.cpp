#include "engine/tools/piece_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "clay/base/memory_guard.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/cut.h"
#include "engine/document/beside.h"
#include "engine/document/size_words.h"

namespace argil::engine {

namespace {

/// What a row's cost follows.
struct Measure {
  double in = 0;     ///< Bricks of the pieces.
  double out = 0;    ///< Bricks that are made.
  double more = 0;   ///< Of another amount of work, in bricks.
  bool clay = true;  ///< False: only channels change, so bytes are theirs.
};
using Measured = Measure (*)(const Document& document, const PieceArguments& arguments);

const Piece& at(const Document& document, const PieceArguments& arguments, size_t index = 0) {
  return *document.piece(arguments.pieces[index]);
}
double bricksOf(const Piece& piece) {
  return static_cast<double>(piece.version.stats().bricks);
}
double voxelOf(const Piece& piece) {
  return piece.version.grid().voxelMm;
}

// Area after the surface moved by so much over the area before: as of a box.
double grown(const Piece& piece, double mm) {
  if (piece.version.stats().bricks == 0) return 1;
  const clay::BoxMm box = boundsOf(piece);
  const auto area = [](const Vec3d& s) { return s.x() * s.y() + s.y() * s.z() + s.z() * s.x(); };
  const Vec3d size = box.high - box.low;
  return std::min(area((size.array() + 2 * mm).max(0.0).matrix()) / std::max(area(size), 1e-12), 1e6);
}

Measure same(const Document& document, const PieceArguments& a) {
  const double bricks = bricksOf(at(document, a));
  return {bricks, bricks, 0};
}
// Nothing that follows the piece's size.
Measure nothing(const Document&, const PieceArguments&) {
  return {};
}
Measure channel(const Document& document, const PieceArguments& a) {
  return {bricksOf(at(document, a)), 0, 0, false};
}
Measure lasso(const Document& document, const PieceArguments& a) {
  const double in = bricksOf(at(document, a));
  return {in, 0, a.get<MaskLassoValues>().frontOnly ? in : 0, false};
}
Measure offset(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  const double mm = a.get<OffsetValues>().distanceMm, in = bricksOf(piece), out = in * grown(piece, mm);
  return {in, out, std::max(in, out) * std::abs(mm) / voxelOf(piece)};
}
Measure shell(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  const auto& [inner, outer, narrow] = a.get<ShellValues>();
  const double in = bricksOf(piece);
  const double outside = outer > 0 ? grown(piece, outer) : 1, inside = inner > 0 ? grown(piece, -inner) : 1;
  // Two offsets, and two of the hollow.
  return {in * (narrow > 0 ? 1 + inside : 1), in * (outside + inside),
          in * (outside * outer + inner + narrow) / voxelOf(piece)};
}
Measure smooth(const Document& document, const PieceArguments& a) {
  const double in = bricksOf(at(document, a));
  // Four passes are a look; distances are solved in the last one and in every third (clay/whole/NOTES.md).
  const int looks = (a.get<SmoothValues>().passes + 3) / 4, solved = (looks + 2) / 3;
  return {in, in, in * (solved + 0.18 * (looks - solved))};
}
Measure resample(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  const double in = bricksOf(piece), scale = voxelOf(piece) / a.get<ResampleValues>().voxelMm;
  return {in, in * scale * scale, 0};
}
Measure soften(const Document& document, const PieceArguments& a) {
  const double in = at(document, a).version.has(clay::Channel::mask) ? bricksOf(at(document, a)) : 0;
  return {in, 0, in * a.get<MaskBlurValues>().passes, false};
}
// Share of its bricks whose middle lies within the other.
double within(const Piece& piece, const Piece& other) {
  uint64_t inside = 0, all = 0;
  piece.version.forEachBrick([&](const clay::Brick& brick) {
    const Vec3d middle = (brick.coord * clay::kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
    const Vec3d voxel =
        other.version.grid().toVoxel(other.pose.applyInverse(piece.pose.apply(piece.version.grid().toWorld(middle))));
    ++all;
    if (!(voxel.cwiseAbs().maxCoeff() < clay::kBrickReach * clay::kBrickEdge)) return;
    const Vec3d floor = voxel.array().floor();
    const Coord at{static_cast<int32_t>(floor.x()), static_cast<int32_t>(floor.y()), static_cast<int32_t>(floor.z())};
    inside += other.version.find(at >> clay::kBrickBits)
                  .phi(clay::Brick::offset(at.x & 7, at.y & 7, at.z & 7), other.version.grid().band) < 0;
  });
  return static_cast<double>(inside) / static_cast<double>(std::max<uint64_t>(all, 1));
}
// What a divider leaves of a piece, and the walls that it makes.
Measure divided(const Piece& piece, const clay::Divider& divider, int keep, bool firstKept) {
  const double half = clay::kBrickEdge / 2 * voxelOf(piece);
  uint64_t first = 0, other = 0, on = 0;
  piece.version.forEachBrick([&](const clay::Brick& brick) {
    const Vec3d middle = (brick.coord * clay::kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
    const double distance = divider.distance(piece.version.grid().toWorld(middle));
    ++(distance < 0 ? first : other);
    on += std::abs(distance) < half;
  });
  const auto kept = static_cast<double>(keep == 0 ? first + other : (keep > 0) == firstKept ? first : other);
  // Walls as of a round section: a strip of bricks around it is as long as that.
  const double round = static_cast<double>(on) / (clay::kBricksOfArea * clay::kBrickEdge);
  const double wall = clay::kBricksOfArea * round * round / (4 * std::numbers::pi);
  const double sides = keep == 0 ? 2 : 1;
  return {bricksOf(piece) * sides, kept + sides * wall, 0};
}
Measure cutPlane(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  return divided(
      piece,
      clay::PlaneDivider(piece.pose.applyInverse(a.plane.pointMm), piece.pose.rotation.conjugate() * a.plane.normal),
      a.get<CutValues>().keep, false);
}
Measure cutCurve(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  clay::CurveDivider::Curve curve{
      {}, piece.pose.rotation.conjugate() * a.directionMm, a.closed, a.get<CutValues>().smoothMm};
  for (const Vec3d& p : a.pointsMm) curve.pointsMm.push_back(piece.pose.applyInverse(p));
  return divided(piece, clay::CurveDivider(curve), a.get<CutValues>().keep, true);
}
Measure bent(const Document& document, const PieceArguments& a) {
  const double in = bricksOf(at(document, a));
  return {in, in, in * std::abs(a.get<AlongValues>().angle)};
}
Measure twisted(const Document& document, const PieceArguments& a) {
  const double in = bricksOf(at(document, a));
  // What turns so far is followed to second order in smaller steps.
  constexpr double kFar = 21.5;
  return {in, in, std::abs(a.get<AlongValues>().angle) > kFar ? in : 0};
}
Measure tapered(const Document& document, const PieceArguments& a) {
  const double in = bricksOf(at(document, a)), width = a.get<AlongValues>().width;
  return {in, in * (1 + width / 100) / 2, in * std::abs(width - 100)};
}
Measure combine(const Document& document, const PieceArguments& a, clay::Combination how) {
  const Piece &first = at(document, a, 0), &second = at(document, a, 1);
  const double wanted = a.get<CombineValues>().voxelMm;
  const double voxel =
      wanted > 0 ? wanted
                 : combineCost(*findPieceJob(how == clay::Combination::cut ? "cut" : "join"), first, second, 0).voxelMm;
  const auto scaled = [&](const Piece& piece) {
    const double scale = voxelOf(piece) / voxel;
    return bricksOf(piece) * scale * scale;
  };
  const double one = scaled(first), other = scaled(second);
  double resampled = voxel == voxelOf(first) ? 0 : one;
  if (first.pose.translation != second.pose.translation ||
      first.pose.rotation.coeffs() != second.pose.rotation.coeffs() || voxel != voxelOf(second) ||
      !(first.version.grid() == second.version.grid()))
    resampled += other;
  const double own = within(first, second), others = within(second, first);
  const double out = (how == clay::Combination::intersect ? own : 1 - own) * one +
                     (how == clay::Combination::join ? 1 - others : others) * other;
  return {one + other, out, resampled};
}
template <clay::Combination how>
Measure combined(const Document& document, const PieceArguments& a) {
  return combine(document, a, how);
}
// Of a new solid with so much surface. `slant`: as ClayPlan has it.
constexpr double kRoundSlant = 4 / std::numbers::pi;  // around an axis
double bricks(double areaMm2, double slant, double voxelMm) {
  // 7 of a brick's 16.65 voxels along an axis for each unit of slant: clay::bytesOfClay.
  return areaMm2 / (voxelMm * voxelMm) * clay::kBricksOfArea * (1 + 7 * (slant - 1.5) / 16.65);
}
Measure cylinder(const Document&, const PieceArguments& a) {
  const auto& s = a.get<SolidValues>();
  const double ends = 2 * std::numbers::pi * s.radiusMm * s.radiusMm,
               side = 2 * std::numbers::pi * s.radiusMm * s.heightMm;
  return {0, bricks(ends, 1, s.voxelMm) + bricks(side, kRoundSlant, s.voxelMm), 0};
}
Measure cone(const Document&, const PieceArguments& a) {
  const auto& s = a.get<SolidValues>();
  const double across = s.radiusMm - s.topMm, along = std::hypot(across, s.heightMm);
  const double ends = std::numbers::pi * (s.radiusMm * s.radiusMm + s.topMm * s.topMm),
               side = std::numbers::pi * (s.radiusMm + s.topMm) * along;
  const double slant = (std::abs(across) + kRoundSlant * s.heightMm) / std::max(along, 1e-12);
  return {0, bricks(ends, 1, s.voxelMm) + bricks(side, slant, s.voxelMm), 0};
}
Measure ring(const Document&, const PieceArguments& a) {
  const auto& s = a.get<SolidValues>();
  return {0, bricks(4 * std::numbers::pi * std::numbers::pi * s.radiusMm * s.tubeMm, 1.5, s.voxelMm), 0};
}
Measure ellipsoid(const Document&, const PieceArguments& a) {
  const auto& s = a.get<SolidValues>();
  // K. Thomsen's formula, within 1.1 %.
  constexpr double p = 1.6075;
  const auto power = [](double x, double y) { return std::pow(x * y, p); };
  const double mean =
      (power(s.radiusXMm, s.radiusYMm) + power(s.radiusYMm, s.radiusZMm) + power(s.radiusZMm, s.radiusXMm)) / 3;
  return {0, bricks(4 * std::numbers::pi * std::pow(mean, 1 / p), 1.5, s.voxelMm), 0};
}

// A hollow is about so much of the box around a piece.
constexpr double kHollow = 0.35;
Measure infill(const Document& document, const PieceArguments& a) {
  const auto& values = a.get<InfillValues>();
  const clay::BoxMm box = clay::boundsOf(at(document, a).version);
  const double volume = kHollow * (box.high - box.low).cwiseMax(0.0).prod(), voxel = voxelOf(at(document, a));
  // Walls of cubes run through each other: measured.
  const double share = values.kind == clay::Infill::cubic ? 0.4 : 1;
  const double added = share * bricks(2 * values.percent / 100 * volume / values.wallMm, 1.5, voxel);
  return {bricksOf(at(document, a)), bricksOf(at(document, a)) + added, added};
}
Measure pegs(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  return divided(
      piece,
      clay::PlaneDivider(piece.pose.applyInverse(a.plane.pointMm), piece.pose.rotation.conjugate() * a.plane.normal), 0,
      false);
}
Measure everything(const Document& document, const PieceArguments&) {
  double all = 0;
  for (const Piece& piece : document.pieces) all += bricksOf(piece);
  return {all, 0, 0};
}
Measure lookedAt(const Document& document, const PieceArguments& a) {
  return {bricksOf(at(document, a)), 0, 0};
}
Measure plate(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  const Vec3d size =
      (boundsOf(piece).high - boundsOf(piece).low).cwiseMax(0.0) + 2 * a.get<BaseValues>().marginMm * Vec3d(1, 1, 0);
  const double added = bricks(2 * size.x() * size.y(), 1, voxelOf(piece));
  return {bricksOf(piece), bricksOf(piece) + added, added};
}
// Both halves have the clay's surface between them, the block's, and what they meet in; all of the block is looked at.
Measure halves(const Document& document, const PieceArguments& a) {
  const Piece& piece = at(document, a);
  const clay::BoxMm box = clay::boundsOf(piece.version);
  const Vec3d size = (box.high - box.low).cwiseMax(0.0) + Vec3d::Constant(2 * a.get<MouldValues>().wallMm);
  const double voxel = voxelOf(piece), edge = clay::kBrickEdge * voxel;
  const double around = 2 * (2 * size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
  return {bricksOf(piece), bricksOf(piece) + bricks(around, 1, voxel), size.prod() / (edge * edge * edge)};
}

/// µs of one core for each brick of a measure, on the machine that kReferenceUs is of: `argil bench costs`.
struct Rate {
  std::string_view id;
  Measured measured;
  double in = 0, out = 0, more = 0;
};
constexpr std::array kRates{
    Rate{"join", combined<clay::Combination::join>, 46, 0, 46},
    Rate{"cut", combined<clay::Combination::cut>, 20, 0, 120},
    Rate{"intersect", combined<clay::Combination::intersect>, 20, 0, 120},
    Rate{"split", same, 1.5, 0, 0},
    Rate{"offset", offset, 16, 0, 1.8},
    Rate{"shell", shell, 31, 0, 2.5},
    Rate{"smooth-all", smooth, 8, 0, 15.4},
    Rate{"scale", same, 1, 0, 0},
    Rate{"resample", resample, 0, 95, 0},
    Rate{"precision", same, 0.8, 0, 0},
    Rate{"mirror", same, 180, 0, 0},
    Rate{"fill-voids", same, 2.2, 0, 0},
    Rate{"remove-crumbs", same, 1.6, 0, 0},
    Rate{"cut-plane", cutPlane, 3.4, 0, 0},
    Rate{"cut-curve", cutCurve, 0, 16, 0},
    Rate{"infill", infill, 20, 0, 150},
    Rate{"drain", same, 180, 0, 0},
    Rate{"cut-pegs", pegs, 140, 0, 0},
    Rate{"lay-flat", lookedAt, 120, 0, 0},
    Rate{"base", plate, 10, 0, 70},
    Rate{"nest", everything, 7, 0, 0},
    Rate{"mould", halves, 520, 15, 12},
    Rate{"bend", bent, 205, 0, 6.5},
    Rate{"twist", twisted, 187, 0, 175},
    Rate{"taper", tapered, 247, 0, 3.4},
    Rate{"stretch", same, 267, 0, 0},
    Rate{"lattice", same, 267, 0, 0},
    Rate{"cylinder", cylinder, 0, 13.3, 0},
    Rate{"cone", cone, 0, 21, 0},
    Rate{"ring", ring, 0, 12.5, 0},
    Rate{"ellipsoid", ellipsoid, 0, 67, 0},
    Rate{"mask-invert", channel, 1, 0, 0},
    Rate{"mask-clear", channel, 1, 0, 0},
    Rate{"mask-soften", soften, 2.5, 0, 1.85},
    Rate{"mask-cavity", channel, 67, 0, 0},
    Rate{"mask-lasso", lasso, 2, 0, 2.3},
    Rate{"mask-hide", nothing},
    Rate{"mask-show", nothing},
};
// A dab of 20 voxels on that machine.
constexpr double kReferenceMs = 0.646;

}  // namespace

PieceCost costOf(const PieceJob& row, const Document& document, const PieceArguments& arguments,
                 const MachineSpeed& machine) {
  const auto rate = std::find_if(kRates.begin(), kRates.end(), [&](const Rate& each) { return each.id == row.id; });
  if (rate == kRates.end()) return {};
  const Measure m = rate->measured(document, arguments);
  PieceCost cost;
  cost.coreSeconds =
      1e-6 * (m.in * rate->in + m.out * rate->out + m.more * rate->more) * machine.dabMs(20, 3, 1.5) / kReferenceMs;
  constexpr double kSurface = 1570;  // bytes of a brick's triangles
  const auto precision =
      arguments.pieces.empty() ? clay::Precision::float32 : at(document, arguments).version.store()->precision();
  if (m.clay) cost.bytes = m.out * (static_cast<double>(clay::brickBytes(precision)) + kSurface);
  return cost;
}

std::string sentence(const PieceCost& cost, int cores) {
  const double seconds = cost.coreSeconds / std::max(1, cores);
  const std::string time = seconds < 0.1    ? "less than 0.1 s"
                           : seconds < 0.95 ? fmt::format("about {:.1g} s", seconds)
                           : seconds < 90   ? fmt::format("about {:.0f} s", seconds)
                                            : fmt::format("about {:.0f} min", seconds / 60);
  return cost.bytes > 0 ? fmt::format("{}, {}B", time, counted(cost.bytes)) : time;
}

void requireMemoryFor(const PieceJob& row, const Document& document, const PieceArguments& arguments,
                      const PieceCost& cost) {
  const Piece* piece = arguments.pieces.empty() ? nullptr : document.piece(arguments.pieces[0]);
  requireMemory(cost.bytes, piece ? fmt::format("{} of {}", row.name, piece->name) : std::string(row.name),
                "use a larger voxel, or close what is not needed");
}

}  // namespace argil::engine
