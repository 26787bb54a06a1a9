// argil bench fine: how far the two grades of the surface are from solids that are known exactly.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "bench/bench.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "io/models/mesh_file.h"

namespace argil::bench {

namespace {

constexpr int kRuns = 3;

struct Solid {
  clay::Version version;
  std::function<double(const Vec3d&)> distance;  ///< In mm, not negative or signed.
  std::vector<Vec3d> edges;                      ///< Points of its edges, and of what rounds them.
};

/// The box of half sides 14, 12, 10 voxels of a millimetre, its edges rounded, turned about no axis of the grid.
Solid turnedBox(double round, double angle) {
  const Vec3d half = Vec3d(14, 12, 10) - Vec3d::Constant(round), centre(0.31, -0.22, 0.47);
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(angle, Vec3d(0.36, 0.48, 0.8)).toRotationMatrix();
  Solid solid;
  solid.distance = [=](const Vec3d& p) {
    const Vec3d q = (axes.transpose() * (p - centre)).cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - round;
  };
  for (int edge = 0; edge < 12; ++edge)
    for (int i = -60; i <= 60; ++i)
      for (int k = 0; k <= (round > 0 ? 8 : 0); ++k) {
        const double turn = k * EIGEN_PI / 16;
        Vec3d p;
        p[edge / 4] = i / 60.0 * half[edge / 4];
        const int u = (edge / 4 + 1) % 3, v = (edge / 4 + 2) % 3;
        p[u] = (edge & 1 ? 1 : -1) * (half[u] + round * std::cos(turn));
        p[v] = (edge & 2 ? 1 : -1) * (half[v] + round * std::sin(turn));
        solid.edges.push_back(centre + axes * p);
      }
  clay::Grid grid;
  grid.voxelMm = 1;
  clay::Editor editor(clay::Version::empty(clay::Store::make(), grid));
  constexpr int kBricks = 4;
  for (int b = 0; b < 8 * kBricks * kBricks * kBricks; ++b) {
    const Coord brick{b / (4 * kBricks * kBricks) - kBricks, b / (2 * kBricks) % (2 * kBricks) - kBricks,
                      b % (2 * kBricks) - kBricks};
    std::array<float, clay::kBrickVoxels> phi;
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      phi[static_cast<size_t>(i)] =
          static_cast<float>(solid.distance((brick * clay::kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d()));
    editor.setVoxels(brick, phi);
  }
  solid.version = editor.commit();
  return solid;
}

/// Points a quarter of a voxel apart on the edges where faces of the mesh turn by more than 30°.
std::vector<Vec3d> creasesOf(const clay::TriangleMesh& mesh, double voxelMm) {
  std::map<std::pair<uint32_t, uint32_t>, Vec3d> normalAt;
  std::vector<Vec3d> points;
  for (const auto& t : mesh.triangles) {
    const Vec3d normal =
        (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]).normalized();
    for (size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(t[i], t[(i + 1) % 3]);
      const auto [other, first] = normalAt.try_emplace({a, b}, normal);
      if (first || other->second.dot(normal) > std::cos(EIGEN_PI / 6)) continue;
      const Vec3d from = mesh.positions[a], along = mesh.positions[b] - from;
      const int steps = std::max(1, static_cast<int>(std::ceil(along.norm() / voxelMm * 4)));
      for (int k = 0; k <= steps; ++k) points.push_back(from + along * k / steps);
    }
  }
  return points;
}

/// Voxels, and the time that the surface took.
struct Measured {
  double most = 0;
  uint64_t points = 0;
  Samples us;
};

Measured measure(const Solid& solid, clay::Grade grade) {
  Measured result;
  const double voxel = solid.version.grid().voxelMm;
  const auto take = [&](double mm) {
    result.most = std::max(result.most, std::abs(mm) / voxel);
    ++result.points;
  };
  clay::TriangleMesh mesh;
  for (int run = 0; run < kRuns; ++run) {
    clay::Surface surface(true, grade);
    const Stopwatch watch;
    surface.update(solid.version);
    result.us.add(watch.us());
    if (run == 0) mesh = surface.toMesh();
  }
  for (const auto& t : mesh.triangles)
    for (int i = 0; i <= 3; ++i)
      for (int j = 0; i + j <= 3; ++j)
        take(solid.distance((i * mesh.positions[t[0]] + j * mesh.positions[t[1]] + (3 - i - j) * mesh.positions[t[2]]) /
                            3));
  const clay::NearestTriangle tree(mesh);
  for (const Vec3d& p : solid.edges) take(std::sqrt(tree.nearest(p).squared));
  return result;
}

void add(BenchReport& report, const std::string& name, const Solid& solid) {
  const Measured draft = measure(solid, clay::Grade::draft), fine = measure(solid, clay::Grade::fine);
  BenchResult r;
  r.name = "fine/error/" + name;
  r.unit = "voxel";
  r.median = fine.most;
  r.n = fine.points;
  r.peer = draft.most;
  r.peerName = "draft";
  r.note = fmt::format("cost {:.0f}×", fine.us.median() / draft.us.median());
  report.add(r);
}

}  // namespace

void benchFineError(BenchReport& report, const BenchOptions& options) {
  report.heading(
      "fine: the largest error in voxels, over points of all triangles and of the true edges, with the time beside "
      "that of the draft");
  for (const double round : {0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0}) {
    if (options.job) options.job->step(0);
    add(report, fmt::format("box/round {:g}", round), turnedBox(round, 0.9));
  }
  const char* data = std::getenv("ARGIL_DATA");
  if (!data) return report.heading("fine: set ARGIL_DATA to the folder of test data for the fandisk");
  const clay::TriangleMesh mesh = io::readMesh(std::filesystem::path(data) / "mesh" / "fandisk.obj").mesh;
  const clay::NearestTriangle tree(mesh);
  for (const int along : {160, 320}) {
    clay::ImportOptions import;
    import.grid.voxelMm = clay::suggestVoxelMm(mesh, along);
    add(report, fmt::format("fandisk/{}", along),
        {clay::meshToClay(clay::Store::make(), mesh, import, options.job).version,
         [&](const Vec3d& p) { return std::sqrt(tree.nearest(p).squared); }, creasesOf(mesh, import.grid.voxelMm)});
  }
}

}  // namespace argil::bench
