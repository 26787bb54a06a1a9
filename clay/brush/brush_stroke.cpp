#include "clay/brush/brush.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/brush/brush_channels.h"
#include "clay/brush/brush_method.h"
#include "clay/brush/mask_reach.h"
#include "clay/brush/swept_tip.h"
#include "clay/brush/trail.h"
#include "clay/brush/wall_limit.h"
#include "clay/field/redistance.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/store/store.h"

namespace argil::clay {

namespace {

// From the centre of a brick's voxels to its corner voxel, and a little that covers rounding: bricks farther out are
// decided without looking at their voxels, with the same result.
const double kHalfDiagonal = 3.5 * std::sqrt(3.0) + 0.01;
// The same for a region of 8×8×8 bricks, so that a brush of any size costs its surface.
const double kRegionHalfDiagonal = 31.5 * std::sqrt(3.0) + 0.01;

// Due bricks are gathered until their count is worth the ring of neighbours that is solved along with them.
constexpr size_t kBatch = 64;
// Due bricks that one step before an application redistances.
constexpr size_t kPreparedAtOnce = 512;
// Places are multiples of this, so that sums and mirror images in planes between voxels are exact.
constexpr double kPlaceStep = 1.0 / 65536;
// Bricks of an application that are worth a second thread.
constexpr size_t kParallelFrom = 256;
// Applications whose bricks are computed together at most. What is shown lags by less.
constexpr size_t kTogether = 4;
// Clay that moves by no more than this stays in the bricks around those that it was in.
constexpr double kMoveWithin = 6;
// Surfaces that meet at a smaller angle leave distances: where slopes differ by no more than this along any axis, what
// the lesser of two distances says beside their edge is wrong by 0.07 voxel at most, and redistancing would leave it as
// it is.
constexpr float kMeets = 0.25f;
// A ball that grows by more of its way is not quite at the distance that its lines say.
constexpr float kGrows = 0.02f;
// Bricks of a swept tip that are computed before they are linked: as many as a cache holds.
constexpr size_t kSweptAtOnce = 512;
// Bricks that are made at once for a method to write, of which those that it changes stay.
constexpr size_t kComputedAtOnce = 1024;

// Rounded to even, as mirror images in planes between voxels must be rounded to mirror images.
Vec3d quantised(const Vec3d& p) {
  return p.unaryExpr([](double v) { return std::nearbyint(v / kPlaceStep) * kPlaceStep; });
}

std::vector<Stamp> quantised(std::span<const Stamp> given) {
  std::vector<Stamp> images(given.begin(), given.end());
  for (Stamp& each : images) {
    each.a = quantised(each.a);
    each.b = quantised(each.b);
  }
  return images;
}

const Operation* distanceOperation(const Brush& brush) {
  for (const Operation& each : brush.operations)
    if (each.property == Property::distance) return &each;
  return nullptr;
}

}  // namespace

struct BrushStroke::State {
  State(Version base, std::shared_ptr<const Brush> given, Version start, int threadCount)
      : brush(std::move(given)),
        threads(threadCount),
        redistancing{.tolerance = static_cast<float>(brush->quality.tolerance), .passes = brush->quality.passes},
        trail(static_cast<float>(brush->quality.drift)) {
    brush->check();
    if (const Operation* operation = distanceOperation(*brush)) {
      if (operation->method == Method::carve) tool = Method::carve;
      if (operation->method == Method::add || operation->method == Method::wax) tool = Method::add;
      if (operation->method == Method::wax) blendsWith = base;
      method = makeMethod({brush, *operation, start ? std::move(start) : base, base.grid().band, base, threads});
    }
    if (method && base.has(Channel::mask)) maskReach.emplace(base);
    if (brush->leastWall > 0) wallLimit.emplace(brush->leastWall, aroundTip(*brush));
    editor.emplace(std::move(base));
  }

  std::shared_ptr<const Brush> brush;
  int threads;
  std::optional<Method> tool;              // carve or add: the way that costs least
  Version blendsWith;                      // wax: adds, but for the bricks that this clay had
  std::unique_ptr<DistanceMethod> method;  // any other
  std::optional<Editor> editor;
  Editor::Counts before;  // of the editors that were published
  uint64_t stamps = 0, touched = 0, collected = 0;

  CarriedFrom carriedFrom;
  std::optional<MaskReach> maskReach;  // of clay that has a mask
  std::optional<WallLimit> wallLimit;

