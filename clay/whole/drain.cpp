#include "clay/whole/drain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "clay/base/error.h"
#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/field/slice_sweep.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/ways_out.h"

namespace argil::clay {

namespace {

constexpr double kLeastWidth = 4;     // voxels, of a hole
constexpr int kMostRounds = 16;       // of looking and boring
constexpr int kDirections = 600;      // that a way out is looked for in: 8° from one to the next
constexpr double kUpwards = 0.1;      // sine of what still counts as level
constexpr double kStep = 0.25;        // voxels, where the surface is near
constexpr double kMostFloor = 2;      // voxels from a hollow's lowest voxel to its floor
constexpr double kBelowFloor = 0.25;  // voxels: so far below the floor a hole's lower side runs
constexpr double kFarthest = 200000;  // voxels: the diagonal of the largest clay
constexpr int kAround = 16;           // places on the rim of a hole
constexpr size_t kMostNarrow = 8;     // hollows at once

// Directions spread evenly over the sphere.
Vec3d direction(int i) {
  const double z = 1 - (2.0 * i + 1) / kDirections, r = std::sqrt(1 - z * z);
  const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
  return {r * std::cos(turn), r * std::sin(turn), z};
}

// How far it is along `way` to where the clay ends, voxels; no farther than `most`.
double toOutside(Sampler& clay, const Vec3d& from, const Vec3d& way, double most) {
  double done = 0;
  while (done < most) {
    const double phi = clay.trilinear(from + done * way);
    if (phi >= 0) return done;
    done += std::max(kStep, -0.9 * phi);
  }
  return most;
}

// The axis of a hole, voxels.
struct Bore {
  Vec3d from, to;
};

class Borer {
 public:
  Borer(const Version& now, const Version& solid, double radius) : now_(now), solid_(solid), radius_(radius) {}

  Bore from(const Vec3d& lowest, const Vec3d& up) {
    double best = kFarthest;
    Vec3d way = -up;
    for (int i = 0; i < kDirections; ++i) {
      const Vec3d each = direction(i);
      if (each.dot(up) > kUpwards) continue;
      const double length = toOutside(solid_, lowest, each, best);
      if (length < best) best = length, way = each;
    }
    // A way that runs along the floor would lie half below it: its lower side goes through the lowest place. A hollow
    // that is lower than the hole has it in the middle.
    Vec3d start = lowest;
    if (const Vec3d aside = up - up.dot(way) * way; aside.norm() > kUpwards) {
      const Vec3d sideways = aside.normalized();
      const double floor = room(lowest, -sideways, kMostFloor), ceiling = room(lowest, sideways, 2 * radius_);
      const double lift = std::min(radius_ - kBelowFloor, (floor + ceiling) / 2) - floor;
      start += lift * aside.norm() * sideways;
      best = toOutside(solid_, start, way, kFarthest);
    }
    // Back into the hollow, so that the end of the hole does not stand in its floor; out until all of its rim is.
    double back = 0;
    while (back < 2 * radius_ && now_.trilinear(start - (back + 1) * way) > 0) back += 1;
    double out = best;
    while (out < best + 4 * radius_ && !rimIsOut(start + out * way, way)) out += 1;
    return {start - back * way, start + (out + 1) * way};
  }

 private:
  // How far air reaches from a place of the hollow, `most` voxels at most.
  double room(const Vec3d& from, const Vec3d& way, double most) {
    double done = 0;
    while (done < most && now_.trilinear(from + (done + kStep) * way) > 0) done += kStep;
    return done;
  }
  bool rimIsOut(const Vec3d& centre, const Vec3d& way) {
    const Vec3d u = way.unitOrthogonal(), v = way.cross(u);
    for (int i = 0; i < kAround; ++i) {
      const double turn = 2 * std::numbers::pi * i / kAround;
      if (solid_.trilinear(centre + radius_ * (std::cos(turn) * u + std::sin(turn) * v)) < 0) return false;
    }
    return true;
  }

  Sampler now_, solid_;
  double radius_;
};

// A clay as it is looked at, and that with its hollows filled.
struct Closed {
  Version clay, solid;
};

// Air where no ball of a hole's width can be, come from outside or in a hollow, counts as clay: narrow ways out are
// shut. What is closed anyway stays a hollow.
Closed shut(const Version& version, const Version& filled, double radiusMm, const WorkPart& part) {
  const auto cut = [](const Version& a, const Version& b, const WorkPart& own) {
    return combine(a, b, Combination::cut, {}, own);
  };
  const Version grown = offset(version, radiusMm, 0, part.part(0, 0.3));
  const Version rooms = fillVoids(grown, part.part(0.3, 0.4)).version;
  const Version shrunk = offset(rooms, -radiusMm, 0, part.part(0.4, 0.6));
  const Version solid = combine(filled, shrunk, Combination::join, {}, part.part(0.6, 0.7));
  const Version hollows = offset(cut(rooms, grown, part.part(0.7, 0.75)), radiusMm, 0, part.part(0.75, 0.9));
  const Version closed = cut(filled, version, part.part(0.9, 0.93));
  return {cut(cut(solid, hollows, part.part(0.93, 0.97)), closed, part.part(0.97, 1)), solid};
}

class Drain {
 public:
  Drain(const Version& version, const DrainOptions& options, const WorkPart& part)
      : options_(options), radius_(options.diameterMm / version.grid().voxelMm / 2) {
    result_.version = version;
    Cleaned filled = fillVoids(version, part.part(0, 0.02));
    looked_ = version;
    solid_ = filled.version;
    const std::vector<Neck> necks = narrowWaysOut(version, options.diameterMm / 2, 0, part.part(0.02, 0.05));
    // Many are the cells of an infill, which are no hollows of their own.
    const bool opensNarrowly = !necks.empty() && necks.size() <= kMostNarrow;
    if (filled.count == 0 && !opensNarrowly)
      throw Error("nothing is hollow here that opens by less than the holes: make a shell first", Error::Kind::work);
    if (opensNarrowly) {
      Closed closed = shut(version, filled.version, options.diameterMm / 2, part.part(0.05, 0.1));
      looked_ = std::move(closed.clay);
      solid_ = std::move(closed.solid);
    }
    // Upside down first: what drains as the piece stands is what counts, and is looked at last.
    if (options.vents) bore(-1, part.part(0.1, 0.5));
    bore(1, part.part(options.vents ? 0.5 : 0.1, 1));
  }
  [[nodiscard]] Drained take() { return std::move(result_); }

