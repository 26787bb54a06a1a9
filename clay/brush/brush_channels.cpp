// Colour, material and mask under a stamp.

#include "clay/brush/brush_channels.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "clay/brush/brush_method.h"
#include "clay/kernels/paint_kernels.h"
#include "clay/store/brick_margins.h"
#include "clay/store/channel_blur.h"

namespace argil::clay {

namespace {

// Least share that moves a byte at all: less is the rim of a falloff.
constexpr float kLeastShare = 1.0f / 255;

void set(const Brush& brush, const Operation& operation, float share, ChannelBytes& bytes) {
  const bool erase = operation.amount < 0;
  switch (operation.property) {
    case Property::colour:
      if (!erase) return layColour(bytes, brush.colour, share);
      bytes[indexOf(Channel::cover)] = approach(bytes[indexOf(Channel::cover)], 0, share);
      if (bytes[indexOf(Channel::cover)] == 0) bytes[0] = bytes[1] = bytes[2] = 0;
      return;
    case Property::material:
      if (share > 0.5f) bytes[indexOf(Channel::material)] = erase ? uint8_t{0} : brush.material;
      return;
    case Property::mask:
      bytes[indexOf(Channel::mask)] = approach(bytes[indexOf(Channel::mask)], erase ? 0 : 255, share);
      return;
    case Property::distance:
      return;
  }
}

}  // namespace

uint8_t approach(uint8_t from, uint8_t to, float share) noexcept {
  if (from == to || !(share >= kLeastShare)) return from;
  const int way = std::abs(int{to} - int{from});
  const int step = std::clamp(static_cast<int>(static_cast<float>(way) * share + 0.5f), 1, way);
  return static_cast<uint8_t>(to > from ? from + step : from - step);
}

void layColour(ChannelBytes& bytes, const std::array<uint8_t, 3>& colour, float alpha) noexcept {
  if (!(alpha >= kLeastShare)) return;
  uint8_t& cover = bytes[indexOf(Channel::cover)];
  if (cover == 255 && std::equal(colour.begin(), colour.end(), bytes.begin())) return;
  // What the new layer makes of the whole that covers the piece.
  const float whole = static_cast<float>(cover) + (255.0f - static_cast<float>(cover)) * alpha;
  const float share = std::min(alpha * 255.0f / whole, 1.0f);
  for (size_t i = 0; i < 3; ++i) {
    uint8_t& mine = bytes[indexOf(kColourChannels[i])];
    mine = cover == 0 ? colour[i] : approach(mine, colour[i], share);
  }
  cover = approach(cover, 255, alpha);
}

std::vector<Coord> surfaceBricks(const Editor& editor, std::span<const Stamp> images,
                                 const std::function<double(const Stamp&)>& reach) {
  std::vector<Coord> all;
  for (const Stamp& s : images) {
    const double margin = reach(s);
    // Of bricks with a voxel in the box, so that mirrored stamps choose mirrored ones.
    const auto brickOf = [](const Vec3d& p) {
      return Coord{static_cast<int32_t>(p.x()), static_cast<int32_t>(p.y()), static_cast<int32_t>(p.z())};
    };
    const Coord first = brickOf(((s.a.cwiseMin(s.b).array() - margin - 7) / kBrickEdge).ceil()),
                last = brickOf(((s.a.cwiseMax(s.b).array() + margin) / kBrickEdge).floor());
    const auto near = [&](Coord brick, double half, double diagonal) {
      return segmentDistance(s, (brick * kBrickEdge).toVec3d() + Vec3d::Constant(half)) - diagonal < margin;
    };
    for (int rx = first.x >> 3; rx <= last.x >> 3; ++rx)
      for (int ry = first.y >> 3; ry <= last.y >> 3; ++ry)
        for (int rz = first.z >> 3; rz <= last.z >> 3; ++rz) {
          const Coord region = Coord{rx, ry, rz} * 8;
          if (!near(region, 31.5, kRegionHalfDiagonal)) continue;
          for (int x = std::max(first.x, region.x); x <= std::min(last.x, region.x + 7); ++x)
            for (int y = std::max(first.y, region.y); y <= std::min(last.y, region.y + 7); ++y)
              for (int z = std::max(first.z, region.z); z <= std::min(last.z, region.z + 7); ++z)
                if (!editor.find(Coord{x, y, z}).isTile() && near({x, y, z}, 3.5, kHalfDiagonal))
                  all.push_back({x, y, z});
        }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

namespace {

// Weights of an application's stamps at the voxels of a brick, and how far within the stamps each voxel's part of the
// surface lies.
struct StampWeights {
  float weight[kBrickVoxels] = {}, cover[kBrickVoxels] = {};
};

// Taken at the feet of the voxels on the surface, so that a stroke's border does not follow the voxels.
void weighOnSurface(Sampler& field, const Brush& brush, Falloff shape, std::span<const Stamp> images, Coord coord,
                    StampWeights& out) {
  float padded[kPaddedSize] = {}, foot[3 * kBrickVoxels];
  gatherPadded(field, coord, padded);
  surfaceFeet(padded, field.band(), foot);
  for (const Stamp& each : images)
    paintWeights(sweptBall(each, coord), static_cast<int>(shape), each.strength, foot, out.weight, out.cover);
  moreByStamp(static_cast<float>(brush.perStamp), out.weight);
}

// Blends towards what is around it: where each voxel is.
void weighAtVoxels(const Brush& brush, Falloff shape, std::span<const Stamp> images, Coord coord, StampWeights& out) {
  imageWeights(images, shape, coord, static_cast<float>(brush.perStamp), out.weight);
  std::fill(std::begin(out.cover), std::end(out.cover), 1.0f);
}

// The share by which a voxel goes on towards what is laid, of which `laid` is there: stamps add up, and no more of them
// than what they cover. Below kLeastShare nothing changes.
float shareOf(float weight, float cover, float& laid) {
  const float goal = std::min(laid + (1 - laid) * weight, cover), share = (goal - laid) / (1 - laid);
  if (!(share >= kLeastShare)) return 0;
  laid = goal;
  return share;
}

}  // namespace

void applyToChannels(Editor& editor, const Brush& brush, const Operation& operation, std::span<const Stamp> images,
                     LaidShares& laid) {
  const bool masks = editor.has(Channel::mask) && operation.property != Property::mask,
             blurs = operation.method == Method::blur, addsUp = !blurs && operation.property != Property::material;
  const float amount = std::abs(operation.amount);
  const double rim = blurs ? 0 : static_cast<double>(kPaintRim) / 2;
  ChannelReader<Editor> clay(editor);
  Sampler field(editor);
  ChannelBlur blur;
  std::deque<std::pair<Coord, ChannelBlock>> changed;
  for (const Coord coord : surfaceBricks(editor, images, [&](const Stamp& s) { return s.largestRadius() + rim; })) {
    const ChannelPlace& place = clay.at(coord);
    if (masks && place.channel[indexOf(Channel::mask)] == ChannelSlot(true)) continue;
    StampWeights stamps;
    if (blurs)
      weighAtVoxels(brush, operation.shape, images, coord, stamps);
    else
      weighOnSurface(field, brush, operation.shape, images, coord, stamps);
    const auto least = [&](float w) { return w * amount < kLeastShare; };
    if (std::all_of(std::begin(stamps.weight), std::end(stamps.weight), least)) continue;
    if (blurs && !blur.gather(clay, coord, operation.property == Property::colour)) continue;
    ChannelBlock& block = changed.emplace_back(coord, place).second;
    float* before = addsUp ? laid.of(operation.property, coord) : nullptr;
    uint64_t inBand[kBrickEdge];
    place.inBand(clay.band(), inBand);
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (!((inBand[i >> 6] >> (i & 63)) & 1)) continue;
      float share = stamps.weight[i] * amount;
      if (masks) share *= static_cast<float>(255 - block[Channel::mask][i]) / 255.0f;
      if (before)
        share = shareOf(share, stamps.cover[i], before[i]);
      else
        share = std::min(share, stamps.cover[i]);
      if (!(share >= kLeastShare)) continue;
      ChannelBytes bytes = block.bytes(i);
      if (blurs)
        blur.apply(i, share, bytes);
      else
        set(brush, operation, share, bytes);
      block.set(i, bytes);
    }
  }
  for (const auto& [coord, block] : changed) block.storeChanged(editor, coord);
}

}  // namespace argil::clay
