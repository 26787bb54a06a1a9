// The exact active set against the dual of it: the point of a hull that is nearest to the hand's direction
// (Ruspini et al. 1997).

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "haptics/contact/active_set.h"

namespace argil::haptics {
namespace {

constexpr uint32_t kSeed = 17;
constexpr int kSets = 100'000;

using Point = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1>;

// Gilbert's search for the point of a hull nearest to the origin, with Wolfe's correction: on each support point found
// the best of the corral's affine hull is taken, so it ends after finitely many. `sum`: of the weights of all points
// but the first.
Point nearestOfHull(const std::vector<Point>& points, double& sum) {
  std::vector<size_t> corral{0};
  std::vector<double> weight{1};
  Point x = points[0];
  for (int major = 0; major < 200; ++major) {
    size_t support = 0;
    for (size_t i = 1; i < points.size(); ++i)
      if (x.dot(points[i]) < x.dot(points[support])) support = i;
    double largest = 0;
    for (size_t i : corral) largest = std::max(largest, points[i].squaredNorm());
    if (x.dot(points[support]) > x.squaredNorm() - 1e-15 * std::max(1.0, largest)) break;
    if (std::find(corral.begin(), corral.end(), support) != corral.end()) break;
    corral.push_back(support);
    weight.push_back(0);
    for (;;) {
      const Eigen::Index n = static_cast<Eigen::Index>(corral.size());
      // Weights that sum to one: x = p0 + B y, the least |x|.
      Eigen::MatrixXd edges(x.size(), n - 1);
      for (Eigen::Index i = 1; i < n; ++i) edges.col(i - 1) = points[corral[size_t(i)]] - points[corral[0]];
      std::vector<double> best(size_t(n), 1.0);
      if (n > 1) {
        const Eigen::VectorXd y = edges.colPivHouseholderQr().solve(-points[corral[0]]);
        for (Eigen::Index i = 1; i < n; ++i) {
          best[size_t(i)] = y[i - 1];
          best[0] -= y[i - 1];
        }
      }
      double share = 1;
      for (size_t i = 0; i < best.size(); ++i)
        if (best[i] <= 0) share = std::min(share, weight[i] / (weight[i] - best[i]));
      for (size_t i = 0; i < best.size(); ++i) weight[i] += share * (best[i] - weight[i]);
      bool dropped = false;
      for (size_t i = best.size(); i-- > 0;)
        if (weight[i] <= 1e-14 && best[i] <= 0) {
          corral.erase(corral.begin() + static_cast<std::ptrdiff_t>(i));
          weight.erase(weight.begin() + static_cast<std::ptrdiff_t>(i));
          dropped = true;
        }
      if (!dropped) break;
    }
    x.setZero();
    for (size_t i = 0; i < corral.size(); ++i) x += weight[i] * points[corral[i]];
  }
  sum = 0;
  for (size_t i = 0; i < corral.size(); ++i)
    if (corral[i] != 0) sum += weight[i];
  return x;
}

struct Random {
  std::mt19937 engine{kSeed};
  std::normal_distribution<double> normal{0, 1};
  double value() { return normal(engine); }
  Vec3d vector() { return {value(), value(), value()}; }
};

// Ruspini's form, to the letter: all planes through the proxy, at the origin.
TEST(Gilbert, AgreesWithTheActiveSetForPlanesThroughTheProxy) {
  Random random;
  double worst = 0;
  int active[4] = {};
  for (int set = 0; set < kSets; ++set) {
    const Vec3d u = random.vector(), towards = u.normalized();
    std::vector<HalfSpace> planes;
    std::vector<Point> hull{Point(-towards)};
    const int count = 1 + set % 4;
    while (static_cast<int>(planes.size()) < count) {
      const Vec3d n = random.vector().normalized();
      if (n.dot(towards) > -0.05) continue;  // Planes that the hand does not press on are not in the hull.
      planes.push_back({n, 0});
      hull.emplace_back(Vec3d(n / n.dot(towards) - towards));
    }
    double sum = 0;
    const Vec3d dual = -u.norm() * nearestOfHull(hull, sum);
    const ActiveSet exact = nearestAllowed(u, planes.data(), count);
    ASSERT_TRUE(exact.feasible);
    ++active[exact.count];
    worst = std::max(worst, (exact.x - dual).norm());
    ASSERT_LE((exact.x - dual).norm(), 1e-9) << "seed " << kSeed << " set " << set;
  }
  std::printf(
      "seed %u: %d sets of planes through the proxy, 1 / 2 / 3 active in %d / %d / %d, largest difference %.1e\n",
      kSeed, kSets, active[1], active[2], active[3], worst);
  EXPECT_GT(active[3], 1000);
}

// Any offsets, and locks: the same dual one dimension higher, where every plane goes through the origin; a lock is two
// planes.
TEST(Gilbert, AgreesWithTheActiveSetForAnyPlanesAndLocks) {
  Random random;
  constexpr double kReach = 200;  // Of the hull along each generator: enough that only the origin's corner bounds it.
  double worst = 0;
  int active[4] = {}, dimensions[4] = {}, cramped = 0;
  for (int set = 0; set < kSets; ++set) {
    const int count = 1 + set % 6, dimension = set / 6 % 4;
    const Vec3d u = random.vector(), allowed = 0.5 * random.vector();
    Subspace within;
    if (dimension == 2) within = Subspace::plane(allowed, random.vector());
    if (dimension == 1) within = Subspace::line(allowed, random.vector());
    if (dimension == 0) within = Subspace::at(allowed);
    Point e4(4);
    e4 << 0, 0, 0, 1;
    std::vector<Point> hull{Point(-e4)};
    const auto generator = [&](const Vec3d& n, double wanted) {
      Point m(4);
      m << n, wanted;
      hull.emplace_back(kReach * m / m.norm() - e4);
    };
    std::vector<HalfSpace> planes;
    for (int i = 0; i < count; ++i) {
      const Vec3d n = random.vector().normalized();
      planes.push_back({n, n.dot(allowed) - 0.3 * std::abs(random.value())});
      generator(n, planes.back().offset - n.dot(u));
    }
    std::vector<Vec3d> square;
    if (dimension == 2) square = {within.axes[0].cross(within.axes[1])};
    if (dimension == 1)
      square = {within.axes[0].unitOrthogonal(), within.axes[0].cross(within.axes[0].unitOrthogonal())};
    if (dimension == 0) square = {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()};
    for (const Vec3d& n : square) {
      generator(n, n.dot(allowed - u));
      generator(-n, -n.dot(allowed - u));
    }
    const ActiveSet exact = nearestAllowed(u, planes.data(), count, within);
    ASSERT_TRUE(exact.feasible) << "seed " << kSeed << " set " << set;
    ASSERT_LE((within.nearest(exact.x) - exact.x).norm(), 1e-12) << "off the lock: seed " << kSeed << " set " << set;
    Vec3d push = Vec3d::Zero();
    for (int i = 0; i < exact.count; ++i)
      push += exact.multiplier[size_t(i)] * within.along(planes[size_t(exact.active[size_t(i)])].normal);
    ASSERT_LE((within.nearest(u) + push - exact.x).norm(), 1e-9) << "seed " << kSeed << " set " << set;
    double sum = 0;
    const Point residual = nearestOfHull(hull, sum);
    if (sum > 0.999) {
      ++cramped;
      continue;
    }
    const Vec3d dual = u - residual.head<3>() / residual[3];
    ++active[exact.count];
    ++dimensions[within.dimension];
    worst = std::max(worst, (exact.x - dual).norm());
    ASSERT_LE((exact.x - dual).norm(), 1e-9) << "seed " << kSeed << " set " << set << " dimension " << dimension;
  }
  std::printf(
      "seed %u: %d sets, free / plane / line / point %d / %d / %d / %d, 0 to 3 active in %d / %d / %d / %d, largest "
      "difference %.1e\n",
      kSeed, kSets, dimensions[3], dimensions[2], dimensions[1], dimensions[0], active[0], active[1], active[2],
      active[3], worst);
  EXPECT_GT(active[3], 300);
  EXPECT_LT(cramped, kSets / 100);
}

}  // namespace
}  // namespace argil::haptics
