#include "clay/field/renewal.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "clay/kernels/warp_kernels.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {
namespace {

// Squares of cosines between the slopes at a voxel and at its foot: to be a foot at all, and to be that of a smooth
// surface; how near to zero the foot has to be, voxels.
constexpr float kFacing = 0.8f, kSmooth = 0.99f, kFound = 0.1f;

template <class Visit>
void forEachFrozen(const uint64_t* frozen, const Visit& visit) {
  for (int x = 0; x < kBrickEdge; ++x)
    for (uint64_t left = frozen[x]; left != 0; left &= left - 1) visit(64 * x + std::countr_zero(left));
}

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
    AxisPlace at[3];
    for (int k = 0; k < 3; ++k) {
      at[k] = placeOf(voxel[k], step[k]);
      moved[k] = static_cast<float>(at[k].base - voxel[k]) + at[k].t;
    }
    sample = {broad + broadOffset(at[0].base + 3, at[1].base + 3, at[2].base + 3), at[0].t, at[1].t, at[2].t};
  };
  forEachFrozen(frozen, [&](int i) {
    const float* at = broad + broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4);
    if (std::abs(*at) < least) return;
    const Vec3f g(0.5f * (at[kX] - at[-kX]), 0.5f * (at[kY] - at[-kY]), 0.5f * (at[1] - at[-1]));
    const float squared = (g.x() * g.x() + g.y() * g.y()) + g.z() * g.z();
    if (!(squared > 0.04f)) return;
    // At a crease of true distances both sides of a voxel differ, and what is there is right.
    float slopes2 = 0;
    bool kink = false;
    for (const int axis : {kX, kY, 1}) {
      const float down = std::abs(*at - at[-axis]), up = std::abs(at[axis] - *at), most = std::max(down, up);
      kink = kink || std::abs(up - down) > 0.5f;
      slopes2 += most * most;
    }
    if (kink && slopes2 > 0.7f && slopes2 < 2.2f) return;
    const float by = -*at / squared;
    const Vec3f step(by * g.x(), by * g.y(), by * g.z());
    if (!(std::abs(step.x()) <= 1.75f && std::abs(step.y()) <= 1.75f && std::abs(step.z()) <= 1.75f)) return;
    slope[count] = g;
    voxels[count] = i;
    place(i, step, way[count], samples[count]);
    ++count;
  });
  sampleField(std::span(samples, count), kX, kY, values);
  for (size_t n = 0; n < count; ++n) {
    const FieldValue& v = values[n];
    const int i = voxels[n];
    const float squared = (v.x * v.x + v.y * v.y) + v.z * v.z;
    const Vec3f& g = slope[n];
    const float was2 = (g.x() * g.x() + g.y() * g.y()) + g.z() * g.z(),
                facing = (g.x() * v.x + g.y() * v.y) + g.z() * v.z;
    if (!(squared > 0.04f) || !(facing > 0) || facing * facing < kFacing * (was2 * squared)) continue;
    const float d = (v.value - ((way[n].x() * v.x + way[n].y() * v.y) + way[n].z() * v.z)) / std::sqrt(squared);
    const float phi = broad[broadOffset((i >> 6) + 4, ((i >> 3) & 7) + 4, (i & 7) + 4)];
    if ((d < 0) != (phi < 0) || !(std::abs(d) < 1.5f)) continue;
    // Where the surface bends within a voxel or two the cubic's is not quite the one that is drawn: there what is
    // nearly right stays, or it would wander.
    const bool smooth = facing * facing >= kSmooth * (was2 * squared) && v.value * v.value < kFound * kFound * squared;
    if (smooth || std::abs(d - phi) >= kSlopeTolerance)
      u[paddedOffset((i >> 6) + 1, ((i >> 3) & 7) + 1, (i & 7) + 1)] = std::abs(d);
  }
}

}  // namespace

bool isAmongTiles(Sampler& field, Coord brick, Slot slot) {
  return slot.isTile() && std::all_of(kFaceSteps.begin(), kFaceSteps.end(),
                                      [&](Coord step) { return field.slot(brick + step) == slot; });
}

