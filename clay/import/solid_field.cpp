#include "clay/import/solid_field.h"

#include <openvdb/math/Proximity.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <queue>
#include <span>
#include <unordered_set>

#include "clay/import/voxel_winding.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/openvdb_grids.h"

namespace argil::clay {

namespace {

using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;
using VdbCoord = openvdb::Coord;
using Leaves = openvdb::tree::LeafManager<FloatTree>;

/// No distance: not reached, or taken away.
constexpr float kFar = 1e9f;
/// A triangle between two neighbours lies within one voxel of both together; rounding of float distances on top.
constexpr float kExplained = 1.001f;
/// Around a rim the winding number runs smoothly through a whole turn, one: between neighbours less than a half of it.
constexpr float kHalfStep = 0.5f;
/// Least distance given to a voxel beside the surface where it is estimated: keeps its sign.
constexpr float kLeast = 1e-3f;
/// A mesh is searched where its triangles, each less kShort voxels, have more than kThin voxels of length for each
/// voxel² of their area.
constexpr double kShort = 2, kThin = 8;
constexpr uint64_t kManyBodies = 1000;
/// Voxels of a leaf from which on winding numbers are found for all of them together.
constexpr openvdb::Index64 kManyOfLeaf = 40;
/// Cosine beyond which a voxel is clearly before or behind its nearest triangle.
constexpr double kClearSide = 0.5;
/// Most passes that look for nearer triangles at the neighbours. Two or three find all on the test meshes.
constexpr int kMostRefinements = 8;
/// A lower value than that of before must be lower by this to count.
constexpr float kMarchTolerance = 1e-4f;

const VdbCoord kSelfAndSix[7] = {{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
const std::span<const VdbCoord, 6> kSix(kSelfAndSix + 1, 6);

bool isInside(float winding) {
  return winding > 0.5f;
}

/// OpenVDB's view of a job. Its numbers run from 0 to 99.
struct Interrupter {
  Job* job;
  double from, to;
  void start(const char* = nullptr) {}
  void end() {}
  bool wasInterrupted(int percent = -1) {
    if (!job) return false;
    if (percent < 0) return job->cancelled();
    try {
      job->step(from + (to - from) * percent / 100);
    } catch (const Cancelled&) {
      return true;
    }
    return false;
  }
};

struct Triangles {
  const TriangleMesh& mesh;
  [[nodiscard]] size_t polygonCount() const { return mesh.triangles.size(); }
  [[nodiscard]] size_t pointCount() const { return mesh.positions.size(); }
  [[nodiscard]] size_t vertexCount(size_t) const { return 3; }
  void getIndexSpacePoint(size_t n, size_t v, openvdb::Vec3d& p) const {
    const Vec3d& q = mesh.positions[mesh.triangles[n][v]];
    p = {q.x(), q.y(), q.z()};
  }
};

/// Distances that grow from given voxels along their own side of the surface: label-correcting fast marching with
/// Godunov's first-order update. Value(v), write(v, distance), mayWrite(v, from): the field.
template <class Value, class Write, class MayWrite>
class March {
 public:
  March(Value value, Write write, MayWrite mayWrite) : value_(value), write_(write), mayWrite_(mayWrite) {}
  void seed(const VdbCoord& v, float distance) { queue_.push({distance, v}); }
  void run(float limit, Job* job) {
    for (size_t n = 0; !queue_.empty(); ++n) {
      if (job && n % 65536 == 0 && job->cancelled()) throw Cancelled();
      const auto [distance, v] = queue_.top();
      queue_.pop();
      if (distance > value_(v, v) + kMarchTolerance) continue;
      for (const VdbCoord& step : kSix) {
        const VdbCoord n6 = v + step;
        if (!mayWrite_(n6, v)) continue;
        const float better = solve(n6);
        if (better > limit || better > value_(n6, n6) - kMarchTolerance) continue;
        write_(n6, better);
        queue_.push({better, n6});
      }
    }
  }

 private:
  struct Entry {
    float distance;
    VdbCoord voxel;
    bool operator<(const Entry& o) const { return distance != o.distance ? distance > o.distance : voxel > o.voxel; }
  };
  float solve(const VdbCoord& v) {
    float a[3];
    for (int axis = 0; axis < 3; ++axis)
      a[axis] = std::min(value_(v + kSix[2 * axis], v), value_(v + kSix[2 * axis + 1], v));
    std::sort(a, a + 3);
    float u = a[0] + 1;
    if (u <= a[1]) return u;
    u = (a[0] + a[1] + std::sqrt(2 - (a[0] - a[1]) * (a[0] - a[1]))) / 2;
    if (u <= a[2]) return u;
    const float sum = a[0] + a[1] + a[2];
    const float square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    return (sum + std::sqrt(std::max(0.0f, sum * sum - 3 * (square - 1)))) / 3;
  }

  Value value_;
  Write write_;
  MayWrite mayWrite_;
  std::priority_queue<Entry> queue_;
};

class Builder {
 public:
  Builder(const RepairedMesh& repaired, float band, Job* job)
      : mesh_(repaired.mesh),
        bodies_(repaired.findings.bodies),
        band_(band),
        job_(job),
        indices_(openvdb::Int32Grid::create(-1)),
        winding_(repaired) {}

  SolidField build() {
    measure();
    step(0.5);
    wind();
    step(0.6);
    if (winding_.open()) close();
    step(0.75);
    dropFalse();
    step(0.9);
    return assemble();
  }

 private:
  void step(double fraction) {
    if (job_) job_->step(fraction);
  }

  void measure() {
    if (searchIsQuicker()) return search();
    Interrupter interrupter{job_, 0.05, 0.45};
    const auto unit = openvdb::math::Transform::createLinearTransform(1.0);
    const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter, Triangles{mesh_}, *unit, band_ + 1, 0.0f, openvdb::tools::UNSIGNED_DISTANCE_FIELD, indices_.get());
    step(0.45);  // a conversion that was interrupted must not be taken for a result
    distance_ = grid->treePtr();
    openvdb::tools::changeBackground(*distance_, kFar);
    for (int pass = 0; pass < kMostRefinements && refine(); ++pass) step(0.45);
  }

  /// Decides whether a search for the nearest triangle of each voxel costs less than going through the voxels along
  /// each triangle: for triangles that are long for their area, and for a great many small bodies.
  [[nodiscard]] bool searchIsQuicker() const {
    if (bodies_ > kManyBodies) return true;
    double length = 0, area = 0;
    for (const auto& t : mesh_.triangles) {
      const Vec3d ab = mesh_.positions[t[1]] - mesh_.positions[t[0]],
                  ac = mesh_.positions[t[2]] - mesh_.positions[t[0]];
      const double longest = std::sqrt(std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()}));
      length += std::max(0.0, longest - kShort);
      area += ab.cross(ac).norm() / 2;
    }
    return length > kThin * area;
  }

