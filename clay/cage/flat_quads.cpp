#include "clay/cage/flat_quads.h"

#include <cmath>
#include <utility>
#include <vector>

#include "clay/base/error.h"
#include "clay/cage/coarsen_quads.h"
#include "clay/cage/fit_quads.h"
#include "clay/field/region_work.h"
#include "clay/store/store.h"
#include "clay/whole/cut.h"

namespace argil::clay {

namespace {

constexpr size_t kLeastToHalve = 500;
constexpr int kMostHalvings = 2;
constexpr double kGoodJacobian = 0.85;  // in the mean: what the quads of such a cage are halved from
constexpr double kQuadsAHandle = 16;    // and there are so many at least
constexpr double kMirrored = 0.5;       // voxels
constexpr double kOnVoxels = 0.125;     // voxels: so near to a plane of voxels a half does not end
constexpr double kNearPlane = 0.75;     // voxels: so near to it a half's quads may lie in the plane
constexpr int kHalves = 4;              // that are drawn until one has as many quads as are asked for
constexpr double kEnough = 0.95, kBelow = 0.985;
constexpr double kFacesOfArea = 1.3;  // voxel faces of a surface, of its area, of most
constexpr double kShareOfCage = 0.8, kShareOfFit = 0.9;

double meanJacobian(const QuadMesh& mesh) {
  double sum = 0;
  for (const auto& quad : mesh.quads) sum += scaledJacobian(mesh, quad);
  return sum / double(mesh.quads.size());
}

void evenOut(QuadMesh& mesh, const CageMaker& maker, int halvings, const WorkPart& part) {
  std::vector<float> sizes = maker.sizes();
  for (float& each : sizes) each = std::ldexp(each, -halvings);
  mesh = evenedOut(std::move(mesh), maker.surface(), maker.tree(), maker.creases(), sizes, maker.finestMm(), part);
}

std::optional<FlatQuads> mirrored(const Version& version, size_t most, std::unique_ptr<CageMaker>& maker, int threads,
                                  const WorkPart& part);

// The quads, not yet where they fit best. `end`: of the half of a clay.
FlatQuads drawn(const Version& version, size_t most, const std::optional<EndPlane>& end, int threads,
                const WorkPart& part) {
  bool maybeMirrored = !end;
  const size_t least = end ? kLeastToHalve / 2 : kLeastToHalve;
  FlatQuads out;
  out.halvings = kMostHalvings + 1;
  for (double done = 0, until = 0; done < 1; done = until) {
    do --out.halvings;
    while (out.halvings > 0 && most >> (2 * out.halvings) < least);
    until = out.halvings == 0 ? 1 : 0.5 * (done + 1);
    const WorkPart step = part.part(kShareOfCage * done, kShareOfCage * until);
    const size_t few = most >> (2 * out.halvings);
    try {
      out.maker = std::make_unique<CageMaker>(version, few, true, threads, step.part(0, 0.3), end);
      if (std::exchange(maybeMirrored, false))
        if (std::optional<FlatQuads> both = mirrored(version, most, out.maker, threads, step.part(0.3, 1)))
          return std::move(*both);
      if (out.halvings > 0 && double(few) < -kQuadsAHandle * double(out.maker->shape())) continue;
      out.mesh = out.maker->make(step.part(0.3, 1)).mesh;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      if (out.halvings == 0) throw;
      continue;
    }
    if (meanJacobian(out.mesh) > kGoodJacobian) break;
  }
  for (int i = 1; i <= out.halvings; ++i) {
    out.mesh = halved(out.mesh);
    evenOut(out.mesh, *out.maker, i, part.part(kShareOfCage, 1));
  }
  return out;
}

// `maker` is of the whole clay.
std::optional<FlatQuads> mirrored(const Version& version, size_t most, std::unique_ptr<CageMaker>& maker, int threads,
                                  const WorkPart& part) {
  const Grid& grid = version.grid();
  const std::optional<MirrorPlane> plane = mirrorPlaneOf(maker->surface(), maker->tree(), kMirrored * grid.voxelMm);
  if (!plane) return std::nullopt;
  Vec3d point = Vec3d::Zero(), normal = Vec3d::Zero();
  normal[plane->axis] = 1;
  // Faces in a plane of voxels leave gaps in creases: there the half ends a little before it.
  const double voxel = grid.toVoxel(plane->atMm * normal)[plane->axis], off = std::abs(voxel - std::round(voxel));
  const EndPlane end{plane->axis, plane->atMm - (off < kOnVoxels ? 2 * kOnVoxels * grid.voxelMm : 0),
                     kNearPlane * grid.voxelMm};
  point[plane->axis] = end.atMm;
  const Version half = cut(version, PlaneDivider(point, normal), true, Store::make(), nullptr, threads);
  const double both = areaOf(version) / kFacesOfArea, one = areaOf(half) - 0.5 * areaOf(version) + 0.5 * both;
  double share = 0.5 * both / one;  // of the half's surface that is not in the plane
  const double enough = kEnough * double(most);
  std::optional<FlatQuads> best;
  for (int i = 0; i < kHalves && !(best && double(best->mesh.quads.size()) >= enough); ++i) {
    FlatQuads of;
    try {
      of = drawn(half, static_cast<size_t>(0.5 * kBelow * double(most) / share), end, threads,
                 part.part(double(i) / kHalves, double(i + 1) / kHalves));
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      break;
    }
    std::optional<MirroredQuads> quads = mirroredQuads(of.mesh, end, *plane, maker->creases());
    if (!quads || (int64_t(quads->mesh.positions.size()) - int64_t(quads->mesh.quads.size())) / 2 != maker->shape())
      break;
    share = double(quads->ofHalf) / double(of.mesh.quads.size());
    if (quads->mesh.quads.size() > most || (best && best->mesh.quads.size() > quads->mesh.quads.size())) continue;
    best.emplace();
    best->halvings = of.halvings;
    best->mirror = plane;
    best->image = std::move(quads->image);
    best->mesh = std::move(quads->mesh);
  }
  if (!best) return std::nullopt;
  // Edges cross the plane straight, not as they came to the half's end.
  evenOut(best->mesh, *maker, best->halvings, part);
  makeMirrored(best->mesh, best->image, *plane);
  best->maker = std::move(maker);
  return best;
}

}  // namespace

FlatQuads flatQuads(const Version& version, size_t most, int threads, const WorkPart& part) {
  FlatQuads out = drawn(version, most, {}, threads, part.part(0, kShareOfFit));
  fitQuads(out.mesh, out.maker->surface(), out.maker->tree(), out.maker->creases(), threads, part.part(kShareOfFit, 1));
  if (out.mirror) makeMirrored(out.mesh, out.image, *out.mirror);
  return out;
}

}  // namespace argil::clay
