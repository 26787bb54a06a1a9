#include "clay/cage/flat_quads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <tuple>
#include <utility>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/cage/coarsen_quads.h"
#include "clay/cage/fit_quads.h"
#include "clay/cage/unfold_quads.h"
#include "clay/field/region_work.h"
#include "clay/store/store.h"
#include "clay/whole/cut.h"

namespace argil::clay {

namespace {

constexpr size_t kLeastToHalve = 500;
constexpr int kMostHalvings = 2;
constexpr double kGoodJacobian = 0.85;  // in the mean: what the quads of such a cage are halved from
constexpr double kQuadsAHandle = 16;    // and there are so many at least
constexpr double kMirrored = 2;         // voxels: fine surfaces of one shape differ by as much at sharp tips
constexpr double kOnVoxels = 0.125;     // voxels: so near to a plane of voxels a half does not end
constexpr double kNearPlane = 0.75;     // voxels: so near to it a half's quads may lie in the plane
constexpr int kHalves = 6;              // tries until one has as many quads as are asked for
constexpr double kEnough = 0.95, kBelow = 0.985;
// Layouts of one clay differ, from count to count and from limit to limit, by a third in irregular vertices and in what
// they leave out: of some the best is taken. Fewer are drawn of many quads, which take long, and of cages without
// creases that are to be halved, which have few irregular vertices anyway.
struct Layout {
  double share;  // of the quads that are asked for
  bool regular;  // as in coarsened()
};
constexpr std::array<Layout, 4> kLayouts{{{1, true}, {1, false}, {0.985, true}, {0.985, false}}};
constexpr size_t kManyQuads = 1300, kFewLayouts = 2;
constexpr double kBadJacobian = 0.2, kBadQuad = 4;  // such a quad counts as so many irregular vertices,
constexpr double kAnyway = 8;                       // and every layout has about as many that none can do without;
constexpr double kTooFew = 160;                     // fewer quads than were asked for, in parts of these
constexpr double kOfMost = 0.2;                     // what the largest distance counts beside the RMS
constexpr double kLeastOff = 0.01;                  // of the finest that is looked at: less makes no layout better
constexpr size_t kPlaces = 20000;                   // of the surface, where distances are taken,
constexpr size_t kBlock = 1024;                     // so many at once
constexpr int kFits = 3;                            // the first, and those of sizes that follow from the one before,
constexpr size_t kMostRefitted = 5000;              // of up to so many quads: of more they gain little
constexpr double kTooFar = 1;                       // even edges: quads that lie so far off are too few
constexpr std::array kMore{1.5, 2.0, 3.0, 4.0};     // times the quads that were asked for: then so many are drawn
constexpr double kShareOfCage = 0.8, kShareOfHalf = 0.95, kShareOfFit = 0.9, kShareOfFirst = 0.6;

// Quads that do not lie in the end of a half: how many, and their mean scaled Jacobian.
struct Outside {
  size_t count = 0;
  double jacobian = 0;
};
Outside outsideOf(const QuadMesh& mesh, const std::optional<EndPlane>& end) {
  Outside out;
  for (const auto& quad : mesh.quads) {
    if (end && liesIn(mesh, quad, *end)) continue;
    ++out.count;
    out.jacobian += scaledJacobian(mesh, quad);
  }
  out.jacobian /= double(std::max<size_t>(1, out.count));
  return out;
}

// How much of the surface lies in the end of a half, counted in quads of its sizes.
double shareInEnd(const CageMaker& maker, const EndPlane& end) {
  const TriangleMesh& surface = maker.surface();
  double all = 0, in = 0;
  for (const auto& t : surface.triangles) {
    const Vec3d &a = surface.positions[t[0]], &b = surface.positions[t[1]], &c = surface.positions[t[2]];
    const double size = (double(maker.sizes()[t[0]]) + double(maker.sizes()[t[1]]) + double(maker.sizes()[t[2]])) / 3;
    const double quads = (b - a).cross(c - a).norm() / (size * size);
    all += quads;
    if (std::all_of(t.begin(), t.end(), [&](uint32_t v) { return end.has(surface.positions[v]); })) in += quads;
  }
  return in / all;
}

// What is nearest to each of so many places.
template <class Place>
std::vector<NearestTriangle::Hit> hitsOf(size_t count, const NearestTriangle& to, int threads, const Place& place) {
  std::vector<NearestTriangle::Hit> hits(count);
  const auto look = [&](size_t begin, size_t end) {
    uint32_t hint = UINT32_MAX;
    for (size_t i = begin; i < end; ++i) {
      hits[i] = to.nearest(place(i), hint);
      hint = hits[i].triangle;
    }
  };
  parallelBlocks(count, threads, look, kBlock);
  return hits;
}

// Between quads and clay, both ways, as for all that is told of distances, mm.
struct Distance {
  double rms = 0, most = 0;
  [[nodiscard]] double both() const { return rms + kOfMost * most; }
  void add(const std::vector<NearestTriangle::Hit>& hits) {
    double sum = 0;
    for (const NearestTriangle::Hit& hit : hits) {
      sum += hit.squared / double(hits.size());
      most = std::max(most, std::sqrt(hit.squared));
    }
    rms = std::max(rms, std::sqrt(sum));
  }
};
Distance distanceOf(const QuadMesh& mesh, const CageMaker& maker, int threads) {
  const std::vector<Vec3d>& places = maker.surface().positions;
  const TriangleMesh triangles = trianglesOf(mesh);
  const size_t step = 1 + places.size() / kPlaces;
  Distance out;
  out.add(hitsOf(1 + (places.size() - 1) / step, NearestTriangle(triangles), threads,
                 [&](size_t i) { return places[i * step]; }));
  out.add(hitsOf(7 * triangles.triangles.size(), maker.tree(), threads, [&](size_t i) {
    const auto& t = triangles.triangles[i / 7];
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const std::array<Vec3d, 7> of{(a + b + c) / 3, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), a, b, c};
    return of[i % 7];
  }));
  return out;
}

// At each vertex of the surface how far it lies off the quads, or the middle of a quad's triangle off it.
std::vector<float> offOf(const QuadMesh& mesh, const CageMaker& maker, int threads) {
  const auto mm = [](const NearestTriangle::Hit& hit) { return static_cast<float>(std::sqrt(hit.squared)); };
  const std::vector<Vec3d>& places = maker.surface().positions;
  const TriangleMesh triangles = trianglesOf(mesh);
  std::vector<float> off;
  for (const NearestTriangle::Hit& hit :
       hitsOf(places.size(), NearestTriangle(triangles), threads, [&](size_t i) { return places[i]; }))
    off.push_back(mm(hit));
  for (const NearestTriangle::Hit& hit : hitsOf(triangles.triangles.size(), maker.tree(), threads, [&](size_t i) {
         const auto& t = triangles.triangles[i];
         return Vec3d((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3);
       }))
    for (const uint32_t v : maker.tree().corners(hit.triangle)) off[v] = std::max(off[v], mm(hit));
  return off;
}

// Irregular vertices and bad quads, squared, times distances. Not squared, layouts with more of them would be taken,
// since quads come near the clay in any.
double lackOf(const QuadMesh& mesh, size_t most, const CageMaker& maker, int threads) {
  auto lack = double(QuadTopology(mesh).irregular()) + kAnyway;
  lack += kTooFew * std::max(0.0, kEnough - double(mesh.quads.size()) / double(most));
  for (const auto& quad : mesh.quads)
    if (scaledJacobian(mesh, quad) < kBadJacobian) lack += kBadQuad;
  // On flat faces distances are none.
  return lack * lack * (distanceOf(mesh, maker, threads).both() + kLeastOff * maker.finestMm());
}

// What a layout lacks, once its quads lie where they fit best; without corners as places, which chooses better ones.
double lackOnceFitted(QuadMesh mesh, size_t most, const CageMaker& maker, const WorkPart& part) {
  unfoldQuads(mesh, maker.surface(), maker.tree(), maker.creases(), part);
  fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 1, part);
  return lackOf(mesh, most, maker, 1);
}

// The same for any count of threads.
QuadMesh bestLayout(const CageMaker& maker, size_t most, bool toHalve, int threads, const WorkPart& part) {
  struct Drawn {
    QuadMesh mesh;
    bool poor = false;  // not to be halved
    double lack = HUGE_VAL;
    std::exception_ptr refused;
  };
  const bool few = most > kManyQuads || (toHalve && maker.creases().empty());
  std::vector<Drawn> drawn(few ? kFewLayouts : kLayouts.size());
  const auto draw = [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const WorkPart own = i == 0 ? part : part.beside();
      try {
        drawn[i].mesh =
            maker.make(own, static_cast<size_t>(kLayouts[i].share * double(most)), kLayouts[i].regular).mesh;
        drawn[i].poor = toHalve && shapesOf(drawn[i].mesh).mean <= kGoodJacobian;
        if (const double lack = lackOnceFitted(drawn[i].mesh, most, maker, own.part(1, 1)); std::isfinite(lack))
          drawn[i].lack = lack;
      } catch (const Cancelled&) {
        throw;
      } catch (const Error&) {
        drawn[i].refused = std::current_exception();
      }
    }
  };
  parallelBlocks(drawn.size(), threads, draw, 1);
  const auto best = std::min_element(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) {
    return std::tuple(a.mesh.quads.empty(), a.poor, a.lack) < std::tuple(b.mesh.quads.empty(), b.poor, b.lack);
  });
  if (best->mesh.quads.empty()) std::rethrow_exception(drawn.front().refused);
  return std::move(best->mesh);
}

