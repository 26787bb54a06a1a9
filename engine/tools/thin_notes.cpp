#include "engine/tools/thin_notes.h"

#include <fmt/format.h>

#include <cmath>

namespace argil::engine {

namespace {

constexpr double kLeastTold = 0.001;  // mm³
constexpr double kLeastSeam = 4;      // voxels²: less is a crease where surfaces only meet

std::string volumeWords(double mm3) {
  return mm3 < kLeastTold ? fmt::format("less than {:g} mm³", kLeastTold) : fmt::format("{:.3g} mm³", mm3);
}

}  // namespace

void addThinNotes(std::vector<std::string>& notes, const Piece& piece, const clay::ThinParts& gone) {
  const double voxel = piece.version.grid().voxelMm, voxel3 = std::pow(voxel, 3);
  const std::string thin = fmt::format("thinner than a quarter voxel ({:.3g} mm)", double(clay::kThinnest) * voxel);
  if (gone.seamArea >= kLeastSeam)
    notes.push_back(fmt::format("{}: faces that touched were joined, {:.3g} mm²; gaps {} between them were filled.",
                                piece.name, gone.seamArea * voxel * voxel, thin));
  else if (gone.airVoxels > 0)
    notes.push_back(fmt::format("{}: gaps {} were filled: {} voxels, {}.", piece.name, thin, gone.airVoxels,
                                volumeWords(gone.airVolume * voxel3)));
  if (gone.clayVoxels > 0)
    notes.push_back(fmt::format("{}: clay {} was removed: {} voxels, {}.", piece.name, thin, gone.clayVoxels,
                                volumeWords(gone.clayVolume * voxel3)));
  if (gone.betweenVoxels >= kLeastBetween)
    notes.push_back(
        fmt::format("{}: at least {} of clay thinner than a voxel ({:.3g} mm) was lost beside the cut; finer "
                    "voxels keep it.",
                    piece.name, volumeWords(gone.betweenVoxels * voxel3), voxel));
}

}  // namespace argil::engine
