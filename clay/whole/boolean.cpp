#include "clay/whole/boolean.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <utility>

#include "clay/field/redistance.h"
#include "clay/field/region_work.h"
#include "clay/field/settle.h"
#include "clay/field/thin_parts.h"
#include "clay/field/work_rooms.h"
#include "clay/kernels/shaping_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/store/channel_source.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/store/tree_view.h"
#include "clay/whole/resample.h"
#include "clay/whole/wedge.h"

namespace argil::clay {

namespace {

constexpr float kSlopeOff = 0.05f;  // what slopes of distances differ from 1 by away from edges
constexpr double kMostBlend = 100;  // voxels: regions are measured so far around
using MaterialMap = std::vector<uint8_t>;

uint8_t mapped(const MaterialMap& materials, uint8_t own) {
  return own < materials.size() ? materials[own] : own;
}

constexpr uint64_t kStepEvery = 256;  // bricks between two looks at the job

// All three are an intersection of solids, one or both of them and the result turned inside out.
class Combiner {
 public:
  Combiner(Editor& editor, const Version& b, Combination how, const MaterialMap& materials, const WorkPart& part)
      : editor_(editor),
        b_(b),
        materials_(materials),
        turnA_(how == Combination::join),
        turnB_(how != Combination::intersect),
        channels_(ChannelSource::any(editor.base())),
        channelsB_(ChannelSource::any(b)),
        facing_(turnA_ ? Tile::inside : Tile::outside),
        fieldA_(editor.base()),
        fieldB_(b),
        all_(std::max<uint64_t>(b.stats().bricks, 1)),
        part_(part) {}

  void combine(const TreePlace& a, const TreePlace& b) {
    if (outOfReach(b) || (a.isTile() && empty(a.tile(), turnA_))) return;
    if (b.isTile()) {
      takeTile(b);
      if (channels_ && empty(b.tile(), turnB_)) clearBelow(a);
      return;
    }
    if (a.isTile()) {
      copy(b);
    } else if (a.isNode()) {
      for (int i = 0; i < 512; ++i) combine(a.child(i), b.child(i));
    } else {
      mix(*a.brick(), *b.brick());
    }
  }

  /// Bricks with voxels whose distance was measured to what the other solid took away.
  [[nodiscard]] const std::vector<Coord>& creases() const { return creases_; }
  /// Where a seam ends, at another surface, distances do not tell that faces coincide; beside those that do they do.
  void growFacing() {
    std::vector<Coord> more;
    const float band = editor_.grid().band;
    facing_.forEach([&](Coord voxel) {
      for (const Coord step : kAroundSteps) {
        const float pa = turned(turnA_, fieldA_.voxel(voxel + step)), pb = turned(turnB_, fieldB_.voxel(voxel + step));
        if (std::abs(pa + pb) < kCoincident && std::abs(pa) < band && !facing_.holds(voxel + step))
          more.push_back(voxel + step);
      }
    });
    for (const Coord voxel : more) {
      const float value = std::max(turned(turnA_, fieldA_.voxel(voxel)), turned(turnB_, fieldB_.voxel(voxel)));
      facing_.add(voxel, turnA_ ? value <= 0 : value < 0);
    }
  }
  /// Tells whether a voxel is in the intersection, as far as that is not too thin.
  [[nodiscard]] bool isInside(Coord voxel) const {
    const float phi = editor_.find(voxel >> kBrickBits).phi(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7), 1);
    return turnA_ ? phi >= 0 : phi < 0;
  }
  /// Whether the distance that combine() gave a voxel is one to the new surface.
  [[nodiscard]] bool stands(Coord voxel) {
    const float band = editor_.grid().band;
    const float pa = turned(turnA_, fieldA_.voxel(voxel)), pb = turned(turnB_, fieldB_.voxel(voxel));
    if (facing_.holds(voxel)) return false;
    if (std::max(pa, pb) <= 0) return true;
    return standsOnSurface(
        voxel.toVec3d(), pa, pb, band,
        [&](int axis, int step) { return turned(turnA_, fieldA_.voxel(beside(voxel, axis, step))); },
        [&](int axis, int step) { return turned(turnB_, fieldB_.voxel(beside(voxel, axis, step))); },
        [&](const Vec3d& p) {
          const float value = std::max(turned(turnA_, fieldA_.trilinear(p)), turned(turnB_, fieldB_.trilinear(p)));
          if (value > band || anyInside(p, [&](Coord at) { return isInside(at); })) return value;
          fallen_.push_back(voxel >> kBrickBits);
          return band;
        });
  }
  /// Bricks where distances did not stand because what they were measured to is too thin, since it was asked last;
  /// sorted.
  [[nodiscard]] std::vector<Coord> takeFallen() {
    std::sort(fallen_.begin(), fallen_.end());
    fallen_.erase(std::unique(fallen_.begin(), fallen_.end()), fallen_.end());
    return std::exchange(fallen_, {});
  }
  /// Volume of what is in the intersection and in no voxel, voxels³, but for faces that face each other: of a cut or an
  /// intersection.
  [[nodiscard]] double volumeBetween() {
    return volumeBetweenVoxels(
        editor_, rims_,
        [&](Coord voxel) {
          return std::abs(fieldA_.voxel(voxel)) < kThinReach && std::abs(fieldB_.voxel(voxel)) < kThinReach &&
                 !facing_.holds(voxel);
        },
        [&](const Vec3d& p) { return double(turned(turnA_, fieldA_.distance(p))); },
        [&](const Vec3d& p) { return double(turned(turnB_, fieldB_.distance(p))); });
  }
  /// Voxels where both surfaces face each other.
  [[nodiscard]] const ThinVoxels& facing() const { return facing_; }
  /// Where there are channels: bricks in which both clays have a band.
  [[nodiscard]] const std::vector<Coord>& met() const { return met_; }