  Redistancing redistancing;
  Trail trail;

  // A brick that the tip reaches: what it was, what it becomes, and what covers it.
  struct Swept {
    Slot was;
    FloatBrick* brick;
    std::unique_ptr<MaskCover> cover;
    BrickChange change;
    bool exact = false;  // its distances are distances yet
  };
  std::vector<Swept> swept;  // waiting to be computed

  void sweepTip(const Stamp& s, std::vector<Coord>& influenced, std::vector<Coord>& blended);
  void computeSwept(const Stamp& s, std::vector<Coord>& influenced);
  [[nodiscard]] std::optional<MaskCover> coverOf(Coord coord, double largestRadius);
  BrickChange masked(const MaskCover& cover, const float* source, FloatBrick& brick, float& most) const;
  // Applications that were begun and whose bricks are to be computed yet.
  std::vector<Stamp> begun;
  size_t begunCount = 0;
  bool begunOnce = false;  // some have waited
  double begunMove = 0;

  void begin(std::span<const Stamp> images, std::span<const Coord> coords);
  void compute(std::span<const Stamp> images, const std::vector<Coord>& coords, std::vector<Coord>& influenced);
  void work(std::span<const Stamp> images, const std::vector<Coord>& coords, std::vector<Coord>& influenced) {
    if (coords.empty()) return;
    begin(images, coords);
    compute(images, coords, influenced);
  }
  void workLater(std::span<const Stamp> images, double move, bool together, std::vector<Coord>& influenced);
  void computeBegun(std::vector<Coord>& influenced);
  void workInParts(std::span<const Stamp> images, bool together, std::vector<Coord>& influenced);
  [[nodiscard]] std::vector<Coord> bricksWithin(std::span<const Stamp> images, double moved = 0);
  void redistanceDue(size_t most = SIZE_MAX);
  void apply(const std::vector<Stamp>& images);

  [[nodiscard]] Editor::Counts counts() const {
    const Editor::Counts now = editor->counts();
    return {before.bricksMade + now.bricksMade, before.nodesMade + now.nodesMade,
            before.channelBricksMade + now.channelBricksMade};
  }
  [[nodiscard]] Version commit() {
    before = counts();
    Version version = editor->commit();
    editor.emplace(version);
    return version;
  }

  // One of the things that have to be done before these images are applied and take about as long as that: bricks of
  // the applications before that these cannot be computed with; and where what the method keeps has grown too large,
  // that it goes on from the clay as it is now. False when there is none.
  bool prepare(std::span<const Stamp> images) {
    if (!method) return false;
    const bool full = method->full();
    if (begunCount > 0 && (full || (method->parts(images) == 1 && !goesAlong(method->moves(images))))) {
      std::vector<Coord> influenced;
      computeBegun(influenced);
      trail.touch(stamps, std::move(influenced));
      return true;
    }
    if (!full) return false;
    trail.follow(stamps);
    if (trail.due() > 0) {
      redistanceDue(kPreparedAtOnce);
      return true;
    }
    method->beginAnew(commit());
    collect();
    return false;
  }
  // Whether bricks of an application are computed together with those that wait.
  [[nodiscard]] bool goesAlong(double move) const { return begunMove + move <= brush->quality.together; }

  // Frees what versions that were dropped on the way alone used: as much as has been made since the last time, so that
  // memory does not follow the stroke's length.
  void collect() {
    const Editor::Counts made = counts();
    constexpr uint64_t kNodeWork = 8, kAtLeast = 256;
    const uint64_t work = made.bricksMade + made.channelBricksMade + kNodeWork * made.nodesMade;
    (void)editor->base().store()->collect(2 * (work - std::exchange(collected, work)) + kAtLeast);
  }

  // What is painted goes along with distances: that needs the clay as it was. Nothing where there is nothing to carry.
  [[nodiscard]] Version beforeChange() { return method && carriesChannels(*editor, *brush) ? commit() : Version(); }
  void carry(const Version& was, const DistanceMethod* by, std::span<const Stamp> images) {
    if (!was) return;
    (void)commit();  // the editor's base is the clay as it is now
    carryChannels(*editor, was, *brush, by, images, carriedFrom);
    collect();
  }

