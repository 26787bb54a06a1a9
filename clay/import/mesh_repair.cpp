#include "clay/import/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"
#include "clay/mesh/crossing_triangles.h"
#include "clay/mesh/weld.h"
#include "clay/mesh/winding_number.h"

namespace argil::clay {

namespace {

using Triangle = std::array<uint32_t, 3>;

void flip(Triangle& t) {
  std::swap(t[1], t[2]);
}

/// One use of an undirected edge by a triangle.
struct EdgeUse {
  uint32_t low, high, triangle;
  bool forward;  // the triangle runs from low to high
};

std::vector<EdgeUse> edgeUses(const std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(triangles.size() * 3);
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return uses;
}

/// Calls visit(begin, end) with the uses of each edge.
template <class Visit>
void forEachEdge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (size_t begin = 0; begin < uses.size();) {
    size_t end = begin + 1;
    while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high) ++end;
    visit(begin, end);
    begin = end;
  }
}

/// Leaves one face of each set of faces on the same corners. As many of them facing one way as the other cancel (a flap
/// of no thickness): then all go, unless an edge would be left with a single face, because then the face closes a
/// surface.
void dropDuplicates(std::vector<Triangle>& triangles, uint64_t& dropped) {
  struct Key {
    Triangle sorted;
    uint32_t index;
    bool even;  // turn of the corners against the sorted ones
  };
  std::vector<Key> keys(triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    Triangle s = triangles[i];
    const bool even = (s[0] < s[1]) ^ (s[1] < s[2]) ^ (s[0] < s[2]);
    std::sort(s.begin(), s.end());
    keys[i] = {s, i, even};
  }
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return a.sorted != b.sorted ? a.sorted < b.sorted : a.index < b.index; });

  std::vector<bool> gone(triangles.size(), false);
  std::vector<uint32_t> cancelling;
  for (size_t begin = 0; begin < keys.size();) {
    size_t end = begin + 1;
    while (end < keys.size() && keys[end].sorted == keys[begin].sorted) ++end;
    if (end - begin > 1) {
      const auto even =
          std::count_if(keys.begin() + long(begin), keys.begin() + long(end), [](const Key& k) { return k.even; });
      const bool balanced = size_t(2 * even) == end - begin;
      const bool keepEven = size_t(2 * even) > end - begin;
      bool kept = false;
      for (size_t i = begin; i < end; ++i) {
        if (!kept && (balanced || keys[i].even == keepEven)) {
          kept = true;
          if (balanced) cancelling.push_back(keys[i].index);
        } else {
          gone[keys[i].index] = true;
        }
      }
    }
    begin = end;
  }

  if (!cancelling.empty()) {
    // Uses of each edge without the cancelling faces; then those that close an edge are put back, until none does.
    std::vector<bool> out = gone;
    for (const uint32_t t : cancelling) out[t] = true;
    const std::vector<EdgeUse> uses = edgeUses(triangles);
    std::vector<uint32_t> edgeOf(triangles.size() * 3);
    std::vector<uint32_t> faces;
    std::vector<int> filled(triangles.size(), 0);
    forEachEdge(uses, [&](size_t begin, size_t end) {
      faces.push_back(0);
      for (size_t i = begin; i < end; ++i) {
        const uint32_t t = uses[i].triangle;
        edgeOf[t * 3 + size_t(filled[t]++)] = uint32_t(faces.size() - 1);
        if (!out[t]) ++faces.back();
      }
    });
    for (bool changed = true; changed;) {
      changed = false;
      for (const uint32_t t : cancelling) {
        const uint32_t* e = &edgeOf[t * 3];
        if (!out[t] || (faces[e[0]] != 1 && faces[e[1]] != 1 && faces[e[2]] != 1)) continue;
        out[t] = false;
        for (int k = 0; k < 3; ++k) ++faces[e[k]];
        changed = true;
      }
    }
    gone = out;
  }

  std::vector<Triangle> kept;
  kept.reserve(triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (!gone[i]) kept.push_back(triangles[i]);
  }
  dropped += triangles.size() - kept.size();
  triangles = std::move(kept);
}

