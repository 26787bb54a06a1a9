#include "clay/cage/cage_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"
#include "clay/base/parallel.h"
#include "clay/cage/coarsen_quads.h"
#include "clay/cage/quad_web.h"
#include "clay/field/region_work.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"
#include "clay/surface/vertex_channels.h"
#include "clay/whole/resample.h"

namespace argil::clay {

namespace {

constexpr size_t kLeastQuads = 24;
constexpr double kBeginWith = 20;  // quads for each that is asked for
// Where a cage with creases has more quads than the few that were asked for, but not so many more: by way of so many
// times as many. For few alone, since each way takes about 0.2 ms a quad that goes.
constexpr size_t kFewQuads = 200;
constexpr double kNearlyFew = 1.5, kBetween[] = {8, 6, 5, 4, 3, 2};
constexpr double kLost = 1.5;      // voxels of a coarse grid: what is farther from its surface was lost on it
constexpr size_t kPlaces = 20000;  // where that is looked for
constexpr size_t kBlock = 4096;    // vertices at once
constexpr double kEnough = 0.95, kLeastShare = 0.5;   // of the quads that are asked for
constexpr double kShared = 2;                         // times them: more are not drawn, or hardly
constexpr double kFinest = 1.4, kFinestOfEven = 0.1;  // voxels, even edges: nothing finer is looked at
constexpr double kOfThickness = 0.7;  // an edge is at most so long: four quads go around a limb or into a slit
constexpr double kLeastOfEven = 0.25, kLeastRefined = 1.0 / 6;  // of an even edge
constexpr double kNearEnd = 0.1;                                // even edges: so near to an end they are
constexpr float kLargerAtEnd = 2;                               // times as large
constexpr double kGrowth = 0.35;                                // of sizes, a mm
constexpr int kGrades = 60;                                     // sweeps until they do, at most
constexpr double kOff = 1.5;                                    // times the RMS: more is too far off
constexpr double kSmallest = 0.5, kLargest = 1.25;              // times the size before

int64_t shapeOf(uint64_t vertices, uint64_t quads) {
  // Each quad has two edges of its own.
  return (static_cast<int64_t>(vertices) - static_cast<int64_t>(quads)) / 2;
}

// Vertices that hang together have one number.
std::vector<uint32_t> bodiesIn(const QuadMesh& mesh, size_t& count) {
  JoinedSets joined(mesh.positions.size());
  count = mesh.positions.size();
  for (const auto& quad : mesh.quads)
    for (size_t s = 1; s < 4; ++s)
      if (joined.join(quad[0], quad[s])) --count;
  std::vector<uint32_t> body(mesh.positions.size());
  for (uint32_t v = 0; v < body.size(); ++v) body[v] = joined.find(v);
  return body;
}
size_t bodiesOf(const QuadMesh& mesh) {
  size_t count = 0;
  (void)bodiesIn(mesh, count);
  return count;
}

// A crumb that a coarse grid met with one point alone has a surface there that is as small as it lies deep: it grows to
// `least` across, so that its quads have a length.
void growCrumbs(QuadMesh& mesh, double least) {
  size_t count = 0;
  const std::vector<uint32_t> body = bodiesIn(mesh, count);
  std::vector<Eigen::AlignedBox3d> boxes(mesh.positions.size());
  for (size_t v = 0; v < body.size(); ++v) boxes[body[v]].extend(mesh.positions[v]);
  for (size_t v = 0; v < body.size(); ++v) {
    const Eigen::AlignedBox3d& box = boxes[body[v]];
    const double most = box.sizes().maxCoeff();
    if (most < least)
      mesh.positions[v] = box.center() + (mesh.positions[v] - box.center()) * (least / std::max(most, 1e-9));
  }
}

// How far the clay goes on below each vertex (`side` −1), or the air above it (1), mm, up to `most`: as the mesh or as
// the field says, whichever is farther. A vertex on a crease may have triangles of one face alone, and what lies below
// that is the other face.
std::vector<float> thicknesses(const Version& version, const TriangleMesh& mesh, int side, double most, int threads) {
  std::vector<Vec3d> normals(mesh.positions.size(), Vec3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const Vec3d normal = (b - a).cross(c - a);
    for (const uint32_t v : t) normals[v] += normal;
  }
  const Grid& grid = version.grid();
  std::vector<float> out(mesh.positions.size());
  const auto look = [&](size_t begin, size_t end) {
    Sampler field(version);
    for (size_t i = begin; i < end; ++i) {
      const Vec3d& at = mesh.positions[i];
      Vec3f gradient;
      (void)field.tricubic(grid.toVoxel(at), gradient);
      double deepest = 0;
      for (const Vec3d& each : {normals[i], Vec3d(gradient.cast<double>())}) {
        const Vec3d way = side * each.normalized();
        double deep = 2 * grid.voxelMm;
        while (deep < most) {
          const double phi = side * double(field.trilinear(grid.toVoxel(at + deep * way)));
          if (!(phi > 0)) break;
          deep += std::max(0.5, phi) * grid.voxelMm;
        }
        deepest = std::max(deepest, deep);
      }
      out[i] = static_cast<float>(std::min(deepest, most));
    }
  };
  parallelBlocks(out.size(), threads, look, kBlock);
  return out;
}

// Whether some of the surface is farther than that from the quads.
bool isFarther(const TriangleMesh& surface, const QuadMesh& quads, double than) {
  const TriangleMesh triangles = trianglesOf(quads);
  const NearestTriangle tree(triangles);
  for (size_t i = 0; i < surface.positions.size(); i += 1 + surface.positions.size() / kPlaces)
    if (!tree.within(surface.positions[i], than)) return true;
  return false;
}

}  // namespace

QuadMesh quadsOf(const Surface& surface) {
  // Two triangles a quad, along its corners 0 and 2.
  TriangleMesh mesh = surface.toMesh();
  QuadMesh quads;
  quads.positions = std::move(mesh.positions);
  for (size_t i = 0; i + 1 < mesh.triangles.size(); i += 2) {
    const auto &a = mesh.triangles[i], &b = mesh.triangles[i + 1];
    quads.quads.push_back({a[0], a[1], a[2], b[2]});
  }
  return quads;
}

CageMaker::CageMaker(const Version& version, size_t most, bool creased, int threads, const WorkPart& part,
                     const std::optional<EndPlane>& end, const CageWishes& wishes)
    : most_(most) {
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is no surface to draw a cage on");
  if (most < kLeastQuads) throw Error(fmt::format("a cage of {} quads: give at least {}", most, kLeastQuads));
  const Grid& grid = version.grid();
  const double area = areaOf(version);  // voxel faces
  even_ = std::sqrt(area / double(most)) * grid.voxelMm;
  finest_ = std::max(kFinest * grid.voxelMm, kFinestOfEven * even_);
  // Where there are creases the draft, which cuts them off, would draw the faces beside them away from them.
  Surface own(creased, creased ? Grade::fine : Grade::draft);
  own.update(version, threads);
  surface_ = own.toMesh();
  creases_.emplace(own, surface_, even_, end, creased ? wishes.guides : std::vector<GuideLoop>());
  if (creased && creases_->empty()) {
    own = Surface(false);
    own.update(version, threads);
    surface_ = own.toMesh();
  }
  tree_.emplace(surface_);
  shape_ = shapeOf(own.vertexCount(), own.quadCount());
  const size_t bodies = bodiesOf(quadsOf(own));
  // As no vertex has more quads than kMostOnCrease.
  static_assert(QuadWeb::kMostOnCrease == 8);
  if (const int64_t least = -4 * shape_; int64_t(most) < least)
    throw Error(fmt::format("the piece has {} handles: a cage needs at least {} quads",
                            static_cast<int64_t>(bodies) - shape_, least),
                Error::Kind::work);
  part.step(0.3);
  walls_ = thicknesses(version, surface_, -1, even_ / kOfThickness, threads);
  sizes_ = thicknesses(version, surface_, 1, even_ / kOfThickness, threads);
  for (size_t v = 0; v < sizes_.size(); ++v) sizes_[v] = std::min(sizes_[v], walls_[v]);
  for (float& each : sizes_)
    each = static_cast<float>(std::clamp(kOfThickness * double(each), kLeastOfEven * even_, even_));
  if (wishes.maskDensity != 1) {
    if (!(wishes.maskDensity >= 1 / kMostMaskDensity && wishes.maskDensity <= kMostMaskDensity))
      throw Error(fmt::format("{:g} times as many quads where the clay is masked: give {:g} to {:g}",
                              wishes.maskDensity, 1 / kMostMaskDensity, kMostMaskDensity));
    maskDensity_ = wishes.maskDensity;
    const std::vector<VertexPaint> paint = meshPaint(own);
    for (const VertexPaint& each : paint) masks_.push_back(each.mask);
    for (size_t v = 0; v < paint.size(); ++v)
      sizes_[v] = static_cast<float>(
          std::max(double(sizes_[v]) * std::pow(wishes.maskDensity, -paint[v].mask / 510.0), kLeastRefined * even_));
  }
  // Lines become fewer more slowly than what lies beside them.
  for (size_t v = 0; end && v < sizes_.size(); ++v)
    if (std::abs(surface_.positions[v][end->axis] - end->atMm) < kNearEnd * even_) sizes_[v] *= kLargerAtEnd;
  evenOut();
  part.step(0.5);
  // The clay on a coarser grid, or on its own where a part or a hole would be lost.
  double voxel = std::sqrt(area * 1.5 / (kBeginWith * double(most))) * grid.voxelMm;
  for (;; voxel *= 0.7) {
    if (voxel <= grid.voxelMm) {
      fine_ = quadsOf(own);
      break;
    }
    Grid coarse = grid;
    coarse.voxelMm = voxel;
    coarse.originMm += Vec3d::Constant(0.25 * voxel);
    Surface surface(false, grade());
    surface.update(resample(version, coarse, Eigen::Isometry3d::Identity(), threads), threads);
    part.step(0.8);
    // Neither a body for a handle: a lost crumb and a closed hole would add up to the same.
    if (shapeOf(surface.vertexCount(), surface.quadCount()) != shape_) continue;
    fine_ = quadsOf(surface);
    // Nor a thin wall within a hollow, with which no shape changes.
    if (bodiesOf(fine_) == bodies && !isFarther(surface_, fine_, kLost * voxel)) break;
  }
  growCrumbs(fine_, finest_);
  creases_->mark(fine_, *tree_);
  part.step(1);
}

// Sizes grow by no more than kGrowth a mm.
void CageMaker::evenOut() {
  for (int round = 0, changed = 1; round < kGrades && changed > 0; ++round) {
    changed = 0;
    for (const auto& t : surface_.triangles)
      for (size_t s = 0; s < 3; ++s) {
        float &a = sizes_[t[s]], &b = sizes_[t[(s + 1) % 3]];
        const Vec3d way = surface_.positions[t[s]] - surface_.positions[t[(s + 1) % 3]];
        const auto most = static_cast<float>(kGrowth * way.norm());
        if (a > b + 1.001f * most) a = b + most, ++changed;
        if (b > a + 1.001f * most) b = a + most, ++changed;
      }
  }
}

CoarseCage CageMaker::make(const WorkPart& part, size_t most, bool regular) const {
  if (most == 0) most = most_;
  CoarseCage cage;
  cage.mesh = fewerOf(most, part, regular);
  // Lines that lost edges took rows of quads with them: then more are drawn at first, as many as went or some of them.
  const auto share = double(cage.mesh.quads.size()) / double(most);
  for (const double more : {1.0, 0.5, 0.25}) {
    if (!regular || creases_->empty() || share >= kEnough || share < kLeastShare) break;
    const auto asked = static_cast<size_t>((1 + more * (1 / share - 1)) * double(most));
    QuadMesh mesh = fewerOf(asked, part, regular);
    if (mesh.quads.size() > most || mesh.quads.size() <= cage.mesh.quads.size()) continue;
    cage.mesh = std::move(mesh);
    break;
  }
  // Lines of creases get in each other's way. Evened out in between they come to lie otherwise.
  if (most <= kFewQuads && cage.mesh.quads.size() > most &&
      double(cage.mesh.quads.size()) < kNearlyFew * double(most)) {
    QuadMesh between = fine_;
    for (const double times : kBetween) {
      between = fewer(std::move(between), static_cast<size_t>(times * double(most)), true, part);
      QuadMesh mesh = fewer(between, most, false, part);
      if (mesh.quads.size() < cage.mesh.quads.size()) cage.mesh = std::move(mesh);
      if (cage.mesh.quads.size() <= most) break;
    }
  }
  if (cage.mesh.quads.size() > most && !creases_->empty()) {
    QuadMesh smooth = fine_;
    smooth.creases.clear();
    cage.mesh = coarsened(std::move(smooth), ground(sizes_), most, part, {.regular = regular});
  }
  if (cage.mesh.quads.size() > most)
    throw Error(fmt::format("no cage of at most {} quads goes around this piece, which took {}: give more", most,
                            cage.mesh.quads.size()),
                Error::Kind::work);
  cage.edgeMm = even_;
  cage.shape = shapeOf(cage.mesh.positions.size(), cage.mesh.quads.size());
  return cage;
}

QuadMesh CageMaker::fewerOf(size_t most, const WorkPart& part, bool regular) const {
  const Coarsening how{.regular = regular};
  const SharedCoarsening* shared = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (!shared_)
      shared_.emplace(fine_, ground(sizes_), static_cast<size_t>(kShared * double(most_)), part.part(0, 0.5));
    shared = &*shared_;
  }
  return most <= shared->most() ? shared->to(most, part.part(0.5, 1), how)
                                : coarsened(fine_, ground(sizes_), most, part, how);
}

