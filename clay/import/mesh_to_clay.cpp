#include "clay/import/mesh_to_clay.h"

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "clay/base/memory_guard.h"
#include "clay/import/solid_field.h"
#include "clay/mesh/crossing_triangles.h"
#include "clay/store/vdb_bridge.h"

namespace argil::clay {

namespace {

constexpr double kLeastVoxelMm = 1e-3, kMostVoxelMm = 1e3;  // as Grid::check() has them
constexpr double kMostVoxelsAlong = 65536;
constexpr double kMostActiveVoxels = 1 << 28;
constexpr double kBytesOfVoxel = 80;    // at the peak of an import
constexpr int kMargin = 16;             // voxels between a placed origin and the mesh: more than any band
constexpr double kLeastBacked = 0.5;    // share of an open mesh's area with an inside behind it: below, it is a sheet
constexpr double kLostVoxels = 50;      // of a mesh's area in voxels²: rims and tips lose less
constexpr double kVoxelsAWall = 2;      // that keep it
constexpr double kWorthSaying = 0.005;  // share of the band: a few voxels fall out at every sharp tip and rim

struct Box {
  Vec3d low = Vec3d::Constant(INFINITY), high = Vec3d::Constant(-INFINITY);
  [[nodiscard]] double longest() const { return (high - low).maxCoeff(); }
};

Box boxOf(const TriangleMesh& mesh) {
  Box box;
  for (const auto& t : mesh.triangles) {
    for (const uint32_t v : t) {
      box.low = box.low.cwiseMin(mesh.positions[v]);
      box.high = box.high.cwiseMax(mesh.positions[v]);
    }
  }
  return box;
}

double areaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    area += (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).norm() / 2;
  }
  return area;
}

/// Three digits, never below what was asked for when `up`.
double rounded(double value, bool up) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 2);
  return (up ? std::ceil(value / unit) : std::round(value / unit)) * unit;
}

Error noTriangles() {
  return Error("the mesh holds no triangle with an area: there is nothing to make clay of");
}

/// What to do where a larger voxel is needed, which there may not be.
std::string largerVoxel(double voxelMm) {
  return voxelMm > kMostVoxelMm
             ? fmt::format("give a smaller unit or scale it down, as voxels are {:g} mm at most", kMostVoxelMm)
             : fmt::format("use {:g} mm or more", voxelMm);
}

/// Refuses what would not fit and gives the grid with its origin.
Grid gridFor(const Box& box, double area, const ImportOptions& options) {
  Grid grid = options.grid;
  if (options.placeOrigin) grid.originMm = Vec3d::Zero();
  grid.check();
  const double along = box.longest() / grid.voxelMm + 2 * kMargin;
  if (along > kMostVoxelsAlong) {
    throw Error(fmt::format(
        "at a voxel size of {:g} mm the mesh would be {:.0f} voxels long, and {:.0f} is the most: {}", grid.voxelMm,
        along, kMostVoxelsAlong, largerVoxel(rounded(box.longest() / (kMostVoxelsAlong - 2 * kMargin), true))));
  }
  const double active = area / (grid.voxelMm * grid.voxelMm) * 2 * grid.band;
  if (active > kMostActiveVoxels) {
    throw Error(
        fmt::format("at a voxel size of {:g} mm the mesh would take about {:.0f} million voxels, and {:.0f} million is "
                    "the most: {}",
                    grid.voxelMm, active / 1e6, kMostActiveVoxels / 1e6,
                    largerVoxel(rounded(grid.voxelMm * std::sqrt(active / kMostActiveVoxels), true))));
  }
  requireMemory(kBytesOfVoxel * active, fmt::format("clay of {:.0f} million voxels", active / 1e6),
                fmt::format("use a voxel larger than {:g} mm", grid.voxelMm));
  if (options.placeOrigin) {
    for (int k = 0; k < 3; ++k) grid.originMm[k] = grid.voxelMm * (std::floor(box.low[k] / grid.voxelMm) - kMargin);
    grid.check();
  }
  const double reach = double(kBrickReach) * kBrickEdge - kMargin;
  if (grid.toVoxel(box.low).minCoeff() < -reach || grid.toVoxel(box.high).maxCoeff() > reach) {
    throw Error(
        fmt::format("the mesh lies farther than {:.0f} voxels from the grid's origin: place the origin near the mesh "
                    "or use a larger voxel",
                    reach));
  }
  return grid;
}