 private:
  // Half a ball of a hole's width: less than that is no pool.
  [[nodiscard]] uint64_t poolVoxels() const {
    return static_cast<uint64_t>(std::max(8.0, 2.0 / 3 * std::numbers::pi * std::pow(radius_, 3)));
  }

  void bore(int side, const WorkPart& part) {
    Eigen::Matrix3d turn = options_.turn;
    if (side < 0) turn = Eigen::Vector3d(1, -1, -1).asDiagonal() * turn;
    const Vec3d up = turn.row(2);
    for (int round = 0;; ++round) {
      const WorkPart own = part.part(1 - std::pow(0.5, round), 1 - std::pow(0.5, round + 1));
      const std::vector<Trap> traps = pools(turn, own, side > 0);
      if (traps.empty()) return;
      if (round == kMostRounds)
        throw Error(fmt::format("after {} holes there is still a pool of {:.3g} mm³: give a wider hole",
                                result_.holes.size(), traps[0].volumeMm3),
                    Error::Kind::work);
      for (const Trap& trap : traps) hole(result_.version.grid().toVoxel(trap.at), up, side < 0);
    }
  }

  // What stays in the hollows; lowest places in the piece.
  std::vector<Trap> pools(const Eigen::Matrix3d& turn, const WorkPart& part, bool counts) {
    const Version& now = looked_;
    Version layers = now;
    if (!turn.isIdentity(1e-9)) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.linear() = turn;
      layers = resample(now, now.grid(), pose, 0, part.part(0, 0.7));
    }
    const SliceReport report = sweepSlices(layers, part.part(0.7, 1));
    std::vector<Trap> pools;
    Sampler solid(solid_);
    result_.leftMm3 = 0;
    int cups = 0;
    const double voxel3 = std::pow(now.grid().voxelMm, 3);
    for (Trap trap : report.traps) {
      trap.at = turn.transpose() * trap.at;
      if (solid.trilinear(now.grid().toVoxel(trap.at)) >= 0)
        ++cups;
      else if (trap.closed || trap.volumeMm3 > double(poolVoxels()) * voxel3)
        pools.push_back(trap);
      else
        result_.leftMm3 += trap.volumeMm3;
    }
    if (counts) result_.cups = cups;
    return pools;
  }

  void hole(const Vec3d& lowest, const Vec3d& up, bool vent) {
    const Version before = result_.version;
    const Grid& grid = before.grid();
    const Bore bore = Borer(looked_, solid_, radius_).from(lowest, up);
    const DrainHole made{grid.toWorld(bore.from), grid.toWorld(bore.to), vent};
    const Precision precision = before.store()->precision();
    const auto rod = [&](double radiusMm) {
      return makeRod(Store::make(precision), grid, made.fromMm, made.toMm, radiusMm);
    };
    const bool same = looked_ == before;
    result_.version = combine(before, rod(options_.diameterMm / 2), Combination::cut);
    looked_ = same ? result_.version : combine(looked_, rod(options_.diameterMm / 2), Combination::cut);
    result_.holes.push_back(made);
    if (!options_.plugs) return;
    const Version plug = combine(rod(options_.diameterMm / 2 - options_.clearanceMm), before, Combination::intersect);
    // Where a hole leads through several walls, the others are no plug.
    result_.plugs.push_back(removeCrumbs(plug, std::numeric_limits<double>::max()).version);
  }

  DrainOptions options_;
  double radius_;
  Version looked_;  // the result, with narrow ways out shut
  Version solid_;   // with its hollows filled
  Drained result_;
};

}  // namespace

Drained drain(const Version& version, const DrainOptions& options, const WorkPart& part) {
  const double voxel = version.grid().voxelMm;
  if (!(options.diameterMm >= kLeastWidth * voxel))
    throw Error(fmt::format("holes of {:g} mm at voxels of {:g} mm: give at least {:g} mm", options.diameterMm, voxel,
                            kLeastWidth * voxel));
  if (options.plugs && !(options.clearanceMm >= 0 && options.diameterMm / 2 - options.clearanceMm >= voxel))
    throw Error(fmt::format("plugs thinner all around by {:g} mm for holes of {:g} mm: give from 0 to {:g} mm",
                            options.clearanceMm, options.diameterMm, options.diameterMm / 2 - voxel));
  return Drain(version, options, part).take();
}

}  // namespace argil::clay
