#include "clay/cage/fit_quads.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "clay/base/parallel.h"

namespace argil::clay {

namespace {

constexpr int kRounds = 5;
constexpr std::array kPlaces = {1.0 / 6, 0.5, 5.0 / 6};
constexpr size_t kWithin = kPlaces.size() * kPlaces.size(), kOfQuad = kWithin + 4;  // and its corners
constexpr double kFar = 0.5;             // of the RMS: what lies off by more counts more,
constexpr double kMostFar = 20;          // by its distance, up to so many times
constexpr double kAlong = 0.02;          // of a place's weight: how much a vertex is held along the surface
constexpr double kStay = 0.02;           // and where it is at all
constexpr double kLeastJacobian = 0.25;  // a move that makes a quad worse is taken back in part, by halves
constexpr int kHalves = 5;
constexpr double kOnIt = 1e-9;        // mm: what lies so near has no way to go
constexpr size_t kOfSurface = 20000;  // vertices of it that draw what is nearest to them, or fewer than twice as many
constexpr size_t kBlock = 64;
constexpr double kHeld = 1000;     // of a place's weight: how much creases and corners hold their vertices
constexpr int kSteps = 200;        // of conjugate gradients, at most
constexpr double kSolved = 1e-16;  // of the squared residual

// Which ways a vertex is held, as a projection: across its crease, or all of them at a corner.
struct Held {
  uint32_t vertex;
  bool corner;
  uint32_t hint = UINT32_MAX;
  Eigen::Matrix3d ways = Eigen::Matrix3d::Zero();
};
std::vector<Held> heldIn(const QuadMesh& mesh) {
  std::vector<Held> held;
  if (mesh.creases.empty()) return held;
  const QuadTopology topology(mesh);
  std::vector<bool> corner(mesh.positions.size());
  for (const uint32_t v : mesh.corners) corner[v] = true;
  for (uint32_t v = 0; v < corner.size(); ++v)
    if (corner[v] || topology.creasesAt(v) != 0) held.push_back({v, corner[v]});
  return held;
}

// A place of a quad: its weights of the corners, how far it lies off, and which way.
struct Off {
  uint32_t quad = UINT32_MAX;  // none where what is nearest faces the other way
  std::array<double, 4> weights{};
  Vec3d normal = Vec3d::Zero();
  double mm = 0;
};

// On the two triangles of a quad; `turned`: along its other diagonal. At the end its corners.
std::array<double, 4> weightsOf(size_t place, bool turned) {
  if (place >= kWithin) {
    std::array<double, 4> weights{};
    weights[place - kWithin] = 1;
    return weights;
  }
  double u = kPlaces[place % kPlaces.size()], v = kPlaces[place / kPlaces.size()];
  if (turned) std::tie(u, v) = std::pair(v, 1 - u);
  const double least = std::min(u, v);
  const std::array<double, 4> weights{1 - std::max(u, v), u - least, least, v - least};
  if (turned) return {weights[3], weights[0], weights[1], weights[2]};
  return weights;
}

std::vector<Off> offOf(const QuadMesh& mesh, bool corners, const TriangleMesh& surface, const NearestTriangle& tree,
                       int threads) {
  const size_t ofQuad = corners ? kOfQuad : kWithin;
  std::vector<Off> out(ofQuad * mesh.quads.size());
  parallelBlocks(
      mesh.quads.size(), threads,
      [&](size_t begin, size_t end) {
        uint32_t hint = UINT32_MAX;
        for (size_t f = begin; f < end; ++f) {
          const auto& q = mesh.quads[f];
          const bool turned = trianglesOf(std::array{mesh.positions[q[0]], mesh.positions[q[1]], mesh.positions[q[2]],
                                                     mesh.positions[q[3]]})[0][0] != 0;
          for (size_t k = 0; k < ofQuad; ++k) {
            const std::array<double, 4> weights = weightsOf(k, turned);
            Vec3d p = Vec3d::Zero();
            for (size_t c = 0; c < 4; ++c) p += weights[c] * mesh.positions[q[c]];
            hint = tree.nearest(p, hint).triangle;
            const auto& t = tree.corners(hint);
            const Vec3d &a = surface.positions[t[0]], &b = surface.positions[t[1]], &c = surface.positions[t[2]];
            const Vec3d way = p - nearestOnTriangle(p, a, b, c), face = (b - a).cross(c - a).normalized();
            // Off an edge or a corner the way itself is the normal.
            const double length = way.norm();
            const bool outside = way.dot(face) > 0;
            const Vec3d normal = length > kOnIt ? Vec3d((outside ? 1 : -1) / length * way) : face;
            out[ofQuad * f + k] = {static_cast<uint32_t>(f), weights, normal, outside ? length : -length};
          }
        }
      },
      kBlock);
  return out;
}

// Of its vertices, by area, not of length 1.
std::vector<Vec3d> normalsOf(const TriangleMesh& mesh) {
  std::vector<Vec3d> normals(mesh.positions.size(), Vec3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Vec3d& a = mesh.positions[t[0]];
    const Vec3d normal = (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a);
    for (const uint32_t v : t) normals[v] += normal;
  }
  return normals;
}

// The places that are nearest to vertices of the surface, each of `step`.
void addNearest(const QuadMesh& mesh, const TriangleMesh& surface, const std::vector<Vec3d>& normals, size_t step,
                int threads, std::vector<Off>& out) {
  const TriangleMesh triangles = trianglesOf(mesh);
  const NearestTriangle tree(triangles);
  const size_t first = out.size();
  out.resize(first + (surface.positions.size() + step - 1) / step);
  parallelBlocks(
      out.size() - first, threads,
      [&](size_t begin, size_t end) {
        uint32_t hint = UINT32_MAX;
        for (size_t i = begin; i < end; ++i) {
          const Vec3d& p = surface.positions[i * step];
          hint = tree.nearest(p, hint).triangle;
          const uint32_t triangle = tree.indexOf(hint);
          const auto& t = triangles.triangles[triangle];
          const Vec3d &a = mesh.positions[t[0]], ab = mesh.positions[t[1]] - a, ac = mesh.positions[t[2]] - a;
          const Vec3d face = ab.cross(ac), foot = nearestOnTriangle(p, a, a + ab, a + ac), way = foot - p;
          if (face.squaredNorm() == 0 || face.dot(normals[i * step]) < 0) continue;
          const double s = (foot - a).cross(ac).dot(face) / face.squaredNorm(),
                       r = ab.cross(foot - a).dot(face) / face.squaredNorm(), length = way.norm();
          const auto& quad = mesh.quads[triangle / 2];
          const auto weight = [&](uint32_t v) { return v == t[0] ? 1 - s - r : v == t[1] ? s : v == t[2] ? r : 0; };
          out[first + i] = {triangle / 2,
                            {weight(quad[0]), weight(quad[1]), weight(quad[2]), weight(quad[3])},
                            length > kOnIt ? Vec3d(way / length) : face.normalized(),
                            length};
        }
      },
      kBlock);
}

// What the places of a quad want of its corners: least squares.
using Block = Eigen::Matrix<double, 12, 12>;
using Side = Eigen::Matrix<double, 12, 1>;

// Moves of all vertices that are best for all quads: conjugate gradients, preconditioned by the block of each vertex.
// Each vertex is held by places near it, so that some twenty steps do; a factorised matrix took longer than all else.
Eigen::VectorXd solved(const QuadMesh& mesh, const std::vector<Block>& blocks, const std::vector<Side>& sides,
                       const std::vector<Held>& held) {
  const auto at = [](uint32_t vertex) { return 3 * static_cast<Eigen::Index>(vertex); };
  const auto unknowns = static_cast<Eigen::Index>(3 * mesh.positions.size());
  Eigen::VectorXd move = Eigen::VectorXd::Zero(unknowns), rest = move, pull = move, better = move;
  std::vector<Eigen::Matrix3d> inverse(mesh.positions.size(), Eigen::Matrix3d(kOnIt * Eigen::Matrix3d::Identity()));
  for (size_t f = 0; f < blocks.size(); ++f)
    for (int c = 0; c < 4; ++c) {
      const uint32_t v = mesh.quads[f][size_t(c)];
      rest.segment<3>(at(v)) += sides[f].segment<3>(3 * c);
      inverse[v] += blocks[f].block<3, 3>(3 * c, 3 * c);
    }
  for (const Held& each : held) inverse[each.vertex] += each.ways;
  for (Eigen::Matrix3d& each : inverse) each = each.llt().solve(Eigen::Matrix3d::Identity()).eval();
  const auto apply = [&](const Eigen::VectorXd& way) {
    pull.setZero();
    Side x;
    for (size_t f = 0; f < blocks.size(); ++f) {
      const auto& quad = mesh.quads[f];
      for (int c = 0; c < 4; ++c) x.segment<3>(3 * c) = way.segment<3>(at(quad[size_t(c)]));
      const Side y = blocks[f] * x;
      for (int c = 0; c < 4; ++c) pull.segment<3>(at(quad[size_t(c)])) += y.segment<3>(3 * c);
    }
    for (const Held& each : held) pull.segment<3>(at(each.vertex)) += each.ways * way.segment<3>(at(each.vertex));
  };
  const auto precondition = [&] {
    for (uint32_t v = 0; v < inverse.size(); ++v) better.segment<3>(at(v)) = inverse[v] * rest.segment<3>(at(v));
    return rest.dot(better);
  };
  double size = precondition();
  const double first = size;
  Eigen::VectorXd way = better;
  for (int step = 0; step < kSteps && size > kSolved * first && size > 0; ++step) {
    apply(way);
    const double length = size / way.dot(pull);
    move += length * way;
    rest -= length * pull;
    const double next = precondition();
    way = better + (next / size) * way;
    size = next;
  }
  return move;
}

// Moves of vertices become shorter around quads that they would fold, until none is worse than it was or than a quad
// may be.
void keepShape(QuadMesh& mesh, const std::vector<Vec3d>& before) {
  std::vector<double> worst(mesh.quads.size());
  const std::vector<Vec3d> wanted = std::exchange(mesh.positions, before);
  for (size_t f = 0; f < worst.size(); ++f) worst[f] = std::min(kLeastJacobian, scaledJacobian(mesh, mesh.quads[f]));
  mesh.positions = wanted;
  std::vector<int> halves(wanted.size(), 0);
  for (bool again = true; again;) {
    again = false;
    std::vector<bool> shorter(wanted.size());
    for (size_t f = 0; f < worst.size(); ++f)
      if (scaledJacobian(mesh, mesh.quads[f]) < worst[f])
        for (const uint32_t v : mesh.quads[f]) shorter[v] = true;
    for (size_t v = 0; v < wanted.size(); ++v) {
      if (!shorter[v] || halves[v] > kHalves) continue;
      again = true;
      const double share = ++halves[v] > kHalves ? 0 : std::ldexp(1.0, -halves[v]);
      mesh.positions[v] = before[v] + share * (wanted[v] - before[v]);
    }
  }
}

}  // namespace

void fitQuads(QuadMesh& mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
              int threads, const WorkPart& part, bool corners) {
  std::vector<Held> held = heldIn(mesh);
  const size_t step = std::max<size_t>(1, surface.positions.size() / std::max(kOfSurface, kWithin * mesh.quads.size()));
  const std::vector<Vec3d> normals = normalsOf(surface);
  for (int round = 0; round < kRounds; ++round) {
    part.step(double(round) / kRounds);
    std::vector<Off> off = offOf(mesh, corners, surface, tree, threads);
    const size_t forth = off.size();
    addNearest(mesh, surface, normals, step, threads, off);
    const double backWeight = double(forth) / double(off.size() - forth);
    double far = 0;
    for (size_t i = 0; i < off.size(); ++i)
      far += 0.5 * (i < forth ? 1 : backWeight) * off[i].mm * off[i].mm / double(forth);
    far = std::max(kOnIt, kFar * std::sqrt(far));
    std::vector<Block> blocks(mesh.quads.size(), Block::Zero());
    std::vector<Side> sides(mesh.quads.size(), Side::Zero());
    for (size_t i = 0; i < off.size(); ++i) {
      const Off& each = off[i];
      if (each.quad == UINT32_MAX) continue;
      const double weight = (i < forth ? 1 : backWeight) * std::clamp(std::abs(each.mm) / far, 1.0, kMostFar);
      Side row;
      for (int c = 0; c < 4; ++c) row.segment<3>(3 * c) = each.weights[size_t(c)] * each.normal;
      blocks[each.quad] += weight * row * row.transpose();
      sides[each.quad] -= weight * each.mm * row;
      for (int c = 0; c < 4; ++c)
        blocks[each.quad].block<3, 3>(3 * c, 3 * c) +=
            weight * each.weights[size_t(c)] *
            (kAlong * (Eigen::Matrix3d::Identity() - each.normal * each.normal.transpose()) +
             kStay * Eigen::Matrix3d::Identity());
    }
    for (Held& each : held) {
      each.ways = kHeld * Eigen::Matrix3d::Identity();
      if (each.corner) continue;
      const Vec3d along = creases.nearest(mesh.positions[each.vertex], each.hint).along;
      each.ways -= kHeld * along * along.transpose();
    }
    const Eigen::VectorXd move = solved(mesh, blocks, sides, held);
    const std::vector<Vec3d> before = mesh.positions;
    for (size_t v = 0; v < mesh.positions.size(); ++v)
      mesh.positions[v] += move.segment<3>(3 * static_cast<Eigen::Index>(v));
    for (Held& each : held) {
      Vec3d& at = mesh.positions[each.vertex];
      const Vec3d way = move.segment<3>(3 * static_cast<Eigen::Index>(each.vertex));
      if (each.corner)
        at -= way;
      else if (const CreaseMap::Hit hit = creases.nearest(at, each.hint); hit.squared < way.squaredNorm())
        at = hit.mm;  // in a gap that was bridged there is no crease near by
    }
    keepShape(mesh, before);
  }
}

}  // namespace argil::clay
