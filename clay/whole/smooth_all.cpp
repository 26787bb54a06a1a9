#include "clay/whole/smooth_all.h"

#include <fmt/format.h>

#include "clay/field/region_work.h"

namespace argil::clay {

namespace {

constexpr float kBeyondBand = 0.5f;  // voxels: a reach past the band has distances measured
constexpr int kVolumeSteps = 2;      // the first leaves what the area changes with the distance

float binomial(const DistanceBox& box, Coord v) {
  constexpr float kWeight[3] = {0.25f, 0.5f, 0.25f};
  float sum = 0;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z) sum += kWeight[x] * kWeight[y] * kWeight[z] * box.at(v + Coord{x - 1, y - 1, z - 1});
  return sum;
}

}  // namespace

Version smoothAll(const Version& version, int passes, bool keepVolume, int threads, Job* job) {
  if (passes < 1 || passes > 200) throw Error(fmt::format("smoothing in {} passes: give 1 to 200", passes));
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is nothing to smooth");
  threads = threadCount(threads);
  const WorkPart all(job);
  const double steps = passes + 1 + (keepVolume ? kVolumeSteps : 0);
  const float reach = version.grid().band + kBeyondBand;
  Version now = version;
  int done = 0;
  const auto run = [&](const std::function<float(const DistanceBox&, Coord)>& value, int pad) {
    now = rebuild(now, regionsNear(now, 2), {reach, reach}, threads, all.part(done / steps, (done + 1) / steps), value,
                  CarryFrom::place, pad);
    ++done;
    if (now.stats().bricks == 0)
      throw Error("nothing is left after smoothing: the piece is thinner than that; give fewer passes",
                  Error::Kind::work);
  };
  const double volume = volumeOf(version);
  for (int pass = 0; pass < passes; ++pass) run(binomial, 1);
  run([](const DistanceBox& box, Coord v) { return box.at(v); }, 0);
  for (int i = 0; keepVolume && i < kVolumeSteps; ++i) {
    const auto shift = static_cast<float>((volume - volumeOf(now)) / areaOf(now));
    run([shift](const DistanceBox& box, Coord v) { return box.at(v) - shift; }, 0);
  }
  if (job) job->step(1);
  return now;
}

}  // namespace argil::clay