  // Visits the bricks around a stamp, region by region, so that consecutive ones share a node. `enter` is asked first,
  // with the region's first brick and the distance of its middle to the segment.
  template <class Enter, class Visit>
  void forBricks(const Stamp& s, double margin, const Enter& enter, const Visit& visit) {
    const Vec3d low = s.a.cwiseMin(s.b) - Vec3d::Constant(margin), high = s.a.cwiseMax(s.b) + Vec3d::Constant(margin);
    Coord first, last;
    // From the last voxel of a brick: mirrored stamps choose mirrored bricks.
    first = {static_cast<int32_t>(std::ceil((low.x() - 7) / 8)), static_cast<int32_t>(std::ceil((low.y() - 7) / 8)),
             static_cast<int32_t>(std::ceil((low.z() - 7) / 8))};
    last = {static_cast<int32_t>(std::floor(high.x() / 8)), static_cast<int32_t>(std::floor(high.y() / 8)),
            static_cast<int32_t>(std::floor(high.z() / 8))};
    for (int rx = first.x >> 3; rx <= last.x >> 3; ++rx)
      for (int ry = first.y >> 3; ry <= last.y >> 3; ++ry)
        for (int rz = first.z >> 3; rz <= last.z >> 3; ++rz) {
          const Coord region = Coord{rx, ry, rz} * 8;
          if (!enter(region, segmentDistance(s, (region * kBrickEdge).toVec3d() + Vec3d::Constant(31.5)))) continue;
          for (int x = std::max(first.x, region.x); x <= std::min(last.x, region.x + 7); ++x)
            for (int y = std::max(first.y, region.y); y <= std::min(last.y, region.y + 7); ++y)
              for (int z = std::max(first.z, region.z); z <= std::min(last.z, region.z + 7); ++z) visit(Coord{x, y, z});
        }
  }
};

void BrushStroke::State::sweepTip(const Stamp& s, std::vector<Coord>& influenced, std::vector<Coord>& blended) {
  const double band = editor->grid().band;
  // Where the radius changes, the least of it says what is wholly inside and the largest what is not touched.
  const double least = std::min(s.radius, s.radiusAtEnd()) * withinTip(*brush),
               largest = s.largestRadius() * aroundTip(*brush);
  const bool carving = *tool == Method::carve;
  const bool masks = editor->has(Channel::mask);
  const Tile result = carving ? Tile::outside : Tile::inside;
  const auto enter = [&](Coord region, double middle) {
    if (middle - kRegionHalfDiagonal - largest >= band) return false;
    if (masks || middle + kRegionHalfDiagonal - least > -band) return true;
    touched += editor->setBlock(region, 1, result);
    return false;
  };
  forBricks(s, largest + band, enter, [&](Coord coord) {
    const double centre = segmentDistance(s, (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5));
    if (centre - kHalfDiagonal - largest >= band) return;
    const Slot slot = editor->find(coord);
    if (slot == Slot(result)) return;
    std::optional<MaskCover> cover;
    if (masks) cover = coverOf(coord, largest);
    if (cover && cover->whole) return;
    if (!cover && centre + kHalfDiagonal - least <= -band) {
      ++touched;
      editor->setTile(coord, result);
      return;
    }
    if (blendsWith && !blendsWith.find(coord).isTile()) {
      blended.push_back(coord);
      return;
    }
    ++touched;
    FloatBrick* mine = slot.isTile() || cover ? nullptr : editor->own(coord);
    swept.push_back(
        {slot, mine ? mine : editor->newBrick(coord), cover ? std::make_unique<MaskCover>(*cover) : nullptr, {}});
    if (swept.size() >= kSweptAtOnce) computeSwept(s, influenced);
  });
  computeSwept(s, influenced);
}

// Bricks of a stamp have nothing to do with one another.
void BrushStroke::State::computeSwept(const Stamp& s, std::vector<Coord>& influenced) {
  const float band = editor->grid().band;
  const bool carving = *tool == Method::carve;
  const bool straight = std::abs(s.radiusAtEnd() - s.radius) <= static_cast<double>(kGrows) * (s.b - s.a).norm();
  parallelBlocks(
      swept.size(), swept.size() >= kParallelFrom ? threads : 1,
      [&](size_t begin, size_t end) {
        BrickValues scratch;
        for (size_t i = begin; i < end; ++i) {
          Swept& each = swept[i];
          FloatBrick& target = *each.brick;
          const float* source = each.was.values(scratch, band);
          if (brush->tip == Tip::ball) {
            const SweptBall ball = sweptBall(s, target.coord);
            if (!each.cover && straight) {
              float distance[kBrickVoxels];
              ballDistances(ball, distance);
              each.exact = !meetAtAnAngle(source, distance, carving ? -1.0f : 1.0f, band, kMeets);
            }
            each.change = carving ? carveBrick(ball, band, source, target) : addBrick(ball, band, source, target);
          } else {
            float distance[kBrickVoxels], most = 0;
            tipDistances(*brush, s, target.coord, distance);
            // One that is written in place is its own source.
            if (each.was == Slot(each.brick)) source = std::copy_n(source, kBrickVoxels, scratch) - kBrickVoxels;
            for (int v = 0; v < kBrickVoxels; ++v)
              target.value[v] = carving ? std::max(source[v], -distance[v]) : std::min(source[v], distance[v]);
            each.change = sealBrick(source, band, target, most);
          }
          float most = 0;
          if (each.cover) each.change = masked(*each.cover, source, target, most);
        }
      },
      32);
  for (const Swept& each : swept) {
    const Coord coord = each.brick->coord;
    if (each.cover) (void)trail.change(coord, 0, Renew::slopes);
    if (each.change.changed)
      editor->link(each.brick, each.change.inBand);
    else if (each.was != Slot(each.brick))
      editor->recycle(each.brick);
    if (editor->find(coord).isTile()) continue;
    // Distances that were waiting to be solved wait on.
    if (!each.exact || trail.waits(coord)) influenced.push_back(coord);
  }
  swept.clear();
}

// Where the band was when the stroke began the mask itself, elsewhere what it means there too: clay that comes up
// beside a mask must not let the next stamp creep over it. A tool that stands on the surface reaches clay as deep as it
// is wide. Nothing where all is free.
std::optional<MaskCover> BrushStroke::State::coverOf(Coord coord, double largestRadius) {
  const float band = editor->grid().band;
  const ChannelSlot mask = editor->find(Channel::mask, coord);
  MaskCover cover;
  Slot began;
  if (maskReach && mask != ChannelSlot(true)) {
    cover = maskReach->at(coord, 2 * largestRadius + static_cast<double>(band));
    began = maskReach->start().find(coord);
  }
  if (began.isTile() && mask == ChannelSlot()) return cover.none ? std::nullopt : std::optional(cover);
  for (int i = 0; i < kBrickVoxels; ++i) {
    uint8_t& value = cover.value[static_cast<size_t>(i)];
    value = std::abs(began.phi(i, band)) < band ? mask.value(i) : std::max(value, mask.value(i));
  }
  if (std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 0; })) return std::nullopt;
  cover.none = false;
  cover.whole = std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 255; });
  return cover;
}

