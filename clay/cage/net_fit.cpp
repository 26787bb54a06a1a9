#include "clay/cage/net_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCore>

#include "clay/base/parallel.h"
#include "clay/cage/patch_deviation.h"

namespace argil::clay {

namespace {

// How much the net is held straight, and how much a place is held where it is along the surface, stage by stage.
struct Stage {
  double stiff, along;
};
constexpr Stage kLeading[] = {{0.3, 1}, {0.05, 0.3}}, kLast[] = {{0.01, 0.02}, {0.001, 0.02}};
constexpr double kFar = 2e-4;                      // of the clay's size: what lies off by more counts more,
constexpr double kMostFar = 60;                    // by its distance, up to so many times
constexpr double kLeastHeld = 0.5, kMostHeld = 8;  // shares of stiffness, by the length of edges
constexpr double kFacing = 0.4;                    // cosine between a patch beside a crease and what draws it
constexpr double kGap = 0.02;                      // of the clay's size: so far from its creases one is not drawn
constexpr double kOnLines = 4, kAtEnds = 8;        // what places of creases and their ends count
constexpr int kFoldSpan = 4;                       // places along a span where patches are looked at for folds
constexpr double kMoreEven = 4, kMostEven = 1e5;   // the net is held so many times more there after each look
constexpr size_t kUnfolded = 10;                   // folds are left at one of so many places, or it is not worth it
constexpr int kEvenRounds = 2;                     // between two looks,
constexpr int kFutile = 4;                         // of which so many may find no fewer folds
constexpr int kFootSpan = 2;                       // places along a span that the clay's nearest is looked for among
constexpr int kSteps = 25;                         // of conjugate gradients a round
constexpr double kSolved = 1e-6;                   // of the squared residual
constexpr int kBlock = 256, kRowBlock = 1024;

using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Table = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Vec3d nearestOn(const TriangleMesh& mesh, const NearestTriangle& tree, const Vec3d& p, uint32_t& hint) {
  const NearestTriangle::Hit hit = tree.nearest(p, hint);
  hint = hit.triangle;
  const auto& c = tree.corners(hit.triangle);
  return nearestOnTriangle(p, mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]);
}

// The net's vertices in place, between the corners of their quads.
Table straightNet(const PatchNet& net, const QuadMesh& cage) {
  Table at(Eigen::Index(net.vertexCount()), 3);
  for (uint32_t f = 0; f < cage.quads.size(); ++f)
    for (int i = 0; i <= kPatchSpans; ++i)
      for (int j = 0; j <= kPatchSpans; ++j) {
        const double u = double(i) / kPatchSpans, v = double(j) / kPatchSpans;
        const auto& quad = cage.quads[f];
        at.row(net.vertex(f, i, j)) =
            ((1 - u) * (1 - v) * cage.positions[quad[0]] + u * (1 - v) * cage.positions[quad[1]] +
             u * v * cage.positions[quad[2]] + (1 - u) * v * cage.positions[quad[3]])
                .transpose();
      }
  return at;
}

// Rows of fitted places.
Rows placesOf(const PatchNet& net, size_t quads, int perSide) {
  std::vector<Eigen::Triplet<double>> entries;
  int row = 0;
  for (uint32_t f = 0; f < quads; ++f)
    for (int i = 0; i < perSide; ++i)
      for (int j = 0; j < perSide; ++j, ++row)
        for (const auto& [vertex, weight] :
             net.at(f, (i + 0.5) * kPatchSpans / perSide, (j + 0.5) * kPatchSpans / perSide))
          entries.emplace_back(row, int(vertex), weight);
  Rows places(row, Eigen::Index(net.vertexCount()));
  places.setFromTriplets(entries.begin(), entries.end());
  return places;
}

// Net vertices beside each other on a crease.
std::vector<std::array<uint32_t, 2>> creasePieces(const PatchNet& net, const QuadTopology& topology) {
  std::vector<std::array<uint32_t, 2>> pieces;
  for (const QuadTopology::Edge& edge : topology.edges())
    for (int i = 0; edge.crease && i < kPatchSpans; ++i) {
      const auto [x, y] = fromCorner(edge.side[0], i, 0, kPatchSpans + 1);
      const auto [u, v] = fromCorner(edge.side[0], i + 1, 0, kPatchSpans + 1);
      pieces.push_back({net.vertex(edge.quad[0], x, y), net.vertex(edge.quad[0], u, v)});
    }
  return pieces;
}

// Rows of places along the cage's creases, each twice, and then of where these end, three times each.
Rows creasePlaces(const PatchNet& net, const QuadTopology& topology, const std::vector<uint32_t>& ends, int perSide) {
  std::vector<Eigen::Triplet<double>> entries;
  int row = 0;
  const auto add = [&](const Weights& weights, int times) {
    for (; times > 0; --times, ++row)
      for (const auto& [vertex, weight] : weights) entries.emplace_back(row, int(vertex), weight);
  };
  for (const QuadTopology::Edge& edge : topology.edges())
    for (int i = 0; edge.crease && i < perSide; ++i) {
      const double t = (i + 0.5) * kPatchSpans / perSide, whole = kPatchSpans;
      const std::array<std::array<double, 2>, 4> at{{{t, 0}, {whole, t}, {whole - t, whole}, {0, whole - t}}};
      const auto& [u, v] = at[edge.side[0]];
      add(net.at(edge.quad[0], u, v), 2);
    }
  for (const uint32_t v : ends) add(net.points()[v], 3);
  Rows places(row, Eigen::Index(net.vertexCount()));
  places.setFromTriplets(entries.begin(), entries.end());
  return places;
}

// How far each vertex of the net lies from the mean of those beside it, where edges are shorter than most multiplied by
// as much.
// On a crease those are the two along it; its ends are free.
Rows bendsOf(const PatchNet& net, const QuadTopology& topology, const Table& at) {
  const std::vector<std::array<uint32_t, 2>> pieces = creasePieces(net, topology);
  std::vector<uint8_t> alongCrease(net.vertexCount(), 0);
  for (const auto& piece : pieces)
    for (const uint32_t v : piece) ++alongCrease[v];
  const auto count = Eigen::Index(net.vertexCount());
  std::vector<Eigen::Triplet<double>> entries;
  for (uint32_t f = 0; f < topology.quads().size(); ++f)
    for (int i = 0; i < kPatchSpans; ++i)
      for (int j = 0; j < kPatchSpans; ++j) {
        const std::array<uint32_t, 4> c{net.vertex(f, i, j), net.vertex(f, i + 1, j), net.vertex(f, i + 1, j + 1),
                                        net.vertex(f, i, j + 1)};
        for (size_t s = 0; s < 4; ++s)
          if (alongCrease[c[s]] == 0) entries.emplace_back(int(c[s]), int(c[(s + 1) & 3]), 1.0);
      }
  for (const auto& [a, b] : pieces) {
    if (alongCrease[a] == 2) entries.emplace_back(int(a), int(b), 1.0);
    if (alongCrease[b] == 2) entries.emplace_back(int(b), int(a), 1.0);
  }
  Rows beside(count, count);
  beside.setFromTriplets(entries.begin(), entries.end());  // each edge once either way, as every side has a partner
  Rows bends(count, count);
  entries.clear();
  Eigen::VectorXd length = Eigen::VectorXd::Zero(count), degree = Eigen::VectorXd::Zero(count);
  for (Eigen::Index v = 0; v < count; ++v)
    for (Rows::InnerIterator it(beside, v); it; ++it) {
      length[v] += it.value() * (at.row(v) - at.row(it.col())).norm();
      degree[v] += it.value();
    }
  const double mean = length.sum() / degree.sum();
  for (Eigen::Index v = 0; v < count; ++v) {
    if (degree[v] == 0) continue;
    const double own = length[v] / degree[v];
    const double share = std::clamp(own > 0 ? mean / own : kMostHeld, kLeastHeld, kMostHeld);
    for (Rows::InnerIterator it(beside, v); it; ++it)
      entries.emplace_back(int(v), int(it.col()), -share * it.value() / degree[v]);
    entries.emplace_back(int(v), int(v), share);
  }
  bends.setFromTriplets(entries.begin(), entries.end());
  return bends;
}

PatchSurface surfaceOf(const PatchNet& net, const QuadMesh& cage, const Table& at) {
  PatchSurface surface;
  surface.cage = cage;
  surface.patches = net.patches();
  surface.points.reserve(net.points().size());
  for (const Weights& weights : net.points()) {
    Vec3d sum = Vec3d::Zero();
    for (const auto& [vertex, weight] : weights) sum += weight * at.row(vertex).transpose();
    surface.points.push_back(sum);
  }
  for (uint32_t f = 0; f < cage.quads.size(); ++f)
    for (size_t s = 0; s < 4; ++s) surface.cage.positions[cage.quads[f][s]] = surface.points[cage.quads[f][s]];
  return surface;
}

// Rows of the places of the patches that are nearest to `points`, by a mesh of the patches as they are; empty ones
// where what is nearest faces the other way.
Rows placesNearest(const PatchNet& net, const PatchSurface& surface, const std::vector<Vec3d>& points,
                   const std::vector<Vec3d>& normals, const std::vector<double>& leastFacing, int threads) {
  const TriangleMesh mesh = meshOf(surface, kFootSpan);
  const NearestTriangle tree(mesh);
  // Triangles of a patch lie together, two a cell of its grid.
  constexpr int kCells = kPatchSpans * kFootSpan;
  std::vector<Weights> rows(points.size());
  parallelBlocks(
      points.size(), threads,
      [&](size_t begin, size_t end) {
        uint32_t hint = UINT32_MAX;
        for (size_t i = begin; i < end; ++i) {
          const NearestTriangle::Hit hit = tree.nearest(points[i], hint);
          hint = hit.triangle;
          const uint32_t index = tree.indexOf(hit.triangle);
          const auto& t = mesh.triangles[index];
          const Vec3d &a = mesh.positions[t[0]], ab = mesh.positions[t[1]] - a, ac = mesh.positions[t[2]] - a;
          const Vec3d foot = nearestOnTriangle(points[i], a, mesh.positions[t[1]], mesh.positions[t[2]]) - a;
          // foot = s ab + r ac
          const double bb = ab.dot(ab), bc = ab.dot(ac), cc = ac.dot(ac), det = bb * cc - bc * bc;
          const double fb = foot.dot(ab), fc = foot.dot(ac);
          const double s = det > 0 ? std::clamp((cc * fb - bc * fc) / det, 0.0, 1.0) : 0,
                       r = det > 0 ? std::clamp((bb * fc - bc * fb) / det, 0.0, 1.0) : 0;
          const uint32_t cell = index / 2 % (kCells * kCells);
          // The first triangle has the corners (0, 0), (1, 0), (1, 1) of its cell, the second (0, 0), (1, 1), (0, 1).
          const double u = cell / kCells + (index % 2 == 0 ? s + r : s),
                       v = cell % kCells + (index % 2 == 0 ? r : s + r);
          const uint32_t patch = index / (2 * kCells * kCells);
          const double along = std::min(u, double(kCells)) / kFootSpan,
                       across = std::min(v, double(kCells)) / kFootSpan;
          const PatchSurface::Tangents tangents = surface.tangentsAt(patch, along, across);
          const Vec3d facing = tangents.u.cross(tangents.v);
          if (facing.dot(normals[i]) >= leastFacing[patch] * facing.norm()) rows[i] = net.at(patch, along, across);
        }
      },
      kBlock);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t i = 0; i < rows.size(); ++i)
    for (const auto& [vertex, weight] : rows[i]) entries.emplace_back(int(i), int(vertex), weight);
  Rows places(Eigen::Index(points.size()), Eigen::Index(net.vertexCount()));
  places.setFromTriplets(entries.begin(), entries.end());
  return places;
}

