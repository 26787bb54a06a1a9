#include "clay/mould/best_pull.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/mould/pull_faces.h"

namespace argil::clay {

namespace {

constexpr int kDirections = 1000;                       // over half of the sphere: 4.5° from one to the next
constexpr int kCoarse = 40, kFine = 160;                // cells along the mesh's longest side
constexpr size_t kLookedAt = 8;                         // on the finer copy
constexpr double kSteps[] = {3, 1.5, 0.75};             // degrees, around the best
constexpr double kSlack = 0.25;                         // of a cell: what a coarse copy is off
constexpr double kNoDraft = 0.5;                        // degrees
constexpr double kForDraft = 0.001, kForHeight = 0.01;  // what a whole surface without draft counts, or a whole height
constexpr double kAxesFirst = 0.001;

// Vertices of a cell become one, at their mean.
TriangleMesh clustered(const TriangleMesh& mesh, double cell) {
  Eigen::AlignedBox3d box;
  for (const Vec3d& p : mesh.positions) box.extend(p);
  TriangleMesh out;
  std::unordered_map<uint64_t, uint32_t> cells;
  std::vector<uint32_t> of(mesh.positions.size());
  std::vector<int> counts;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d at = (mesh.positions[v] - box.min()) / cell;
    const uint64_t key = (uint64_t(at.x()) << 42) | (uint64_t(at.y()) << 21) | uint64_t(at.z());
    const auto [found, fresh] = cells.try_emplace(key, static_cast<uint32_t>(out.positions.size()));
    of[v] = found->second;
    if (fresh) out.positions.emplace_back(Vec3d::Zero()), counts.push_back(0);
    out.positions[of[v]] += mesh.positions[v];
    ++counts[of[v]];
  }
  for (size_t i = 0; i < counts.size(); ++i) out.positions[i] /= counts[i];
  for (const auto& t : mesh.triangles) {
    const std::array<uint32_t, 3> own{of[t[0]], of[t[1]], of[t[2]]};
    if (own[0] != own[1] && own[1] != own[2] && own[2] != own[0]) out.triangles.push_back(own);
  }
  return out;
}

// A copy of the mesh that directions are tried on.
class Trial {
 public:
  Trial(const TriangleMesh& mesh, double extent, int cells, double voxelMm)
      : cell_(std::max(extent / cells, voxelMm)),
        extent_(extent),
        // A fine mesh of a small thing is as it is.
        copy_(clustered(mesh, cell_)) {}
  struct Score {
    double all = 0, undercut = 0;
  };
  [[nodiscard]] Score of(const Vec3d& pull) const {
    const PullFaces faces = pullFaces(copy_, pull, kSlack * cell_, kNoDraft, 1);
    const double area = faces.upperMm2 + faces.lowerMm2 + faces.undercutMm2;
    double low = INFINITY, high = -INFINITY;
    for (const Vec3d& p : copy_.positions) low = std::min(low, p.dot(pull)), high = std::max(high, p.dot(pull));
    if (!(area > 0)) return {};
    const double undercut = faces.undercutMm2 / area;
    return {undercut + kForDraft * faces.steepMm2 / area + kForHeight * (high - low) / extent_, undercut};
  }

 private:
  double cell_, extent_;
  TriangleMesh copy_;
};

Vec3d direction(int i) {
  const double z = (i + 0.5) / kDirections, r = std::sqrt(1 - z * z);
  const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
  return {r * std::cos(turn), r * std::sin(turn), z};
}

}  // namespace

BestPull bestPull(const TriangleMesh& mesh, double voxelMm, int threads, const WorkPart& part) {
  if (mesh.triangles.empty()) throw Error("it has no clay");
  Eigen::AlignedBox3d box;
  for (const Vec3d& p : mesh.positions) box.extend(p);
  const double extent = box.sizes().norm();
  struct Way {
    Vec3d pull;
    Trial::Score score;
  };
  std::vector<Way> ways;
  for (const int axis : {2, 0, 1}) ways.push_back({Vec3d::Unit(axis), {}});
  for (int i = 0; i < kDirections; ++i) ways.push_back({direction(i), {}});
  const auto look = [&](const Trial& trial, std::vector<Way>& all, const WorkPart& own) {
    std::atomic<size_t> done{0};
    parallelBlocks(
        all.size(), threads,
        [&](size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) {
            own.step(double(done.fetch_add(1)) / double(all.size()));
            all[i].score = trial.of(all[i].pull);
          }
        },
        1);
  };
  look(Trial(mesh, extent, kCoarse, voxelMm), ways, part.part(0, 0.6));
  // Axes are looked at again in any case.
  std::vector<Way> best(ways.begin(), ways.begin() + 3);
  ways.erase(ways.begin(), ways.begin() + 3);
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) { return a.score.all < b.score.all; });
  best.insert(best.end(), ways.begin(), ways.begin() + kLookedAt);
  const Trial fine(mesh, extent, kFine, voxelMm);
  look(fine, best, part.part(0.6, 0.8));
  const auto lower = [](const Way& a, const Way& b) { return a.score.all < b.score.all; };
  Way way = *std::min_element(best.begin(), best.end(), lower);
  double at = 0.8;
  for (const double degrees : kSteps) {
    std::vector<Way> around;
    const Vec3d u = way.pull.unitOrthogonal(), v = way.pull.cross(u);
    for (int i = 0; i < 6; ++i) {
      const double turn = std::numbers::pi * i / 3, off = std::tan(degrees * std::numbers::pi / 180);
      around.push_back({(way.pull + off * (std::cos(turn) * u + std::sin(turn) * v)).normalized(), {}});
    }
    look(fine, around, part.part(at, at + 0.2 / 3));
    at += 0.2 / 3;
    const Way& better = *std::min_element(around.begin(), around.end(), lower);
    if (lower(better, way)) way = better;
  }
  for (size_t i = 3; i-- > 0;)
    if (best[i].score.all <= way.score.all + kAxesFirst) way = best[i];
  return {way.pull, way.score.undercut};
}

}  // namespace argil::clay
