#include "clay/mesh/reduce.h"

#include <fmt/format.h>

#include <cmath>

#include "clay/mesh/edge_collapse.h"
#include "clay/mesh/measure_deviation.h"

namespace argil::clay {

namespace {

constexpr uint64_t kFewest = 4;  ///< Triangles of a body.
/// Of the time, the collapses; the rest is measuring.
constexpr double kCollapsing = 0.8;
/// The collapses are bound to less than the error that was asked for: what lies between the places that they look at
/// goes a little farther.
constexpr double kBound = 0.9;
constexpr int kTries = 8;

void check(const TriangleMesh& mesh, const ReduceOptions& options) {
  if (options.triangles.has_value() == options.errorMm.has_value())
    throw Error("a reduction needs a number of triangles or an error in mm: give one of them");
  if (options.triangles && *options.triangles < kFewest)
    throw Error(fmt::format("a reduction to {} triangles is less than any body has: ask for {} or more",
                            *options.triangles, kFewest));
  if (options.errorMm && !(*options.errorMm > 0 && std::isfinite(*options.errorMm)))
    throw Error(fmt::format("a reduction within {} mm is not possible: give an error above 0 mm", *options.errorMm));
  if (mesh.triangles.empty()) throw Error("a mesh without triangles cannot be reduced: add a surface");
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t)
      if (v >= mesh.positions.size())
        throw Error(fmt::format("a triangle names vertex {} of {}: the mesh is damaged", v, mesh.positions.size()),
                    Error::Kind::work);
  for (const Vec3d& p : mesh.positions)
    if (!p.allFinite()) throw Error("a coordinate of the mesh is not finite: repair it before it is reduced");
}

TriangleMesh toCount(const TriangleMesh& mesh, uint64_t target, const WorkPart& work) {
  const auto all = double(mesh.triangles.size());
  const auto watch = [&](uint64_t left) { work.step((all - double(left)) / (all - double(target))); };
  EdgeCollapse collapse(mesh, {}, watch);
  collapse.run(target, watch);
  if (collapse.triangles() > target) {
    throw Error(
        fmt::format("the mesh cannot be reduced to {} triangles and keep its bodies, their holes and their faces "
                    "upright: {} is the fewest, ask for that or more{}",
                    target, collapse.triangles(),
                    collapse.movable() == 0 ? " (no part of it is closed: weld or repair it first)" : ""));
  }
  return collapse.result();
}

/// Marks the vertices and, in later attempts, more and more rings around them: what is wrong beside what was kept is
/// not cured by keeping the same again.
void fix(const TriangleMesh& mesh, const std::vector<uint32_t>& vertices, int attempt, std::vector<bool>& fixed) {
  const int rings = attempt < 3 ? 0 : 1 << (attempt - 3);
  std::vector<bool> marked(fixed.size(), false);
  for (const uint32_t v : vertices) marked[v] = true;
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<bool> wider = marked;
    for (const auto& [a, b, c] : mesh.triangles)
      if (marked[a] || marked[b] || marked[c]) wider[a] = wider[b] = wider[c] = true;
    marked.swap(wider);
  }
  for (size_t v = 0; v < fixed.size(); ++v) fixed[v] = fixed[v] || marked[v];
}

/// Where the measure finds too much, the original is kept, and all is done again.
Reduced withinError(const TriangleMesh& mesh, double errorMm, const WorkPart& work) {
  EdgeCollapse::Bound bound{kBound * errorMm, std::vector<bool>(mesh.positions.size(), false)};
  double begin = 0;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const double end = begin + (1 - begin) / 2, middle = begin + (end - begin) * kCollapsing;
    const auto watch = [&](uint64_t left) {
      work.step(begin + (middle - begin) * (1 - double(left) / double(mesh.triangles.size())));
    };
    Reduced reduced;
    {
      EdgeCollapse collapse(mesh, bound, watch);
      collapse.run(0, watch);
      reduced.mesh = collapse.result();
    }
    std::vector<uint32_t> beyond;
    reduced.deviation = measureDeviation(mesh, reduced.mesh, errorMm, beyond, work.part(middle, end));
    if (reduced.deviation.most() <= errorMm) return reduced;
    fix(mesh, beyond, attempt, bound.fixed);
    begin = end;
  }
  return {mesh, {}};
}

}  // namespace

Reduced reduce(const TriangleMesh& mesh, const ReduceOptions& options, Job* job) {
  check(mesh, options);
  const WorkPart work(job);
  if (options.errorMm) return withinError(mesh, *options.errorMm, work);
  if (mesh.triangles.size() <= *options.triangles) return {mesh, {}};
  Reduced reduced;
  reduced.mesh = toCount(mesh, *options.triangles, work.part(0, kCollapsing));
  std::vector<uint32_t> none;
  reduced.deviation = measureDeviation(mesh, reduced.mesh, INFINITY, none, work.part(kCollapsing, 1));
  return reduced;
}

}  // namespace argil::clay