// A cage of at most so many quads, of which none in the end of a half counts: of that as many more are drawn as it
// takes, which is seen when they are. `onlyGood`: of those that are not, the first will do.
QuadMesh cageOf(const CageMaker& maker, size_t most, const std::optional<EndPlane>& end, bool onlyGood, int threads,
                const WorkPart& part) {
  if (!end) return bestLayout(maker, most, onlyGood, threads, part);
  double asked = double(most) / (1 - shareInEnd(maker, *end));
  QuadMesh best, over;
  double bestCount = 0;
  for (int i = 0; i < kHalves; ++i) {
    const WorkPart step = part.part(double(i) / kHalves, double(i + 1) / kHalves);
    // A few more do not always come of asking for a few more, but of too many the rest can go.
    QuadMesh mesh = over.quads.empty() ? maker.make(step, static_cast<size_t>(asked)).mesh
                                       : maker.fewer(std::move(over), static_cast<size_t>(asked), false, step);
    const Outside outside = outsideOf(mesh, end);
    const auto count = double(std::max<size_t>(1, outside.count));
    const bool enough = count >= kEnough * double(most), good = outside.jacobian >= kGoodJacobian;
    if (outside.count > most) {
      asked = double(mesh.quads.size()) - std::max(1.0, count - kBelow * double(most));
      over = std::move(mesh);
      continue;
    }
    if (count > bestCount) {
      bestCount = count;
      best = std::move(mesh);
    }
    if (enough || (onlyGood && !good)) break;
    over = QuadMesh();
    asked *= double(most) / (kBelow * count);
  }
  if (best.quads.empty()) throw Error("no cage of half the quads goes around half the piece", Error::Kind::work);
  return best;
}