void multiply(const Rows& rows, const Table& by, Table& out, int threads) {
  out.resize(rows.rows(), 3);
  parallelBlocks(
      size_t(rows.rows()), threads,
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
          for (Rows::InnerIterator it(rows, Eigen::Index(i)); it; ++it) sum += it.value() * by.row(it.col());
          out.row(Eigen::Index(i)) = sum;
        }
      },
      kRowBlock);
}

Vec3d areaOfTriangle(const TriangleMesh& mesh, const std::array<uint32_t, 3>& t) {
  return (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
}

// Where a place should lie: on a plane, and by `along` near a place of it.
struct Target {
  Vec3d at = Vec3d::Zero(), normal = Vec3d::UnitZ();
  double weight = 0;
};

// Rows and what they should give.
class Pull {
 public:
  void set(Rows rows) {
    rows_ = std::move(rows);
    turned_ = rows_.transpose();
    targets.resize(size_t(rows_.rows()));
  }
  std::vector<Target> targets;
  [[nodiscard]] const Rows& rows() const { return rows_; }

  // Adds the pull of x to `out`; of what x misses its targets by where `missed`.
  void add(const Table& x, bool missed, double along, Table& out, int threads) {
    multiply(rows_, x, there_, threads);
    for (size_t i = 0; i < targets.size(); ++i) {
      const Target& to = targets[i];
      Vec3d off = there_.row(Eigen::Index(i)).transpose();
      if (missed) off -= to.at;
      there_.row(Eigen::Index(i)) =
          (to.weight * (along * off + (1 - along) * off.dot(to.normal) * to.normal)).transpose();
    }
    multiply(turned_, there_, back_, threads);
    out += back_;
  }
  void addDiagonal(double along, Eigen::VectorXd& out) const {
    for (Eigen::Index i = 0; i < rows_.rows(); ++i)
      for (Rows::InnerIterator it(rows_, i); it; ++it)
        out[it.col()] += targets[size_t(i)].weight * (1 + 2 * along) / 3 * it.value() * it.value();
  }

 private:
  Rows rows_, turned_;
  Table there_, back_;
};

double weightOf(double off, double far) {
  return std::clamp(off / far, 1.0, kMostFar);
}

// What the rounds of a fit share.
class NetFit {
 public:
  NetFit(const QuadMesh& cage, const TriangleMesh& clay, const NearestTriangle& tree, const CreaseMap& creases,
         int threads)
      : cage_(cage),
        clay_(clay),
        tree_(tree),
        creases_(creases),
        threads_(threads),
        topology_(cage),
        net_(topology_, cage),
        at_(straightNet(net_, cage)),
        bends_(bendsOf(net_, topology_, at_)),
        turnedBends_(bends_.transpose()),
        leastFacing_(cage.quads.size(), 0),
        normals_(clay.positions.size(), Vec3d::Zero()) {
    // Quads that a crease touches: what lies beyond it is another face.
    for (size_t f = 0; f < cage.quads.size(); ++f)
      for (const uint32_t v : cage.quads[f])
        if (topology_.creasesAt(v) != 0) leastFacing_[f] = kFacing;
    for (const auto& t : clay.triangles)
      for (const uint32_t v : t) normals_[v] += areaOfTriangle(clay, t);
    Eigen::AlignedBox3d box;
    for (const Vec3d& each : clay.positions) box.extend(each);
    far_ = kFar * box.sizes().maxCoeff();
    mostOff_ = kGap * box.sizes().maxCoeff();
  }

  template <size_t Count>
  void improve(const Stage (&stages)[Count], int rounds, int perSide, const WorkPart& part) {
    choosePlaces(perSide);
    const double share = double(forth_.targets.size() + points_.size()) / double(net_.vertexCount());
    int done = 0;
    for (const Stage& stage : stages)
      for (int round = 0; round < rounds; ++round) {
        lookForTargets();
        solve(stage.stiff * share, stage.along);
        part.step(double(++done) / double(rounds * int(Count)));
      }
  }
  // Where patches fold the net is evened out along the surface, more from time to time. The net that folds least stays,
  // or the first one where none folds at a tenth of the places: evened out it lies farther off.
  void unfold(const Stage& stage, int times, const WorkPart& part) {
    const double share = double(forth_.targets.size() + points_.size()) / double(net_.vertexCount());
    Table first = at_, best;
    size_t least = SIZE_MAX, before = 0;
    for (int done = 0, futile = 0;; ++done) {
      const PatchSurface now = surface();
      const TriangleMesh mesh = meshOf(now, kFoldSpan);
      const std::vector<uint32_t> folds = foldsOf(now, mesh, kFoldSpan);
      if (done == 0) before = folds.size();
      if (folds.size() < least) {
        best = at_;
        least = folds.size();
        futile = 0;
      } else {
        ++futile;
      }
      if (folds.empty() || done == times || futile == kFutile) break;
      evenMoreAt(folds, mesh);
      for (int round = 0; round < kEvenRounds; ++round) {
        lookForTargets();
        lookForFacing();
        solve(stage.stiff * share, stage.along);
      }
      part.step(double(done + 1) / times);
    }
    at_ = kUnfolded * least <= before ? std::move(best) : std::move(first);
  }
  [[nodiscard]] PatchSurface surface() const { return surfaceOf(net_, cage_, at_); }

 private:
  // What patches that fold consist of is held kMoreEven times as much as before, patches around them by its root.
  void evenMoreAt(const std::vector<uint32_t>& folds, const TriangleMesh& mesh) {
    constexpr size_t kPerPatch = size_t{2} * kPatchSpans * kFoldSpan * kPatchSpans * kFoldSpan;  // triangles
    std::vector<uint8_t> folded(mesh.positions.size(), 0), folding(cage_.quads.size(), 0);
    for (const uint32_t place : folds) folded[place] = 1;
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const uint32_t place : mesh.triangles[t]) folding[t / kPerPatch] |= folded[place];
    std::vector<uint8_t> beside(cage_.positions.size(), 0);
    for (size_t f = 0; f < folding.size(); ++f)
      for (const uint32_t v : cage_.quads[f]) beside[v] |= folding[f];
    std::vector<double> more(net_.vertexCount(), 1);
    for (uint32_t f = 0; f < folding.size(); ++f) {
      const auto& quad = cage_.quads[f];
      if (std::none_of(quad.begin(), quad.end(), [&](uint32_t v) { return beside[v]; })) continue;
      const double times = folding[f] ? kMoreEven : std::sqrt(kMoreEven);
      for (int i = 0; i <= kPatchSpans; ++i)
        for (int j = 0; j <= kPatchSpans; ++j) {
          double& own = more[net_.vertex(f, i, j)];
          own = std::max(own, times);
        }
    }
    evened_.resize(more.size(), 0);
    for (size_t v = 0; v < more.size(); ++v)
      if (more[v] > 1) evened_[v] = std::clamp(evened_[v] * more[v], kMoreEven, kMostEven);
  }
  // Where the surface faces at the vertices that are evened out.
  void lookForFacing() {
    facing_.resize(evened_.size());
    uint32_t hint = UINT32_MAX;
    for (size_t v = 0; v < evened_.size(); ++v) {
      if (evened_[v] == 0) continue;
      hint = tree_.nearest(at_.row(Eigen::Index(v)).transpose(), hint).triangle;
      facing_[v] = areaOfTriangle(clay_, tree_.corners(hint)).normalized();
    }
  }

  // Of the patches so many a side; of the clay about as many in all: what they miss pulls them.
  void choosePlaces(int perSide) {
    perSide_ = perSide;
    forth_.set(placesOf(net_, cage_.quads.size(), perSide));
    lines_.set(creasePlaces(net_, topology_, cage_.corners, perSide));
    endsAt_ = lines_.targets.size() - 3 * cage_.corners.size();
    for (size_t i = endsAt_; i < lines_.targets.size(); ++i)
      lines_.targets[i] = {cage_.positions[cage_.corners[(i - endsAt_) / 3]], Vec3d::Unit(int((i - endsAt_) % 3)),
                           kAtEnds};
    points_.clear();
    pointNormals_.clear();
    const double stride = std::max(1.0, double(clay_.positions.size()) / double(forth_.targets.size()));
    for (double i = 0; i < double(clay_.positions.size()); i += stride) {
      points_.push_back(clay_.positions[size_t(i)]);
      pointNormals_.push_back(normals_[size_t(i)].normalized());
    }
    hints_.assign(forth_.targets.size(), UINT32_MAX);
    lineHints_.assign(lines_.targets.size(), UINT32_MAX);
  }

  void lookForTargets() {
    const PatchSurface now = surface();
    multiply(forth_.rows(), at_, there_, threads_);
    const auto perPatch = size_t(perSide_ * perSide_);
    parallelBlocks(
        forth_.targets.size(), threads_,
        [&](size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) {
            Target& to = forth_.targets[i];
            const Vec3d from = there_.row(Eigen::Index(i)).transpose();
            to.at = nearestOn(clay_, tree_, from, hints_[i]);
            to.normal = areaOfTriangle(clay_, tree_.corners(hints_[i])).normalized();
            const auto in = static_cast<int>(i % perPatch);
            const PatchSurface::Tangents tangents =
                now.tangentsAt(static_cast<uint32_t>(i / perPatch), (in / perSide_ + 0.5) * kPatchSpans / perSide_,
                               (in % perSide_ + 0.5) * kPatchSpans / perSide_);
            const Vec3d facing = tangents.u.cross(tangents.v);
            const bool same = facing.dot(to.normal) >= leastFacing_[i / perPatch] * facing.norm();
            to.weight = same ? weightOf((to.at - from).norm(), far_) : 0;
          }
        },
        kBlock);
    multiply(lines_.rows(), at_, there_, threads_);
    for (size_t i = 0; i < endsAt_; i += 2) {
      const Vec3d from = there_.row(Eigen::Index(i)).transpose();
      const CreaseMap::Hit hit = creases_.nearest(from, lineHints_[i]);
      // In a gap that was bridged there is none.
      const bool isThere = hit.squared < mostOff_ * mostOff_;
      const Vec3d across = hit.along.unitOrthogonal();
      lines_.targets[i] = {hit.mm, across, isThere ? kOnLines : 0};
      lines_.targets[i + 1] = {hit.mm, hit.along.cross(across), isThere ? kOnLines : 0};
    }
    back_.set(placesNearest(net_, now, points_, pointNormals_, leastFacing_, threads_));
    multiply(back_.rows(), at_, there_, threads_);
    for (size_t i = 0; i < points_.size(); ++i)
      back_.targets[i] = {points_[i], pointNormals_[i],
                          weightOf((there_.row(Eigen::Index(i)).transpose() - points_[i]).norm(), far_)};
  }

  // What pulls at x, of what it misses its targets by where `missed`.
  void apply(const Table& x, bool missed, double stiff, double along) {
    pull_.setZero(x.rows(), 3);
    forth_.add(x, missed, along, pull_, threads_);
    back_.add(x, missed, along, pull_, threads_);
    lines_.add(x, missed, 0, pull_, threads_);
    multiply(bends_, x, held_, threads_);
    for (size_t v = 0; v < evened_.size(); ++v) {
      if (evened_[v] == 0) continue;
      const Vec3d bend = held_.row(Eigen::Index(v)).transpose();
      held_.row(Eigen::Index(v)) += evened_[v] * (bend - bend.dot(facing_[v]) * facing_[v]).transpose();
    }
    multiply(turnedBends_, held_, bent_, threads_);
    pull_ += stiff * bent_;
  }

  // Conjugate gradients, preconditioned by the diagonal, from where the net is.
  void solve(double stiff, double along) {
    Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(at_.rows(), 1e-9);
    forth_.addDiagonal(along, diagonal);
    back_.addDiagonal(along, diagonal);
    lines_.addDiagonal(0, diagonal);
    for (Eigen::Index i = 0; i < bends_.rows(); ++i) {
      const double held = stiff * (evened_.empty() ? 1 : 1 + 2 * evened_[size_t(i)] / 3);
      for (Rows::InnerIterator it(bends_, i); it; ++it) diagonal[it.col()] += held * it.value() * it.value();
    }
    const Eigen::VectorXd inverse = diagonal.cwiseInverse();
    apply(at_, true, stiff, along);
    Table rest = -pull_, way = inverse.asDiagonal() * rest, better;
    double size = (rest.array() * way.array()).sum();
    const double first = size;
    for (int step = 0; step < kSteps && size > kSolved * first && size > 0; ++step) {
      apply(way, false, stiff, along);
      const double length = size / (way.array() * pull_.array()).sum();
      at_ += length * way;
      rest -= length * pull_;
      better = inverse.asDiagonal() * rest;
      const double next = (rest.array() * better.array()).sum();
      way = better + (next / size) * way;
      size = next;
    }
  }

  const QuadMesh& cage_;
  const TriangleMesh& clay_;
  const NearestTriangle& tree_;
  const CreaseMap& creases_;
  const int threads_;
  const QuadTopology topology_;
  const PatchNet net_;
  Table at_;  // the net
  const Rows bends_, turnedBends_;
  std::vector<double> leastFacing_;  // of each quad
  std::vector<Vec3d> normals_;       // of the clay's vertices
  double far_ = 0, mostOff_ = 0;
  int perSide_ = 0;
  Pull forth_, back_, lines_;
  size_t endsAt_ = 0;  // of lines_
  std::vector<Vec3d> points_, pointNormals_;
  std::vector<uint32_t> hints_, lineHints_;
  Table there_, pull_, held_, bent_;
  std::vector<double> evened_;  // how much more each vertex of the net is held straight along the surface,
  std::vector<Vec3d> facing_;   // which faces there so; none before patches fold
};

}  // namespace

PatchSurface fittedNet(const QuadMesh& cage, const TriangleMesh& clay, const NearestTriangle& tree,
                       const CreaseMap& creases, const FitEffort& effort, int threads, const WorkPart& part) {
  NetFit fit(cage, clay, tree, creases, threads);
  fit.improve(kLeading, effort.rounds, effort.leading, part.part(0, 0.4));
  fit.improve(kLast, effort.rounds, effort.last, part.part(0.4, effort.unfoldings > 0 ? 0.8 : 1));
  if (effort.unfoldings > 0) fit.unfold(kLast[1], effort.unfoldings, part.part(0.8, 1));
  return fit.surface();
}

}  // namespace argil::clay