// What a mask covers goes back to what it was, by as much as it covers; at 255 to the bit.
BrickChange BrushStroke::State::masked(const MaskCover& mask, const float* source, FloatBrick& brick,
                                       float& most) const {
  for (int i = 0; i < kBrickVoxels; ++i) {
    const uint8_t cover = mask.value[static_cast<size_t>(i)];
    if (cover == 0 || (cover < 255 && method && method->masks())) continue;
    brick.value[i] = cover == 255
                         ? source[i]
                         : source[i] + (brick.value[i] - source[i]) * (static_cast<float>(255 - cover) / 255.0f);
  }
  return sealBrick(source, editor->grid().band, brick, most);
}

// Bricks within reach of a stamp that hold some surface, and those beside them. Sorted.
std::vector<Coord> BrushStroke::State::bricksWithin(std::span<const Stamp> images, double moved) {
  std::vector<Coord> surface;
  // The band moves along.
  const double travel = std::max(method->travel(), moved > kMoveWithin ? moved : 0);
  const int rings = std::max(1, static_cast<int>(std::ceil((travel + editor->grid().band) / kBrickEdge)));
  for (const Stamp& s : images) {
    const double reach = method->reach(s), margin = 8.0 * rings;
    const auto enter = [&](Coord, double middle) { return middle - kRegionHalfDiagonal - margin < reach; };
    forBricks(s, reach + margin, enter, [&](Coord coord) {
      if (!editor->find(coord).isTile()) surface.push_back(coord);
    });
  }
  if (method->everywhere())
    for (const Stamp& s : images)
      forBricks(
          s, method->reach(s), [](Coord, double) { return true; },
          [&](Coord coord) {
            if (editor->find(coord) != Slot(*tool == Method::carve ? Tile::outside : Tile::inside))
              surface.push_back(coord);
          });
  std::vector<Coord> all = withNeighbours(surface);
  for (int ring = 1; ring < rings; ++ring) all = withNeighbours(all);
  std::erase_if(all, [&](Coord coord) {
    const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
    return std::none_of(images.begin(), images.end(),
                        [&](const Stamp& s) { return segmentDistance(s, middle) - kHalfDiagonal < method->reach(s); });
  });
  return all;
}

