#include "engine/print/lay_flat.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/base/work_part.h"
#include "clay/surface/surface.h"

namespace argil::engine {

namespace {

constexpr int kDirections = 3000;  // whose outermost places are looked at: 2.1° apart
constexpr int kStarts = 1000;      // that are rolled from
constexpr int kMostRolls = 200;
constexpr double kTouches = 0.25;  // voxels
constexpr double kSame = 0.9998;   // cosine of the angle within which two rests are one
constexpr int kThreads = 2;

using Vec2d = Eigen::Vector2d;

Vec3d direction(int i, int of) {
  const double z = 1 - (2.0 * i + 1) / of, r = std::sqrt(1 - z * z);
  const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
  return {r * std::cos(turn), r * std::sin(turn), z};
}

// Places that can touch a bed, and the middle of the mass.
struct Body {
  std::vector<Vec3d> all, outer;
  Vec3d middle = Vec3d::Zero();
  double size = 0;
};

Body bodyOf(const clay::Version& version, const haptics::Pose& pose) {
  Body body;
  clay::Surface surface(false, clay::Grade::crisp);
  (void)surface.update(version, kThreads);
  if (surface.quadCount() == 0) throw Error("it has no clay");
  const clay::TriangleMesh mesh = surface.toMesh();
  body.all.reserve(mesh.positions.size());
  for (const Vec3d& each : mesh.positions) body.all.push_back(pose.apply(each));
  // Tetrahedra from a place of the body, so that no digits are lost far from the world's middle.
  const Vec3d from = body.all[0];
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = body.all[t[0]] - from, b = body.all[t[1]] - from, c = body.all[t[2]] - from;
    const double each = a.dot(b.cross(c));
    volume += each;
    body.middle += each * (a + b + c) / 4;
  }
  body.middle = volume > 0 ? Vec3d(from + body.middle / volume) : from;
  return body;
}

void findOuter(Body& body, const clay::WorkPart& part) {
  std::vector<size_t> found(kDirections);
  std::atomic<int> done{0};
  clay::parallelBlocks(
      found.size(), kThreads,
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          part.step(double(done.fetch_add(1)) / kDirections);
          const Vec3d way = direction(static_cast<int>(i), kDirections);
          double most = -INFINITY;
          for (size_t k = 0; k < body.all.size(); ++k)
            if (const double at = body.all[k].dot(way); at > most) most = at, found[i] = k;
        }
      },
      16);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (const size_t k : found) body.outer.push_back(body.all[k]);
  for (const Vec3d& each : body.outer) body.size = std::max(body.size, (each - body.middle).norm());
}

// The outer place that is met first when the body, on a bed with the normal `up`, tips about an axis through `at` so
// that the side of `across` goes down; and by how much it tips.
struct Met {
  size_t place = SIZE_MAX;
  double angle = INFINITY;
};
Met firstMet(const Body& body, const Vec3d& at, const Vec3d& across, const Vec3d& up) {
  Met met;
  for (size_t i = 0; i < body.outer.size(); ++i) {
    const Vec3d off = body.outer[i] - at;
    const double along = off.dot(across), above = off.dot(up);
    if (along * along + above * above < 1e-18 * body.size * body.size) continue;
    const double angle = std::atan2(std::max(above, 0.0), along);
    if (angle < met.angle - 1e-12) met = {i, angle};
  }
  return met;
}

