#include "clay/field/renewed_block.h"

#include <algorithm>
#include <cmath>

#include "clay/field/settle.h"
#include "clay/store/brick_margins.h"
#include "clay/store/channel_source.h"

namespace argil::clay {

void RenewedBlock::begin(Coord block, float band) {
  first_ = block * kBlockEdge;
  band_ = band;
  fields_.clear();
  tiles_.clear();
  renewal_.reset();
}

float* RenewedBlock::add(Coord brick) {
  fields_.emplace_back();
  fields_.back().brick = brick;
  return fields_.back().phi.data();
}

void RenewedBlock::solve(Renew how, Sampler& beside, const Beside& instead, float known) {
  const auto before = [](const Field& a, const Field& b) { return a.brick < b.brick; };
  if (!std::is_sorted(fields_.begin(), fields_.end(), before)) std::sort(fields_.begin(), fields_.end(), before);
  std::vector<Coord> coords, solved;
  for (Field& field : fields_) {
    coords.push_back(field.brick);
    if (field.kept) continue;
    field.number = solved.size();
    solved.push_back(field.brick);
  }
  if (solved.empty()) return;
  const auto numbers = besideEach(coords, kAroundSteps);
  renewal_.reset();  // One at a time on a thread.
  renewal_.emplace(solved, band_, 1);
  float broad[kBroadSize] = {};
  for (size_t i = 0; i < fields_.size(); ++i) {
    if (fields_[i].kept) continue;
    std::array<const float*, kBricksAround> around{};
    for (size_t k = 0; k < kBricksAround; ++k) {
      if (const ptrdiff_t at = numbers[i][k]; at >= 0)
        around[k] = fields_[static_cast<size_t>(at)].phi.data();
      else if (instead)
        around[k] = instead(coords[i] + kAroundSteps[k]);
    }
    gatherBroad(beside, coords[i], 4, broad, around.data());
    renewal_->begin(fields_[i].number, broad, how, {}, known);
  }
  renewal_->run();
}

void RenewedBlock::put(Editor& editor, std::mutex& editing, const Paint& paint) {
  for (const auto& [brick, inside] : tiles_) {
    const Tile tile = inside ? Tile::inside : Tile::outside;
    const std::lock_guard lock(editing);
    if (editor.find(brick) != Slot(tile)) editor.setTile(brick, tile);
  }
  for (size_t i = 0; i < fields_.size(); ++i) {
    const Coord coord = fields_[i].brick;
    if (!holds(coord)) continue;
    FloatBrick* brick;
    {
      const std::lock_guard lock(editing);
      brick = editor.newBrick(coord);
    }
    BrickValues sizes;
    if (renewal_ && !fields_[i].kept)
      renewal_->sizes(fields_[i].number, sizes);
    else
      for (int v = 0; v < kBrickVoxels; ++v) sizes[v] = std::min(std::abs(fields_[i].phi[v]), band_);
    const bool inBand = settleDistance(fields_[i].phi.data(), sizes, band_, 0, *brick).inBand;
    ChannelBlock channels{ChannelPlace{}};
    try {
      if (paint && inBand) channels = paint(*brick, i);
    } catch (...) {
      const std::lock_guard lock(editing);
      editor.recycle(brick);
      throw;
    }
    const std::lock_guard lock(editing);
    editor.link(brick, inBand);
    if (!paint || !inBand) continue;
    channels.store(editor, coord);
    clearChannelsRoundedAway(editor, coord);
  }
  renewal_.reset();
}

RenewedBlock::Feet::Feet(const RenewedBlock& block, size_t number, Sampler* beside) {
  const Field& own = block.fields_[number];
  if (!own.kept) {
    block.renewal_->around(own.number, around_.data());
    return;
  }
  float broad[kBroadSize] = {};
  gatherBroad(*beside, own.brick, 2, broad);
  for (int x = 0; x < 12; ++x)
    for (int y = 0; y < 12; ++y)
      std::copy_n(broad + broadOffset(x + 2, y + 2, 2), 12, around_.data() + wideOffset(x, y, 0));
}

Vec3f RenewedBlock::Feet::way(int voxel) const {
  const float* at = around_.data() + wideOffset((voxel >> 6) + 2, ((voxel >> 3) & 7) + 2, (voxel & 7) + 2);
  constexpr int kSteps[3] = {12 * kWideRow, kWideRow, 1};
  const float own = std::abs(*at);
  Vec3f way = Vec3f::Zero();
  for (int k = 0; k < 3; ++k) {
    const float below = std::abs(at[-kSteps[k]]), above = std::abs(at[kSteps[k]]);
    if (const float nearer = std::min(below, above); nearer < own) way[k] = below < above ? nearer - own : own - nearer;
  }
  const float length = way.norm();
  return length > 0 ? Vec3f(way * (own / length)) : way;
}

}  // namespace argil::clay