void BrushStroke::State::begin(std::span<const Stamp> images, std::span<const Coord> coords) {
  Sampler field(*editor);
  method->begin(field, images, coords);
}

// Where each of them moves clay a little they are computed together: they look at the same bricks.
void BrushStroke::State::workLater(std::span<const Stamp> images, double move, bool together,
                                   std::vector<Coord>& influenced) {
  if (begunCount > 0 && !goesAlong(move)) computeBegun(influenced);
  begin(images, {});
  begun.insert(begun.end(), images.begin(), images.end());
  ++begunCount;
  begunMove += move;
  if (!together || begunCount >= kTogether) return computeBegun(influenced);
  begunOnce = true;
}

void BrushStroke::State::computeBegun(std::vector<Coord>& influenced) {
  if (begunCount == 0) return;
  const std::vector<Stamp> images = std::exchange(begun, {});
  const double moved = std::exchange(begunMove, 0);
  begunCount = 0;
  const std::vector<Coord> coords = bricksWithin(images, moved);
  if (!coords.empty()) compute(images, coords, influenced);
}

void BrushStroke::State::compute(std::span<const Stamp> images, const std::vector<Coord>& coords,
                                 std::vector<Coord>& influenced) {
  const float band = editor->grid().band;
  const bool masks = editor->has(Channel::mask);
  struct Result {
    FloatBrick* brick = nullptr;
    std::optional<MaskCover> cover;
    BrickChange change;
    float most = 0;
  };
  double largest = 0;
  for (const Stamp& s : images) largest = std::max(largest, s.largestRadius() * aroundTip(*brush));
  std::vector<Result> results, kept;
  for (size_t from = 0; from < coords.size(); from += kComputedAtOnce) {
    const std::span<const Coord> some =
        std::span(coords).subspan(from, std::min(kComputedAtOnce, coords.size() - from));
    results.assign(some.size(), {});
    for (size_t i = 0; i < some.size(); ++i) {
      results[i].brick = editor->newBrick(some[i]);
      if (masks) results[i].cover = coverOf(some[i], largest);
    }
    parallelBlocks(
        some.size(), coords.size() >= kParallelFrom ? threads : 1,
        [&](size_t begin, size_t end) {
          Sampler mine(*editor);
          BrickValues scratch;
          for (size_t i = begin; i < end; ++i) {
            Result& r = results[i];
            if ((r.cover && r.cover->whole) || !method->brick(mine, images, some[i], r.brick->value)) continue;
            const float* source = mine.slot(some[i]).values(scratch, band);
            r.change =
                !r.cover ? sealBrick(source, band, *r.brick, r.most) : masked(*r.cover, source, *r.brick, r.most);
          }
        },
        16);
    for (const Result& r : results) {
      if (r.change.changed)
        kept.push_back({r.brick, std::nullopt, r.change, r.most});
      else
        editor->recycle(r.brick);
    }
  }
  touched += coords.size();
  // Linked once all have been computed: every brick comes from the field as it was before.
  std::vector<Coord> changed, drifted;
  for (const Result& r : kept) {
    const Coord coord = r.brick->coord;
    const Renew renew = masks ? std::max(method->leaves(), Renew::slopes) : method->leaves();
    if (trail.change(coord, method->lasting() ? 0 : r.most, renew)) drifted.push_back(coord);
    changed.push_back(coord);
    editor->link(r.brick, r.change.inBand);
  }
  // The surface may have come nearer to a neighbour that is a tile yet: redistancing makes the brick if so.
  const std::vector<Coord> around = withNeighbours(changed);
  influenced.insert(influenced.end(), around.begin(), around.end());
  if (drifted.empty()) return;
  const Trail::Work work = trail.takeNow(drifted);
  redistance(*editor, work.bricks, work.renew, threads, redistancing);
}