QuadMesh CageMaker::fewer(QuadMesh mesh, size_t most, bool between, const WorkPart& part) const {
  return coarsened(std::move(mesh), ground(sizes_), most, part, {.between = between});
}

WishesMet CageMaker::settle(QuadMesh& mesh) const {
  WishesMet met{.guides = creases_->guides(), .guidesMm = creases_->guidesMm()};
  met.onGuidesMm = creases_->clearGuides(mesh);
  std::array<double, 2> quads{}, area{};  // not masked, masked
  uint32_t hint = UINT32_MAX;
  for (const auto& q : mesh.quads) {
    if (masks_.empty()) break;
    const Vec3d &a = mesh.positions[q[0]], &b = mesh.positions[q[1]], &c = mesh.positions[q[2]],
                &d = mesh.positions[q[3]];
    hint = tree_->nearest((a + b + c + d) / 4, hint).triangle;
    const auto& t = tree_->corners(hint);
    const size_t masked = masks_[t[0]] + masks_[t[1]] + masks_[t[2]] >= 3 * 128 ? 1 : 0;
    quads[masked] += 1;
    area[masked] += 0.5 * (c - a).cross(d - b).norm();
  }
  if (area[0] > 0 && area[1] > 0) met.maskDensity = quads[1] * area[0] / (quads[0] * area[1]);
  return met;
}

void CageMaker::refine(std::vector<float> off) {
  // With so many times as many quads a surface that is smooth lies off by their square less: that is wished for, and
  // not to be taken back.
  for (size_t i = 0; i < masks_.size(); ++i)
    off[i] *= static_cast<float>(std::pow(maskDensity_, 2 * masks_[i] / 255.0));
  shared_.reset();
  double sum = 0;
  for (const float each : off) sum += double(each) * double(each) / double(off.size());
  const double enough = kOff * std::sqrt(sum);
  for (size_t i = 0; i < off.size(); ++i) {
    // An error goes with the fourth power of the size where the surface is smooth, with less where it is not.
    const double share = enough / std::max(double(off[i]), enough / 16);
    const double factor = share < 1 ? std::max(kSmallest, std::sqrt(share)) : std::min(kLargest, std::pow(share, 0.25));
    sizes_[i] = static_cast<float>(std::max(kLeastRefined * even_, factor * double(sizes_[i])));
  }
  evenOut();
}

CoarseCage coarseCage(const Version& version, size_t most, const WorkPart& part) {
  const CageMaker maker(version, most, false, 1, part.part(0, 0.5));
  return maker.make(part.part(0.5, 1));
}

}  // namespace argil::clay
