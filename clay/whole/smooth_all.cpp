#include "clay/whole/smooth_all.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/field/region_work.h"

namespace argil::clay {

namespace {

constexpr int kTogether = 4;  // passes on one box of distances, which reaches farther for it
constexpr int kVolumeSteps = 6;
constexpr double kVolumeError = 1e-5;

// How far outwards the surface has that volume: by secants, the first with the area.
float shiftTo(double volume, const Version& version) {
  const double most = version.grid().band - 1, begin = volumeOf(version);
  double shift = 0, now = begin, gain = areaOf(version);
  for (int i = 0; i < kVolumeSteps && std::abs(volume - now) > kVolumeError * volume; ++i) {
    shift = std::clamp(shift + (volume - now) / gain, -most, most);
    now = volumeOf(version, static_cast<float>(shift));
    if (shift != 0 && (now - begin) / shift > 0) gain = (now - begin) / shift;
  }
  return static_cast<float>(shift);
}

}  // namespace

Version smoothAll(const Version& version, int passes, bool keepVolume, int threads, Job* job) {
  if (passes < 1 || passes > 200) throw Error(fmt::format("smoothing in {} passes: give 1 to 200", passes));
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is nothing to smooth");
  threads = threadCount(threads);
  const WorkPart all(job);
  const int boxes = (passes + kTogether - 1) / kTogether;
  const double steps = boxes + 1;
  Version now = version;
  int done = 0;
  const auto run = [&](int together, float shift) {
    // Values within the band come from voxels that lie a little farther off; the mean leaves no distances, so that the
    // last step measures them even where nothing moves.
    const float reach = version.grid().band + 0.5f + static_cast<float>(std::max(together - 1, 0)) + std::abs(shift);
    const int near = 2 + static_cast<int>(std::ceil(std::abs(shift)));
    now = rebuild(now, regionsNear(now, near), {reach, reach}, threads, all.part(done / steps, (done + 1) / steps),
                  {together, shift, CarryFrom::place});
    ++done;
    if (now.stats().bricks == 0)
      throw Error("nothing is left after smoothing: the piece is thinner than that; give fewer passes",
                  Error::Kind::work);
  };
  const double volume = volumeOf(version);
  for (int left = passes; left > 0; left -= kTogether) run(std::min(left, kTogether), 0);
  run(0, keepVolume ? shiftTo(volume, now) : 0);
  if (job) job->step(1);
  return now;
}

}  // namespace argil::clay
