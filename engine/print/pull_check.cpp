#include "engine/print/pull_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "clay/base/error.h"
#include "clay/base/work_part.h"
#include "clay/mould/best_pull.h"
#include "clay/mould/pull_faces.h"

namespace argil::engine {

namespace {

constexpr double kCrumb = 10;  // times what a wall may be uneven by, squared: less is no undercut that anybody sees
constexpr int kThreads = 2;

}  // namespace

PullReport checkPull(const clay::TriangleMesh& mesh, double unevenMm, std::optional<Vec3d> pull, double draftDegrees,
                     Job* job) {
  const clay::WorkPart part(job);
  if (mesh.triangles.empty()) throw Error("it has no surface");
  if (!(draftDegrees >= 0 && draftDegrees <= 45))
    throw Error(fmt::format("a draft of {:g}°: give 0 to 45", draftDegrees));
  PullReport report;
  report.pull = pull ? pull->normalized() : clay::bestPull(mesh, 10 * unevenMm, kThreads, part.part(0, 0.8)).pull;
  part.step(0.8);
  const clay::PullFaces faces = clay::pullFaces(mesh, report.pull, unevenMm, draftDegrees, kThreads);
  part.step(0.9);
  report.areaMm2 = faces.upperMm2 + faces.lowerMm2 + faces.undercutMm2;
  report.undercutMm2 = faces.undercutMm2;
  report.steepMm2 = faces.steepMm2;

  // What shares a vertex hangs together.
  std::vector<uint32_t> of(mesh.positions.size());
  std::iota(of.begin(), of.end(), 0u);
  const auto rootOf = [&](uint32_t v) {
    while (of[v] != v) v = of[v] = of[of[v]];
    return v;
  };
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (faces.sides[t] != clay::PullSide::undercut) continue;
    const auto& c = mesh.triangles[t];
    for (size_t k = 1; k < 3; ++k) of[std::max(rootOf(c[0]), rootOf(c[k]))] = std::min(rootOf(c[0]), rootOf(c[k]));
  }
  struct Sum {
    double area = 0;
    Vec3d place = Vec3d::Zero();
  };
  std::vector<Sum> sums(mesh.positions.size());
  const auto each = [&](const auto& visit) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (faces.sides[t] != clay::PullSide::undercut) continue;
      const auto& c = mesh.triangles[t];
      const Vec3d &a = mesh.positions[c[0]], &b = mesh.positions[c[1]], &d = mesh.positions[c[2]];
      visit(rootOf(c[0]), (b - a).cross(d - a).norm() / 2, Vec3d((a + b + d) / 3));
    }
  };
  each([&](uint32_t root, double area, const Vec3d& at) {
    sums[root].area += area;
    sums[root].place += area * at;
  });
  // The face that is nearest to the middle: the middle itself may lie in the air.
  std::vector<double> nearest(sums.size(), INFINITY);
  std::vector<Vec3d> places(sums.size(), Vec3d::Zero());
  each([&](uint32_t root, double, const Vec3d& at) {
    const double off = (at - sums[root].place / std::max(sums[root].area, 1e-300)).squaredNorm();
    if (off < nearest[root]) nearest[root] = off, places[root] = at;
  });
  for (size_t v = 0; v < sums.size(); ++v)
    if (sums[v].area > kCrumb * kCrumb * unevenMm * unevenMm) report.undercuts.push_back({places[v], sums[v].area});
  std::stable_sort(report.undercuts.begin(), report.undercuts.end(),
                   [](const Undercut& a, const Undercut& b) { return a.areaMm2 > b.areaMm2; });
  return report;
}

}  // namespace argil::engine
