#include "clay/cage/unfold_quads.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "clay/base/joined_sets.h"

namespace argil::clay {

namespace {

constexpr double kGood = 0.35, kRoom = 0.6;  // scaled Jacobians: of what is good, and what is wanted beside what is not
constexpr double kBetter = 0.01;             // of what is lacking: a vertex moves for as much
constexpr double kOfCrumb = 0.8;  // of a crumb's size: a box whose faces lie as far outside as its corners' clay inside
constexpr size_t kMostLeft = 2000;  // crumbs of which it is not clear by their vertices whose clay they are
constexpr int kRounds = 30;
// Of an edge: so far middles may lie off the surface, or as far as they did; and at last.
constexpr double kOff = 0.15, kMostOff = 0.4;
constexpr int kWays = 12;                              // directions that are tried
constexpr std::array kSteps = {0.6, 0.25, 0.1, 0.04};  // of the mean edge

class Unfolding {
 public:
  Unfolding(QuadMesh& mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases)
      : mesh_(mesh),
        surface_(surface),
        tree_(tree),
        creases_(creases),
        around_(mesh.positions.size()),
        facing_(mesh.quads.size()),
        corner_(mesh.positions.size()),
        onCrease_(mesh.positions.size()) {
    for (uint32_t f = 0; f < mesh.quads.size(); ++f)
      for (const uint32_t v : mesh.quads[f]) around_[v].push_back(f);
    for (const uint32_t v : mesh.corners) corner_[v] = true;
    for (size_t f = 0; f < mesh.creases.size(); ++f)
      for (size_t s = 0; s < 4; ++s)
        if (mesh.creases[f] >> s & 1) onCrease_[mesh.quads[f][s]] = onCrease_[mesh.quads[f][(s + 1) & 3]] = true;
  }

  void run(const WorkPart& part) {
    for (uint32_t f = 0; f < mesh_.quads.size(); ++f) facing_[f] = facing(f);
    for (uint32_t v = 0; v < around_.size(); ++v) boxCrumb(v);
    for (uint32_t f = 0; f < mesh_.quads.size(); ++f) hopeless_.push_back(isHopeless(f));
    // As near to the surface as they are, and where that does not do, farther.
    for (const auto& [last, off] : {std::pair(false, kOff), {true, kOff}, {false, kMostOff}, {true, kMostOff}}) {
      last_ = last;
      off_ = off;
      rounds(part);
    }
  }

 private:
  void rounds(const WorkPart& part) {
    for (int round = 0; round < kRounds; ++round) {
      part.step(0);  // how many there will be nobody knows
      std::vector<bool> bad(mesh_.positions.size());
      bool any = false;
      for (uint32_t f = 0; f < mesh_.quads.size(); ++f) {
        if (worth(f) < kGood) facing_[f] = facing(f);
        if (hopeless_[f] || worth(f) >= kGood) continue;
        any = true;
        for (const uint32_t v : mesh_.quads[f])
          for (const uint32_t beside : around_[v])
            for (const uint32_t each : mesh_.quads[beside]) bad[each] = true;
      }
      if (!any) return;
      bool moved = false;
      for (uint32_t v = 0; v < bad.size(); ++v)
        if (bad[v] && !corner_[v]) moved = move(v) || moved;
      if (!moved) return;
    }
  }