 private:
  [[nodiscard]] static bool empty(Tile tile, bool turned) { return (tile == Tile::outside) != turned; }
  [[nodiscard]] static bool outOfReach(const TreePlace& place) {
    const Coord first = place.first(), last = first + Coord{1, 1, 1} * ((1 << (3 * place.level())) - 1);
    return std::min({last.x, last.y, last.z}) < -kBrickReach || std::max({first.x, first.y, first.z}) >= kBrickReach;
  }
  // Where b has nothing of the intersection, the result has nothing. A block may begin out of reach; any brick of it
  // names it.
  void takeTile(const TreePlace& b) {
    if (!empty(b.tile(), turnB_)) return;
    const Coord f = b.first();
    editor_.setBlock({std::max(f.x, -kBrickReach), std::max(f.y, -kBrickReach), std::max(f.z, -kBrickReach)}, b.level(),
                     turnA_ ? Tile::inside : Tile::outside);
  }

  void count() {
    if (++done_ % kStepEvery == 0) part_.step(std::min(1.0, static_cast<double>(done_) / static_cast<double>(all_)));
  }
  void copy(const TreePlace& b) {
    if (outOfReach(b)) return;
    if (b.isTile()) {
      takeTile(b);
      return;
    }
    if (b.isNode()) {
      for (int i = 0; i < 512; ++i) copy(b.child(i));
      return;
    }
    count();
    const Brick& from = *b.brick();
    FloatBrick* brick = editor_.newBrick(from.coord);
    from.read(0, kBrickVoxels, brick->value);
    if (turnA_ == turnB_) {
      std::memcpy(brick->inside, from.inside, sizeof brick->inside);
    } else {
      for (float& value : brick->value) value = 0.0f - value;
      for (int x = 0; x < kBrickEdge; ++x) {
        uint64_t zero = 0;
        for (int i = 0; i < 64; ++i) zero |= static_cast<uint64_t>(brick->value[x * 64 + i] == 0) << i;
        brick->inside[x] = ~(from.inside[x] | zero);
      }
    }
    editor_.link(brick, true);
    if (channelsB_) copyChannels(from.coord);
  }

  void copyChannels(Coord brick) {
    for (const Channel channel : kAllChannels) {
      if (!b_.has(channel)) continue;
      const ChannelSlot slot = b_.find(channel, brick);
      if (channel == Channel::material && !materials_.empty()) {
        std::array<uint8_t, kBrickVoxels> values;
        const Brick& own = *b_.find(brick).brick();
        for (int v = 0; v < kBrickVoxels; ++v)
          values[static_cast<size_t>(v)] =
              std::abs(own.phi(v)) < b_.grid().band ? mapped(materials_, slot.value(v)) : 0;
        editor_.setChannel(channel, brick, values);
      } else if (slot.isTile())
        editor_.setChannelTile(channel, brick, slot == ChannelSlot(true));
      else
        editor_.setChannel(channel, brick, slot.brick()->value);
    }
    clearChannelsRoundedAway(editor_, brick);
  }
  // The first clay's, where nothing of it is left.
  void clearBelow(const TreePlace& a) {
    if (a.brick()) clearChannels(editor_, a.first());
    if (!a.isNode()) return;
    for (int i = 0; i < 512; ++i) clearBelow(a.child(i));
  }

