// argil bench edit: what one dab of a ball costs, at any size of the model.

#include <openvdb/openvdb.h>
#include <openvdb/tools/Clip.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/brush/brush.h"
#include "clay/brush/brush_method.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/store/vdb_bridge.h"
#include "clay/surface/surface.h"

namespace argil::bench {

namespace {

using namespace clay;

constexpr double kRadius = 20;  // voxels
constexpr double kLargestMillions = 1000;
constexpr int kFresh = 400, kWarm = 20, kPeerDabs = 20;
constexpr int kWalk = 140;  // goes not quite once around the smallest sphere

// As the budget has them: from a million on.
std::vector<double> sizesFrom1M(double largest) {
  std::vector<double> sizes = benchSizes(largest);
  if (largest >= 1) sizes.front() = 1;
  return sizes;
}

struct Model {
  BenchModel sphere;
  double share = 1;  // of the clay that the ball would hold on a flat face
  Surface surface;
  Samples fresh, freshEdit, freshSurface, walk, walkEdit, kernel, copy, stroke;
  uint64_t touched = 0, changed = 0, made = 0, nodes = 0, triangles = 0;
  std::vector<Vec3d> places;
};

void collectAll(const Version& version) {
  while (version.store()->collect()) {
  }
}

const std::shared_ptr<const Brush>& carving() {
  static const std::shared_ptr<const Brush> brush = Brush::of(Method::carve);
  return brush;
}

Stamp dabAt(const Vec3d& at) {
  return {at, at, kRadius};
}

// Points of the sphere no two of which lie within a dab of each other, in random order: fresh clay, cold memory.
std::vector<Vec3d> freshPlaces(const Model& model, uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Vec3d centre = model.sphere.version.grid().toVoxel(Vec3d(3, 5, 7));
  std::vector<Vec3d> places;
  while (static_cast<int>(places.size()) < count)
    places.push_back(centre +
                     Vec3d(normal(random), normal(random), normal(random)).normalized() * model.sphere.radiusVoxels);
  return places;
}

// Places on the cube's faces, clear of its edges.
std::vector<Vec3d> flatPlaces(const Model& model, uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  const double half = model.sphere.radiusVoxels, clear = half - kRadius - 10;
  std::uniform_real_distribution<double> along(-clear, clear);
  const Vec3d centre = model.sphere.version.grid().toVoxel(Vec3d(3, 5, 7));
  std::vector<Vec3d> places;
  while (static_cast<int>(places.size()) < count) {
    const uint64_t face = random() % 6;
    const double u = along(random), v = along(random), side = face % 2 ? half : -half;
    places.push_back(centre + (face < 2 ? Vec3d(side, u, v) : face < 4 ? Vec3d(u, side, v) : Vec3d(u, v, side)));
  }
  return places;
}

// One dab on the untouched model: the edit, then the surface. Each is taken back before the next.
void freshDab(Model& m, const Vec3d& at) {
  const Version& base = m.sphere.version;
  Stopwatch watch;
  Version after;
  Editor::Counts counts;
  {
    BrushStroke stroke(base, carving());
    stroke.apply(dabAt(at));
    after = stroke.publish();
    counts = stroke.counts();
    m.touched += stroke.touched();
  }
  const double edit = watch.us();
  const SurfaceDelta delta = m.surface.update(after);
  const double all = watch.us();
  m.fresh.add(all);
  m.freshEdit.add(edit);
  m.freshSurface.add(all - edit);
  m.made += counts.bricksMade;
  m.nodes += counts.nodesMade;
  for (const BrickMeshPtr& mesh : delta.changed) m.triangles += 2 * mesh->quads.size();

  // The parts, on the bricks of this very dab: arithmetic into one scratch brick, then the plain copy of as many bricks
  // into memory that the pool hands out anew each time.
  struct Work {
    const Brick *from, *to;
  };
  std::vector<Work> work;
  Version::forEachDifference(base, after, [&](Coord, Slot a, Slot b) {
    ++m.changed;
    if (a.brick() && b.brick()) work.push_back({a.brick(), b.brick()});
  });
  FloatBrick scratch;
  BrickValues values, solid;
  Stopwatch kernelWatch;
  for (const Work& w : work) {
    ballDistances(sweptBall(dabAt(at), w.from->coord), solid);
    takeAwaySolid(solid, base.grid().band, w.from->values(values), scratch);
  }
  m.kernel.add(kernelWatch.us());
  const size_t bytes = brickBytes(base.store()->precision());
  std::vector<std::byte> target(work.size() * bytes);
  Stopwatch copyWatch;
  for (size_t i = 0; i < work.size(); ++i)
    std::memcpy(&target[i * bytes], static_cast<const void*>(work[i].from), bytes);
  m.copy.add(copyWatch.us());

  m.surface.update(base);
  after = Version();
  collectAll(base);
}

// Dabs that overlap the last by 90 %, each on the clay that the last one left.
void walk(Model& m, int count) {
  const Version base = m.sphere.version;
  const Vec3d centre = base.grid().toVoxel(Vec3d(3, 5, 7));
  const double radius = m.sphere.radiusVoxels, step = 0.1 * 2 * kRadius / radius;
  const auto at = [&](int i) {
    return Vec3d(centre + radius * Vec3d(std::cos(0.3 + i * step), std::sin(0.3 + i * step), 0.2).normalized());
  };
  Version version = base;
  for (int i = 0; i < count; ++i) {
    Stopwatch watch;
    {
      BrushStroke stroke(version, carving());
      stroke.apply(dabAt(at(i)));
      version = stroke.publish();
    }
    m.walkEdit.add(watch.us());
    m.surface.update(version);
    m.walk.add(watch.us());
    collectAll(version);
  }
  m.surface.update(base);
  // The same walk as a stroke, whose redistancing trails.
  BrushStroke stroke(base, carving());
  for (int i = 0; i < count; ++i) {
    Stopwatch watch;
    stroke.apply(dabAt(at(i)));
    m.surface.update(stroke.publish());
    m.stroke.add(watch.us());
    collectAll(base);
  }
  Stopwatch watch;
  m.surface.update(stroke.finish());
  m.stroke.add(watch.us());
  m.surface.update(base);
  version = Version();
  collectAll(base);
}

// The same by OpenVDB, on the same field: the dab by an accessor, volumeToMesh of the dab's box and of the whole.
void peer(BenchReport& report, const Model& m) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto grid = std::static_pointer_cast<openvdb::FloatGrid>(toVdb(m.sphere.version).grid);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  const float band = m.sphere.version.grid().band;
  Samples dab, box;
  for (int i = 0; i < kPeerDabs; ++i) {
    const Vec3d c = m.places[static_cast<size_t>(i)];
    const int reach = static_cast<int>(kRadius + band) + 1;
    const openvdb::Coord middle(static_cast<int>(std::lround(c.x())), static_cast<int>(std::lround(c.y())),
                                static_cast<int>(std::lround(c.z())));
    const openvdb::CoordBBox bounds(middle.offsetBy(-reach), middle.offsetBy(reach));
    Stopwatch watch;
    auto accessor = grid->getAccessor();
    for (auto it = bounds.begin(); it; ++it) {
      const openvdb::Coord& v = *it;
      const double x = v.x() - c.x(), y = v.y() - c.y(), z = v.z() - c.z();
      const float cut = static_cast<float>(kRadius - std::sqrt(x * x + y * y + z * z));
      if (cut <= -band) continue;
      const float old = accessor.getValue(v);
      const float next = std::min(std::max(old, cut), band);
      if (next != old) accessor.setValue(v, next);
    }
    dab.add(watch.us());
    const auto part = openvdb::tools::clip(*grid, openvdb::BBoxd(bounds.min().asVec3d(), bounds.max().asVec3d()));
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    Stopwatch boxWatch;
    openvdb::tools::volumeToMesh(*part, points, triangles, quads, 0, 0);
    box.add(boxWatch.us());
  }
  BenchResult r = m.freshEdit.result("edit/ball20-edit/" + m.sphere.name);
  r.peer = dab.median();
  r.peerName = "OpenVDB accessor dab";
  report.add(r);
  r = m.freshSurface.result("edit/ball20-extract/" + m.sphere.name);
  r.peer = box.median();
  r.peerName = "volumeToMesh of the box";
  report.add(r);
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  Stopwatch watch;
  openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0, 0);
  r = m.freshSurface.result("edit/ball20-extract-whole/" + m.sphere.name);
  r.peer = watch.us();
  r.peerName = "volumeToMesh of the whole";
  report.add(r);
}

