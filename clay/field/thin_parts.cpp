#include "clay/field/thin_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "clay/base/work_part.h"
#include "clay/field/settle.h"
#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

constexpr float kMeasured = 0.02f;  // voxels by which a thickness that voxels tell is off
// Voxels: a body or hole that a single voxel tells of is off by more, as distances are where surfaces are far on all
// sides.
constexpr float kAlone = 0.5f;
constexpr float kLeastSlope = 0.25f;
constexpr float kSteepestSlope = 1.05f;
constexpr float kNoSlope = 0.5f;     // voxels below a surface that runs along an axis
constexpr float kAlmost = 0.999f;    // of the band
constexpr float kAtSurface = 1e-3f;  // voxels: less is on the surface

Coord stepOf(int axis, int step) {
  return {axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
}
Coord voxelAt(Coord brick, int voxel) {
  return brick * kBrickEdge + Coord{voxel >> 6, (voxel >> 3) & 7, voxel & 7};
}
int offsetOf(Coord voxel) {
  return Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7);
}

// The side that `sign` makes positive, at one of its voxels, seen along an axis on which both neighbours lie on the
// other.
struct Thickness {
  float across;  // voxels, square to it
  float normal;  // along the axis: cosine to it
  float column;  // voxels³, in the column along the axis that is a voxel wide
};
std::optional<Thickness> thicknessAt(Sampler& field, Coord voxel, float own, int axis, float sign) {
  float ends = 0, slope = 0, column = 0;
  int known = 0;
  for (const int way : {-1, 1}) {
    const Coord step = stepOf(axis, way);
    const float phi = field.voxel(voxel + step), end = -sign * phi;
    // Zero is outside.
    if (sign > 0 ? phi >= 0 : phi < 0) return {};
    const float rise = -sign * field.voxel(voxel + step + step) - end;
    ends += end;
    column += own / std::max(own + end, kAtSurface);
    if (rise > kLeastSlope && rise <= kSteepestSlope) slope += rise, ++known;
  }
  const float normal = known == 0 ? 1 : std::min(slope / static_cast<float>(known), 1.0f);
  return Thickness{2 * normal - ends, normal, column};
}

}  // namespace

void ThinVoxels::add(Coord voxel, bool thin) {
  Marks& marks = bricks_[voxel >> kBrickBits];
  const int at = offsetOf(voxel);
  const uint64_t bit = uint64_t{1} << (at & 63);
  marks.all[static_cast<size_t>(at >> 6)] |= bit;
  if (thin) marks.thin[static_cast<size_t>(at >> 6)] |= bit;
}

void ThinVoxels::find(const Editor& editor, std::span<const Coord> bricks) {
  const float sign = becomes_ == Tile::inside ? 1 : -1;
  Sampler field(editor);
  BrickValues room;
  for (const Coord coord : bricks) {
    const Brick* brick = editor.find(coord).brick();
    if (brick == nullptr || (becomes_ == Tile::inside ? brick->anyOutside : brick->anyInside) == 0) continue;
    const BrickValues& phi = brick->values(room);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float own = sign * phi[v];
      if (!(own >= 0 && own < kThinnest) || (sign < 0 && own == 0)) continue;
      const Coord voxel = voxelAt(coord, v);
      std::optional<Thickness> across[3], thin;
      bool alone = true;
      for (int axis = 0; axis < 3; ++axis) {
        across[axis] = thicknessAt(field, voxel, own, axis, sign);
        alone &= across[axis].has_value();
      }
      const float most = alone ? kAlone : kThinnest + kMeasured;
      for (const std::optional<Thickness>& here : across)
        if (here && here->across < most && (!thin || here->normal > thin->normal)) thin = here;
      if (!thin) continue;
      add(voxel, true);
      volumes_[voxel] = thin->column;
    }
  }
}

std::vector<Coord> ThinVoxels::bricks() const {
  std::vector<Coord> coords;
  coords.reserve(bricks_.size());
  for (const auto& entry : bricks_) coords.push_back(entry.first);
  std::sort(coords.begin(), coords.end());
  return coords;
}