/// Makes neighbours through two-faced edges agree; of the two ways to do so the one that leaves more area as it was.
void orientPatches(TriangleMesh& mesh, const std::vector<EdgeUse>& uses, uint64_t& flippedFaces) {
  auto& triangles = mesh.triangles;
  constexpr uint32_t kNone = UINT32_MAX;
  struct Neighbour {
    uint32_t triangle = kNone;
    bool disagrees = false;
  };
  std::vector<std::array<Neighbour, 3>> neighbours(triangles.size());
  std::vector<uint8_t> count(triangles.size(), 0);
  bool any = false;
  forEachEdge(uses, [&](size_t begin, size_t end) {
    if (end - begin != 2) return;
    const EdgeUse &a = uses[begin], &b = uses[begin + 1];
    const bool disagrees = a.forward == b.forward;
    any |= disagrees;
    neighbours[a.triangle][count[a.triangle]++] = {b.triangle, disagrees};
    neighbours[b.triangle][count[b.triangle]++] = {a.triangle, disagrees};
  });
  if (!any) return;

  const auto area = [&](const Triangle& t) {
    return (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]).norm();
  };
  enum : uint8_t { unseen, same, turned };
  std::vector<uint8_t> state(triangles.size(), unseen);
  std::vector<uint32_t> patch;
  for (uint32_t seed = 0; seed < triangles.size(); ++seed) {
    if (state[seed] != unseen) continue;
    patch.assign(1, seed);
    state[seed] = same;
    double areas[2] = {0, 0};
    for (size_t i = 0; i < patch.size(); ++i) {
      const uint32_t t = patch[i];
      areas[state[t] == turned] += area(triangles[t]);
      for (const Neighbour& n : neighbours[t]) {
        if (n.triangle == kNone || state[n.triangle] != unseen) continue;
        state[n.triangle] = (state[t] == turned) != n.disagrees ? turned : same;
        patch.push_back(n.triangle);
      }
    }
    const uint8_t toFlip = areas[1] > areas[0] ? same : turned;
    for (const uint32_t t : patch) {
      if (state[t] != toFlip) continue;
      flip(triangles[t]);
      ++flippedFaces;
    }
  }
}

/// Which way the faces of an open mesh look, as shares of the area of up to a thousand of them.
struct Backed {
  // where the rest of the mesh clearly winds around the face, or clearly the other way
  double behind = 0, before = 0;
};

Backed backedShare(const TriangleMesh& mesh, const WindingNumber& winding) {
  constexpr size_t kSamples = 1000;
  constexpr double kBeside = 1e-3;  // of the face's size: on its two sides, far from everything else
  // A wavy sheet winds up to 0.05 around its own hills, half a sphere 0.25 and more, a scan with holes nearly 0.5.
  constexpr double kClearly = 0.1;
  const size_t step = std::max<size_t>(1, mesh.triangles.size() / kSamples);
  Backed backed;
  double all = 0;
  for (size_t i = 0; i < mesh.triangles.size(); i += step) {
    const Triangle& t = mesh.triangles[i];
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const Vec3d n = (b - a).cross(c - a) / 2;
    const double area = n.norm();
    if (area == 0) continue;
    const Vec3d middle = (a + b + c) / 3, beside = n * (kBeside / std::sqrt(area));
    // The mean of both sides is what everything else winds; the face itself adds a half behind it.
    const double rest = (winding.at(middle + beside) + winding.at(middle - beside)) / 2;
    if (rest > kClearly) backed.behind += area;
    if (rest < -kClearly) backed.before += area;
    all += area;
  }
  if (all > 0) backed.behind /= all, backed.before /= all;
  return backed;
}

