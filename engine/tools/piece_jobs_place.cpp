// Operations that say how pieces stand: laid flat, on a base, side by side on beds.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/base/error.h"
#include "clay/surface/surface.h"
#include "engine/document/size_words.h"
#include "engine/print/base.h"
#include "engine/print/lay_flat.h"
#include "engine/print/nest.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/thin_notes.h"

namespace argil::engine {
namespace {

const Piece& pieceOf(const Document& document, const PieceArguments& arguments) {
  return *document.piece(arguments.pieces[0]);
}

std::string counted(size_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

PieceResult layFlat(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const Rests rests = restsOf(piece.version, piece.pose, job);
  if (rests.ways.empty()) throw Error("it rests nowhere: it is as round as a ball", Error::Kind::work);
  const Rest& rest = rests.ways[0];
  PieceResult result;
  result.changed.push_back(piece);
  // Where it was, on the ground that it stood on.
  haptics::Pose& pose = result.changed[0].pose;
  pose.rotation = (rest.turn * piece.pose.rotation).normalized();
  Vec3d move = rests.middleMm - rest.turn * rests.middleMm;
  move.z() = rests.lowMm - rest.lowMm;
  pose.translation = rest.turn * piece.pose.translation + move;
  result.notes.push_back(fmt::format("{}: on a foot of {} mm², {:.3g} mm high; it tips at {:.2g}°.", piece.name,
                                     figure(rest.footMm2), rest.heightMm, rest.tipsDegrees));
  return result;
}

PieceResult base(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const auto& values = a.get<BaseValues>();
  clay::ThinParts gone;
  PieceResult result;
  result.changed.push_back(piece);
  result.changed[0].version = withBase(piece.version, piece.pose,
                                       {.square = values.square,
                                        .heightMm = values.heightMm,
                                        .marginMm = values.marginMm,
                                        .sunkMm = values.sunkMm,
                                        .dots = values.dots},
                                       job, &gone);
  addThinNotes(result.notes, piece, gone);
  return result;
}

// Places of its surface from above, in the world, about a voxel apart; and its lowest.
struct SeenFromAbove {
  std::vector<Vec2d> places;
  double lowMm = INFINITY;
};
SeenFromAbove fromAbove(const Piece& piece) {
  SeenFromAbove seen;
  clay::Surface surface(false, clay::Grade::crisp);
  (void)surface.update(piece.version, 2);
  const clay::Grid& grid = piece.version.grid();
  surface.forEach([&](const clay::BrickMesh& mesh) {
    for (const Vec3f& each : mesh.positions) {
      const Vec3d at = piece.pose.apply(grid.toWorld(mesh.brick.toVec3d() * clay::kBrickEdge + each.cast<double>()));
      seen.places.emplace_back(at.head<2>());
      seen.lowMm = std::min(seen.lowMm, at.z());
    }
  });
  return seen;
}

constexpr double kBetweenBeds = 20;  // mm

PieceResult nestAll(const Document& document, const PieceArguments& a, Job* job) {
  const auto& values = a.get<NestValues>();
  const clay::WorkPart part(job);
  PieceResult result;
  std::vector<std::vector<Vec2d>> footprints;
  std::vector<double> lows;
  NestOptions options{.bedMm = {values.widthMm, values.depthMm}, .gapMm = values.gapMm, .turns = values.turns};
  Vec2d corner = Vec2d::Constant(INFINITY);
  for (const Piece& piece : document.pieces) {
    part.step(0.3 * double(footprints.size()) / double(document.pieces.size()));
    if (!piece.visible || piece.locked) continue;
    SeenFromAbove seen = fromAbove(piece);
    if (seen.places.empty()) continue;
    for (const Vec2d& each : seen.places) corner = corner.cwiseMin(each);
    options.cellMm = std::max(options.cellMm, 1.5 * piece.version.grid().voxelMm);
    result.changed.push_back(piece);
    footprints.push_back(std::move(seen.places));
    lows.push_back(seen.lowMm);
  }
  if (footprints.empty()) throw Error("there is nothing to lay on a bed: show or unlock a piece");
  std::vector<Nested> nested;
  try {
    nested = nest(footprints, options, part.part(0.3, 1));
  } catch (const LargerThanBed& larger) {
    throw Error(fmt::format("{} is larger than the bed, {:g} × {:g} mm: give a larger one, or cut it",
                            result.changed[larger.which].name, values.widthMm, values.depthMm));
  }
  const double ground = *std::min_element(lows.begin(), lows.end());
  int beds = 0;
  for (size_t i = 0; i < nested.size(); ++i) {
    const Nested& each = nested[i];
    haptics::Pose& pose = result.changed[i].pose;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(each.turn, Vec3d::UnitZ()));
    const Vec2d move = corner + each.moveMm + Vec2d(each.bed * (values.widthMm + kBetweenBeds), 0);
    pose.rotation = (turn * pose.rotation).normalized();
    pose.translation = turn * pose.translation + Vec3d(move.x(), move.y(), ground - lows[i]);
    beds = std::max(beds, each.bed + 1);
  }
  result.notes.push_back(
      fmt::format("{} on {}.", counted(nested.size(), "piece", "pieces"), counted(size_t(beds), "bed", "beds")));
  return result;
}

constexpr std::array<std::string_view, 2> kBaseShapes{"round", "square"};
constexpr std::array kBase{
    valueRow<&BaseValues::square>({
        .id = "shape",
        .name = "Shape",
        .help = "round: around all of the piece; square: as wide and deep as it is.",
        .unit = "",
        .low = 0,
        .high = 1,
        .standard = 0,
        .choices = kBaseShapes,
    }),
    valueRow<&BaseValues::heightMm>({
        .id = "height",
        .name = "Height",
        .help = "Of the base.",
        .unit = "mm",
        .low = 0.01,
        .high = 1000,
        .standard = 5,
        .logarithmic = true,
    }),
    valueRow<&BaseValues::marginMm>({
        .id = "margin",
        .name = "Margin",
        .help = "By which it is wider than the piece, all around.",
        .unit = "mm",
        .low = 0,
        .high = 1000,
        .standard = 3,
    }),
    valueRow<&BaseValues::sunkMm>({
        .id = "sunk",
        .name = "Sunk",
        .help = "How deep the piece stands in it.",
        .unit = "mm",
        .low = 0,
        .high = 1000,
        .standard = 1,
    }),
    valueRow<&BaseValues::dots>({
        .id = "dots",
        .name = "Dots",
        .help = "Bored into its underside, to tell pieces apart.",
        .unit = "",
        .low = 0,
        .high = 9,
        .standard = 0,
    }),
};
constexpr std::array kNest{
    valueRow<&NestValues::widthMm>({
        .id = "width",
        .name = "Width",
        .help = "Of the bed.",
        .unit = "mm",
        .low = 1,
        .high = 100000,
        .standard = 250,
        .logarithmic = true,
    }),
    valueRow<&NestValues::depthMm>({
        .id = "depth",
        .name = "Depth",
        .help = "Of the bed.",
        .unit = "mm",
        .low = 1,
        .high = 100000,
        .standard = 210,
        .logarithmic = true,
    }),
    valueRow<&NestValues::gapMm>({
        .id = "gap",
        .name = "Gap",
        .help = "From one piece to the next.",
        .unit = "mm",
        .low = 0,
        .high = 1000,
        .standard = 3,
    }),
    valueRow<&NestValues::turns>({
        .id = "turns",
        .name = "Turns",
        .help = "Ways to turn each piece that are tried; 1: as it lies.",
        .unit = "",
        .low = 1,
        .high = 64,
        .standard = 8,
    }),
};
const std::array kRows{
    PieceJob{
        .id = "lay-flat",
        .name = "Lay flat",
        .help = "Turns it so that it rests on its largest foot, and stands it on the ground.",
        .doing = "Laying flat",
        .group = "Print",
        .run = layFlat,
    },
    PieceJob{
        .id = "base",
        .name = "Base",
        .help = "Gives it a plate to stand on.",
        .doing = "Making a base",
        .group = "Print",
        .parameters = kBase,
        .run = base,
    },
    PieceJob{
        .id = "nest",
        .name = "Nest",
        .help = "Lays all visible pieces close together on a bed, and on more beds where one has no room.",
        .doing = "Nesting",
        .group = "Print",
        .pieces = 0,
        .parameters = kNest,
        .run = nestAll,
        .takesAll = true,
    },
};

}  // namespace

std::span<const PieceJob> placeJobs() {
  return kRows;
}

}  // namespace argil::engine
