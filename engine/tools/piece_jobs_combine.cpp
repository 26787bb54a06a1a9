// Operations on two pieces, and those that make several of one.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/base/error.h"
#include "clay/field/loose_parts.h"
#include "clay/whole/boolean.h"
#include "clay/whole/resample.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/thin_notes.h"

namespace argil::engine {
namespace {

Eigen::Isometry3d isometry(const haptics::Pose& pose) {
  Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
  m.linear() = pose.rotation.toRotationMatrix();
  m.translation() = pose.translation;
  return m;
}

// Rows of the second piece's materials that the first lacks go behind its own, as far as there is room. What each of
// the second's numbers becomes.
std::vector<uint8_t> joinMaterials(std::vector<MaterialRow>& rows, const std::vector<MaterialRow>& more) {
  std::vector<uint8_t> becomes{0};
  for (const MaterialRow& row : more) {
    auto at = std::find(rows.begin(), rows.end(), row);
    if (at == rows.end() && rows.size() < kMaxMaterialRows) at = rows.insert(rows.end(), row);
    becomes.push_back(at == rows.end() ? 0 : static_cast<uint8_t>(at - rows.begin() + 1));
  }
  return becomes;
}

constexpr double kMostMemory = 2;  // Of a result whose voxels nobody chose, times that of both pieces.
constexpr double kMegabyte = 1e6;

CombineCost combineCost(bool cuts, const Piece& first, const Piece& second, double voxelMm) {
  // Memory follows the surface, counted in voxels.
  const double a = first.version.grid().voxelMm, b = second.version.grid().voxelMm;
  const double bytesA = double(first.version.stats().bytes()), bytesB = double(second.version.stats().bytes());
  const double area = bytesA * a * a + bytesB * b * b;
  if (!(voxelMm > 0))
    voxelMm = cuts || a == b
                  ? a
                  : std::clamp(std::sqrt(area / (kMostMemory * (bytesA + bytesB))), std::min(a, b), std::max(a, b));
  return {voxelMm, static_cast<uint64_t>(area / (voxelMm * voxelMm))};
}

template <clay::Combination how>
PieceResult combinePieces(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece &first = *document.piece(arguments.pieces[0]), &second = *document.piece(arguments.pieces[1]);
  const auto& values = arguments.get<CombineValues>();
  const Eigen::Isometry3d toFirst = isometry(first.pose).inverse() * isometry(second.pose);
  clay::Version own = first.version, other = second.version;
  const clay::WorkPart all(job);
  const bool moves = !(toFirst.matrix() - Eigen::Matrix4d::Identity()).isZero(1e-12);
  clay::Grid grid = own.grid();
  const CombineCost cost = combineCost(how == clay::Combination::cut, first, second, values.voxelMm);
  if (cost.voxelMm != grid.voxelMm) {
    grid.voxelMm = cost.voxelMm;
    own = clay::resample(own, grid, Eigen::Isometry3d::Identity(), 0, all.part(0, 0.3));
  }
  if (moves || !(other.grid() == grid)) other = clay::resample(other, grid, toFirst, 0, all.part(0.3, 0.6));
  clay::CombineOptions options;
  clay::ThinParts gone;
  options.blendMm = values.blendMm;
  options.gone = &gone;
  Piece piece = first;
  if (other.has(clay::Channel::material)) options.materials = joinMaterials(piece.materials, second.materials);
  piece.version = clay::combine(own, other, how, options, all.part(0.6, 1));
  if (piece.version.stats().bricks == 0) {
    for (const Piece* each : {&first, &second})
      if (each->version.stats().bricks == 0)
        throw Error(fmt::format("{} is empty: add clay first", each->name), Error::Kind::work);
    throw Error(fmt::format("nothing is left of {} and {}: move them so that they {}", first.name, second.name,
                            how == clay::Combination::cut ? "overlap less" : "overlap"),
                Error::Kind::work);
  }
  PieceResult result;
  addThinNotes(result.notes, piece, gone);
  result.changed.push_back(std::move(piece));
  if (!values.keepsSecond) result.removed.push_back(second.id);
  if (first.version.grid().voxelMm != second.version.grid().voxelMm) {
    const clay::Version& made = result.changed[0].version;
    result.notes.push_back(fmt::format("{}: voxels of {:.4g} mm, {:.0f} MB; {} had {:.4g} mm and {} {:.4g} mm.",
                                       first.name, made.grid().voxelMm,
                                       std::ceil(double(made.stats().bytes()) / kMegabyte), first.name,
                                       first.version.grid().voxelMm, second.name, second.version.grid().voxelMm));
  }
  return result;
}

PieceResult split(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = *document.piece(arguments.pieces[0]);
  const std::vector<clay::Version> parts = clay::splitParts(piece.version, job);
  PieceResult result;
  if (parts.size() == 1) {
    result.notes.push_back(fmt::format("{} is in one part; there is nothing to split.", piece.name));
    return result;
  }
  for (size_t i = 0; i < parts.size(); ++i) {
    Piece part = piece;
    part.version = parts[i];
    if (i > 0) part.name = fmt::format("{} {}", piece.name, i + 1);
    (i == 0 ? result.changed : result.added).push_back(std::move(part));
  }
  result.notes.push_back(fmt::format("{} was split into {} parts.", piece.name, parts.size()));
  return result;
}

constexpr std::array kCombine{
    valueRow<&CombineValues::blendMm>({
        .id = "blend",
        .name = "Blend",
        .help = "Width over which the surfaces run into each other; 0: a sharp crease.",
        .unit = "mm",
        .low = 0,
        .high = 50,
        .standard = 0,
        .zero = "none",
    }),
    valueRow<&CombineValues::keepsSecond>({
        .id = "keep",
        .name = "Keep the second piece",
        .help = "It stays beside the result.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 0,
    }),
    valueRow<&CombineValues::voxelMm>({
        .id = "voxel",
        .name = "Voxel size",
        .help = "Of the result; 0: as suits both pieces.",
        .unit = "mm",
        .low = 0,
        .high = 1000,
        .standard = 0,
        .zero = "automatic",
    }),
};

const std::array kRows{
    PieceJob{
        .id = "join",
        .name = "Join",
        .help = "Makes one piece of two.",
        .doing = "Joining",
        .group = "Combine",
        .pieces = 2,
        .parameters = kCombine,
        .run = combinePieces<clay::Combination::join>,
    },
    PieceJob{
        .id = "cut",
        .name = "Cut away",
        .help = "Takes the second piece's shape out of the first.",
        .doing = "Cutting",
        .group = "Combine",
        .pieces = 2,
        .parameters = kCombine,
        .run = combinePieces<clay::Combination::cut>,
    },
    PieceJob{
        .id = "intersect",
        .name = "Intersect",
        .help = "Keeps what lies in both pieces.",
        .doing = "Intersecting",
        .group = "Combine",
        .pieces = 2,
        .parameters = kCombine,
        .run = combinePieces<clay::Combination::intersect>,
    },
    PieceJob{
        .id = "split",
        .name = "Split loose parts",
        .help = "Makes a piece of each part that hangs together.",
        .doing = "Splitting",
        .group = "Combine",
        .run = split,
    },
};

}  // namespace

CombineCost combineCost(const PieceJob& row, const Piece& first, const Piece& second, double voxelMm) {
  return combineCost(row.id == "cut", first, second, voxelMm);
}

std::span<const PieceJob> combineJobs() {
  return kRows;
}

}  // namespace argil::engine
