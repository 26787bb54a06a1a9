// Operations on the shape of one whole piece.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/base/error.h"
#include "clay/field/loose_parts.h"
#include "clay/whole/change_grid.h"
#include "clay/whole/change_precision.h"
#include "clay/whole/mirror.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "engine/document/beside.h"
#include "engine/document/size_words.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/thin_notes.h"

namespace argil::engine {
namespace {

const Piece& pieceOf(const Document& document, const PieceArguments& arguments) {
  return *document.piece(arguments.pieces[0]);
}

PieceResult changedTo(const Piece& piece, clay::Version version, std::vector<std::string> notes = {}) {
  PieceResult result;
  if (version == piece.version) {
    result.notes = std::move(notes);
    return result;
  }
  result.changed.push_back(piece);
  result.changed.back().version = std::move(version);
  result.notes = std::move(notes);
  return result;
}

PieceResult offset(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  clay::ThinParts gone;
  const clay::Version version = clay::offset(piece.version, a.get<OffsetValues>().distanceMm, 0, job, &gone);
  std::vector<std::string> notes;
  addThinNotes(notes, piece, gone);
  return changedTo(piece, version, std::move(notes));
}

PieceResult shell(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const auto& [innerMm, outerMm, narrowMm] = a.get<ShellValues>();
  clay::ThinParts gone;
  const clay::Version version = clay::shell(piece.version, innerMm, outerMm, 0, job, narrowMm, &gone);
  std::vector<std::string> notes;
  addThinNotes(notes, piece, gone);
  return changedTo(piece, version, std::move(notes));
}

PieceResult smooth(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  return changedTo(piece, clay::smoothAll(piece.version, a.get<SmoothValues>().passes, true, 0, job));
}

PieceResult resample(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  clay::Grid grid = piece.version.grid();
  grid.voxelMm = a.get<ResampleValues>().voxelMm;
  const clay::WorkPart all(job);
  const clay::Version version = clay::resample(piece.version, grid, Eigen::Isometry3d::Identity(), 0, all.part(0, 0.9));
  const clay::ResampleError error =
      clay::resampleError(piece.version, version, Eigen::Isometry3d::Identity(), 0, all.part(0.9, 1));
  return changedTo(piece, version,
                   {fmt::format("{}: voxels of {:g} mm, from {:g}; the surface moved by {:.2g} mm RMS and {:.2g} mm at "
                                "most ({:.2g} voxel), measured at {} points both ways.",
                                piece.name, grid.voxelMm, piece.version.grid().voxelMm, error.rmsMm(), error.maxMm(),
                                error.maxMm() / grid.voxelMm, error.points)});
}

PieceResult precision(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const clay::WorkPart all(job);
  const clay::Precision wanted = a.get<PrecisionValues>().precision;
  const clay::Version version = clay::withPrecision(piece.version, wanted, all);
  const int bits = wanted == clay::Precision::fixed16 ? 16 : 32;
  if (version == piece.version)
    return changedTo(piece, version, {fmt::format("{}: has {} bits a voxel already.", piece.name, bits)});
  // Voxel by voxel, as both have the same grid: points of the surface would tell more of how they were found.
  const float band = version.grid().band;
  float moved = 0;
  piece.version.forEachBrick([&](const clay::Brick& brick) {
    const clay::Slot now = version.find(brick.coord);
    for (int i = 0; i < clay::kBrickVoxels; ++i) moved = std::max(moved, std::abs(brick.phi(i) - now.phi(i, band)));
  });
  constexpr double kMegabyte = 1 << 20;
  return changedTo(
      piece, version,
      {fmt::format(
          "{}: {} bits a voxel, {:.1f} MiB, from {:.1f}; no distance moved by more than {:.2g} mm ({:.2g} voxel).",
          piece.name, bits, double(version.stats().bytes()) / kMegabyte,
          double(piece.version.stats().bytes()) / kMegabyte, double(moved) * version.grid().voxelMm, moved)});
}

PieceResult mirror(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const Vec3d point = piece.pose.rotation.conjugate() * (a.plane.pointMm - piece.pose.translation),
              normal = piece.pose.rotation.conjugate() * a.plane.normal;
  return changedTo(piece, clay::mirrorHalf(piece.version, point, normal, 0, job));
}

PieceResult fillVoids(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const clay::Cleaned cleaned = clay::fillVoids(piece.version, clay::WorkPart(job));
  return changedTo(
      piece, cleaned.version,
      {fmt::format("{}: {} filled, {} mm³ together.", piece.name,
                   cleaned.count == 1 ? "1 void" : fmt::format("{} voids", cleaned.count), figure(cleaned.volumeMm3))});
}

PieceResult crumbs(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const clay::Cleaned cleaned = clay::removeCrumbs(piece.version, a.get<CrumbValues>().belowMm3, job);
  return changedTo(piece, cleaned.version,
                   {fmt::format("{}: {} removed, {} mm³ together.", piece.name,
                                cleaned.count == 1 ? "1 crumb" : fmt::format("{} crumbs", cleaned.count),
                                figure(cleaned.volumeMm3))});
}

// Without another place the middle of its lower side stays where it is: what stands goes on standing.
PieceResult scale(const Document& document, const PieceArguments& a, Job* job) {
  const Piece& piece = pieceOf(document, a);
  const double factor = a.get<ScaleValues>().percent / 100;
  if (factor == 1) return {};
  PieceResult result = changedTo(piece, clay::scaled(piece.version, factor, clay::WorkPart(job)));
  const clay::BoxMm before = boundsOf(piece), after = boundsOf(result.changed[0]);
  const auto foot = [](const clay::BoxMm& box) {
    return Vec3d((box.low.x() + box.high.x()) / 2, (box.low.y() + box.high.y()) / 2, box.low.z());
  };
  const auto& about = a.get<ScaleValues>().aboutMm;
  if (about)
    result.changed[0].pose.translation = *about + factor * (piece.pose.translation - *about);
  else if (piece.version.stats().bricks > 0)
    result.changed[0].pose.translation += foot(before) - foot(after);
  const double voxel = result.changed[0].version.grid().voxelMm;
  result.notes.push_back(fmt::format("{}: {}, with voxels of {:.4g} mm; no detail was lost.", piece.name,
                                     sizeWords(after.high - after.low), voxel));
  return result;
}

constexpr std::array kScale{
    valueRow<&ScaleValues::percent>({
        .id = "size",
        .name = "Size",
        .help = "Of the size that it has: 200 makes it twice as large, with the same voxels, each twice as large.",
        .unit = "%",
        .low = 1,
        .high = 10000,
        .standard = 100,
        .logarithmic = true,
    }),
};
constexpr std::array kOffset{
    valueRow<&OffsetValues::distanceMm>({
        .id = "distance",
        .name = "Distance",
        .help = "How far the surface moves: outwards where positive, inwards where negative.",
        .unit = "mm",
        .low = -100,
        .high = 100,
        .standard = 1,
    }),
};
constexpr std::array kShell{
    valueRow<&ShellValues::innerMm>({
        .id = "inner",
        .name = "Inner wall",
        .help = "Thickness of the wall to the inside of the surface.",
        .unit = "mm",
        .low = 0,
        .high = 100,
        .standard = 2,
    }),
    valueRow<&ShellValues::outerMm>({
        .id = "outer",
        .name = "Outer wall",
        .help = "Thickness of the wall to the outside of the surface.",
        .unit = "mm",
        .low = 0,
        .high = 100,
        .standard = 0,
    }),
    valueRow<&ShellValues::narrowMm>({
        .id = "narrow",
        .name = "Least hollow",
        .help = "Hollows narrower than this stay solid, as in pins and thin plates; 0: all are made.",
        .unit = "mm",
        .low = 0,
        .high = 100,
        .standard = 2,
        .zero = "all are made",
    }),
};
constexpr std::array kSmooth{
    valueRow<&SmoothValues::passes>({
        .id = "passes",
        .name = "Passes",
        .help = "How often the surface is evened out; the volume stays.",
        .unit = "",
        .low = 1,
        .high = 200,
        .standard = 3,
        .logarithmic = true,
    }),
};
constexpr std::array kResample{
    valueRow<&ResampleValues::voxelMm>({
        .id = "voxel",
        .name = "Voxel size",
        .help = "Edge of the new voxels.",
        .unit = "mm",
        .low = 0.001,
        .high = 1000,
        .standard = 0.5,
        .logarithmic = true,
    }),
};
constexpr std::array<std::string_view, 2> kBits{"32", "16"};  // as clay::Precision has them
constexpr std::array kPrecision{
    valueRow<&PrecisionValues::precision>({
        .id = "bits",
        .name = "Bits",
        .help = "Of a voxel's distance: 32, or 16 in half the memory.",
        .unit = "",
        .low = 0,
        .high = 1,
        .standard = 1,
        .choices = kBits,
    }),
};
constexpr std::array kCrumbs{
    valueRow<&CrumbValues::belowMm3>({
        .id = "below",
        .name = "Below",
        .help = "Bodies of a lesser volume go; the largest stays.",
        .unit = "mm³",
        .low = 0.001,
        .high = 1e6,
        .standard = 10,
        .logarithmic = true,
    }),
};

const std::array kRows{
    PieceJob{
        .id = "offset",
        .name = "Offset",
        .help = "Makes the piece thicker or thinner all over.",
        .doing = "Offsetting",
        .group = "Shape",
        .parameters = kOffset,
        .run = offset,
        .growsMm = [](const PieceArguments& a) { return a.get<OffsetValues>().distanceMm; },
    },
    PieceJob{
        .id = "shell",
        .name = "Shell",
        .help = "Makes the piece hollow, with a wall of a given thickness.",
        .doing = "Hollowing",
        .group = "Shape",
        .parameters = kShell,
        .run = shell,
        .growsMm = [](const PieceArguments& a) { return a.get<ShellValues>().outerMm; },
    },
    PieceJob{
        .id = "smooth-all",
        .name = "Smooth all",
        .help = "Evens out the whole surface and keeps the volume.",
        .doing = "Smoothing",
        .group = "Shape",
        .parameters = kSmooth,
        .run = smooth,
    },
    PieceJob{
        .id = "scale",
        .name = "Scale",
        .help = "Makes the piece larger or smaller, exactly: its voxels grow with it.",
        .doing = "Scaling",
        .group = "Shape",
        .parameters = kScale,
        .run = scale,
    },
    PieceJob{
        .id = "resample",
        .name = "Resample",
        .help = "Changes the voxel size and says how far the surface moved.",
        .doing = "Resampling",
        .group = "Shape",
        .parameters = kResample,
        .run = resample,
    },
    PieceJob{
        .id = "precision",
        .name = "Precision",
        .help = "Keeps distances in 16 bits, in half the memory, or in 32 again, and says how far they moved.",
        .doing = "Changing the precision",
        .group = "Shape",
        .parameters = kPrecision,
        .run = precision,
    },
    PieceJob{
        .id = "mirror",
        .name = "Mirror now",
        .help = "Puts the mirror image of the half that the plane's normal points to in the place of the other.",
        .doing = "Mirroring",
        .group = "Shape",
        .takesPlane = true,
        .run = mirror,
    },
    PieceJob{
        .id = "fill-voids",
        .name = "Fill voids",
        .help = "Makes cavities solid that no way leads to from outside.",
        .doing = "Filling voids",
        .group = "Repair",
        .run = fillVoids,
    },
    PieceJob{
        .id = "remove-crumbs",
        .name = "Remove crumbs",
        .help = "Takes away loose bodies below a volume.",
        .doing = "Removing crumbs",
        .group = "Repair",
        .parameters = kCrumbs,
        .run = crumbs,
    },
};

}  // namespace

std::span<const PieceJob> shapeJobs() {
  return kRows;
}

}  // namespace argil::engine
