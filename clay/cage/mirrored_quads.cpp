#include "clay/cage/mirrored_quads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"

namespace argil::clay {

namespace {

constexpr size_t kFirstLook = 499;  // vertices: most clays are refused after these

// Which quads lie in the end of a half: parts between creases, none of whose vertices lies farther off. Nothing where
// another quad does.
std::optional<std::vector<bool>> inEnd(const QuadMesh& mesh, const EndPlane& end) {
  const QuadTopology topology(mesh);
  JoinedSets parts(mesh.quads.size());
  for (const auto& each : topology.edges())
    if (!each.crease) parts.join(each.quad[0], each.quad[1]);
  std::vector<bool> lies(mesh.quads.size()), all(mesh.quads.size(), true);
  for (uint32_t f = 0; f < mesh.quads.size(); ++f) {
    lies[f] = liesIn(mesh, mesh.quads[f], end);
    if (!lies[f]) all[parts.find(f)] = false;
  }
  for (uint32_t f = 0; f < mesh.quads.size(); ++f)
    if (lies[f] && !all[parts.find(f)]) return std::nullopt;
  return lies;
}

}  // namespace

std::optional<MirrorPlane> mirrorPlaneOf(const TriangleMesh& surface, const NearestTriangle& tree, double withinMm) {
  if (surface.positions.empty()) return std::nullopt;
  Eigen::AlignedBox3d box;
  for (const Vec3d& p : surface.positions) box.extend(p);
  for (int axis = 0; axis < 3; ++axis) {
    const MirrorPlane plane{axis, box.center()[axis]};
    uint32_t hint = UINT32_MAX;
    const auto lies = [&](const Vec3d& p) {
      const NearestTriangle::Hit hit = tree.nearest(plane.imageOf(p), hint);
      hint = hit.triangle;
      return hit.squared <= withinMm * withinMm;
    };
    bool all = true;
    const size_t count = surface.positions.size(), stride = std::max<size_t>(1, count / kFirstLook);
    for (size_t i = 0; i < count && all; i += stride) all = lies(surface.positions[i]);
    for (size_t i = 0; i < count && all; ++i) all = lies(surface.positions[i]);
    if (all) return plane;
  }
  return std::nullopt;
}

bool liesIn(const QuadMesh& mesh, const std::array<uint32_t, 4>& quad, const EndPlane& end) {
  return std::all_of(quad.begin(), quad.end(), [&](uint32_t v) { return end.has(mesh.positions[v]); });
}

void makeMirrored(QuadMesh& mesh, const std::vector<uint32_t>& image, const MirrorPlane& plane) {
  for (uint32_t v = 0; v < image.size(); ++v) {
    Vec3d& p = mesh.positions[v];
    if (image[v] == v) {
      p[plane.axis] = plane.atMm;
    } else if (v < image[v]) {
      Vec3d& other = mesh.positions[image[v]];
      p = 0.5 * (p + plane.imageOf(other));
      other = plane.imageOf(p);
    }
  }
}

std::optional<MirroredQuads> mirroredQuads(const QuadMesh& half, const EndPlane& end, const MirrorPlane& plane,
                                           const CreaseMap& creases) {
  const std::optional<std::vector<bool>> ends = inEnd(half, end);
  if (!ends) return std::nullopt;
  const std::vector<bool>& goes = *ends;
  const double nearMm = end.nearMm;
  const size_t count = half.positions.size();
  std::vector<size_t> kept(count, 0), gone(count, 0);  // quads at each vertex
  for (size_t f = 0; f < half.quads.size(); ++f)
    for (const uint32_t v : half.quads[f]) ++(goes[f] ? gone : kept)[v];

  MirroredQuads out;
  const auto isBorder = [&](uint32_t v) { return gone[v] > 0 && kept[v] > 0; };
  // A vertex of the border with one quad would have two: it goes, and the quad and its image become one.
  std::vector<uint32_t> number(count, UINT32_MAX);
  for (uint32_t v = 0; v < count; ++v) {
    if (kept[v] == 0 || (isBorder(v) && kept[v] == 1)) continue;
    number[v] = static_cast<uint32_t>(out.mesh.positions.size());
    out.image.push_back(number[v]);
    Vec3d p = half.positions[v];
    if (isBorder(v)) p[plane.axis] = plane.atMm;
    out.mesh.positions.push_back(p);
  }
  for (uint32_t v = 0; v < count; ++v) {
    if (number[v] == UINT32_MAX || isBorder(v)) continue;
    out.image[number[v]] = static_cast<uint32_t>(out.mesh.positions.size());
    out.image.push_back(number[v]);
    out.mesh.positions.push_back(plane.imageOf(half.positions[v]));
  }

  uint32_t hint = UINT32_MAX;
  const auto isCreaseInPlane = [&](uint32_t a, uint32_t b) {
    return !creases.empty() &&
           creases.nearest(0.5 * (half.positions[a] + half.positions[b]), hint).squared < nearMm * nearMm;
  };
  for (size_t f = 0; f < half.quads.size(); ++f) {
    if (goes[f]) continue;
    const auto& q = half.quads[f];
    std::array<uint32_t, 4> own{}, image{};
    int bits = half.creases.empty() || creases.empty() ? 0 : half.creases[f];
    int joined = -1;  // the corner that goes
    for (int s = 0; s < 4; ++s) {
      const uint32_t v = q[size_t(s)], next = q[(size_t(s) + 1) & 3];
      own[size_t(s)] = number[v];
      if (isBorder(v) && isBorder(next) && !isCreaseInPlane(v, next)) bits &= ~(1 << s);
      if (number[v] != UINT32_MAX) continue;
      const uint32_t across = number[q[(size_t(s) + 2) & 3]];
      if (joined >= 0 || across == UINT32_MAX || out.image[across] == across) return std::nullopt;
      own[size_t(s)] = out.image[across];
      joined = s;
    }
    if (std::all_of(own.begin(), own.end(), [&](uint32_t v) { return out.image[v] == v; })) return std::nullopt;
    if (joined >= 0) {
      // Its sides are now those away from that corner and their images; a crease along the others would be broken.
      const auto bit = [&](int s) { return bits >> (s & 3) & 1; };
      if (bit(joined) != 0 || bit(joined + 3) != 0) return std::nullopt;
      const int next = bit(joined + 1), last = bit(joined + 2);
      bits = 0;
      for (const auto& [s, crease] : {std::pair{0, next}, {1, next}, {2, last}, {3, last}})
        bits |= crease << ((joined + s) & 3);
    }
    out.mesh.quads.push_back(own);
    out.mesh.creases.push_back(static_cast<uint8_t>(bits));
    if (joined >= 0) continue;
    // The other way round: side s of the image is side 2 − s of the quad.
    int turned = 0;
    for (int s = 0; s < 4; ++s) {
      image[size_t(3 - s)] = out.image[own[size_t(s)]];
      turned |= (bits >> s & 1) << ((2 - s) & 3);
    }
    out.mesh.quads.push_back(image);
    out.mesh.creases.push_back(static_cast<uint8_t>(turned));
  }
  if (std::all_of(out.mesh.creases.begin(), out.mesh.creases.end(), [](uint8_t each) { return each == 0; }))
    out.mesh.creases.clear();
  for (const uint32_t v : half.corners) {
    if (number[v] == UINT32_MAX || out.mesh.creases.empty()) continue;
    const auto isCorner = [&](const Vec3d& corner) { return (corner - half.positions[v]).norm() < nearMm; };
    if (isBorder(v) && std::none_of(creases.corners().begin(), creases.corners().end(), isCorner)) continue;
    out.mesh.corners.push_back(number[v]);
    if (!isBorder(v)) out.mesh.corners.push_back(out.image[number[v]]);
  }
  try {
    (void)QuadTopology(out.mesh);
  } catch (const Error&) {
    return std::nullopt;
  }
  return out;
}

}  // namespace argil::clay
