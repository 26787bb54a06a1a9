#include "clay/whole/fill_hollows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/base/error.h"
#include "clay/field/loose_parts.h"
#include "clay/field/region_work.h"
#include "clay/field/solid_from.h"
#include "clay/store/sampler.h"
#include "clay/whole/boolean.h"
#include "clay/whole/deform.h"

namespace argil::clay {

namespace {

constexpr double kLeastWall = 2;  // voxels: less is a sheet that they cannot tell
constexpr double kLeastDensity = 0.02, kMostDensity = 0.8;
constexpr double kPlaces = 40000;  // that a density is counted at
constexpr int kHalvings = 14;      // of the cell: to a thousandth

// Places spread evenly over what is clay in `filled` and air in `version`, in voxels.
std::vector<Vec3d> placesInHollows(const Version& version, const Version& filled, const BoxMm& box, double hollow) {
  const Vec3d low = version.grid().toVoxel(box.low), size = version.grid().toVoxel(box.high) - low;
  const auto count = static_cast<int>(std::min(1e8, kPlaces * std::max(1.0, size.prod() / std::max(1.0, hollow))));
  Sampler with(version), without(filled);
  std::vector<Vec3d> places;
  for (int i = 0; i < count; ++i) {
    // The R3 sequence (Roberts 2018).
    const Vec3d at(std::fmod(0.5 + 0.8191725134 * i, 1), std::fmod(0.5 + 0.6710436067 * i, 1),
                   std::fmod(0.5 + 0.5497004779 * i, 1));
    const Vec3d p = low + at.cwiseProduct(size);
    if (without.trilinear(p) < 0 && with.trilinear(p) >= 0) places.push_back(p);
  }
  return places;
}

double densityAt(const std::vector<Vec3d>& places, const InfillField& field) {
  const auto inside =
      std::count_if(places.begin(), places.end(), [&](const Vec3d& p) { return field.distance(p) < 0; });
  return double(inside) / double(places.size());
}

}  // namespace

FilledHollows fillHollows(const Version& version, const HollowFilling& filling, int threads, const WorkPart& part) {
  const double voxel = version.grid().voxelMm, wall = filling.wallMm / voxel;
  if (!(wall >= kLeastWall))
    throw Error(fmt::format("an infill of {:g} mm at voxels of {:g} mm: give at least {:g} mm, two voxels",
                            filling.wallMm, voxel, kLeastWall * voxel));
  if (!(filling.density >= kLeastDensity && filling.density <= kMostDensity))
    throw Error(fmt::format("an infill of {:.3g} %: give {:g} to {:g}", 100 * filling.density, 100 * kLeastDensity,
                            100 * kMostDensity));
  threads = threadCount(threads);
  const Cleaned solid = fillVoids(version, part.part(0, 0.05));
  const double before = volumeOf(version, 0, threads), hollow = volumeOf(solid.version, 0, threads) - before;
  std::vector<Vec3d> places;
  const BoxMm box = boundsOf(solid.version);
  if (solid.count > 0) places = placesInHollows(version, solid.version, box, hollow);
  if (places.empty())
    throw Error("nothing is hollow here, with walls all around: make a shell first, and holes afterwards",
                Error::Kind::work);
  part.step(0.1);
  const Vec3d low = version.grid().toVoxel(box.low), high = version.grid().toVoxel(box.high);
  const Vec3d centre = (low + high) / 2, half = (high - low) / 2;
  for (Vec3d& each : places) each -= centre;
  const double near = double(version.grid().band) + 2;
  const auto fieldOf = [&](double cell) { return InfillField(filling.kind, cell, wall, filling.turn, near); };

  double small = 1.05 * wall, large = wall;  // The density falls as the cell grows.
  while (infillDensity(filling.kind, wall / large) > filling.density / 2) large *= 1.5;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(small * large);
    (densityAt(places, fieldOf(middle)) > filling.density ? small : large) = middle;
    part.step(0.1 + 0.2 * i / kHalvings);
  }
  FilledHollows result;
  const double cell = std::sqrt(small * large);
  result.cellMm = cell * voxel;
  result.hollowMm3 = hollow * voxel * voxel * voxel;

  const InfillField field = fieldOf(cell);
  const Version pattern =
      solid::make(Store::make(version.store()->precision()), version.grid(), (box.low + box.high) / 2,
                  (box.high - box.low) / 2, "infill", nullptr, [&](const Vec3d& p) {
                    const Vec3d q = (p - centre).cwiseAbs() - half;
                    return std::max(field.distance(p - centre), q.maxCoeff());
                  });
  part.step(0.5);
  const Version inside =
      combine(pattern, solid.version, Combination::intersect, {.threads = threads}, part.part(0.5, 0.75));
  result.version = combine(version, inside, Combination::join, {.threads = threads}, part.part(0.75, 1));
  result.density = (volumeOf(result.version, 0, threads) - before) / hollow;
  return result;
}

}  // namespace argil::clay