/// Bodies that were turned since the winding numbers of all were found. A closed body winds around nothing outside of
/// its box, so that each is asked where its box is alone.
class TurnedBodies {
 public:
  /// `own`: the body as it is now.
  void add(const TriangleMesh& own, WindingNumber&& winding) {
    Turned turned{own.positions[0], own.positions[0], std::move(winding)};
    for (const Vec3d& p : own.positions) turned.low = turned.low.cwiseMin(p), turned.high = turned.high.cwiseMax(p);
    all_.push_back(std::move(turned));
  }
  /// Returns by how much the turns changed the winding number at a place.
  [[nodiscard]] double change(const Vec3d& p) const {
    double sum = 0;
    for (const Turned& each : all_)
      if ((p.array() >= each.low.array()).all() && (p.array() <= each.high.array()).all())
        sum += 2 * each.winding.at(p);
    return sum;
  }

 private:
  struct Turned {
    Vec3d low, high;
    WindingNumber winding;
  };
  std::vector<Turned> all_;
};

/// Some triangles of a mesh with the positions that they use.
TriangleMesh meshOf(const TriangleMesh& mesh, const std::vector<uint32_t>& faces) {
  TriangleMesh own;
  for (const uint32_t t : faces) {
    const auto first = uint32_t(own.positions.size());
    for (const uint32_t v : mesh.triangles[t]) own.positions.push_back(mesh.positions[v]);
    own.triangles.push_back({first, first + 1, first + 2});
  }
  return own;
}

/// Turns what is inside out: the whole, or closed bodies that do not lie in another one.
void orientBodies(TriangleMesh& mesh, const std::vector<EdgeUse>& usesBefore, MeshFindings& findings, Job* job) {
  auto& triangles = mesh.triangles;
  JoinedSets sets(triangles.size());
  forEachEdge(usesBefore, [&](size_t begin, size_t end) {
    for (size_t i = begin + 1; i < end; ++i) sets.join(usesBefore[begin].triangle, usesBefore[i].triangle);
  });
  struct Body {
    double volume = 0;
    bool closed = true, flipped = false;
    std::vector<uint32_t> faces;
  };
  std::vector<Body> bodies;
  std::vector<uint32_t> bodyOf(triangles.size(), UINT32_MAX);
  Vec3d low = mesh.positions[triangles[0][0]], high = low;
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const uint32_t root = sets.find(t);  // the lowest index of its set, so met first
    if (root == t) {
      bodyOf[t] = uint32_t(bodies.size());
      bodies.emplace_back();
    }
    bodyOf[t] = bodyOf[root];
    bodies[bodyOf[t]].faces.push_back(t);
    for (const uint32_t v : triangles[t])
      low = low.cwiseMin(mesh.positions[v]), high = high.cwiseMax(mesh.positions[v]);
  }
  {
    JoinedSets corners(mesh.positions.size());
    std::vector<bool> used(mesh.positions.size(), false);
    for (const Triangle& t : triangles) {
      corners.join(t[0], t[1]);
      corners.join(t[1], t[2]);
      for (const uint32_t v : t) used[v] = true;
    }
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) findings.bodies += used[v] && corners.find(v) == v;
  }

  const Vec3d middle = (low + high) / 2;
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const Vec3d a = mesh.positions[triangles[t][0]] - middle, b = mesh.positions[triangles[t][1]] - middle,
                c = mesh.positions[triangles[t][2]] - middle;
    bodies[bodyOf[t]].volume += a.dot(b.cross(c)) / 6;
  }
  // Directions changed since the uses were listed; closed means that they cancel on every edge.
  const std::vector<EdgeUse> uses = edgeUses(triangles);
  forEachEdge(uses, [&](size_t begin, size_t end) {
    int net = 0;
    for (size_t i = begin; i < end; ++i) net += uses[i].forward ? 1 : -1;
    if (net != 0) bodies[bodyOf[uses[begin].triangle]].closed = false;
  });

  const auto turn = [&](Body& body) {
    for (const uint32_t t : body.faces) flip(triangles[t]);
    body.volume = -body.volume;
    body.flipped = !body.flipped;
  };
  std::optional<WindingNumber> all;
  double total = 0;
  bool closed = true;
  for (const Body& body : bodies) total += body.volume, closed &= body.closed;
  if (!closed) {
    // The volume of an open mesh depends on where it is measured from; which side is wound around does not.
    all.emplace(mesh);
    const Backed backed = backedShare(mesh, *all);
    total = backed.behind - backed.before;
    findings.backedShare = std::max(backed.behind, backed.before);
  }
  if (total < 0) {
    for (Body& body : bodies) turn(body);
    all.reset();
  }

  TurnedBodies turned;
  for (Body& body : bodies) {
    if (!body.closed || body.volume >= 0) continue;
    if (job && job->cancelled()) throw Cancelled();
    if (bodies.size() > 1) {
      if (!all) all.emplace(mesh);
      const WindingNumber self(meshOf(mesh, body.faces));
      // Three places on the body vote on whether it is a cavity: the others wind around them.
      int votes = 0;
      for (int k = 0; k < 3; ++k) {
        const Triangle& t = triangles[body.faces[body.faces.size() * size_t(k) / 3]];
        const Vec3d p = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3;
        if (all->at(p) + turned.change(p) - self.exact(p) > 0.5) ++votes;
      }
      if (votes >= 2) continue;
    }
    turn(body);
    if (bodies.size() > 1) {
      const TriangleMesh own = meshOf(mesh, body.faces);
      turned.add(own, WindingNumber(own));
    }
  }
  const auto flipped = uint64_t(std::count_if(bodies.begin(), bodies.end(), [](const Body& b) { return b.flipped; }));
  findings.flippedWhole = flipped == bodies.size();
  findings.flippedBodies = findings.flippedWhole ? 0 : flipped;
}

}  // namespace