void Renewal::begin(size_t i, const float* broad, Renew how, ChannelSlot mask, float known) {
  float padded[kPaddedSize] = {}, near[kPaddedSize], wide[kWideSize];
  uint64_t frozen[kBrickEdge];
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 10; ++y) std::copy_n(broad + broadOffset(x + 3, y + 3, 3), 10, padded + paddedOffset(x, y, 0));
  startDistance(padded, band_, frozen, near);
  if (how != Renew::none) {
    const float least = how == Renew::impossible ? 1.0f : 0.0f;
    float sloped[kPaddedSize];
    std::copy_n(near, kPaddedSize, sloped);
    renewNearDistance(padded, frozen, least, sloped);
    forEachFrozen(frozen, [&](int voxel) {
      const int at = paddedOffset((voxel >> 6) + 1, ((voxel >> 3) & 7) + 1, (voxel & 7) + 1);
      if (std::abs(sloped[at] - near[at]) >= kSlopeTolerance) near[at] = sloped[at];
    });
    distancesOfFeet(broad, frozen, least, near);
  }
  holdMasked(mask, padded, frozen, near);
  for (int v = 0; v < kBrickVoxels && known > 0; ++v) {
    const int at = paddedOffset((v >> 6) + 1, ((v >> 3) & 7) + 1, (v & 7) + 1);
    if (std::abs(padded[at]) >= known) continue;
    frozen[v >> 6] |= uint64_t{1} << (v & 63);
    near[at] = std::abs(padded[at]);
  }
  startWide(broad, near, frozen, band_, wide);
  solver_.begin(i, wide, frozen);
}

void Renewal::beginUnknown(size_t i, Tile tile) {
  constexpr uint64_t kNone[kBrickEdge] = {};
  float wide[kWideSize];
  std::fill(std::begin(wide), std::end(wide), tile == Tile::inside ? -kUnknownDistance : kUnknownDistance);
  solver_.begin(i, wide, kNone, 0);
}

void Renewal::run(const Redistancing& options) {
  solver_.run(options.passesOf(band_), [&](const float* around, const uint64_t* frozen, uint64_t rows, float* out) {
    return widePass(around, frozen, rows, band_, out);
  });
}

void Renewal::sizes(size_t i, float* out) const {
  const float* u = solver_.values(i);
  for (int v = 0; v < kBrickVoxels; ++v) out[v] = std::min(std::abs(u[v]), band_);
}

std::vector<SettledBrick> renewDistances(const Sampler& before, Editor& editor, std::span<const Coord> coords,
                                         std::span<const Renew> renew, std::span<const uint8_t> wanted, int threads,
                                         const Redistancing& options) {
  const float band = editor.grid().band;
  const bool masks = editor.has(Channel::mask);
  std::vector<Slot> sources(coords.size());
  Renewal renewal(coords, band, threads);
  forBrickRanges(coords.size(), threads, [&](size_t begin, size_t end) {
    Sampler field = before;
    float broad[kBroadSize] = {};
    for (size_t i = begin; i < end; ++i) {
      const ChannelSlot mask = masks ? editor.find(Channel::mask, coords[i]) : ChannelSlot();
      sources[i] = field.slot(coords[i]);
      if (mask == ChannelSlot() && isAmongTiles(field, coords[i], sources[i])) {
        renewal.beginUnknown(i, sources[i].tile());
        continue;
      }
      gatherBroad(field, coords[i], 4, broad);
      renewal.begin(i, broad, renew[i], mask);
    }
  });
  renewal.run(options);
  return settleBricks(editor, coords, wanted, threads, [&](size_t i, FloatBrick& brick) {
    BrickValues solved, room;
    renewal.sizes(i, solved);
    const float most = options.toleranceOf(renew[i] == Renew::none ? Renew::none : Renew::all);
    return settleDistance(sources[i].values(room, band), solved, band, most, brick);
  });
}

}  // namespace argil::clay