// Fresh dabs over all models in turn, warmed up.
void freshDabs(std::vector<Model>& models, Job* job) {
  for (int warm = 0; warm < kWarm; ++warm)
    for (Model& m : models) freshDab(m, m.places[static_cast<size_t>(warm)]);
  for (Model& m : models) {
    const Samples none;
    m.fresh = m.freshEdit = m.freshSurface = m.kernel = m.copy = none;
    m.touched = m.changed = m.made = m.nodes = m.triangles = 0;
  }
  for (int i = 0; i < kFresh; ++i) {
    for (Model& m : models) freshDab(m, m.places[static_cast<size_t>(i)]);
    if (job) job->step(0.5 * i / kFresh);
  }
}

// The same dab with the surface that the studio shows, which finds the rims of the cut.
void liveDabs(BenchReport& report, std::vector<Model>& models) {
  std::vector<Samples> live(models.size());
  for (Model& m : models) {
    m.surface = Surface(true, Grade::crisp);
    m.surface.update(m.sphere.version, 2);
  }
  for (int i = 0; i < kFresh; ++i)
    for (size_t k = 0; k < models.size(); ++k) {
      Model& m = models[k];
      const Version& base = m.sphere.version;
      Stopwatch watch;
      Version after;
      {
        BrushStroke stroke(base, carving());
        stroke.apply(dabAt(m.places[static_cast<size_t>(i)]));
        after = stroke.publish();
      }
      m.surface.update(after);
      if (i >= kWarm) live[k].add(watch.us());
      m.surface.update(base);
      after = Version();
      collectAll(base);
    }
  for (size_t k = 0; k < models.size(); ++k) {
    BenchResult r = live[k].result("edit/ball20-live/" + models[k].sphere.name);
    r.note = fmt::format("with the live grade; {:.2f}× with the draft", live[k].median() / models[k].fresh.median());
    report.add(r);
  }
}

