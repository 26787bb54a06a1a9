#include "clay/cage/crease_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "clay/base/joined_sets.h"
#include "clay/mesh/surface_faces.h"

namespace argil::clay {

namespace {

constexpr double kLeastLine = 2, kLeastWidth = 0.2;  // even edges: shorter creases and narrower faces are left out
constexpr int kCornerPieces = 4;                     // of a line, over which a turn is seen
constexpr double kCornerTurn = 0.7;                  // radians
constexpr float kAcrossEnd = 0.9f;                   // cosine to the axis
constexpr double kOneCorner = 1.5;                   // pieces
constexpr double kOnePlace = 0.01;                   // of the mean side
constexpr double kPlaces[][2] = {{0.5, 0.5}, {0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}};  // of a quad
// Where four faces meet, meetings of three may be so near to it, pieces of the map or sides of quads, with so many
// edges between them.
constexpr double kTouching = 4, kNearCrossing = 4;
constexpr int kMostTouching = 4;
// Even edges, and parts of its own length: a guide that leaves the surface by more than both is none.
constexpr double kGuideOff = 0.25, kGuideOffOfLength = 0.02;
constexpr double kParallel = 0.05;  // squared sine of an angle

const float kLeastCosine = static_cast<float>(std::cos(kCreaseDegrees / 180 * std::numbers::pi));

// Halfway between where two lines come nearest to each other; of parallel ones between the places.
Vec3d crossingOf(const Vec3d& a, const Vec3d& along, const Vec3d& b, const Vec3d& other) {
  const Vec3d up = along.cross(other), between = b - a;
  const double square = up.squaredNorm();
  if (square < kParallel * along.squaredNorm() * other.squaredNorm()) return (a + b) / 2;
  return 0.5 * (a + between.cross(other).dot(up) / square * along + b + between.cross(along).dot(up) / square * other);
}

}  // namespace

CreaseMap::CreaseMap(const Surface& fine, const TriangleMesh& mesh, double evenMm, const std::optional<EndPlane>& end,
                     const std::vector<GuideLoop>& guides) {
  std::vector<bool> sharp;
  sharp.reserve(mesh.positions.size());
  fine.forEach([&](const BrickMesh& brick) {
    for (const PackedNormal& each : brick.normals) sharp.push_back((each.v & 1) != 0);
  });
  sharp.resize(mesh.positions.size(), false);
  if (!end && guides.empty() && std::find(sharp.begin(), sharp.end(), true) == sharp.end()) return;
  // Sides between two sharp vertices at which the surface turns.
  const SurfaceCells cells(mesh.positions, mesh.triangles);
  const auto to = [&](size_t side) { return cells.corners[side - side % 3 + (side + 1) % 3]; };
  std::vector<bool> bent(cells.corners.size());
  JoinedSets lines(mesh.positions.size());
  std::unordered_map<uint32_t, double> lineLengths;
  for (size_t side = 0; side < bent.size(); ++side) {
    if (!sharp[cells.corners[side]] || !sharp[to(side)]) continue;
    bent[side] = cells.normals[side / 3].dot(cells.normals[cells.across[side]]) < kLeastCosine;
    if (bent[side]) lines.join(cells.corners[side], to(side));
  }
  for (size_t side = 0; side < bent.size(); ++side)
    if (bent[side]) lineLengths[lines.find(cells.corners[side])] += 0.5 * double(cells.lengths[side]);
  for (size_t side = 0; side < bent.size(); ++side)
    bent[side] = bent[side] && lineLengths[lines.find(cells.corners[side])] >= kLeastLine * evenMm;
  if (end) {
    std::vector<bool> ends(cells.count());
    for (size_t cell = 0; cell < ends.size(); ++cell) {
      const auto& t = mesh.triangles[cell];
      ends[cell] = cells.normals[cell][end->axis] > kAcrossEnd &&
                   std::all_of(t.begin(), t.end(), [&](uint32_t v) { return end->has(mesh.positions[v]); });
    }
    for (size_t side = 0; side < bent.size(); ++side)
      if (ends[side / 3] != ends[cells.across[side]])
        bent[side] = true;
      else if (ends[side / 3])
        bent[side] = false;
  }
  const double mean = std::accumulate(cells.lengths.begin(), cells.lengths.end(), 0.0) / double(bent.size());
  // Guides go along sides, but their pieces lie on the curves themselves, or on the creases that these meet.
  std::vector<bool> guided(bent.size());
  std::unordered_map<uint32_t, std::pair<Vec3d, Vec3d>> curve;  // place, direction
  if (!guides.empty()) {
    GuideWays ways(mesh, cells, bent, mean);
    for (const GuideLoop& guide : guides) {
      double length = 0;
      for (size_t i = 0; i < guide.size(); ++i) length += (guide[(i + 1) % guide.size()] - guide[i]).norm();
      const double off = std::max({kGuideOff * evenMm, kGuideOffOfLength * length, 2 * mean});
      const std::optional<GuideWay> way = ways.along(guide, off);
      if (way) ++guides_, guidesMm_ += length;
      for (size_t i = 0, n = way ? way->vertices.size() : 0; i < n; ++i) {
        const uint32_t a = way->vertices[i], b = way->vertices[(i + 1) % n];
        const Vec3d along = way->places[(i + 1) % n] - way->places[(i + n - 1) % n];
        if (const auto [at, fresh] = curve.try_emplace(a, way->places[i], along); !fresh)
          at->second.first = crossingOf(at->second.first, at->second.second, way->places[i], along);
        for (const uint32_t side : {ways.side(a, b), ways.side(b, a)})
          if (!bent[side]) bent[side] = guided[side] = true;
      }
      if (way) ways.add(*way);
    }
  }
  face_ = facesOf(cells, bent, kLeastWidth * evenMm);
  // Vertices at one place are one end of pieces.
  JoinedSets places(mesh.positions.size());
  for (size_t side = 0; side < bent.size(); ++side)
    if (double(cells.lengths[side]) < kOnePlace * mean) places.join(cells.corners[side], to(side));
  std::unordered_map<uint32_t, uint32_t> index;
  const auto indexOf = [&](uint32_t v) {
    v = places.find(v);
    const auto [it, isNew] = index.try_emplace(v, static_cast<uint32_t>(pieces_.positions.size()));
    if (isNew) pieces_.positions.push_back(curve.contains(v) ? curve.at(v).first : mesh.positions[v]);
    return it->second;
  };
  std::set<std::pair<uint32_t, uint32_t>> known;
  for (uint32_t side = 0; side < bent.size(); ++side) {
    const uint32_t a = cells.corners[side], b = to(side);
    if (!bent[side] || a > b || face_[side / 3] == face_[cells.across[side]]) continue;
    const uint32_t from = indexOf(a), last = indexOf(b);
    if (from == last || !known.insert(std::minmax(from, last)).second) continue;
    pieces_.triangles.push_back({from, last, last});
    guide_.push_back(guided[side]);
  }
  if (empty()) return;
  tree_ = std::make_unique<NearestTriangle>(pieces_);
  std::vector<std::set<uint32_t>> faces(pieces_.positions.size());
  for (size_t side = 0; side < bent.size(); ++side)
    if (const auto it = index.find(places.find(cells.corners[side])); it != index.end())
      faces[it->second].insert(face_[side / 3]);
  findCorners(faces);
}

// `faces`: those at each end of pieces.
void CreaseMap::findCorners(const std::vector<std::set<uint32_t>>& faces) {
  std::vector<std::vector<uint32_t>> beside(pieces_.positions.size());
  for (const auto& piece : pieces_.triangles) {
    beside[piece[0]].push_back(piece[1]);
    beside[piece[1]].push_back(piece[0]);
  }
  // What lies beside one is the same, seen twice.
  const double length = lengthMm() / double(pieces_.triangles.size());
  const auto add = [&](uint32_t v) {
    const Vec3d& at = pieces_.positions[v];
    const auto isSame = [&](const Vec3d& other) { return (other - at).norm() < kOneCorner * length; };
    if (std::none_of(corners_.begin(), corners_.end(), isSame)) corners_.push_back(at);
  };
  // Where a guide crosses aslant, four faces may touch along a few pieces, with three of them at each end. Of creases
  // such are the corners of a thin plate.
  std::vector<bool> guided(beside.size());
  for (size_t i = 0; i < guide_.size(); ++i)
    if (guide_[i]) guided[pieces_.triangles[i][0]] = guided[pieces_.triangles[i][1]] = true;
  std::vector<uint32_t> meetings;
  for (uint32_t v = 0; v < beside.size(); ++v) {
    if (faces[v].size() < 3) continue;
    add(v);
    if (!guided[v]) continue;
    if (faces[v].size() > 3) crossings_.push_back(pieces_.positions[v]);
    for (const uint32_t other : meetings) {
      const Vec3d &a = pieces_.positions[v], &b = pieces_.positions[other];
      if ((a - b).norm() > kTouching * length) continue;
      std::set<uint32_t> both = faces[v];
      both.insert(faces[other].begin(), faces[other].end());
      if (both.size() > 3) crossings_.push_back(0.5 * (a + b));
    }
    meetings.push_back(v);
  }
  meetings_ = corners_.size();
  // Over some pieces either way, so that a place that lies beside its line is none.
  std::vector<double> turn(beside.size(), 0);
  const auto walk = [&](uint32_t from, uint32_t to, const auto& visit) {
    for (int i = 0; i < kCornerPieces; ++i) {
      visit(to);
      if (beside[to].size() != 2) break;
      from = std::exchange(to, beside[to][0] == from ? beside[to][1] : beside[to][0]);
    }
  };
  for (uint32_t v = 0; v < beside.size(); ++v) {
    if (beside[v].size() != 2) continue;  // the end of one is a gap
    std::array<Vec3d, 2> ways;
    for (size_t k = 0; k < 2; ++k)
      walk(v, beside[v][k], [&](uint32_t at) { ways[k] = pieces_.positions[at] - pieces_.positions[v]; });
    turn[v] = std::numbers::pi - std::atan2(ways[0].cross(ways[1]).norm(), ways[0].dot(ways[1]));
  }
  for (uint32_t v = 0; v < beside.size(); ++v) {
    if (turn[v] < kCornerTurn) continue;
    bool most = true;
    for (const uint32_t next : beside[v])
      walk(v, next, [&](uint32_t at) { most = most && (turn[at] < turn[v] || (turn[at] == turn[v] && at >= v)); });
    if (most) add(v);
  }
}

double CreaseMap::lengthMm() const {
  double length = 0;
  for (const auto& piece : pieces_.triangles)
    length += (pieces_.positions[piece[0]] - pieces_.positions[piece[1]]).norm();
  return length;
}

CreaseMap::Hit CreaseMap::nearest(const Vec3d& mm, uint32_t& hint) const {
  Hit out;
  if (empty()) return out;
  const NearestTriangle::Hit hit = tree_->nearest(mm, hint);
  hint = hit.triangle;
  const auto& c = tree_->corners(hit.triangle);
  const Vec3d &a = pieces_.positions[c[0]], &b = pieces_.positions[c[1]];
  out.mm = nearestOnTriangle(mm, a, b, b);
  out.squared = hit.squared;
  if ((b - a).squaredNorm() > 0) out.along = (b - a).normalized();
  return out;
}

// Where four faces meet on the clay, two may touch along a few edges of the mesh, with a meeting of three at each end
// of them. Quads beside those edges go, from one of the ends, to the face that meets them there: then all four meet at
// the other.
void CreaseMap::joinMeetings(const SurfaceCells& cells, const QuadMesh& mesh, std::vector<uint32_t>& face) const {
  if (crossings_.empty()) return;
  const auto isNear = [&](const Vec3d& p, double length) {
    return std::ranges::any_of(crossings_,
                               [&](const Vec3d& each) { return (each - p).norm() < kNearCrossing * length; });
  };
  const auto endOf = [&](uint32_t side) { return cells.corners[side / 4 * 4 + (side + 1) % 4]; };
  const auto beside = [](uint32_t side, uint32_t step) { return side / 4 * 4 + (side + step) % 4; };
  std::vector<uint32_t> near;
  std::unordered_map<uint32_t, std::vector<uint32_t>> around;  // sides that begin at the ends of those
  for (uint32_t side = 0; side < cells.across.size(); ++side) {
    if (!isNear(mesh.positions[cells.corners[side]], double(cells.lengths[side]))) continue;
    near.push_back(side);
    around[cells.corners[side]], around[endOf(side)];
  }
  for (uint32_t side = 0; side < cells.corners.size(); ++side)
    if (const auto at = around.find(cells.corners[side]); at != around.end()) at->second.push_back(side);
  // The face at a vertex beside two others, where that is one.
  const auto third = [&](uint32_t v, uint32_t a, uint32_t b) {
    uint32_t found = UINT32_MAX;
    for (const uint32_t side : around.at(v)) {
      const uint32_t each = face[side / 4];
      if (each == a || each == b || each == found) continue;
      if (found != UINT32_MAX) return UINT32_MAX;
      found = each;
    }
    return found;
  };
  // The third face where the edges that two faces touch along end, from this one on.
  const auto thirdAtEnd = [&](uint32_t side) {
    const uint32_t own = face[side / 4], other = face[cells.across[side]];
    for (int i = 0; i < kMostTouching; ++i) {
      const auto at = around.find(endOf(side));
      if (at == around.end()) break;
      if (const uint32_t found = third(at->first, own, other); found != UINT32_MAX) return found;
      const auto next = std::ranges::find_if(
          at->second, [&](uint32_t each) { return face[each / 4] == own && face[cells.across[each]] == other; });
      if (next == at->second.end()) break;
      side = *next;
    }
    return UINT32_MAX;
  };
  const auto twinOf = [&](uint32_t side) {
    const std::vector<uint32_t>& sides = around.at(endOf(side));
    return *std::ranges::find_if(sides, [&](uint32_t each) { return endOf(each) == cells.corners[side]; });
  };
  std::unordered_set<uint32_t> changed;  // once at most
  for (int i = 0; i < kMostTouching; ++i)
    for (const uint32_t side : near) {
      const uint32_t own = face[side / 4], other = face[cells.across[side]];
      if (own == other || changed.contains(side / 4)) continue;
      const uint32_t before = third(cells.corners[side], own, other), after = third(endOf(side), own, other);
      if (before != UINT32_MAX && face[cells.across[beside(side, 3)]] == before) {
        if (const uint32_t end = thirdAtEnd(side); end != UINT32_MAX && end != before)
          face[side / 4] = before, changed.insert(side / 4);
      } else if (after != UINT32_MAX && face[cells.across[beside(side, 1)]] == after) {
        if (const uint32_t end = thirdAtEnd(twinOf(side)); end != UINT32_MAX && end != after)
          face[side / 4] = after, changed.insert(side / 4);
      }
    }
}

double CreaseMap::clearGuides(QuadMesh& mesh) const {
  double cleared = 0;
  if (empty() || std::ranges::find(guide_, true) == guide_.end()) return cleared;
  uint32_t hint = UINT32_MAX;
  for (size_t f = 0; f < mesh.creases.size(); ++f)
    for (size_t s = 0; s < 4; ++s) {
      if ((mesh.creases[f] >> s & 1) == 0) continue;
      const Vec3d &a = mesh.positions[mesh.quads[f][s]], &b = mesh.positions[mesh.quads[f][(s + 1) & 3]];
      hint = tree_->nearest(0.5 * (a + b), hint).triangle;
      if (!guide_[tree_->indexOf(hint)]) continue;
      mesh.creases[f] = static_cast<uint8_t>(mesh.creases[f] & ~(1 << s));
      cleared += 0.5 * (b - a).norm();  // a side of two quads
    }
  return cleared;
}

void CreaseMap::mark(QuadMesh& mesh, const NearestTriangle& tree) const {
  mesh.creases.assign(mesh.quads.size(), 0);
  if (empty()) return;
  const SurfaceCells cells(mesh.positions, mesh.quads);
  // Of each quad the face that most of its places lie on, on the side of the clay that it is itself on.
  std::vector<uint32_t> face(cells.count(), UINT32_MAX);
  uint32_t hint = UINT32_MAX;
  for (uint32_t f = 0; f < face.size(); ++f) {
    const auto& q = mesh.quads[f];
    const auto at = [&](size_t s) { return mesh.positions[q[s]]; };
    std::array<std::pair<uint32_t, int>, std::size(kPlaces)> votes{};
    size_t known = 0;
    for (const auto& [u, v] : kPlaces) {
      const Vec3d p = (1 - u) * (1 - v) * at(0) + u * (1 - v) * at(1) + u * v * at(2) + (1 - u) * v * at(3);
      hint = tree.nearest(p, hint).triangle;
      const auto& c = tree.corners(hint);
      const Vec3d &a = tree.mesh().positions[c[0]], &b = tree.mesh().positions[c[1]], &d = tree.mesh().positions[c[2]];
      if ((b - a).cross(d - a).dot(cells.normals[f].cast<double>()) < 0) continue;
      const uint32_t own = face_[tree.indexOf(hint)];
      size_t i = 0;
      while (i < known && votes[i].first != own) ++i;
      if (i == known) votes[known++] = {own, 0};
      ++votes[i].second;
    }
    int most = 0;  // the first of equals: the middle's
    for (size_t i = 0; i < known; ++i)
      if (votes[i].second > most) most = votes[i].second, face[f] = votes[i].first;
  }
  tidyFaces(cells, face);
  joinMeetings(cells, mesh, face);
  for (uint32_t side = 0; side < cells.across.size(); ++side)
    if (face[side / 4] != face[cells.across[side]])
      mesh.creases[side / 4] = static_cast<uint8_t>(mesh.creases[side / 4] | 1 << side % 4);
}

}  // namespace argil::clay