  void mix(const Brick& a, const Brick& b) {
    count();
    const float band = editor_.grid().band;
    BrickValues phi, scratchA, scratchB;
    const BrickValues &valuesA = a.values(scratchA), &valuesB = b.values(scratchB);
    const bool loses = !turnA_;  // A join loses no clay between voxels.
    bool ends = false, near = false, rim = false;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float pa = turnA_ ? -valuesA[i] : valuesA[i], pb = turnB_ ? -valuesB[i] : valuesB[i];
      float value = std::max(pa, pb);
      near |= isNear(pa, pb, band);
      if (loses) rim |= std::abs(pa) < kThinReach && std::abs(pb) < kThinReach;
      if (mayEnd(pa, pb, band)) {
        ends = true;
        value = outside(voxelOf(a.coord, i), pa, pb);
      }
      if (pa + pb > -kThinnest && pa + pb < kHiding) face(voxelOf(a.coord, i), pa, pb, band);
      phi[i] = turnA_ ? -value : value;
    }
    editor_.setVoxels(a.coord, phi);
    // What is no distance beside an edge of either solid was a bound before, or is one now.
    if (ends || (near && !isSlopeOne(phi, band - 1, kSlopeOff))) creases_.push_back(a.coord);
    if (rim) rims_.push_back(a.coord);
    if (channels_ || channelsB_) met_.push_back(a.coord);
  }