// Counts on a sphere follow how much clay the ball holds there; over that share they say how much the size of the model
// costs.
void reportFresh(BenchReport& report, const std::vector<Model>& models, const std::string& name) {
  const auto counts = [](const Model& m) {
    return std::array{m.changed, m.made, m.nodes,
                      m.touched * sizeof(FloatBrick) + Editor::Counts{m.made, m.nodes}.bytes()};
  };
  for (const Model& m : models) {
    BenchResult r = m.fresh.result(name + m.sphere.name);
    // Bricks touched: computed or turned into tiles. Bytes: those bricks read, the nodes copied, the bricks written.
    const auto perDab = [](uint64_t n) { return static_cast<double>(n) / kFresh; };
    r.bricks = static_cast<uint64_t>(std::lround(perDab(m.touched)));
    r.chunks = static_cast<uint64_t>(std::lround(perDab(m.nodes)));
    r.bytes = static_cast<uint64_t>(perDab(m.touched * sizeof(FloatBrick) + Editor::Counts{m.made, m.nodes}.bytes()));
    r.triangles = m.triangles / kFresh;
    const auto here = counts(m), last = counts(models.back());
    const auto off = [&](size_t i, double over) {
      return 100 * (static_cast<double>(here[i]) / static_cast<double>(last[i]) / over - 1);
    };
    const double over = m.share / models.back().share;
    r.note = fmt::format(
        "{:.2f}× the smallest's time; per dab {:.1f} bricks touched, {:.1f} changed, {:.1f} made, {:.2f} nodes; beside "
        "the largest's, changed, made, "
        "nodes, bytes: {:+.1f} {:+.1f} {:+.1f} {:+.1f} %",
        m.fresh.median() / models.front().fresh.median(), perDab(m.touched), perDab(m.changed), perDab(m.made),
        perDab(m.nodes), off(0, 1), off(1, 1), off(2, 1), off(3, 1));
    if (m.share < 1)
      r.note +=
          fmt::format("; over the clay in the ball ({:.3f} of that on a flat face): {:+.1f} {:+.1f} {:+.1f} {:+.1f} %",
                      m.share, off(0, over), off(1, over), off(2, over), off(3, over));
    report.add(r);
  }
}

