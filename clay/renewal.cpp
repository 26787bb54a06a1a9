#include "clay/renewal.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "clay/shaping_kernels.h"
#include "clay/warp_kernels.h"

namespace argil::clay {
namespace {

// Squares of cosines between the slopes at a voxel and at its foot: to be a foot at all, and to be that of a smooth surface; how near to zero the foot has to be, voxels.
constexpr float kFacing = 0.8f, kSmooth = 0.99f, kFound = 0.1f;
// As in redistance().
constexpr int kPasses = 6;

constexpr Coord kFaces[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

struct Work {
  float u[2][kWideSize];
  uint64_t frozen[kBrickEdge];
  Slot source;
  ptrdiff_t beside[6];  // index of the neighbour across each face; −1: not among them
  bool changed = true;
};

// Follows the field to where it is zero, from voxels beside it; `u` where that goes well.
void distancesOfFeet(const float* broad, const uint64_t* frozen, float least, float* u) {
  constexpr int kX = 16 * kBroadRow, kY = kBroadRow;
  FieldSample samples[kBrickVoxels];
  FieldValue values[kBrickVoxels];
  Vec3f way[kBrickVoxels], slope[kBrickVoxels];
  int voxels[kBrickVoxels];
  size_t count = 0;
  const auto place = [&](int i, const Vec3f& step, Vec3f& moved, FieldSample& sample) {
    const int voxel[3] = {i >> 6, (i >> 3) & 7, i & 7};
    int base[3];
    float t[3];
    for (int k = 0; k < 3; ++k) {
      const float whole = std::nearbyint(step[k]), rest = (step[k] - whole + 192.0f) - 192.0f;
      base[k] = voxel[k] + static_cast<int>(whole) + (rest < 0 ? -1 : 0);
      t[k] = rest < 0 ? rest + 1 : rest;
      moved[k] = whole + rest;
    }
    sample = {broad + broadOffset(base[0] + 3, base[1] + 3, base[2] + 3), t[0], t[1], t[2]};
  };
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (!((frozen[i >> 6] >> (i & 63)) & 1)) continue;
    const float* at = broad + broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4);
    if (std::abs(*at) < least) continue;
    const Vec3f g(0.5f * (at[kX] - at[-kX]), 0.5f * (at[kY] - at[-kY]), 0.5f * (at[1] - at[-1]));
    const float squared = (g.x() * g.x() + g.y() * g.y()) + g.z() * g.z();
    if (!(squared > 0.04f)) continue;
    // At a crease of true distances both sides of a voxel differ, and what is there is right.
    float slopes2 = 0;
    bool kink = false;
    for (const int axis : {kX, kY, 1}) {
      const float down = std::abs(*at - at[-axis]), up = std::abs(at[axis] - *at), most = std::max(down, up);
      kink = kink || std::abs(up - down) > 0.5f;
      slopes2 += most * most;
    }
    if (kink && slopes2 > 0.7f && slopes2 < 2.2f) continue;
    const float by = -*at / squared;
    const Vec3f step(by * g.x(), by * g.y(), by * g.z());
    if (!(std::abs(step.x()) <= 1.75f && std::abs(step.y()) <= 1.75f && std::abs(step.z()) <= 1.75f)) continue;
    slope[count] = g;
    voxels[count] = i;
    place(i, step, way[count], samples[count]);
    ++count;
  }
  sampleField(std::span(samples, count), kX, kY, values);
  for (size_t n = 0; n < count; ++n) {
    const FieldValue& v = values[n];
    const int i = voxels[n];
    const float squared = (v.x * v.x + v.y * v.y) + v.z * v.z;
    const Vec3f& g = slope[n];
    const float was2 = (g.x() * g.x() + g.y() * g.y()) + g.z() * g.z(), facing = (g.x() * v.x + g.y() * v.y) + g.z() * v.z;
    if (!(squared > 0.04f) || !(facing > 0) || facing * facing < kFacing * (was2 * squared)) continue;
    const float d = (v.value - ((way[n].x() * v.x + way[n].y() * v.y) + way[n].z() * v.z)) / std::sqrt(squared);
    const float phi = broad[broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4)];
    if ((d < 0) != (phi < 0) || !(std::abs(d) < 1.5f)) continue;
    // Where the surface bends within a voxel or two the cubic's is not quite the one that is drawn: there what is nearly right stays, or it would wander.
    const bool smooth = facing * facing >= kSmooth * (was2 * squared) && v.value * v.value < kFound * kFound * squared;
    if (smooth || std::abs(d - phi) >= kSlopeTolerance) u[paddedOffset((i >> 6) + 1, ((i >> 3) & 7) + 1, (i & 7) + 1)] = std::abs(d);
  }
}

// Of a brick its values and four around them.
void gatherBroad(Sampler& field, Coord coord, float* broad) {
  for (int i = 0; i < 27; ++i) {
    const int side[3] = {i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
    int begin[3], end[3];
    for (int k = 0; k < 3; ++k) {
      begin[k] = side[k] < 0 ? 0 : side[k] == 0 ? 4 : 12;
      end[k] = side[k] < 0 ? 4 : side[k] == 0 ? 12 : 16;
    }
    const Slot slot = field.slot(coord + Coord{side[0], side[1], side[2]});
    const float flat = slot.isTile() ? slot.phi(0, field.band()) : 0;
    for (int x = begin[0]; x < end[0]; ++x)
      for (int y = begin[1]; y < end[1]; ++y) {
        float* row = broad + broadOffset(x, y, begin[2]);
        if (slot.isTile())
          std::fill_n(row, end[2] - begin[2], flat);
        else
          slot.brick()->read(Brick::offset((x + 4) & 7, (y + 4) & 7, (begin[2] + 4) & 7), end[2] - begin[2], row, field.step());
      }
  }
}

void copyLayers(const float* from, float* to, int axis, bool positive) {
  const int source = positive ? 8 : 2, target = positive ? 0 : 10;
  for (int layer = 0; layer < 2; ++layer)
    for (int i = 2; i < 10; ++i) {
      if (axis == 2) {
        for (int j = 2; j < 10; ++j) to[wideOffset(i, j, target + layer)] = from[wideOffset(i, j, source + layer)];
        continue;
      }
      const int t = axis == 0 ? wideOffset(target + layer, i, 2) : wideOffset(i, target + layer, 2);
      const int f = axis == 0 ? wideOffset(source + layer, i, 2) : wideOffset(i, source + layer, 2);
      std::memcpy(to + t, from + f, kBrickEdge * sizeof(float));
    }
}

}  // namespace