void BrushStroke::State::workInParts(std::span<const Stamp> images, bool together, std::vector<Coord>& influenced) {
  const int parts = method->parts(images);
  const auto workOn = [&](std::span<const Stamp> part) {
    if (const double move = method->moves(part); std::isfinite(move))
      workLater(part, move, together, influenced);
    else
      work(part, bricksWithin(part), influenced);
  };
  if (parts == 1) return workOn(images);
  for (int i = 0; i < parts; ++i) {
    std::vector<Stamp> part(images.begin(), images.end());
    for (size_t k = 0; k < part.size(); ++k) {
      const Stamp& whole = images[k];
      const auto at = [&](int step) {
        return quantised(whole.a + (whole.b - whole.a) * (static_cast<double>(step) / parts));
      };
      part[k].a = at(i);
      part[k].b = at(i + 1);
      part[k].radius = whole.radius + (whole.radiusAtEnd() - whole.radius) * i / parts;
      part[k].endRadius = whole.radius + (whole.radiusAtEnd() - whole.radius) * (i + 1) / parts;
      // What goes by the way becomes less with it; a dab has none.
      if (whole.a == whole.b) part[k].strength = whole.strength / static_cast<float>(parts);
    }
    workOn(part);
  }
}

void BrushStroke::State::redistanceDue(size_t most) {
  if (trail.due() == 0) return;
  const Trail::Work work = trail.take(most);
  const Version was = beforeChange();
  redistance(*editor, work.bricks, work.renew, threads, redistancing);
  carry(was, nullptr, {});
}

BrushStroke::BrushStroke(Version base, std::shared_ptr<const Brush> brush, Version start, int threads)
    : state_(std::make_unique<State>(std::move(base), std::move(brush), std::move(start), threads)) {}
BrushStroke::~BrushStroke() = default;

void BrushStroke::apply(std::span<const Stamp> given) {
  if (given.empty() || given.size() > 64) throw Error("a stamp has 1 to 64 images");
  for (const Stamp& each : given) checkStamp(each);
  State& s = *state_;
  const std::vector<Stamp> images = quantised(given);
  if (!s.wallLimit) return s.apply(images);
  // One after the other: what one image cuts may be the far side of another.
  for (size_t i = 0; i < images.size(); ++i)
    for (const Stamp& each : s.wallLimit->allowed(*s.editor, images[i], i)) s.apply(quantised(std::span(&each, 1)));
}

void BrushStroke::State::apply(const std::vector<Stamp>& images) {
  while (prepare(images)) {
  }
  const Version was = beforeChange();
  std::vector<Coord> influenced;
  // what a mask covers in part depends on the order of images
  const bool blends = images.size() > 1 && editor->has(Channel::mask);
  if (tool && !blends) {
    // Cutting away one thing after the other gives the same in any order.
    std::vector<Coord> blended;
    for (const Stamp& each : images) sweepTip(each, influenced, blended);
    std::sort(blended.begin(), blended.end());
    blended.erase(std::unique(blended.begin(), blended.end()), blended.end());
    work(images, blended, influenced);
  } else if (method) {
    // What goes along with clay is looked at application by application.
    workInParts(images, !was, influenced);
  }
  carry(was, tool ? nullptr : method.get(), images);
  for (const Operation& each : brush->operations)
    if (each.property != Property::distance) applyToChannels(*editor, *brush, each, images);
  const uint64_t number = ++stamps;
  trail.touch(number, std::move(influenced));
  // What is computed together is touched again together.
  const uint64_t behind = static_cast<uint64_t>(brush->quality.trail) + (begunOnce ? kTogether : 0);
  if (number > behind) trail.follow(number - behind);
  if (trail.due() >= kBatch) redistanceDue();
}

bool BrushStroke::prepare(std::span<const Stamp> given) {
  return state_->prepare(quantised(given));
}

Version BrushStroke::publish() {
  return state_->commit();
}

Version BrushStroke::finish() {
  State& s = *state_;
  std::vector<Coord> influenced;
  s.computeBegun(influenced);
  s.trail.touch(s.stamps, std::move(influenced));
  s.trail.follow(s.stamps);
  s.redistanceDue();
  return publish();
}

std::vector<WallAhead> BrushStroke::wallsAhead() {
  State& s = *state_;
  return s.wallLimit ? s.wallLimit->ahead(*s.editor) : std::vector<WallAhead>();
}

uint64_t BrushStroke::touched() const {
  return state_->touched;
}

Editor::Counts BrushStroke::counts() const {
  return state_->counts();
}

}  // namespace argil::clay