// How far the surface of one lies from that of the other, voxels.
double worstBetween(const Version& a, const Version& b) {
  Surface surface(false);
  surface.update(a, 2);
  Sampler here(a), there(b);
  double worst = 0;
  surface.forEach([&](const BrickMesh& mesh) {
    for (const Vec3f& position : mesh.positions) {
      const Vec3d p = (mesh.brick * 8).toVec3d() + position.cast<double>();
      worst = std::max(worst, std::abs(double(there.trilinear(p)) - double(here.trilinear(p))));
    }
  });
  return worst;
}

// What 16 bits cost and save: memory, the dab, the whole surface, and how far a stroke ends from that on floats.
void precisions(BenchReport& report, const BenchOptions& options) {
  report.heading("distances of 32 and of 16 bits, the same dabs in turn, one thread");
  std::vector<Model> models;
  for (const Precision precision : {Precision::float32, Precision::fixed16}) {
    Model m;
    m.sphere = benchSphere(sizesFrom1M(std::min(options.largest, 12.0)).back(), precision);
    m.surface.update(m.sphere.version, 2);
    m.places = freshPlaces(m, 20261120, kFresh);
    models.push_back(std::move(m));
  }
  freshDabs(models, options.job);
  std::vector<Version> strokes;
  for (Model& m : models) {
    walk(m, kWalk);
    BrushStroke stroke(m.sphere.version, carving());
    for (int i = 0; i < 20; ++i) stroke.apply(dabAt(m.places[static_cast<size_t>(i)]));
    strokes.push_back(stroke.finish());
  }
  Samples whole[2];
  for (int i = 0; i < 5; ++i)
    for (size_t k = 0; k < 2; ++k) {
      Stopwatch watch;
      Surface surface;
      surface.update(models[k].sphere.version);
      whole[k].add(watch.us());
    }
  for (size_t k = 0; k < 2; ++k) {
    const Model& m = models[k];
    const std::string name = fmt::format("bits{}/", k == 0 ? 32 : 16) + m.sphere.name;
    const VersionStats stats = m.sphere.version.stats();
    BenchResult r = m.fresh.result("edit/ball20-" + name);
    r.bytes = stats.bytes() / stats.bricks;
    r.note = fmt::format(
        "bytes: a brick with its share of nodes; the edit alone {:.1f} us, {:.3f}× 32 bits; after 20 dabs the surface "
        "lies {:.6f} voxel from that of 32 bits at most",
        m.freshEdit.median(), m.freshEdit.median() / models[0].freshEdit.median(),
        worstBetween(strokes[0], strokes[k]));
    report.add(r);
    r = m.stroke.result("edit/ball20-stroke-" + name);
    r.note = fmt::format("{:.3f}× 32 bits", m.stroke.median() / models[0].stroke.median());
    report.add(r);
    r = whole[k].result("edit/whole-surface-" + name);
    r.note = fmt::format("{:.3f}× 32 bits", whole[k].median() / whole[0].median());
    report.add(r);
  }
}