void evenOut(QuadMesh& mesh, const CageMaker& maker, int halvings, const WorkPart& part) {
  std::vector<float> sizes = maker.sizes();
  for (float& each : sizes) each = std::ldexp(each, -halvings);
  mesh = evenedOut(std::move(mesh), maker.ground(sizes), part);
}

std::optional<FlatQuads> mirroredCage(const Version& version, size_t most, std::unique_ptr<CageMaker>& maker,
                                      int threads, const WorkPart& part, const CageWishes& wishes);

// The quads, not yet where they fit best. `end`: of the half of a clay; what lies there does not count.
FlatQuads drawn(const Version& version, size_t most, bool maybeMirrored, const std::optional<EndPlane>& end,
                int threads, const WorkPart& part, const CageWishes& wishes) {
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
      out.maker = std::make_unique<CageMaker>(version, few, true, threads, step.part(0, 0.3), end, wishes);
      if (std::exchange(maybeMirrored, false))
        if (std::optional<FlatQuads> both = mirroredCage(version, most, out.maker, threads, step.part(0.3, 1), wishes))
          return std::move(*both);
      if (out.halvings > 0 && double(few) < -kQuadsAHandle * double(out.maker->shape())) continue;
      out.mesh = cageOf(*out.maker, few, end, out.halvings > 0, threads, step.part(0.3, 1));
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      if (out.halvings == 0) throw;
      continue;
    }
    if (outsideOf(out.mesh, end).jacobian > kGoodJacobian) break;
  }
  for (int i = 1; i <= out.halvings; ++i) {
    out.mesh = halved(out.mesh);
    const auto until = [&](int each) { return kShareOfCage + (1 - kShareOfCage) * each / out.halvings; };
    evenOut(out.mesh, *out.maker, i, part.part(until(i - 1), until(i)));
  }
  return out;
}