std::string counted(uint64_t n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

}  // namespace

std::vector<std::string> ImportReport::sentences() const {
  std::vector<std::string> out;
  const char* sum = sound() && bodies == 1 && !duplicateFaces && !degenerate && !flippedWhole && !crossings
                        ? ": one closed body, nothing to repair"
                        : "";
  out.push_back(fmt::format("The mesh has {} in {}{}.", counted(triangles, "triangle", "triangles"),
                            counted(bodies, "body", "bodies"), sum));
  if (degenerate)
    out.push_back(fmt::format("{} without an area.", counted(degenerate, "triangle is", "triangles are")));
  if (duplicateFaces)
    out.push_back(fmt::format("{} on corners that had one already; left out.",
                              counted(duplicateFaces, "face lies", "faces lie")));
  if (inconsistentEdges) {
    out.push_back(fmt::format("Faces disagreed on what is outside along {}; {} turned around.",
                              counted(inconsistentEdges, "edge", "edges"),
                              counted(flippedFaces, "face was", "faces were")));
  }
  if (flippedWhole) out.push_back("The whole mesh was inside out and was turned around.");
  if (flippedBodies)
    out.push_back(fmt::format("{} inside out and turned around.", counted(flippedBodies, "body was", "bodies were")));
  if (nonManifoldEdges) {
    out.push_back(fmt::format("{} more than two faces; the winding number decided what is inside.",
                              counted(nonManifoldEdges, "edge has", "edges have")));
  }
  if (crossings) {
    const bool most = crossings >= kMostCrossings;
    out.push_back(fmt::format("{}{} each other; what they enclose more than once is clay once.",
                              most ? "At least " : "",
                              counted(crossings, "pair of triangles crosses", "pairs of triangles cross")));
  }
  const double voxel = voxelMm, less = losses.meshMm3 > 0 ? 1 - losses.clayMm3 / losses.meshMm3 : 0;
  const bool wallsLost = losses.lostMm2 > kLostVoxels * voxel * voxel;
  if (boundaryEdges) {
    out.push_back(fmt::format("The mesh is open along {}; {}.", counted(boundaryEdges, "edge", "edges"),
                              closingEdges ? fmt::format("about {:.3g} mm² of new surface closes it", closedMm2)
                              : wallsLost  ? std::string("nothing closes it where it has no inside")
                                           : std::string("its gaps are finer than a voxel and closed by themselves")));
  }
  const std::string place =
      fmt::format("{:.4g}, {:.4g}, {:.4g} mm", losses.lostAtMm.x(), losses.lostAtMm.y(), losses.lostAtMm.z());
  const double thick = losses.lostThickMm;
  // Blames the voxels only where no triangles cross.
  if (wallsLost && less > kWorthSaying && thick > 0 && !crossings) {
    out.push_back(
        fmt::format("Walls about {:.2g} mm thin are lost at a voxel of {:.3g} mm: {:.1f} % of the volume, {:.3g} mm² "
                    "on both sides, around {}. Voxels of {:.2g} mm would keep them.",
                    thick, voxel, 100 * less, losses.lostMm2, place, std::min(thick / kVoxelsAWall, 0.5 * voxel)));
  } else if (wallsLost) {
    out.push_back(
        fmt::format("Walls thinner than the voxel of {:.3g} mm are lost: {:.3g} mm² on both sides, around {}.", voxel,
                    losses.lostMm2, place));
  } else if (double(droppedVoxels) > kWorthSaying * double(bandVoxels)) {
    out.push_back("Walls inside the material or too thin for the voxel size were left out.");
  }
  if (crossings && std::abs(less) > kWorthSaying)
    out.push_back(
        fmt::format("The clay has {:.1f} % {} volume than the triangles add up to, as they cross: {}.",
                    100 * std::abs(less), less > 0 ? "less" : "more",
                    less > 0 ? "the sum counts some of it more than once" : "the sum takes what is inside out away"));
  else if (!(wallsLost && less > kWorthSaying && thick > 0) && std::abs(less) > kWorthSaying)
    out.push_back(fmt::format("The clay has {:.1f} % {} volume than the mesh at this voxel size.", 100 * std::abs(less),
                              less > 0 ? "less" : "more"));
  if (losses.specks > 0) {
    out.push_back(fmt::format("{} of {:.2g} mm³ together, which the mesh's narrow places left, {} taken out.",
                              counted(losses.specks, "speck", "specks"), losses.speckMm3,
                              losses.specks == 1 ? "was" : "were"));
  }
  if (losses.bodies + losses.cavities != bodies) {
    out.push_back(fmt::format(
        "The clay has {}{}.", counted(losses.bodies, "body", "bodies"),
        losses.cavities > 0 ? fmt::format(" and {}", counted(losses.cavities, "cavity", "cavities")) : std::string()));
  }
  return out;
}