std::vector<Coord> renewDistances(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew) {
  Sampler field(editor);
  const float band = editor.grid().band;
  const bool masks = editor.has(Channel::mask);
  const size_t count = coords.size();
  static thread_local std::unique_ptr<Work[]> scratch;
  static thread_local size_t capacity = 0;
  if (capacity < count) {
    capacity = std::max(count, 2 * capacity);
    scratch = std::make_unique_for_overwrite<Work[]>(capacity);
  }
  const std::span<Work> works(scratch.get(), count);
  for (size_t i = 0; i < count; ++i) {
    Work& w = works[i];
    w.changed = true;
    w.source = editor.find(coords[i]);
    for (int face = 0; face < 6; ++face) {
      const auto it = std::lower_bound(coords.begin(), coords.end(), coords[i] + kFaces[face]);
      w.beside[face] = it != coords.end() && *it == coords[i] + kFaces[face] ? it - coords.begin() : -1;
    }
    float broad[kBroadSize] = {}, padded[kPaddedSize] = {}, near[kPaddedSize];
    gatherBroad(field, coords[i], broad);
    for (int x = 0; x < 10; ++x)
      for (int y = 0; y < 10; ++y) std::copy_n(broad + broadOffset(x + 3, y + 3, 3), 10, padded + paddedOffset(x, y, 0));
    startDistance(padded, band, w.frozen, near);
    if (renew[i] != Renew::none) {
      const float least = renew[i] == Renew::impossible ? 1.0f : 0.0f;
      float sloped[kPaddedSize];
      std::copy_n(near, kPaddedSize, sloped);
      renewNearDistance(padded, w.frozen, least, sloped);
      for (int at = 0; at < kPaddedSize; ++at)
        if (std::abs(sloped[at] - near[at]) >= kSlopeTolerance) near[at] = sloped[at];
      distancesOfFeet(broad, w.frozen, least, near);
    }
    if (masks) {
      const ChannelSlot mask = editor.find(Channel::mask, coords[i]);
      for (int v = 0; mask != ChannelSlot() && v < kBrickVoxels; ++v) {
        if (mask.value(v) != 255) continue;
        w.frozen[v >> 6] |= uint64_t{1} << (v & 63);
        const int at = paddedOffset((v >> 6) + 1, ((v >> 3) & 7) + 1, (v & 7) + 1);
        near[at] = std::abs(padded[at]);
      }
    }
    for (int x = 0; x < 12; ++x)
      for (int y = 0; y < 12; ++y)
        for (int z = 0; z < 12; ++z) {
          const float phi = broad[broadOffset(x + 2, y + 2, z + 2)];
          w.u[0][wideOffset(x, y, z)] = std::abs(phi) < band ? phi : phi < 0 ? -kUnknownDistance : kUnknownDistance;
        }
    for (int v = 0; v < kBrickVoxels; ++v) {
      const int x = v >> 6, y = (v >> 3) & 7, z = v & 7;
      const float u = ((w.frozen[x] >> (v & 63)) & 1) ? near[paddedOffset(x + 1, y + 1, z + 1)] : kUnknownDistance;
      w.u[0][wideOffset(x + 2, y + 2, z + 2)] = padded[paddedOffset(x + 1, y + 1, z + 1)] < 0 ? -u : u;
    }
    std::copy_n(w.u[0], kWideSize, w.u[1]);
  }
  const auto pull = [&](Work& w, int which) {
    for (int face = 0; face < 6; ++face)
      if (w.beside[face] >= 0) copyLayers(works[static_cast<size_t>(w.beside[face])].u[which], w.u[which], face / 2, face % 2 == 0);
  };
  for (int which = 0; which < 2; ++which)
    for (Work& w : works) pull(w, which);
  int now = 0;
  for (int pass = 0; pass < kPasses; ++pass, now ^= 1) {
    for (Work& w : works) w.changed = widePass(w.u[now], w.frozen, band, w.u[now ^ 1]);
    for (Work& w : works) pull(w, now ^ 1);
  }
  BrickValues room;
  std::vector<Coord> changed;
  for (size_t i = 0; i < count; ++i) {
    const Work& w = works[i];
    float solved[kPaddedSize] = {};
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < 8; ++z) solved[paddedOffset(x + 1, y + 1, z + 1)] = std::min(std::abs(w.u[now][wideOffset(x + 2, y + 2, z + 2)]), band);
    FloatBrick* brick = editor.newBrick(coords[i]);
    const float* phi = w.source.values(room, band);
    const BrickChange change = settleDistance(phi, solved, band, renew[i] == Renew::none ? kRedistanceTolerance : kRenewTolerance, *brick);
    if (!change.changed) {
      editor.recycle(brick);
      continue;
    }
    editor.link(brick, change.inBand);
    changed.push_back(coords[i]);
  }
  return changed;
}

}  // namespace argil::clay