  // A body of six quads of which one is bad becomes a box around what is there: of a crumb all vertices may have come
  // to one place. `first`: one of its vertices.
  void boxCrumb(uint32_t first) {
    if (around_[first].size() != 3) return;
    std::array<std::pair<uint32_t, int>, 8> place;  // vertices, and on which side of it each lies along three axes
    size_t known = 0;
    const auto sidesOf = [&](uint32_t v) {
      const auto end = place.begin() + static_cast<ptrdiff_t>(known);
      const auto it = std::find_if(place.begin(), end, [&](const auto& each) { return each.first == v; });
      return it == end ? -1 : it->second;
    };
    const auto add = [&](uint32_t v, int sides) {
      if (sidesOf(v) < 0 && known < place.size()) place[known++] = {v, sides};
    };
    add(first, 0);
    for (const uint32_t f : around_[first]) {
      const auto& q = mesh_.quads[f];
      const auto s = static_cast<size_t>(std::find(q.begin(), q.end(), first) - q.begin());
      for (const size_t end : {(s + 1) & 3, (s + 3) & 3})
        if (sidesOf(q[end]) < 0 && known < 4) add(q[end], 1 << (known - 1));
    }
    if (known != 4) return;
    std::vector<uint32_t> quads = around_[first];
    for (const uint32_t f : around_[first]) {
      const auto& q = mesh_.quads[f];
      const auto s = static_cast<size_t>(std::find(q.begin(), q.end(), first) - q.begin());
      add(q[(s + 2) & 3], sidesOf(q[(s + 1) & 3]) | sidesOf(q[(s + 3) & 3]));
      quads.insert(quads.end(), around_[q[(s + 2) & 3]].begin(), around_[q[(s + 2) & 3]].end());
    }
    std::sort(quads.begin(), quads.end());
    quads.erase(std::unique(quads.begin(), quads.end()), quads.end());
    if (known != 7 || quads.size() != 6) return;
    for (const uint32_t f : quads)
      for (const uint32_t v : mesh_.quads[f]) add(v, 7);
    const bool closed = std::all_of(quads.begin(), quads.end(), [&](uint32_t f) {
      return std::ranges::all_of(mesh_.quads[f], [&](uint32_t v) {
        return sidesOf(v) >= 0 && around_[v].size() == 3 && !corner_[v] && !onCrease_[v];
      });
    });
    const bool bad = std::any_of(quads.begin(), quads.end(), [&](uint32_t f) { return worth(f) < kGood; });
    if (known != 8 || !closed || !bad) return;

    // The axes of the clay's own body, and how far it reaches along them.
    if (bodies_.empty()) findBodies();
    const auto own = clayOf_.find(meshBodies_[first]);
    if (own == clayOf_.end()) return;
    const uint32_t body = own->second;
    Vec3d mean = Vec3d::Zero();
    std::vector<Vec3d> points;
    for (uint32_t v = 0; v < bodies_.size(); ++v)
      if (bodies_[v] == body) points.push_back(surface_.positions[v]), mean += points.back();
    mean /= double(points.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vec3d& p : points) spread += (p - mean) * (p - mean).transpose();
    const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
    Vec3d low = Vec3d::Constant(INFINITY), high = -low;
    for (const Vec3d& p : points) {
      const Vec3d at = axes.transpose() * (p - mean);
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
    const Vec3d middle = 0.5 * (low + high),
                half = (kOfCrumb * 0.5 * (high - low)).cwiseMax(0.01 * (high - low).maxCoeff());
    const auto put = [&](double side) {
      for (const auto& [v, sides] : place) {
        const Vec3d way(sides & 1 ? side : -side, sides & 2 ? 1 : -1, sides & 4 ? 1 : -1);
        mesh_.positions[v] = mean + axes * (middle + way.cwiseProduct(half));
      }
    };
    put(1);
    double volume = 0;
    for (const uint32_t f : quads) {
      const auto& q = mesh_.quads[f];
      const auto at = [&](size_t s) -> Vec3d { return mesh_.positions[q[s]] - mean; };
      volume += at(0).dot(at(1).cross(at(2))) + at(0).dot(at(2).cross(at(3)));
    }
    if (volume < 0) put(-1);
    for (const uint32_t f : quads) facing_[f] = facing(f);
  }

  // Which body of the mesh goes around which of the clay: of each two the ones of which most vertices lie on the other,
  // and of crumbs, whose vertices may all have come to lie on another body, those that are left and nearest.
  void findBodies() {
    JoinedSets sets(surface_.positions.size()), meshSets(mesh_.positions.size());
    for (const auto& t : surface_.triangles) sets.join(t[0], t[1]), sets.join(t[0], t[2]);
    for (const auto& q : mesh_.quads)
      for (size_t s = 1; s < 4; ++s) meshSets.join(q[0], q[s]);
    std::map<uint32_t, Eigen::AlignedBox3d> clay, mesh;
    for (uint32_t v = 0; v < surface_.positions.size(); ++v) {
      bodies_.push_back(sets.find(v));
      clay[bodies_.back()].extend(surface_.positions[v]);
    }
    std::map<std::pair<uint32_t, uint32_t>, int> votes;
    for (uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      meshBodies_.push_back(meshSets.find(v));
      mesh[meshBodies_.back()].extend(mesh_.positions[v]);
      hint_ = tree_.nearest(mesh_.positions[v], hint_).triangle;
      ++votes[{meshBodies_.back(), bodies_[tree_.corners(hint_)[0]]}];
    }
    if (clay.size() != mesh.size()) return;
    std::set<uint32_t> taken;
    std::vector<std::tuple<double, uint32_t, uint32_t>> pairs;
    const auto join = [&] {
      std::sort(pairs.begin(), pairs.end());
      for (const auto& [cost, of, on] : pairs)
        if (!clayOf_.contains(of) && taken.insert(on).second) clayOf_[of] = on;
      pairs.clear();
    };
    for (const auto& [pair, count] : votes) pairs.emplace_back(-count, pair.first, pair.second);
    join();
    const size_t left = mesh.size() - taken.size();
    if (left > kMostLeft) return;
    for (const auto& [of, box] : mesh)
      for (const auto& [on, other] : clay)
        if (!clayOf_.contains(of) && !taken.contains(on))
          pairs.emplace_back((box.center() - other.center()).norm(), of, on);
    join();
  }

  // Of the surface at a quad's middle.
  Vec3d facing(uint32_t f) {
    const auto& q = mesh_.quads[f];
    const auto& p = mesh_.positions;
    return normalAt(0.25 * (p[q[0]] + p[q[1]] + p[q[2]] + p[q[3]]), hint_).second;
  }
  // The nearest place of the surface, and its normal.
  std::pair<Vec3d, Vec3d> normalAt(const Vec3d& p, uint32_t& hint) const {
    hint = tree_.nearest(p, hint).triangle;
    const auto& t = tree_.corners(hint);
    const Vec3d &a = surface_.positions[t[0]], &b = surface_.positions[t[1]], &c = surface_.positions[t[2]];
    return {nearestOnTriangle(p, a, b, c), (b - a).cross(c - a).normalized()};
  }

  // Its scaled Jacobian, and one less where it looks against the surface.
  double worth(uint32_t f) const {
    const auto& q = mesh_.quads[f];
    const auto& p = mesh_.positions;
    const Vec3d own = (p[q[2]] - p[q[0]]).cross(p[q[3]] - p[q[1]]);
    return scaledJacobian(mesh_, q) - (own.dot(facing_[f]) > 0 ? 0 : 1);
  }
  // A quad with two sides on one crease has a corner of half a turn, wherever its vertices go.
  bool isHopeless(uint32_t f) const {
    if (mesh_.creases.empty()) return false;
    const auto& q = mesh_.quads[f];
    for (size_t s = 0; s < 4; ++s) {
      if (!(mesh_.creases[f] >> s & 1) || !(mesh_.creases[f] >> ((s + 3) & 3) & 1)) continue;
      const Vec3d& p = mesh_.positions[q[s]];
      const Vec3d a = (mesh_.positions[q[(s + 1) & 3]] - p).normalized(),
                  b = (mesh_.positions[q[(s + 3) & 3]] - p).normalized();
      if (a.cross(b).norm() < kGood) return true;
    }
    return false;
  }

  // What its quads lack altogether, by squares, where they make room for each other; at last what the worst lacks.
  double lackAt(uint32_t v) const {
    double sum = 0, most = 0;
    for (const uint32_t f : around_[v]) {
      if (hopeless_[f]) continue;
      const double lack = std::max(0.0, (last_ ? kGood : kRoom) - worth(f));
      sum += lack * lack;
      most = std::max(most, lack);
    }
    return last_ ? most : sum;
  }

  // How far the middles of the quads around a vertex and of its edges lie off the surface at most.
  double offAt(uint32_t v) {
    double most = 0;
    const auto& p = mesh_.positions;
    for (const uint32_t f : around_[v]) {
      const auto& q = mesh_.quads[f];
      const auto s = static_cast<size_t>(std::find(q.begin(), q.end(), v) - q.begin());
      for (const Vec3d& place :
           {Vec3d(0.5 * (p[v] + p[q[(s + 1) & 3]])), Vec3d(0.25 * ((p[q[0]] + p[q[1]]) + (p[q[2]] + p[q[3]])))}) {
        const NearestTriangle::Hit hit = tree_.nearest(place, hint_);
        hint_ = hit.triangle;
        most = std::max(most, std::sqrt(hit.squared));
      }
    }
    return most;
  }

  bool move(uint32_t v) {
    const double before = lackAt(v);
    if (before == 0) return false;
    const Vec3d was = mesh_.positions[v];
    double length = 0;
    for (const uint32_t f : around_[v]) {
      const auto& q = mesh_.quads[f];
      const auto s = static_cast<size_t>(std::find(q.begin(), q.end(), v) - q.begin());
      length += (mesh_.positions[q[(s + 1) & 3]] - was).norm() / double(around_[v].size());
    }
    // As far off the surface as it was: quads lie around it.
    const auto [foot, normal] = normalAt(was, hint_);
    const double height = (was - foot).dot(normal);
    // A sliver without area has none: any way will do.
    const Vec3d out = normal.squaredNorm() > 0 ? normal : Vec3d::UnitZ();
    const Vec3d across = out.unitOrthogonal(), over = out.cross(across);
    double best = before;
    Vec3d to = was;
    const double allowed = std::max(offAt(v), off_ * length);
    const auto attempt = [&](const Vec3d& place) {
      mesh_.positions[v] = place;
      if (const double now = lackAt(v); now < best - kBetter * before && offAt(v) <= allowed) best = now, to = place;
    };
    for (const double step : kSteps) {
      if (onCrease_[v]) {
        const Vec3d along = creases_.nearest(was, creaseHint_).along;
        for (const double way : {-1.0, 1.0})
          attempt(creases_.nearest(was + way * step * length * along, creaseHint_).mm);
        continue;
      }
      for (int k = 0; k < kWays; ++k) {
        const double angle = 2 * M_PI * k / kWays;
        const auto [on, there] =
            normalAt(was + step * length * (std::cos(angle) * across + std::sin(angle) * over), hint_);
        attempt(on + height * there);
      }
    }
    mesh_.positions[v] = to;
    return best < before;
  }

  QuadMesh& mesh_;
  const TriangleMesh& surface_;
  const NearestTriangle& tree_;
  const CreaseMap& creases_;
  std::vector<std::vector<uint32_t>> around_;
  std::vector<Vec3d> facing_;
  std::vector<uint32_t> bodies_, meshBodies_;  // of the surface's vertices and the mesh's, once a crumb asks
  std::map<uint32_t, uint32_t> clayOf_;        // bodies of the surface by those of the mesh
  std::vector<bool> corner_, onCrease_, hopeless_;
  bool last_ = false;
  double off_ = 0;
  uint32_t hint_ = UINT32_MAX, creaseHint_ = UINT32_MAX;
};

}  // namespace

void unfoldQuads(QuadMesh& mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
                 const WorkPart& part) {
  Unfolding(mesh, surface, tree, creases).run(part);
}

}  // namespace argil::clay