// Spheres of these sizes with their surfaces, and places for fresh dabs.
std::vector<Model> spheres(const std::vector<double>& sizes, Precision precision, Job* job) {
  std::vector<Model> models;
  for (const double size : sizes) {
    Model m;
    m.sphere = benchSphere(size, precision);
    m.share = 1 - 3 * kRadius / (8 * m.sphere.radiusVoxels);
    m.surface.update(m.sphere.version, 2);
    m.places = freshPlaces(m, 20261120, kFresh);
    models.push_back(std::move(m));
    if (job) job->step(0);
  }
  return models;
}

// The largest clay there is, by itself: with others beside it there would be no memory.
void benchLargest(BenchReport& report, const BenchOptions& options) {
  report.heading("edit: the same dab on a thousand million active voxels of 16 bits beside a million, one thread");
  std::vector<Model> models = spheres({1.0, kLargestMillions}, Precision::fixed16, options.job);
  freshDabs(models, options.job);
  for (Model& m : models) walk(m, kWalk);
  reportFresh(report, models, "edit/ball20-bits16/");
  for (const Model& m : models) {
    BenchResult r = m.walk.result("edit/ball20-bits16-walk/" + m.sphere.name);
    r.note = fmt::format("{:.2f}× the smallest's time", m.walk.median() / models.front().walk.median());
    report.add(r);
  }
}

}  // namespace

void benchEdit(BenchReport& report, const BenchOptions& options) {
  if (options.largest >= kLargestMillions) return benchLargest(report, options);
  report.heading(fmt::format(
      "edit: a ball of {} voxels carves a sphere of 40 mm; edit + surface with normals, one thread; sizes in turn",
      kRadius));
  std::vector<Model> models = spheres(sizesFrom1M(options.largest), Precision::float32, options.job);
  freshDabs(models, options.job);
  for (Model& m : models) walk(m, kWalk);

  const Model& smallest = models.front();
  reportFresh(report, models, "edit/ball20/");
  for (const Model& m : models) {
    BenchResult r = m.walk.result("edit/ball20-walk/" + m.sphere.name);
    r.note = fmt::format("{:.2f}× the smallest's time", m.walk.median() / smallest.walk.median());
    report.add(r);
  }
  for (const Model& m : models) {
    BenchResult r = m.stroke.result("edit/ball20-stroke/" + m.sphere.name);
    r.note = "the walk as one stroke: redistancing trails";
    report.add(r);
  }
  report.heading("parts of the fresh dab");
  for (const Model& m : models) {
    report.add(m.kernel.result("edit/ball20-kernel/" + m.sphere.name));
    report.add(m.copy.result("edit/ball20-copy/" + m.sphere.name));
    BenchResult tree;
    tree.name = "edit/ball20-tree/" + m.sphere.name;
    tree.median = m.freshEdit.median() - m.kernel.median();
    tree.n = m.freshEdit.count();
    tree.note = "edit less kernel: choosing bricks, cold reads, path copies, the version";
    report.add(tree);
    report.add(m.freshSurface.result("edit/ball20-extraction/" + m.sphere.name));
  }
  liveDabs(report, models);
  report.heading("OpenVDB beside it, one thread");
  // The peer needs several times a model's memory: what is done with goes first.
  for (Model& m : models) m.surface = Surface();
  for (Model& m : models) {
    peer(report, m);
    m = Model();
  }
  models.clear();

  report.heading(
      "the same fresh dab on the flat faces of a cube: what is left of the counts' differences when curvature is gone");
  for (const double size : sizesFrom1M(options.largest)) {
    Model m;
    m.sphere = benchCube(size);
    m.surface.update(m.sphere.version, 2);
    m.places = flatPlaces(m, 20261120, kFresh);
    models.push_back(std::move(m));
  }
  freshDabs(models, options.job);
  reportFresh(report, models, "edit/ball20-flat/");
  models.clear();
  precisions(report, options);
}

}  // namespace argil::bench