// `maker` is of the whole clay; taken where its clay is a mirror image of itself.
std::optional<FlatQuads> mirroredCage(const Version& version, size_t most, std::unique_ptr<CageMaker>& maker,
                                      int threads, const WorkPart& part, const CageWishes& wishes) {
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
  FlatQuads half;
  try {
    half = drawn(cut(version, PlaneDivider(point, normal), true, Store::make(), nullptr, threads), most / 2, false, end,
                 threads, part.part(0, kShareOfHalf), wishes);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error&) {
    return std::nullopt;
  }
  std::optional<MirroredQuads> whole = mirroredQuads(half.mesh, end, *plane, maker->creases());
  if (!whole || whole->mesh.quads.size() > most ||
      (int64_t(whole->mesh.positions.size()) - int64_t(whole->mesh.quads.size())) / 2 != maker->shape())
    return std::nullopt;
  FlatQuads out;
  out.mesh = std::move(whole->mesh);
  out.image = std::move(whole->image);
  out.halvings = half.halvings;
  out.mirror = plane;
  out.maker = std::move(maker);
  // Edges cross the plane straight, not as they came to the half's end.
  evenOut(out.mesh, *out.maker, out.halvings, part.part(kShareOfHalf, 1));
  makeMirrored(out.mesh, out.image, *plane);
  return out;
}

FlatQuads fitted(const Version& version, size_t most, bool mirrored, int threads, const WorkPart& part,
                 const CageWishes& wishes) {
  FlatQuads out = drawn(version, most, mirrored, {}, threads, part.part(0, kShareOfFit), wishes);
  const CageMaker& maker = *out.maker;
  const int fits = most > kMostRefitted ? 1 : kFits;
  QuadMesh now = std::move(out.mesh);
  double least = HUGE_VAL;
  for (int i = 0; i < fits; ++i) {
    const WorkPart own =
        part.part(kShareOfFit + (1 - kShareOfFit) * i / fits, kShareOfFit + (1 - kShareOfFit) * (i + 1) / fits);
    if (i > 0) {
      // The same quads, smaller where they lay off and larger elsewhere.
      out.maker->refine(offOf(now, maker, threads));
      evenOut(now, maker, out.halvings, own.part(0, 0));
    }
    unfoldQuads(now, maker.surface(), maker.tree(), maker.creases(), own.part(0, 0));
    fitQuads(now, maker.surface(), maker.tree(), maker.creases(), threads, own, true);
    if (out.mirror) makeMirrored(now, out.image, *out.mirror);
    const double lack = fits > 1 ? lackOf(now, most, maker, threads) : 0;
    if (i > 0 && !(lack < least)) continue;
    least = lack;
    out.mesh = now;
  }
  out.met = out.maker->settle(out.mesh);
  return out;
}

}  // namespace

FlatQuads flatQuads(const Version& version, size_t most, bool mirrored, int threads, const WorkPart& part,
                    const CageWishes& wishes) {
  const double enough = kTooFar * std::sqrt(areaOf(version) / double(most)) * version.grid().voxelMm;
  FlatQuads out;
  std::exception_ptr refused;
  double farthest = HUGE_VAL, least = 1;  // mm off; times as many quads are too few
  try {
    out = fitted(version, most, mirrored, threads, part.part(0, kShareOfFirst), wishes);
    farthest = distanceOf(out.mesh, *out.maker, threads).most;
    if (farthest <= enough) return out;
    // Twice the quads bring the farthest place about twice as near.
    least = std::min(farthest / enough, kMore.back());
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    if (e.kind() == Error::Kind::input) throw;
    refused = std::current_exception();
  }
  for (size_t i = 0; i < kMore.size(); ++i) {
    if (kMore[i] < least) continue;
    const auto until = [&](size_t each) {
      return kShareOfFirst + (1 - kShareOfFirst) * double(each) / double(kMore.size());
    };
    try {
      FlatQuads finer = fitted(version, static_cast<size_t>(kMore[i] * double(most)), mirrored, threads,
                               part.part(until(i), until(i + 1)), wishes);
      if (distanceOf(finer.mesh, *finer.maker, threads).most > enough) continue;
      finer.tooFarMm = farthest;
      return finer;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      continue;  // what was drawn or said at first is there
    }
  }
  if (refused) std::rethrow_exception(refused);
  return out;
}

}  // namespace argil::clay
