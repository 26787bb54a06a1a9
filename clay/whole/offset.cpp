#include "clay/whole/offset.h"

#include <fmt/format.h>

#include <cmath>

#include "clay/field/region_work.h"
#include "clay/field/thin_parts.h"
#include "clay/whole/boolean.h"

namespace argil::clay {

namespace {

constexpr double kMostVoxels = 10000;
constexpr double kMostStep = 16;  // voxels: the margin around a region grows with it
constexpr double kLeastWall = 2;  // voxels: less is a sheet that the voxels cannot tell from its sides

// One step, so short that the region around a place holds all that can be nearest.
Version step(const Version& version, float voxels, int threads, const WorkPart& part, ThinParts* gone) {
  const float band = version.grid().band;
  const DistanceBox::Reach reach{std::max(band, band - voxels), std::max(band, band + voxels)};
  const std::vector<Coord> regions = regionsNear(version, static_cast<int>(std::ceil(std::abs(voxels))) + 2);
  return rebuild(version, regions, reach, threads, part, voxels, gone);
}

Version moved(const Version& version, double voxels, int threads, const WorkPart& part, ThinParts* gone = nullptr) {
  if (!(std::abs(voxels) <= kMostVoxels))
    throw Error(
        fmt::format("moving the surface by {:.0f} voxels is too much: give at most {:.0f}, or use a larger voxel",
                    voxels, kMostVoxels));
  if (voxels == 0) return version;
  const int steps = static_cast<int>(std::ceil(std::abs(voxels) / kMostStep));
  Version now = version;
  for (int i = 0; i < steps; ++i) {
    now = step(now, static_cast<float>(voxels / steps), threads, part.part(double(i) / steps, double(i + 1) / steps),
               gone);
    if (now.stats().bricks == 0) break;
  }
  return now;
}

}  // namespace

Version offset(const Version& version, double mm, int threads, Job* job, ThinParts* gone) {
  return offset(version, mm, threads, WorkPart(job), gone);
}

Version offset(const Version& version, double mm, int threads, const WorkPart& part, ThinParts* gone) {
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is no surface to move");
  const Version result = moved(version, mm / version.grid().voxelMm, threadCount(threads), part, gone);
  if (result.stats().bricks == 0)
    throw Error(fmt::format("nothing is left when the surface moves inwards by {:g} mm: give less", -mm),
                Error::Kind::work);
  part.step(1);
  return result;
}

Version shell(const Version& version, double innerMm, double outerMm, int threads, Job* job, double narrowMm,
              ThinParts* gone) {
  const double voxel = version.grid().voxelMm;
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is nothing to hollow");
  if (!(innerMm >= 0 && outerMm >= 0) || !((innerMm + outerMm) / voxel >= kLeastWall))
    throw Error(fmt::format(
        "a wall of {:g} mm inside and {:g} mm outside at voxels of {:g} mm: give a wall of at least {:g} mm", innerMm,
        outerMm, voxel, kLeastWall * voxel));
  if (!(narrowMm >= 0)) throw Error(fmt::format("hollows narrower than {:g} mm: give 0 or more", narrowMm));
  threads = threadCount(threads);
  const WorkPart all(job);
  const double inner = innerMm / voxel, outer = outerMm / voxel, ball = 0.5 * narrowMm / voxel,
               work = (inner + outer + 2 * ball) / 0.85, outside = outer / work, within = (outer + inner) / work,
               middles = within + ball / work;
  ThinParts here, inHollow;
  const Version around = moved(version, outer, threads, all.part(0, outside), &here);
  Version hollow = moved(version, -inner, threads, all.part(outside, within), &inHollow);
  if (ball > 0 && hollow.stats().bricks > 0) {
    const Version middle = moved(hollow, -ball, threads, all.part(within, middles));
    // Both: beside sharp edges what goes out again goes up to half a voxel too far.
    hollow = middle.stats().bricks == 0 ? middle
                                        : combine(hollow, moved(middle, ball, threads, all.part(middles, 0.85)),
                                                  Combination::intersect, {.gone = &inHollow}, all.part(0.85, 0.9));
  }
  if (hollow.stats().bricks == 0)
    throw Error(
        fmt::format("nothing is hollow with a wall of {:g} mm to the inside{}: the piece is too thin; give less",
                    innerMm, ball > 0 ? fmt::format(", hollows {:g} mm wide and more", narrowMm) : ""),
        Error::Kind::work);
  const Version wall = combine(around, hollow, Combination::cut, {.gone = &here}, all.part(0.9, 1));
  if (gone != nullptr) {
    // A hollow is made as the clay that it takes out.
    here.airVoxels += inHollow.clayVoxels;
    here.airVolume += inHollow.clayVolume;
    *gone += here;
  }
  if (job) job->step(1);
  return wall;
}

}  // namespace argil::clay
