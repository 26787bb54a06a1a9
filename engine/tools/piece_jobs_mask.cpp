// Masks of whole pieces, as rows of the table.

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/base/error.h"
#include "clay/whole/mask_work.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {
namespace {

constexpr std::array kBlur{
    valueRow<&MaskBlurValues::passes>({
        .id = "passes",
        .name = "Passes",
        .help = "How often it is softened.",
        .unit = "",
        .low = 1,
        .high = 100,
        .standard = 4,
    }),
};
constexpr std::array kCavity{
    valueRow<&MaskCavityValues::radiusMm>({
        .id = "radius",
        .name = "Radius",
        .help = "Hollows as narrow as this are masked whole, those twice as wide not at all.",
        .unit = "mm",
        .low = 0.01,
        .high = 100,
        .standard = 3,
        .logarithmic = true,
    }),
    valueRow<&MaskCavityValues::ridges>({
        .id = "ridges",
        .name = "Ridges",
        .help = "What stands out instead of hollows.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 0,
    }),
    valueRow<&MaskCavityValues::adds>({
        .id = "add",
        .name = "Add",
        .help = "To the mask there is.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 0,
    }),
};
constexpr std::array kLasso{
    valueRow<&MaskLassoValues::frontOnly>({
        .id = "front",
        .name = "Front only",
        .help = "Only clay that faces the view; else through and through.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 1,
    }),
    valueRow<&MaskLassoValues::frees>({
        .id = "erase",
        .name = "Free",
        .help = "Frees what is in the curve instead.",
        .unit = "on",
        .low = 0,
        .high = 1,
        .standard = 0,
    }),
};

const Piece& theFirst(const Document& document, const PieceArguments& arguments) {
  return *document.piece(arguments.pieces.at(0));
}

PieceResult masked(const Piece& piece, clay::Version version) {
  PieceResult result;
  result.changed.push_back(piece);
  result.changed.back().version = std::move(version);
  return result;
}

PieceResult invert(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  return masked(piece, clay::invertMask(piece.version, job, 2));
}

PieceResult clear(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  return masked(piece, clay::clearMask(piece.version, job));
}

PieceResult hide(const Document& document, const PieceArguments& arguments, Job*) {
  PieceResult result;
  result.changed.push_back(hideMasked(theFirst(document, arguments)));
  return result;
}

PieceResult showAll(const Document& document, const PieceArguments& arguments, Job*) {
  PieceResult result = masked(theFirst(document, arguments), theFirst(document, arguments).version);
  result.changed.back().hideMasked = false;
  return result;
}

PieceResult blur(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  return masked(piece, clay::blurMask(piece.version, arguments.get<MaskBlurValues>().passes, job, 2));
}

PieceResult cavity(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  const auto& values = arguments.get<MaskCavityValues>();
  clay::MaskByCavity how;
  how.radius = std::clamp(values.radiusMm / piece.version.grid().voxelMm, 1.0, 1000.0);
  how.ridges = values.ridges;
  how.add = values.adds;
  return masked(piece, clay::maskByCavity(piece.version, how, job, 2));
}

// The curve is seen along its direction, from far away.
PieceResult lasso(const Document& document, const PieceArguments& arguments, Job* job) {
  const Piece& piece = theFirst(document, arguments);
  const Vec3d away = arguments.directionMm.stableNormalized();
  if (!(away.norm() > 0.5)) throw Error("mask-lasso: a direction of no length: give the one that you look along");
  const Vec3d across = away.unitOrthogonal(), up = away.cross(across);
  const clay::Grid& grid = piece.version.grid();
  const auto worldOf = [&](const Vec3d& voxel) -> Vec3d { return piece.pose.apply(grid.toWorld(voxel)); };
  const Vec3d zero = worldOf(Vec3d::Zero());
  clay::MaskLasso how;
  how.view.setZero();
  for (int i = 0; i < 3; ++i) {
    const Vec3d step = worldOf(Vec3d::Unit(i)) - zero;
    how.view(0, i) = across.dot(step);
    how.view(1, i) = up.dot(step);
  }
  how.view(0, 3) = across.dot(zero);
  how.view(1, 3) = up.dot(zero);
  how.view(3, 3) = 1;
  for (const Vec3d& p : arguments.pointsMm) how.curve.emplace_back(across.dot(p), up.dot(p));
  if (arguments.get<MaskLassoValues>().frontOnly) how.eye = Vec3d(piece.pose.rotation.conjugate() * away) * -1e9;
  how.erase = arguments.get<MaskLassoValues>().frees;
  return masked(piece, clay::maskByLasso(piece.version, how, job, 2));
}

}  // namespace

std::span<const PieceJob> maskJobs() {
  static constexpr std::array rows{
      PieceJob{
          .id = "mask-invert",
          .name = "Invert mask",
          .help = "Frees what is masked and masks what is free.",
          .doing = "Inverting the mask",
          .group = "Mask",
          .run = invert,
          .brief = "Invert",
      },
      PieceJob{
          .id = "mask-clear",
          .name = "Clear mask",
          .help = "Frees all of the piece.",
          .doing = "Clearing the mask",
          .group = "Mask",
          .run = clear,
          .brief = "Clear",
      },
      PieceJob{
          .id = "mask-soften",
          .name = "Soften mask",
          .help = "Softens the rim of the mask.",
          .doing = "Softening the mask",
          .group = "Mask",
          .parameters = kBlur,
          .run = blur,
          .brief = "Soften",
      },
      PieceJob{
          .id = "mask-cavity",
          .name = "Mask by cavity",
          .help = "Masks hollows, or what stands out.",
          .doing = "Finding hollows",
          .group = "Mask",
          .parameters = kCavity,
          .run = cavity,
          .brief = "By cavity",
      },
      PieceJob{
          .id = "mask-lasso",
          .name = "Mask by lasso",
          .help = "Masks what a drawn curve goes around.",
          .doing = "Masking",
          .group = "Mask",
          .takesCurve = true,
          .parameters = kLasso,
          .run = lasso,
          .brief = "By lasso",
      },
      PieceJob{
          .id = "mask-hide",
          .name = "Hide masked part",
          .help = "Neither seen nor felt nor changed until all is shown.",
          .doing = "Hiding",
          .group = "Mask",
          .run = hide,
          .brief = "Hide",
      },
      PieceJob{
          .id = "mask-show",
          .name = "Show all",
          .help = "Shows what was hidden; it stays masked.",
          .doing = "Showing",
          .group = "Mask",
          .run = showAll,
          .brief = "Show all",
      },
  };
  return rows;
}

}  // namespace argil::engine
