// Two hundred pieces with one fault each, anywhere and of any size, and twenty without: what a check of a print finds.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "engine/print/print_check.h"

namespace argil::engine {
namespace {

using clay::Combination;
using clay::Version;

constexpr double kVoxel = 0.25;

class Shapes {
 public:
  explicit Shapes(uint32_t seed) : random_(seed) {
    grid_.voxelMm = kVoxel;
    grid_.originMm = {in(0, kVoxel), in(0, kVoxel), in(0, kVoxel)};
  }
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int of(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  [[nodiscard]] Version block(const Vec3d& low, const Vec3d& high) const {
    return clay::makeBlock(store_, grid_, (low + high) / 2, high - low, 0);
  }
  [[nodiscard]] Version ball(const Vec3d& at, double radius) const {
    return clay::makeSphere(store_, grid_, at, radius);
  }
  [[nodiscard]] Version rod(const Vec3d& from, const Vec3d& to, double radius) const {
    return clay::makeRod(store_, grid_, from, to, radius, 0);
  }
  [[nodiscard]] Version cone(double radius, double top, double height) const {
    return clay::makeCone(store_, grid_, {0, 0, height / 2}, radius, top, height);
  }
  [[nodiscard]] Version cylinder(double radius, double height) const {
    return clay::makeCylinder(store_, grid_, {0, 0, height / 2}, radius, height);
  }

 private:
  std::mt19937 random_;
  clay::Grid grid_;
  std::shared_ptr<clay::Store> store_ = clay::Store::make();
};

Version join(const Version& a, const Version& b) {
  return clay::combine(a, b, Combination::join);
}
Version cut(const Version& a, const Version& b) {
  return clay::combine(a, b, Combination::cut);
}

// Stands on z = 0, wide at its foot, solid.
Version sound(Shapes& s, double& height) {
  height = s.in(8, 14);
  switch (s.of(4)) {
    case 0:
      return s.block({-s.in(6, 10), -s.in(6, 10), 0}, {s.in(6, 10), s.in(6, 10), height});
    case 1:
      return s.cylinder(s.in(6, 10), height);
    case 2:
      return s.cone(s.in(9, 12), s.in(6, 8), height);
    default: {
      const double step = height / 2;
      return join(s.block({-10, -9, 0}, {9, 10, step}), s.block({-6.5, -6, 0}, {6, 6.5, height}));
    }
  }
}

enum class Fault { wall, gap, closedHollow, cup, island, neck, overhang };
constexpr std::array kFaults{Fault::wall,   Fault::gap,  Fault::closedHollow, Fault::cup,
                             Fault::island, Fault::neck, Fault::overhang};

// With one fault of that kind and none of the others; where it is.
Version with(Fault fault, Shapes& s, const PrintProcess& process, Vec3d& at) {
  double height = 0;
  const Version base = sound(s, height);
  const double x = s.in(-3, 3), y = s.in(-3, 3);
  switch (fault) {
    case Fault::wall: {
      const double thick = s.in(2 * kVoxel, 0.85 * process.wallMm), long_ = s.in(2, 8), high = s.in(2, 8);
      at = {x, y, height + high / 2};
      return join(base,
                  s.block({x - thick / 2, y - long_ / 2, height - 2}, {x + thick / 2, y + long_ / 2, height + high}));
    }
    case Fault::gap: {
      // A slot along all of it, so that it holds nothing.
      const double wide = s.in(2 * kVoxel, 0.85 * process.gapMm), deep = s.in(3, height - 3);
      at = {x, 0, height - deep / 2};
      return cut(base, s.block({x - wide / 2, -20, height - deep}, {x + wide / 2, 20, height + 5}));
    }
    case Fault::closedHollow: {
      const double radius = s.in(1, 2.5);
      at = {x / 2, y / 2, s.in(radius + 1.5, height - radius - 1.5)};
      return cut(base, s.ball(at, radius));
    }
    case Fault::cup: {
      const double half = s.in(1.5, 2.5), deep = s.in(2, height - 3);
      at = {x / 2, y / 2, height - deep};
      return cut(base,
                 s.block({at.x() - half, at.y() - half, height - deep}, {at.x() + half, at.y() + half, height + 5}));
    }
    case Fault::neck: {
      // Out of its lowest place, so that it is emptied where that is wide enough.
      const double radius = s.in(2, 2.5), bore = s.in(0.5, 0.42 * process.outletMm), side = radius - 1;
      const Vec3d middle(x / 2, y / 2, s.in(radius + 1.5, height - radius - 1.5));
      at = {middle.x(), middle.y(), 0.5};
      return cut(cut(base, s.ball(middle, radius)), s.rod(middle, {middle.x(), middle.y(), -side}, bore));
    }
    case Fault::island: {
      const double half = s.in(1, 2), above = s.in(1.5, 4);
      at = {x, y, height + above};
      return join(base, s.block({x - half, y - half, at.z()}, {x + half, y + half, at.z() + 2 * half}));
    }
    default: {
      const double out = s.in(3, 8), thick = s.in(2, height / 2 - 1.5);  // a step of the foot stays away
      at = {12 + out / 2, 0, height - thick};
      return join(base, s.block({0, -s.in(2, 4), height - thick}, {12 + out, s.in(2, 4), height}));
    }
  }
}

bool has(Fault fault, const PrintReport& report) {
  const auto& traps = report.slices.traps;
  const auto closed = [](const clay::Trap& trap) { return trap.closed; };
  switch (fault) {
    case Fault::wall:
      return !report.walls.parts.empty();
    case Fault::gap:
      return !report.gaps.parts.empty();
    case Fault::closedHollow:
      return std::any_of(traps.begin(), traps.end(), closed);
    case Fault::cup:
      return !std::all_of(traps.begin(), traps.end(), closed);
    case Fault::island:
      return !report.slices.islands.empty();
    case Fault::neck:
      return !report.necks.empty();
    default:
      return report.overhangMm2 > 0;
  }
}

// How far the found place that is nearest lies off; overhangs are told by area alone.
double farOff(Fault fault, const PrintReport& report, const Vec3d& at) {
  double least = INFINITY;
  const auto look = [&](const Vec3d& p) { least = std::min(least, (p - at).norm()); };
  switch (fault) {
    case Fault::wall:
      for (const auto& part : report.walls.parts) look(part.atMm);
      break;
    case Fault::gap:
      for (const auto& part : report.gaps.parts) {
        least = std::min(least, std::abs(part.atMm.x() - at.x()));
      }
      break;
    case Fault::neck:
      for (const auto& each : report.necks) look(each.atMm);
      break;
    case Fault::island:
      for (const auto& each : report.slices.islands) look(each.at);
      break;
    case Fault::closedHollow:
    case Fault::cup:
      for (const auto& each : report.slices.traps) look(each.at);
      break;
    default:
      return 0;
  }
  return least;
}

TEST(PrintProperty, TwoHundredSeededFaultsAreFound) {
  PrintProcess process = printProcess("sla");
  process.gapMm = 0.9;  // of more than two voxels
  for (uint32_t seed = 0; seed < 210; ++seed) {
    SCOPED_TRACE(seed);
    const Fault fault = kFaults[seed % kFaults.size()];
    Shapes shapes(seed);
    Vec3d at;
    const PrintReport report = checkPrint(with(fault, shapes, process, at), {}, process, nullptr);
    EXPECT_TRUE(has(fault, report)) << "kind " << int(fault);
    EXPECT_LT(farOff(fault, report, at), 6) << "kind " << int(fault);
    for (const Fault other : kFaults) {
      if (other == fault) continue;
      // What hangs in the air looks down too, and so does the roof of a hollow.
      if (other == Fault::overhang && (fault == Fault::island || fault == Fault::closedHollow || fault == Fault::neck))
        continue;
      EXPECT_FALSE(has(other, report)) << "a fault of kind " << int(fault) << " is one of kind " << int(other)
                                       << " too";
    }
    EXPECT_TRUE(report.fits);
  }
}

TEST(PrintProperty, TwentySoundPiecesRaiseNoAlarm) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    Shapes shapes(1000 + seed);
    double height = 0;
    const Version piece = sound(shapes, height);
    for (const PrintProcess& process : printProcesses())
      EXPECT_EQ(checkPrint(piece, {}, process, nullptr).troubles(process), 0) << process.id;
  }
}

}  // namespace
}  // namespace argil::engine