  [[nodiscard]] static Coord voxelOf(Coord brick, int i) {
    return brick * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
  }
  [[nodiscard]] static Coord beside(Coord voxel, int axis, int step) {
    return voxel + Coord{axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
  }
  float outside(Coord voxel, float pa, float pb) {
    return wedgeDistance(
        pa, pb, editor_.grid().band,
        [&](int axis, int step) { return turned(turnA_, fieldA_.voxel(beside(voxel, axis, step))); },
        [&](int axis, int step) { return turned(turnB_, fieldB_.voxel(beside(voxel, axis, step))); });
  }
  void face(Coord voxel, float pa, float pb, float band) {
    if (!faceEachOther(
            pa, pb, band, [&](int axis, int step) { return turned(turnA_, fieldA_.voxel(beside(voxel, axis, step))); },
            [&](int axis, int step) { return turned(turnB_, fieldB_.voxel(beside(voxel, axis, step))); }))
      return;
    // Zero is outside, whichever solid is turned.
    const float value = std::max(pa, pb);
    facing_.add(voxel, turnA_ ? value <= 0 : value < 0);
  }
  [[nodiscard]] static float turned(bool turn, float value) { return turn ? -value : value; }

  Editor& editor_;
  const Version& b_;
  const MaterialMap& materials_;
  bool turnA_, turnB_, channels_, channelsB_;
  ThinVoxels facing_;
  Sampler fieldA_, fieldB_;
  std::vector<Coord> creases_, met_, fallen_, rims_;  // rims_: with voxels near both surfaces
  uint64_t done_ = 0, all_;
  WorkPart part_;
};

// Each voxel of `bricks` (sorted) has its channels from the clay whose surface its distance is to: of both that have it
// in their band, the one whose distance is closer to its own.
void takeChannels(Editor& editor, std::span<const Coord> bricks, const Version& a, const Version& b, Combination how,
                  const MaterialMap& materials, const WorkPart& part) {
  const float band = editor.grid().band, ofB = how == Combination::cut ? -1 : 1;
  ChannelSource fromA(a), fromB(b);
  ChannelBytes bytes;
  for (size_t i = 0; i < bricks.size(); ++i) {
    if (i % kStepEvery == 0) part.step(double(i) / double(bricks.size()));
    const Slot now = editor.find(bricks[i]), inA = a.find(bricks[i]), inB = b.find(bricks[i]);
    ChannelBlock block{ChannelPlace{}};
    for (int v = 0; v < kBrickVoxels; ++v) {
      const float phi = now.phi(v, band);
      if (!(std::abs(phi) < band)) continue;
      const Coord at = bricks[i] * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      const float offA = std::abs(inA.phi(v, band) - phi), offB = std::abs(ofB * inB.phi(v, band) - phi);
      bool isB = offA > offB;
      const int near = (isB ? fromB : fromA).nearest(at, bytes);
      // Where both bands end, or the one that is closer does not come near, the voxels decide.
      if (ChannelBytes ofOther; (near == ChannelSource::kNone || (near > 0 && offA == offB)) &&
                                (isB ? fromA : fromB).nearest(at, ofOther) < near) {
        bytes = ofOther;
        isB = !isB;
      }
      if (isB) bytes[indexOf(Channel::material)] = mapped(materials, bytes[indexOf(Channel::material)]);
      block.set(v, bytes);
    }
    block.store(editor, bricks[i]);
  }
}

// Area of the faces of both clays that touch, and volume of what lies between them.
struct Seam {
  double area = 0, volume = 0;
};
// Edges of voxels along an axis cross a face as often as it is wide there, so each counts with the face's normal, and
// with as much of it as lies in `joined`.
Seam seamOf(const ThinVoxels& facing, const Version& a, const Version& b, Combination how, const Editor& joined) {
  const float signA = how == Combination::join ? -1 : 1, signB = how == Combination::intersect ? 1 : -1;
  Sampler fieldA(a), fieldB(b), fieldOf(joined);
  constexpr Coord kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  ThinVoxels places(Tile::inside);
  facing.forEach([&](Coord voxel) {
    places.add(voxel, false);
    for (const Coord axis : kAxes) {
      places.add(voxel + axis, false);
      places.add(voxel - axis, false);
    }
  });
  // Distance to the middle between both, and the distance between them.
  const auto middle = [&](Coord at) { return (signA * fieldA.voxel(at) - signB * fieldB.voxel(at)) / 2; };
  const auto apart = [&](Coord at) { return -(signA * fieldA.voxel(at) + signB * fieldB.voxel(at)); };
  const bool joins = how == Combination::join;
  Seam seam;
  places.forEach([&](Coord voxel) {
    const float here = middle(voxel), gap = apart(voxel);
    if (std::abs(here) > 1) return;
    float slope[3], length = 0;
    for (int axis = 0; axis < 3; ++axis) {
      slope[axis] = (middle(voxel + kAxes[axis]) - middle(voxel - kAxes[axis])) / 2;
      length += slope[axis] * slope[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
      const Coord next = voxel + kAxes[axis];
      if ((middle(next) < 0) == (here < 0) || !places.holds(next)) continue;
      const bool isHere = facing.holds(voxel), isNext = facing.holds(next);
      const float between = isHere ? gap : isNext ? apart(next) : 0;
      if (std::abs(between) > kThinnest) continue;
      const float depth = joins ? (fieldOf.voxel(voxel) + fieldOf.voxel(next)) / 2 : isHere || isNext ? -1.0f : 1.0f;
      const double part = double(std::abs(slope[axis]) / std::sqrt(std::max(length, 1e-6f))) *
                          double(std::clamp(0.5f - depth, 0.0f, 1.0f));
      seam.area += part;
      seam.volume += part * double(std::max(between, 0.0f));
    }
  });
  return seam;
}

// Quadratic smooth maximum: max where they differ by more than the width (Quilez).
float blended(float a, float b, float width) {
  const float h = std::max(width - std::abs(a - b), 0.0f) / width;
  return std::max(a, b) + h * h * width * 0.25f;
}

// Where both surfaces are near, the blend of both distances takes the place of the combination. Distances are needed
// beyond the band: to 1.25 widths, where the blend no longer reaches the surface. Returns the bricks that it may have
// changed.
std::vector<Coord> blend(Editor& editor, const Version& a, const Version& b, Combination how, float width, int threads,
                         const WorkPart& part) {
  const float band = a.grid().band, far = 1.25f * width + band;
  const int around = static_cast<int>(std::ceil(1.25f * width)) + 1;
  std::vector<Coord> regions;
  {
    const std::vector<Coord> ofA = regionsNear(a, around), ofB = regionsNear(b, around);
    std::set_intersection(ofA.begin(), ofA.end(), ofB.begin(), ofB.end(), std::back_inserter(regions));
  }
  const bool turnA = how == Combination::join, turnB = how != Combination::intersect;
  std::mutex editing;
  std::vector<Coord> changed;
  forEachWithRoom<DistanceBox>(regions.size(), threads, part.part(0, 0.9), [&](size_t i, DistanceBox& boxA) {
    DistanceBox boxB;
    const Coord first = regions[i] * kRegionBricks, size{kRegionVoxels, kRegionVoxels, kRegionVoxels};
    const DistanceBox::Reach reach{far, far};
    if (!boxA.fill(a, first * kBrickEdge, size, reach) || !boxB.fill(b, first * kBrickEdge, size, reach)) return;
    for (int n = 0; n < 512; ++n) {
      const Coord brick = first + Coord{n >> 6, (n >> 3) & 7, n & 7};
      float phi[kBrickVoxels];
      bool any = false;
      for (int v = 0; v < kBrickVoxels; ++v) {
        const Coord at = brick * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
        const float pa = turnA ? -boxA.at(at) : boxA.at(at), pb = turnB ? -boxB.at(at) : boxB.at(at);
        const float value = blended(pa, pb, width);
        any |= std::abs(pa - pb) < width && std::abs(value) < band;
        phi[v] = turnA ? -value : value;
      }
      if (!any) continue;
      const std::lock_guard lock(editing);
      editor.setVoxels(brick, phi);
      changed.push_back(brick);
    }
  });
  std::vector<Coord> touched = bricksAround(editor, changed);
  redistanceAll(editor, touched, part.part(0.9, 1));
  return touched;
}

// `width`: voxels of blend, 0 for none.
Version combineOnGrid(const Version& a, const Version& b, Combination how, float width, const MaterialMap& materials,
                      int threads, const WorkPart& part, ThinParts* gone) {
  Editor editor(a);
  const double shape = width > 0 ? 0.1 : 0.8;
  Combiner combiner(editor, b, how, materials, part.part(0, shape));
  combiner.combine(TreePlace::root(a), TreePlace::root(b));
  std::vector<Coord> changed;
  if (width > 0) {
    changed = blend(editor, a, b, how, width, threads, part.part(shape, 0.98));
  } else {
    changed = combiner.creases();
    if (!combiner.facing().empty()) {
      ThinParts here;
      combiner.growFacing();
      combiner.facing().settle(editor, here);
      const Seam seam = seamOf(combiner.facing(), a, b, how, editor);
      (how == Combination::join ? here.airVolume : here.clayVolume) = seam.volume;
      if (how == Combination::join) here.seamArea = seam.area;
      const std::vector<Coord> around = bricksAround(editor, combiner.facing().bricks());
      // What rounding hid from the rule.
      ThinVoxels rest(how == Combination::join ? Tile::inside : Tile::outside);
      rest.find(editor, around);
      if (!rest.empty()) rest.settle(editor, here);
      changed.insert(changed.end(), around.begin(), around.end());
      std::sort(changed.begin(), changed.end());
      changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
      if (gone != nullptr) *gone += here;
    }
    // Where more than two surfaces meet, the line between two of them may be cut off by the third, and where they only
    // come near each other there is no such line: values that nothing beside them supports go, and none is farther from
    // the surface than its neighbours allow.
    const auto stands = [&](Coord voxel, float) { return combiner.stands(voxel); };
    redistanceAll(editor, changed, part.part(shape, 0.9), kExactTolerance, stands);
    for (int round = 0; round < kFallenRounds; ++round) {
      const std::vector<Coord> fallen = combiner.takeFallen();
      if (fallen.empty()) break;
      const std::vector<Coord> around = bricksAround(editor, fallen);
      redistanceAll(editor, around, WorkPart(nullptr), kExactTolerance, stands);
      changed.insert(changed.end(), around.begin(), around.end());
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    std::erase_if(changed, [&](Coord c) { return !editor.find(c).brick(); });
    limitSlopes(editor, changed, threads, part.part(0.9, 0.98));
    if (gone != nullptr && how != Combination::join) gone->betweenVoxels += combiner.volumeBetween();
  }
  if (ChannelSource::any(a) || ChannelSource::any(b)) {
    changed.insert(changed.end(), combiner.met().begin(), combiner.met().end());
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    takeChannels(editor, changed, a, b, how, materials, part.part(0.98, 1));
  }
  return editor.commit();
}

}  // namespace

Version combine(const Version& a, const Version& b, Combination how, const CombineOptions& options,
                const WorkPart& part) {
  const int threads = threadCount(options.threads);
  const double width = options.blendMm / a.grid().voxelMm;
  if (!(width >= 0 && width <= kMostBlend))
    throw Error(fmt::format("a blend of {:g} mm at voxels of {:g} mm: give 0 to {:g} mm", options.blendMm,
                            a.grid().voxelMm, kMostBlend * a.grid().voxelMm));
  const bool other = !(b.grid() == a.grid());
  const double ready = other ? 0.6 : 0;
  const Version second = other ? resample(b, a.grid(), Eigen::Isometry3d::Identity(), threads, part.part(0, ready)) : b;
  const Version result = combineOnGrid(a, second, how, width < 1 ? 0 : static_cast<float>(width), options.materials,
                                       threads, part.part(ready, 1), options.gone);
  part.step(1);
  return result;
}

Version combine(const Version& a, const Version& b, Combination how, const CombineOptions& options, Job* job) {
  return combine(a, b, how, options, WorkPart(job));
}

}  // namespace argil::clay