bool ThinVoxels::holds(Coord voxel) const {
  const auto at = bricks_.find(voxel >> kBrickBits);
  return at != bricks_.end() && clay::holds(at->second.all, offsetOf(voxel));
}

// Distances by which the side that the voxel comes to lie on is negative.
float ThinVoxels::settled(Sampler& field, Coord voxel, float own, bool thin) const {
  const float sign = becomes_ == Tile::inside ? 1 : -1, band = field.band();
  float nearest = -band;
  bool beside = false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int way : {-1, 1}) {
      const Coord step = stepOf(axis, way), next = voxel + step;
      const float phi = field.voxel(next);
      // A voxel on the surface counts with either side.
      if ((becomes_ == Tile::inside ? phi < 0 : phi >= kAtSurface) || holds(next)) continue;
      const float slope = holds(next + step) ? 1.0f : std::min(sign * (field.voxel(next + step) - phi), kSteepestSlope);
      // A surface that runs along the axis ends between both.
      nearest = std::max(nearest, sign * phi - (slope >= kLeastSlope ? slope : kNoSlope));
      beside = true;
    }
  }
  if (!beside) return -band;
  return thin ? nearest : std::min(own, nearest);
}

void ThinVoxels::settle(Editor& editor, ThinParts& gone) const {
  const float sign = becomes_ == Tile::inside ? 1 : -1;
  for (const Coord coord : bricks()) {
    const Marks& marks = bricks_.at(coord);
    BrickValues phi;
    editor.find(coord).read(phi, editor.grid().band);
    Sampler field(editor);
    for (size_t x = 0; x < marks.all.size(); ++x) {
      for (uint64_t left = marks.all[x]; left != 0; left &= left - 1) {
        const int v = static_cast<int>(x) * 64 + std::countr_zero(left);
        const bool thin = clay::holds(marks.thin, v);
        const Coord voxel = voxelAt(coord, v);
        const float value = settled(field, voxel, sign * phi[v], thin);
        if (thin) {
          // On the surface that lies there.
          if (value > -kAtSurface) continue;
          (sign > 0 ? gone.airVoxels : gone.clayVoxels) += 1;
          if (const auto volume = volumes_.find(voxel); volume != volumes_.end())
            (sign > 0 ? gone.airVolume : gone.clayVolume) += double(volume->second);
        }
        phi[v] = sign * value;
      }
    }
    // Beside a surface the brick is needed for distances to it; where there is none it goes with them.
    const float band = editor.grid().band;
    if (std::all_of(std::begin(phi), std::end(phi), [=](float each) { return std::abs(each) >= band; }))
      for (float& each : phi) each = std::copysign(kAlmost * band, each);
    editor.setVoxels(coord, phi);
  }
}

ThinParts removeThin(Editor& editor, std::span<const Coord> bricks, std::vector<Coord>& changed) {
  constexpr int kMostRounds = 4;  // what is left beside a film that went may be a crumb alone
  ThinParts gone;
  std::vector<Coord> touched;
  for (const Tile becomes : {Tile::outside, Tile::inside}) {
    for (int round = 0; round < kMostRounds; ++round) {
      ThinVoxels thin(becomes);
      const size_t before = gone.clayVoxels + gone.airVoxels;
      thin.find(editor, bricks);
      if (!thin.empty()) thin.settle(editor, gone);
      if (gone.clayVoxels + gone.airVoxels == before) break;
      const std::vector<Coord> own = thin.bricks();
      touched.insert(touched.end(), own.begin(), own.end());
    }
  }
  if (touched.empty()) return gone;
  const std::vector<Coord> around = bricksAround(editor, touched);
  redistanceAll(editor, around, WorkPart(nullptr), kExactTolerance);
  changed.insert(changed.end(), around.begin(), around.end());
  return gone;
}

}  // namespace argil::clay