Imported meshToClay(std::shared_ptr<Store> store, const TriangleMesh& mesh, const ImportOptions& options, Job* job) {
  if (options.threads < 0 || options.threads > 64)
    throw Error(fmt::format("{} threads: give 1 to 64, or 0 for all cores", options.threads));
  if (mesh.triangles.empty()) throw noTriangles();
  if (job) job->step(0);
  const Box box = boxOf(mesh);
  const double area = areaOf(mesh);
  if (!(area > 0)) throw noTriangles();
  const Grid grid = gridFor(box, area, options);

  RepairedMesh repaired = repairMesh(mesh, job);
  if (repaired.mesh.triangles.empty()) throw noTriangles();
  const MeshFindings& findings = repaired.findings;
  if (!repaired.openEdges.empty() && findings.backedShare < kLeastBacked) {
    throw Error(
        fmt::format("the mesh is an open sheet, with {} open edges and no inside: give it a thickness or a base in the "
                    "program that made it",
                    findings.boundaryEdges));
  }
  for (Vec3d& p : repaired.mesh.positions) p = grid.toVoxel(p);
  if (job) job->step(0.05);

  SolidField field;
  const int cores = tbb::info::default_concurrency();
  tbb::task_arena arena(options.threads > 0 ? std::min(options.threads, cores) : cores);
  arena.execute([&] { field = solidField(repaired, grid.band, job); });
  if (field.insideVoxels == 0) {
    throw Error(fmt::format(
        "nothing of the mesh is as thick as a voxel of {:g} mm: {}, or close the mesh if it is open", grid.voxelMm,
        grid.voxelMm > kLeastVoxelMm ? "use a smaller voxel"
                                     : "give a larger unit or scale it up, as voxels are no smaller"));
  }

  Imported result;
  static_cast<MeshFindings&>(result.report) = findings;
  result.report.closingEdges = field.closingEdges;
  result.report.closedMm2 = field.closedArea * grid.voxelMm * grid.voxelMm;
  result.report.droppedVoxels = field.droppedVoxels;
  result.report.bandVoxels = field.bandVoxels;
  result.report.windingUsed = !findings.sound() || findings.bodies > 1;
  result.version = fromVdb(std::move(store), grid, field.grid, job, 0.9);
  field.grid = {};
  arena.execute([&] { result.report.losses = takeSpecks(result.version, repaired, WorkPart(job, 0.95, 1)); });
  result.report.voxelMm = grid.voxelMm;
  if (job) job->step(1);
  return result;
}

double suggestVoxelMm(const TriangleMesh& mesh, int longestInVoxels) {
  if (longestInVoxels < 1 || longestInVoxels > 65000)
    throw Error(fmt::format("{} voxels along the longest side: give 1 to 65 000", longestInVoxels));
  if (mesh.triangles.empty()) throw noTriangles();
  const double longest = boxOf(mesh).longest();
  if (!(longest > 0)) throw noTriangles();
  return std::clamp(rounded(longest / longestInVoxels, false), kLeastVoxelMm, kMostVoxelMm);
}

}  // namespace argil::clay