// The bed's normal under the body where it rests, rolled from one.
std::optional<Vec3d> rolled(const Body& body, Vec3d up) {
  // On one place first.
  size_t lowest = 0;
  for (size_t i = 1; i < body.outer.size(); ++i)
    if (body.outer[i].dot(up) < body.outer[lowest].dot(up)) lowest = i;
  Vec3d at = body.outer[lowest];
  // The body goes down on the side of `across` until what is met there stands on the bed.
  const auto turned = [](const Vec3d& normal, const Vec3d& across, double angle) {
    return Vec3d(std::cos(angle) * normal - std::sin(angle) * across).normalized();
  };
  // Towards where the middle of the mass hangs over.
  Vec3d over = body.middle - at;
  over -= over.dot(up) * up;
  if (over.norm() < 1e-9 * body.size) over = up.unitOrthogonal();
  Vec3d across = over.normalized();
  Met met = firstMet(body, at, across, up);
  if (met.place == SIZE_MAX) return std::nullopt;
  up = turned(up, across, met.angle);
  Vec3d other = body.outer[met.place];
  // Over edges, from face to face.
  for (int roll = 0; roll < kMostRolls; ++roll) {
    const Vec3d edge = (other - at).normalized();
    Vec3d side = edge.cross(up).normalized();
    if ((body.middle - at).dot(side) < 0) side = -side;
    met = firstMet(body, at, side, up);
    if (met.place == SIZE_MAX) return std::nullopt;
    up = turned(up, side, met.angle);
    const Vec3d third = body.outer[met.place];
    // Above the triangle that it stands on now? Else over the edge that it hangs over.
    const auto hangsOver = [&](const Vec3d& a, const Vec3d& b, const Vec3d& opposite) {
      Vec3d out = (b - a).cross(up);
      if (out.dot(opposite - a) > 0) out = -out;
      return out.dot(body.middle - a) > 1e-9 * body.size * out.norm();
    };
    if (hangsOver(at, third, other)) {
      other = third;
    } else if (hangsOver(other, third, at)) {
      at = other, other = third;
    } else {
      return up;
    }
  }
  return std::nullopt;
}

// Of the polygon around places of a plane, and how far the middle is from its nearest side, inside.
struct Foot {
  double area = 0, margin = -INFINITY;
};
Foot footOf(std::vector<Vec2d> places, const Vec2d& middle) {
  const auto cross = [](const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  std::sort(places.begin(), places.end(),
            [](const Vec2d& a, const Vec2d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  // Andrew's monotone chains.
  std::vector<Vec2d> around;
  for (int pass = 0; pass < 2; ++pass) {
    const size_t first = around.size();
    for (const Vec2d& each : places) {
      while (around.size() >= first + 2 && cross(around[around.size() - 2], around.back(), each) <= 0)
        around.pop_back();
      around.push_back(each);
    }
    if (!around.empty()) around.pop_back();
    std::reverse(places.begin(), places.end());
  }
  Foot foot;
  if (around.size() < 3) return foot;
  foot.margin = INFINITY;
  for (size_t i = 0; i < around.size(); ++i) {
    const Vec2d &a = around[i], &b = around[(i + 1) % around.size()];
    foot.area += (a.x() * b.y() - a.y() * b.x()) / 2;
    foot.margin = std::min(foot.margin, cross(a, b, middle) / (b - a).norm());
  }
  return foot;
}

}  // namespace

Rests restsOf(const clay::Version& version, const haptics::Pose& pose, Job* job) {
  const clay::WorkPart part(job);
  Body body = bodyOf(version, pose);
  part.step(0.3);
  findOuter(body, part.part(0.3, 0.8));
  std::vector<Vec3d> ups;
  for (int i = 0; i < kStarts; ++i) {
    part.step(0.8 + 0.1 * i / kStarts);
    const std::optional<Vec3d> up = rolled(body, direction(i, kStarts));
    if (up && std::none_of(ups.begin(), ups.end(), [&](const Vec3d& each) { return each.dot(*up) > kSame; }))
      ups.push_back(*up);
  }
  Rests rests;
  rests.middleMm = body.middle;
  rests.lowMm = std::min_element(body.all.begin(), body.all.end(), [](const Vec3d& a, const Vec3d& b) {
                  return a.z() < b.z();
                })->z();
  const double touches = kTouches * version.grid().voxelMm;
  for (const Vec3d& up : ups) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3d& each : body.outer) low = std::min(low, each.dot(up)), high = std::max(high, each.dot(up));
    const Vec3d u = up.unitOrthogonal(), v = up.cross(u);
    std::vector<Vec2d> places;
    for (const Vec3d& each : body.outer)
      if (each.dot(up) < low + touches) places.emplace_back(each.dot(u), each.dot(v));
    const Foot foot = footOf(std::move(places), {body.middle.dot(u), body.middle.dot(v)});
    if (!(foot.margin >= 0)) continue;
    rests.ways.push_back({haptics::rotationBetween(up, Vec3d::UnitZ()), low, foot.area,
                          std::atan2(foot.margin, body.middle.dot(up) - low) * 180 / std::numbers::pi, high - low});
  }
  std::stable_sort(rests.ways.begin(), rests.ways.end(),
                   [](const Rest& a, const Rest& b) { return a.footMm2 > b.footMm2; });
  return rests;
}

}  // namespace argil::engine
