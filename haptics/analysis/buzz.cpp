#include "haptics/analysis/buzz.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "haptics/contact/contact.h"
#include "haptics/devices/simulated.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

constexpr double kPeriodS = 1e-3;
constexpr double kWallVoxels = 4;
constexpr double kJump = 2.9;  // Voxels: within the band, or they were tiles.
constexpr double kComeS = 0.5, kAboveMm = 3, kDeepMm = 3, kGlideMms = 40, kBeginMm = -20;
constexpr double kVelocityCutoffHz = 40;  // As the servo filters encoder differences.
constexpr double kDampingFraction = 0.5;
constexpr int kSwingTicks = 50;
constexpr double kTurnMm = 0.05;

constexpr double kTopMm = 0.2, kBottomMm = kTopMm - kWallVoxels * kBuzzVoxelMm;  // Between the planes of voxels.

clay::Version stepWall() {
  clay::Grid grid;
  grid.voxelMm = kBuzzVoxelMm;
  clay::Editor editor(clay::Version::empty(clay::Store::make(), grid));
  constexpr int kHalfX = 8, kHalfY = 2, kHalfZ = 2;  // Bricks.
  for (int bx = -kHalfX; bx < kHalfX; ++bx)
    for (int by = -kHalfY; by < kHalfY; ++by)
      for (int bz = -kHalfZ; bz < kHalfZ; ++bz) {
        float phi[clay::kBrickVoxels];
        for (int i = 0; i < clay::kBrickVoxels; ++i) {
          const double z = kBuzzVoxelMm * (8 * bz + (i & 7));
          const bool inside = z < kTopMm && z > kBottomMm;
          phi[i] = static_cast<float>(inside ? -kJump : kJump);
        }
        editor.setVoxels({bx, by, bz}, std::span<const float, clay::kBrickVoxels>(phi));
      }
  return editor.commit();
}

void judge(BuzzRun& run, double peakN) {
  const auto first = static_cast<size_t>((kComeS + 0.1) / kPeriodS);  // It has arrived.
  double jump2 = 0, swing2 = 0, turn = run.ticks[first].hand.z();
  size_t jumps = 0, swings = 0, turns = 0;
  int way = 1;
  for (size_t i = first; i < run.ticks.size(); ++i) {
    const BuzzTick& tick = run.ticks[i];
    jump2 += (tick.force - run.ticks[i - 1].force).squaredNorm();
    ++jumps;
    run.popped += tick.hand.z() < kBottomMm;
    if (i >= first + kSwingTicks) {
      double low = 1e9, high = -1e9;
      for (size_t k = i - kSwingTicks; k <= i; ++k) {
        low = std::min(low, run.ticks[k].hand.z());
        high = std::max(high, run.ticks[k].hand.z());
      }
      swing2 += (high - low) * (high - low);
      ++swings;
    }
    // A turn is a way back of more than kTurnMm from the farthest place since the last one.
    const double z = tick.hand.z();
    if (way * (z - turn) > 0) {
      turn = z;
    } else if (std::abs(z - turn) > kTurnMm) {
      ++turns;
      way = -way;
      turn = z;
    }
  }
  run.jumpRms = 100 * std::sqrt(jump2 / double(jumps)) / peakN;
  run.swingMm = std::sqrt(swing2 / double(swings));
  run.reversals = double(turns) / (double(run.ticks.size() - first) * kPeriodS);
}

}  // namespace

BuzzRun runBuzz(std::string_view contactName, const DeviceSheet& sheet) {
  Scene scene;
  scene.pieces.push_back({stepWall(), {}, 0});
  scene.materials[0].stiffnessNmm = kBuzzStiffnessNmm;
  scene.tool.radiusMm = kBuzzBallMm;
  scene.check();
  const Vec3d above(kBeginMm, 0.1, kTopMm + kAboveMm), pressed(kBeginMm, 0.1, kTopMm - kDeepMm),
      end(kBeginMm + kGlideMms * kBuzzGlideS, 0.1, kTopMm - kDeepMm);
  const HandPath path = HandPath::line(above, pressed, kComeS)
                            .then(HandPath::hold(pressed, kBuzzPressS))
                            .then(HandPath::line(pressed, end, kBuzzGlideS));
  SimulatedDevice::Options options;
  options.delayS = kPeriodS;
  SimulatedDevice device(sheet, path, options);
  const auto contact = makeContact(contactName);

  Contact::Input in;
  in.periodS = kPeriodS;
  in.topStiffnessNmm = sheet.topStiffnessNmm;
  in.dampingNsmm = kDampingFraction * sheet.topDampingNsmm;
  in.peakForceN = sheet.peakForceN;
  const double smoothing = 1 - std::exp(-2 * std::numbers::pi * kVelocityCutoffHz * kPeriodS);
  BuzzRun run;
  const auto ticks = static_cast<size_t>((kComeS + kBuzzPressS + kBuzzGlideS) / kPeriodS);
  for (size_t i = 0; i < ticks; ++i) {
    const double timeS = double(i) * kPeriodS;
    DeviceState state;
    device.read(timeS, state);
    const Vec3d hand = state.pose.translation;
    if (i) in.velocity += smoothing * ((hand - in.hand) / kPeriodS - in.velocity);
    in.hand = hand;
    in.sampleIndex = i;
    const Contact::Output out = contact->tick(scene, in);
    device.write(timeS, out.force);
    run.ticks.push_back({timeS, device.position(), out.force, (out.flags & kTouching) != 0});
  }
  judge(run, sheet.peakForceN);
  return run;
}

}  // namespace argil::haptics