  /// Measures by a search from each voxel of the leaves that the band may reach: exact, and in the same time however
  /// many triangles pass a voxel.
  void search() {
    const NearestTriangle nearest(mesh_);
    const double reach = double(band_) + 1;
    Vec3d low = mesh_.positions[mesh_.triangles[0][0]], high = low;
    for (const auto& t : mesh_.triangles)
      for (const uint32_t v : t) low = low.cwiseMin(mesh_.positions[v]), high = high.cwiseMax(mesh_.positions[v]);
    constexpr int kBlock = 64, kLeaf = 8;
    const auto near = [&](const VdbCoord& from, int size) {
      const Vec3d middle = Vec3d(from.x(), from.y(), from.z()) + Vec3d::Constant((size - 1) / 2.0);
      return nearest.within(middle, reach + std::sqrt(3.0) * (size - 1) / 2);
    };
    const auto eighths = [](const VdbCoord& from, int size, const auto& visit) {
      const int half = size / 2;
      for (int k = 0; k < 8; ++k) visit(from.offsetBy((k & 1) * half, (k >> 1 & 1) * half, (k >> 2) * half));
    };
    // From one cube around all, halved down to blocks: a mesh may be long and lie along a diagonal.
    int size = kBlock;
    while (size < (high - low).maxCoeff() + 2 * reach + kBlock) size *= 2;
    const auto blockOf = [&](double at) { return int(std::floor((at - reach) / kBlock)) * kBlock; };
    std::vector<VdbCoord> blocks{VdbCoord(blockOf(low.x()), blockOf(low.y()), blockOf(low.z()))}, finer;
    for (; size > kBlock; size /= 2) {
      step(0.05);
      finer.clear();
      for (const VdbCoord& block : blocks)
        eighths(block, size, [&](const VdbCoord& part) {
          if (near(part, size / 2)) finer.push_back(part);
        });
      blocks.swap(finer);
    }
    const auto cancelled = [this] { return job_ && job_->cancelled(); };
    std::vector<std::vector<VdbCoord>> leavesOf(blocks.size());
    tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t b) {
      std::vector<std::pair<VdbCoord, int>> open{{blocks[b], kBlock}};
      while (!open.empty() && !cancelled()) {
        const auto [from, edge] = open.back();
        open.pop_back();
        if (!near(from, edge)) continue;
        if (edge == kLeaf) {
          leavesOf[b].push_back(from);
          continue;
        }
        eighths(from, edge, [&](const VdbCoord& part) { open.emplace_back(part, edge / 2); });
      }
    });
    step(0.1);
    distance_ = std::make_shared<FloatTree>(kFar);
    std::vector<Leaf*> leaves;
    std::vector<openvdb::Int32Tree::LeafNodeType*> indices;
    for (const auto& list : leavesOf) {
      for (const VdbCoord& from : list) {
        leaves.push_back(distance_->touchLeaf(from));
        indices.push_back(indices_->tree().touchLeaf(from));
      }
    }
    tbb::parallel_for(size_t{0}, leaves.size(), [&](size_t n) {
      if (cancelled()) return;
      uint32_t hint = UINT32_MAX;
      for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
        const VdbCoord v = leaves[n]->offsetToGlobalCoord(i);
        const auto hit = nearest.nearerThan(Vec3d(v.x(), v.y(), v.z()), reach, hint);
        if (hit.triangle == UINT32_MAX) continue;
        hint = hit.triangle;
        leaves[n]->setValueOn(i, float(std::sqrt(hit.squared)));
        indices[n]->setValueOn(i, int(nearest.indexOf(hit.triangle)));
      }
    });
    step(0.45);
  }

  [[nodiscard]] openvdb::Vec3d nearestPoint(const VdbCoord& v, int triangle) const {
    const auto& t = mesh_.triangles[size_t(triangle)];
    const auto vec = [&](uint32_t i) { return openvdb::Vec3d(mesh_.positions[i].data()); };
    openvdb::Vec3d weights;
    return openvdb::math::closestPointOnTriangleToPoint(vec(t[0]), vec(t[1]), vec(t[2]), v.asVec3d(), weights);
  }

  /// OpenVDB widens its band from voxel to voxel and misses the nearest triangle of about one outer voxel in a hundred,
  /// by up to 0.9 voxels. Tries the triangles of the six neighbours; true when one was nearer.
  bool refine() {
    struct Better {
      openvdb::Index at;
      float distance;
      int triangle;
    };
    Leaves leaves(*distance_);
    std::vector<std::vector<Better>> found(leaves.leafCount());
    leaves.foreach ([&](Leaf& leaf, size_t n) {
      if (job_ && job_->cancelled()) return;
      openvdb::tree::ValueAccessor<const openvdb::Int32Tree> index(indices_->tree());
      for (auto on = leaf.cbeginValueOn(); on; ++on) {
        const VdbCoord v = on.getCoord();
        int tried[7];
        int count = 0;
        Better better{on.pos(), *on, index.getValue(v)};
        // Its own too: the distance at hand is not always to the triangle at hand.
        for (const VdbCoord& step7 : kSelfAndSix) {
          const int triangle = index.getValue(v + step7);
          if (triangle < 0 || std::find(tried, tried + count, triangle) != tried + count) continue;
          tried[count++] = triangle;
          const auto d = float((nearestPoint(v, triangle) - v.asVec3d()).length());
          if (d < better.distance - kMarchTolerance) better.distance = d, better.triangle = triangle;
        }
        if (better.distance < *on) found[n].push_back(better);
      }
    });
    if (std::all_of(found.begin(), found.end(), [](const auto& leaf) { return leaf.empty(); })) return false;
    leaves.foreach ([&](Leaf& leaf, size_t n) {
      auto* index = indices_->tree().probeLeaf(leaf.origin());
      for (const Better& b : found[n]) {
        leaf.setValueOnly(b.at, b.distance);
        index->setValueOnly(b.at, b.triangle);
      }
    });
    return true;
  }

  /// Winding numbers of all voxels of the band.
  void wind() {
    signs_ = std::make_shared<FloatTree>(*distance_, 0.0f, openvdb::TopologyCopy());
    Leaves leaves(*signs_);
    leaves.foreach ([&](Leaf& leaf, size_t) {
      if (job_ && job_->cancelled()) return;
      float* w = leaf.buffer().data();
      const VdbCoord o = leaf.origin();
      if (winding_.mostlyRims() && leaf.onVoxelCount() > kManyOfLeaf) {
        std::array<float, Leaf::SIZE> all;
        winding_.fill({o.x(), o.y(), o.z()}, all);
        for (auto on = leaf.cbeginValueOn(); on; ++on) w[on.pos()] = all[on.pos()];
        return;
      }
      for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
          const auto column = winding_.column(o.x() + x, o.y() + y);
          for (int z = 0; z < 8; ++z) {
            const int at = Brick::offset(x, y, z);
            if (leaf.isValueOn(openvdb::Index(at))) w[at] = winding_.at(column, {o.x() + x, o.y() + y, o.z() + z});
          }
        }
      }
    });
  }

  [[nodiscard]] static bool crosses(float a, float b) { return isInside(a) != isInside(b); }

  /// Whether the surface that closes holes, not a triangle, passes between two neighbours of different sides: no
  /// triangle is near enough, or their winding numbers differ by less than the step of one across a triangle leaves
  /// beside a rim.
  [[nodiscard]] static bool closes(float wa, float wb, float da, float db) {
    return da + db > kExplained || std::abs(wa - wb) < kHalfStep;
  }

  /// Follows the level 1/2 of the winding number where no triangle is, from the band outwards, and measures from it.
  void close() {
    struct Hash {
      size_t operator()(const VdbCoord& c) const { return c.hash<20>(); }
    };
    std::unordered_set<VdbCoord, Hash> seenCells, seenEdges[3];
    std::vector<VdbCoord> cells;
    FloatTree seeds(kFar);
    openvdb::tree::ValueAccessor<FloatTree> sign(*signs_), seed(seeds);
    openvdb::tree::ValueAccessor<const FloatTree> distance(*distance_);
    constexpr int kUnit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto unit = [&](int axis) { return VdbCoord(kUnit[axis][0], kUnit[axis][1], kUnit[axis][2]); };

    // Both ends must have their winding numbers. Queues the four cells around an edge that closes a hole.
    const auto visitEdge = [&](const VdbCoord& a, int axis) {
      const VdbCoord b = a + unit(axis);
      const float wa = sign.getValue(a), wb = sign.getValue(b);
      if (!crosses(wa, wb) || !closes(wa, wb, distance.getValue(a), distance.getValue(b))) return;
      if (!seenEdges[axis].insert(a).second) return;
      const VdbCoord u = unit((axis + 1) % 3), v = unit((axis + 2) % 3);
      for (const VdbCoord& cell : {a, a - u, a - v, a - u - v}) {
        if (seenCells.insert(cell).second) cells.push_back(cell);
      }
    };
    for (auto leaf = signs_->cbeginLeaf(); leaf; ++leaf) {
      for (auto on = leaf->cbeginValueOn(); on; ++on) {
        const VdbCoord a = on.getCoord();
        for (int axis = 0; axis < 3; ++axis) {
          const VdbCoord b = a + unit(axis);
          if (crosses(*on, sign.getValue(b)) && sign.isValueOn(b)) visitEdge(a, axis);
        }
      }
    }
    while (!cells.empty()) {
      step(0.6);
      std::vector<VdbCoord> unknown;
      for (const VdbCoord& cell : cells) {
        for (int k = 0; k < 8; ++k) {
          const VdbCoord v = cell.offsetBy(k & 1, (k >> 1) & 1, k >> 2);
          if (sign.isValueOn(v)) continue;
          sign.setValue(v, 0);
          unknown.push_back(v);
        }
      }
      std::vector<float> found(unknown.size());
      tbb::parallel_for(size_t{0}, unknown.size(), [&](size_t i) {
        found[i] = winding_.at({unknown[i].x(), unknown[i].y(), unknown[i].z()});
      });
      for (size_t i = 0; i < unknown.size(); ++i) sign.setValue(unknown[i], found[i]);
      const std::vector<VdbCoord> now = std::move(cells);
      cells.clear();
      for (const VdbCoord& cell : now) {
        for (int axis = 0; axis < 3; ++axis) {
          const VdbCoord u = unit((axis + 1) % 3), v = unit((axis + 2) % 3);
          for (const VdbCoord& a : {cell, cell + u, cell + v, cell + u + v}) visitEdge(a, axis);
        }
      }
    }

    // A plane that cuts the three axes at t has the distance 1 / sqrt(Σ 1/t²); the cuts are where the winding number,
    // linear between two voxels, is a half.
    std::vector<VdbCoord> starts;
    const auto cut = [&](const VdbCoord& a, const VdbCoord& step6) {
      const float wa = sign.getValue(a), wb = sign.getValue(a + step6);
      return std::clamp((0.5f - wa) / (wb - wa), kLeast, 1.0f);
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (const VdbCoord& a : seenEdges[axis]) {
        for (const VdbCoord& v : {a, a + unit(axis)}) {
          if (seed.isValueOn(v)) continue;
          float sum = 0;
          for (int k = 0; k < 3; ++k) {
            float t = kFar;
            if (seenEdges[k].contains(v)) t = std::min(t, cut(v, unit(k)));
            if (seenEdges[k].contains(v - unit(k))) t = std::min(t, cut(v, VdbCoord() - unit(k)));
            sum += 1 / (t * t);
          }
          seed.setValue(v, std::max(kLeast, 1 / std::sqrt(sum)));
          starts.push_back(v);
        }
      }
    }
    closingEdges_ = seenEdges[0].size() + seenEdges[1].size() + seenEdges[2].size();
    for (int axis = 0; axis < 3; ++axis) {
      const auto seen = [&](const VdbCoord& a, int along) { return seenEdges[along].contains(a); };
      for (const VdbCoord& a : seenEdges[axis]) closedArea_ += areaAt(a, axis, double(cut(a, unit(axis))), sign, seen);
    }

    // Voxels that were never looked at lie on the side of the voxel from which the march comes: every edge through the
    // closing surface was visited.
    const auto sameSide = [&](const VdbCoord& n, const VdbCoord& v) {
      return !sign.isValueOn(n) || !crosses(sign.getValue(n), sign.getValue(v));
    };
    const auto value = [&](const VdbCoord& n, const VdbCoord& v) { return sameSide(n, v) ? seed.getValue(n) : kFar; };
    const auto write = [&](const VdbCoord& v, float d) { seed.setValue(v, d); };
    const auto mayWrite = [&](const VdbCoord& n, const VdbCoord& from) {
      if (!sameSide(n, from)) return false;
      if (!sign.isValueOn(n)) sign.setValue(n, sign.getValue(from));
      return true;
    };
    March march(value, write, mayWrite);
    for (const VdbCoord& v : starts) march.seed(v, seed.getValue(v));
    march.run(band_ + 1, job_);
    closing_ = std::make_shared<FloatTree>(seeds);
  }

  /// Area in voxels² of the closing surface for which the edge from `a` along `axis` stands, where it cuts the edge at
  /// `t`. All edges of one axis cut a surface once for each voxel² of its shadow along that axis, so the cosine between
  /// axis and normal, summed over the edges of all three axes, is the area. Beside the rim of a hole an edge stands for
  /// what reaches from halfway to the one before up to the nearest triangle.
  template <class Seen>
  [[nodiscard]] double areaAt(const VdbCoord& a, int axis, double t, openvdb::tree::ValueAccessor<FloatTree>& sign,
                              const Seen& seen) const {
    constexpr double kOnRim = 1e-3, kBesideRim = 1.5;  // voxels
    const auto unit = [](int along) { return VdbCoord(along == 0, along == 1, along == 2); };
    const VdbCoord b = a + unit(axis);
    // The winding number is smooth but for steps of one across triangles.
    const auto change = [&](const VdbCoord& from, const VdbCoord& to) {
      const float by = sign.getValue(to) - sign.getValue(from);
      return double(by - std::round(by));
    };
    const Vec3d p = Vec3d(a.x(), a.y(), a.z()) + t * Vec3d::Unit(axis);
    Vec3d rim = Vec3d::Constant(HUGE_VAL);  // from the cut to the nearest triangle
    for (const VdbCoord& end : {a, b}) {
      const int triangle = indices_->tree().getValue(end);
      if (triangle < 0) continue;
      const auto& [i, j, k] = mesh_.triangles[size_t(triangle)];
      const Vec3d to = nearestOnTriangle(p, mesh_.positions[i], mesh_.positions[j], mesh_.positions[k]) - p;
      if (to.squaredNorm() < rim.squaredNorm()) rim = to;
    }
    const auto gradientAt = [&](const VdbCoord& from) {
      const VdbCoord to = from + unit(axis);
      Vec3d gradient;
      gradient[axis] = change(from, to);
      for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
        const VdbCoord u = unit(other);
        gradient[other] =
            (change(from - u, from) + change(from, from + u) + change(to - u, to) + change(to, to + u)) / 4;
      }
      return gradient;
    };
    // Towards a rim the winding number changes fast and without bounds: two voxels before it is told how the surface
    // lies.
    Vec3d gradient = gradientAt(a);
    const double squared = rim.squaredNorm();
    if (squared > 0 && squared < kBesideRim * kBesideRim) {
      const Vec3d before = p - 2 * rim / std::sqrt(squared);
      for (const double along : {0.0, -1.0, 1.0}) {
        VdbCoord near;
        for (int k = 0; k < 3; ++k) near[k] = int(k == axis ? std::floor(before[k] + along) : std::round(before[k]));
        if (!seen(near, axis)) continue;
        gradient = gradientAt(near);
        break;
      }
    }
    if (gradient[axis] == 0 || squared < kOnRim * kOnRim) return 0;
    double share = 1, all = 0;
    std::array<double, 2> along{};  // of the way to the rim, in voxels of the surface along the other axes
    for (const size_t k : {0u, 1u}) {
      const int other = (axis + 1 + int(k)) % 3;
      along[k] = rim[other] - gradient[other] / gradient[axis] * rim[axis];
      all += along[k] * along[k];
    }
    if (std::isfinite(squared))
      for (const double each : along) {
        const double away = squared / std::abs(each);  // voxels up to the rim
        if (away < 1 + kOnRim) share += each * each / all * (std::min(1.0, away) - 0.5);
      }
    return std::max(0.0, share) * std::abs(gradient[axis]) / gradient.norm();
  }

  /// Takes away distances to triangles that do not bound the inside (inner walls of overlapping bodies, fins, walls
  /// that no voxel is behind) and puts distances to what does in their place.
  void dropFalse() {
    const openvdb::Int32Tree& indices = indices_->tree();
    std::vector<std::vector<VdbCoord>> dropped;
    {
      Leaves leaves(*distance_);
      dropped.resize(leaves.leafCount());
      leaves.foreach ([&](Leaf& leaf, size_t n) {
        if (job_ && job_->cancelled()) return;
        openvdb::tree::ValueAccessor<const FloatTree> sign(*signs_);
        openvdb::tree::ValueAccessor<const openvdb::Int32Tree> index(indices);
        for (auto on = leaf.cbeginValueOn(); on; ++on) {
          if (!bounds(on.getCoord(), *on, index.getValue(on.getCoord()), sign)) dropped[n].push_back(on.getCoord());
        }
      });
    }
    openvdb::MaskTree mask;
    {
      openvdb::tree::ValueAccessor<openvdb::MaskTree> maskAt(mask);
      for (const auto& leaf : dropped) {
        for (const VdbCoord& v : leaf) {
          maskAt.setValueOn(v);
          droppedVoxels_ += !closing_ || !closing_->isValueOn(v);
        }
      }
    }
    if (mask.empty()) return;

    openvdb::tree::ValueAccessor<FloatTree> distance(*distance_);
    openvdb::tree::ValueAccessor<const FloatTree> sign(*signs_);
    openvdb::tree::ValueAccessor<const openvdb::MaskTree> isMasked(mask);
    const auto sameSide = [&](const VdbCoord& n, const VdbCoord& v) {
      return sign.isValueOn(n) && !crosses(sign.getValue(n), sign.getValue(v));
    };
    const auto value = [&](const VdbCoord& n, const VdbCoord& v) {
      return sameSide(n, v) ? distance.getValue(n) : kFar;
    };
    const auto write = [&](const VdbCoord& v, float d) { distance.setValue(v, d); };
    const auto mayWrite = [&](const VdbCoord& n, const VdbCoord& from) {
      return isMasked.isValueOn(n) && sameSide(n, from);
    };
    March march(value, write, mayWrite);
    // Beside the surface: what the other side leaves of the voxel between them, or where the winding number is a half.
    // Edges through the closing surface are measured already.
    std::vector<std::pair<VdbCoord, float>> beside;
    for (const auto& leaf : dropped) {
      for (const VdbCoord& v : leaf) {
        float best = kFar;
        for (const VdbCoord& s : kSix) {
          const VdbCoord n = v + s;
          const float other = distance.getValue(n);
          if (sign.isValueOn(n) && crosses(sign.getValue(n), sign.getValue(v))) {
            const float w = sign.getValue(v);
            if (closes(w, sign.getValue(n), distance.getValue(v), other)) continue;
            best = std::min(best, isMasked.isValueOn(n) ? (0.5f - w) / (sign.getValue(n) - w) : 1 - other);
          } else if (distance.isValueOn(n) && !isMasked.isValueOn(n)) {
            march.seed(n, other);
          }
        }
        if (best < kFar) beside.emplace_back(v, std::clamp(best, kLeast, 1.0f));
      }
    }
    for (const auto& leaf : dropped) {
      for (const VdbCoord& v : leaf) distance.setValue(v, kFar);
    }
    for (const auto& [v, d] : beside) {
      distance.setValue(v, d);
      march.seed(v, d);
    }
    march.run(band_ + 1, job_);
  }

  /// Whether all around a voxel that lies on a triangle with this normal is inside: an inner wall of bodies that
  /// overlap, in a plane of voxels as walls of parts often are. Nearly always the voxels before and behind it tell;
  /// where they do not (beside an edge of such a wall, or in a slit of less than a voxel), the winding number itself.
  [[nodiscard]] bool liesWithin(const VdbCoord& v, const Vec3d& normal,
                                openvdb::tree::ValueAccessor<const FloatTree>& sign) const {
    Vec3d::Index axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    VdbCoord step(0, 0, 0);
    step[int(axis)] = 1;
    float before = 0, behind = 0;
    if (!sign.probeValue(v + step, before) || !sign.probeValue(v - step, behind)) return false;
    if (!isInside(before) || !isInside(behind)) return false;
    std::call_once(exactOnce_, [&] { exact_.emplace(mesh_); });
    constexpr double kBeside = 0.01;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d off(corner & 1 ? kBeside : -kBeside, corner & 2 ? kBeside : -kBeside,
                      corner & 4 ? kBeside : -kBeside);
      if (!isInside(float(exact_->at(Vec3d(v.x(), v.y(), v.z()) + off)))) return false;
    }
    return true;
  }

  /// Whether the nearest point of triangle `index` to voxel v lies on the boundary of the inside.
  [[nodiscard]] bool bounds(const VdbCoord& v, float d, int index,
                            openvdb::tree::ValueAccessor<const FloatTree>& sign) const {
    if (index < 0) return true;
    const float w = sign.getValue(v);
    const auto& t = mesh_.triangles[size_t(index)];
    const openvdb::Vec3d p = v.asVec3d(), q = nearestPoint(v, index);

    // Across a triangle the winding number grows by one from its outer to its inner side.
    const Vec3d normal =
        (mesh_.positions[t[1]] - mesh_.positions[t[0]]).cross(mesh_.positions[t[2]] - mesh_.positions[t[0]]);
    const double length = normal.norm();
    if (d > kLeast && length > 0) {
      const double side = (p - q).dot(openvdb::Vec3d(normal.data())) / (d * length);
      if (side > kClearSide && !crosses(w, w + 1)) return false;
      if (side < -kClearSide && !crosses(w, w - 1)) return false;
    }
    if (d <= kLeast && length > 0 && liesWithin(v, normal, sign)) return false;
    // Somewhere in the voxels around the point the sign must change: first in its own cell, then one around it, because
    // an edge or a tip may reach up to a voxel past the last voxel inside.
    const VdbCoord cell = VdbCoord::floor(q);
    const bool in = isInside(w);
    for (const auto& [from, to] : {std::pair{0, 1}, std::pair{-1, 2}}) {
      for (int x = from; x <= to; ++x) {
        for (int y = from; y <= to; ++y) {
          for (int z = from; z <= to; ++z) {
            const VdbCoord n = cell.offsetBy(x, y, z);
            float wn;
            if (sign.probeValue(n, wn) && isInside(wn) != in) return true;
          }
        }
      }
    }
    return false;
  }

  SolidField assemble() {
    auto grid = openvdb::FloatGrid::create(band_);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    auto tree = std::make_shared<FloatTree>(*distance_, band_, openvdb::TopologyCopy());
    if (closing_) tree->topologyUnion(*closing_);
    tbb::enumerable_thread_specific<uint64_t> inside(0);
    {
      Leaves leaves(*tree);
      leaves.foreach ([&](Leaf& leaf, size_t) {
        const Leaf* measured = distance_->probeConstLeaf(leaf.origin());
        const Leaf* closing = closing_ ? closing_->probeConstLeaf(leaf.origin()) : nullptr;
        const Leaf* sign = signs_->probeConstLeaf(leaf.origin());
        float* phi = leaf.buffer().data();
        for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
          if (!leaf.isValueOn(i)) continue;
          float d = measured && measured->isValueOn(i) ? measured->getValue(i) : kFar;
          if (closing && closing->isValueOn(i)) d = std::min(d, closing->getValue(i));
          const bool in = isInside(sign->getValue(i)) && d > 0;
          inside.local() += in;
          phi[i] = in ? -std::min(d, band_) : std::min(d, band_);
          if (d >= band_) leaf.setValueOff(i);
        }
      });
    }
    SolidField result;
    for (const uint64_t n : inside) result.insideVoxels += n;
    result.bandVoxels = tree->activeVoxelCount();
    openvdb::tools::pruneInactive(*tree);
    openvdb::tools::signedFloodFill(*tree);
    grid->setTree(tree);
    result.grid = {grid};
    result.closingEdges = closingEdges_;
    result.closedArea = closedArea_;
    result.droppedVoxels = droppedVoxels_;
    return result;
  }

  const TriangleMesh& mesh_;
  const uint64_t bodies_;
  float band_;
  Job* job_;
  FloatTree::Ptr distance_, signs_, closing_;  // unsigned distance; winding numbers; distance to the closing surface
  openvdb::Int32Grid::Ptr indices_;            // nearest triangle
  VoxelWinding winding_;
  mutable std::once_flag exactOnce_;
  mutable std::optional<WindingNumber> exact_;  // where voxels do not tell
  uint64_t closingEdges_ = 0, droppedVoxels_ = 0;
  double closedArea_ = 0;  // voxels²
};

}  // namespace

SolidField solidField(const RepairedMesh& repaired, float band, Job* job) {
  initializeVdb();
  return Builder(repaired, band, job).build();
}

}  // namespace argil::clay