RepairedMesh repairMesh(const TriangleMesh& given, Job* job) {
  RepairedMesh result;
  MeshFindings& findings = result.findings;
  TriangleMesh& mesh = result.mesh;
  findings.triangles = given.triangles.size();
  mesh = weldOpenEdges(given);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Vec3d u = mesh.positions[t[1]] - mesh.positions[t[0]], v = mesh.positions[t[2]] - mesh.positions[t[0]];
    if (u.cross(v).squaredNorm() == 0) ++findings.degenerate;
    // A sliver on three different corners stays: without it its neighbours would be open.
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
  dropDuplicates(mesh.triangles, findings.duplicateFaces);
  if (mesh.triangles.empty()) return result;

  const std::vector<EdgeUse> uses = edgeUses(mesh.triangles);
  forEachEdge(uses, [&](size_t begin, size_t end) {
    if (end - begin == 1) ++findings.boundaryEdges;
    if (end - begin > 2) ++findings.nonManifoldEdges;
    if (end - begin == 2 && uses[begin].forward == uses[begin + 1].forward) ++findings.inconsistentEdges;
  });
  if (job && job->cancelled()) throw Cancelled();
  orientPatches(mesh, uses, findings.flippedFaces);
  orientBodies(mesh, uses, findings, job);
  findings.crossings = countCrossings(mesh, job);

  const std::vector<EdgeUse> oriented = edgeUses(mesh.triangles);
  forEachEdge(oriented, [&](size_t begin, size_t end) {
    int net = 0;
    for (size_t i = begin; i < end; ++i) net += oriented[i].forward ? 1 : -1;
    const EdgeUse& e = oriented[begin];
    if (net > 0) result.openEdges.push_back({e.low, e.high, uint32_t(net)});
    if (net < 0) result.openEdges.push_back({e.high, e.low, uint32_t(-net)});
  });
  return result;
}

}  // namespace argil::clay
