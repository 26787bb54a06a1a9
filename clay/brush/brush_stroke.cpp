#include "clay/brush/brush.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/base/steps.h"
#include "clay/brush/brush_channels.h"
#include "clay/brush/brush_method.h"
#include "clay/brush/mask_reach.h"
#include "clay/brush/swept_tip.h"
#include "clay/brush/trail.h"
#include "clay/brush/wall_limit.h"
#include "clay/field/redistance.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/store/change_in_parts.h"
#include "clay/store/store.h"

namespace argil::clay {

namespace {

// Due bricks are gathered until their count is worth the ring of neighbours that is solved along with them: so many,
// and half of what is computed at once.
constexpr size_t kBatch = 64;
// Bricks of an application that are worth a second thread; of a swept tip, whose bricks take less.
constexpr size_t kParallelFrom = 128, kParallelSwept = 256;
// Radius up to which they move clay by Quality::together altogether; larger tips by as much more as they are larger.
constexpr double kTogetherRadius = 30;
// Surfaces that meet at a smaller angle leave distances: where slopes differ by no more than this along any axis, what
// the lesser of two distances says beside their edge is wrong by 0.07 voxel at most, and redistancing would leave it as
// it is.
constexpr float kMeets = 0.25f;
// A ball that grows by more of its way is not quite at the distance that its lines say.
constexpr float kGrows = 0.02f;
// Bricks of a swept tip that are computed before they are linked: as many as a cache holds.
constexpr size_t kSweptAtOnce = 512;
// From this radius on, voxels, a tip is swept in steps; one that blends as well, when it may blend enough bricks for
// it.
constexpr double kLargeTip = 64, kLargeBlended = 16;

const Operation* distanceOperation(const Brush& brush) {
  for (const Operation& each : brush.operations)
    if (each.property == Property::distance) return &each;
  return nullptr;
}

// Whether a swept ball begins where and as large as the one before it ended, so that what lies behind its beginning was
// within the reach of that one: at each place there the one before is at least as near.
bool goesOnFrom(const Stamp& before, const Stamp& s) {
  return before.b == s.a && before.radius >= before.radiusAtEnd() && before.radiusAtEnd() == s.radius;
}

// Whether the nearest place of a stamp's segment is its beginning for each voxel of a cube of bricks.
bool liesBehind(const Stamp& s, Coord first, int bricks) {
  const Vec3d d = s.b - s.a;
  return (middleOf(first, bricks) - s.a).dot(d) + (kBrickEdge * bricks - 1) * 0.5 * d.lpNorm<1>() <= 0;
}

}  // namespace

struct BrushStroke::State {
  State(Version base, std::shared_ptr<const Brush> given, Version start, int threadCount)
      : brush(std::move(given)),
        threads(threadCount),
        redistancing{.tolerance = static_cast<float>(brush->quality.tolerance), .passes = brush->quality.passes} {
    brush->check();
    if (const Operation* operation = distanceOperation(*brush)) {
      if (operation->method == Method::carve) tool = Method::carve;
      if (operation->method == Method::add || operation->method == Method::wax) tool = Method::add;
      if (operation->method == Method::wax) blendsWith = base;
      method = makeMethod({brush, *operation, start ? std::move(start) : base, base.grid().band, base, threads});
    }
    const double mostDrift = method ? method->mostDrift() : HUGE_VAL;
    if (std::isfinite(mostDrift)) redistancing.passes = 0;
    trail = Trail(static_cast<float>(std::min(brush->quality.drift, mostDrift)));
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
  size_t computed = 0;  // bricks at once, the last time

  CarriedFrom carriedFrom;
  LaidShares laidShares;
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
  std::vector<Swept> swept;        // waiting to be computed
  std::vector<Stamp> sweptBefore;  // images of the application before this one, where their tip was swept whole

  [[nodiscard]] Steps sweepTip(const Stamp& s, const Stamp* last, std::vector<Coord>& influenced,
                               std::vector<Coord>& blended);
  uint64_t setCube(Coord first, int edge, Tile tile);
  void computeSwept(const Stamp& s, std::vector<Coord>& influenced);
  [[nodiscard]] std::optional<MaskCover> coverOf(Coord coord, double largestRadius) {
    return coverDuring(*editor, maskReach ? &*maskReach : nullptr, coord, largestRadius);
  }
  BrickChange masked(const MaskCover& cover, const float* source, FloatBrick& brick, float& most) const {
    putBack(cover, !(method && method->masks()), source, brick.value);
    return sealBrick(source, editor->grid().band, brick, most);
  }
  // Applications that were begun and whose bricks are to be computed yet.
  std::vector<Stamp> begun;
  size_t begunCount = 0;
  bool begunOnce = false;  // some have waited
  double begunMove = 0;

  [[nodiscard]] Steps work(std::span<const Stamp> images, std::vector<Coord> coords, std::vector<Coord>& influenced);
  [[nodiscard]] Steps computeBegun(std::vector<Coord>& influenced);
  struct Part {
    std::vector<Stamp> images;
    bool first, last;  // of its application
  };
  [[nodiscard]] Steps workOnPart(const Part& part, bool together, std::vector<Coord>& influenced);
  [[nodiscard]] Steps workInParts(std::span<const Stamp> images, bool together, std::vector<Coord>& influenced);
  [[nodiscard]] std::vector<Coord> reached(std::span<const Stamp> images, double moved = 0) const {
    return reachedBricks(*editor, *method, images, moved, tool == Method::carve ? Tile::outside : Tile::inside);
  }
  [[nodiscard]] Steps redistanceBricks(Trail::Work work);
  [[nodiscard]] Steps redistanceDue(size_t most);
  [[nodiscard]] Steps prepare(std::span<const Stamp> images);
  [[nodiscard]] Steps application(std::vector<Stamp> images);
  [[nodiscard]] Steps applicationWithinWalls(std::vector<Stamp> images);
  std::optional<Steps> inWork;  // the application that was begun
  // What is seen of the stroke while the clay is between two states of which nobody may see anything: where a tip was
  // swept in part, clay ends at bricks that are not there; and new clay has no colour before that is carried.
  Version seen;
  Version safe;  // what the clay goes back to where a step of the application in work fails

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

  // Whether bricks of an application are computed together with those that wait.
  [[nodiscard]] bool goesAlong(std::span<const Stamp> images, double move) const {
    double radius = HUGE_VAL;
    for (const Stamp& s : images) radius = std::min({radius, s.radius, s.radiusAtEnd()});
    return begunMove + move <= brush->quality.together * std::max(1.0, radius / kTogetherRadius);
  }

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
};

// How many bricks of a cube were anything else.
uint64_t BrushStroke::State::setCube(Coord first, int edge, Tile tile) {
  if (edge == 8) return editor->setBlock(first, 1, tile);
  uint64_t count = 0;
  for (int x = 0; x < edge; ++x)
    for (int y = 0; y < edge; ++y)
      for (int z = 0; z < edge; ++z) {
        const Coord coord = first + Coord{x, y, z};
        if (editor->find(coord) == Slot(tile)) continue;
        editor->setTile(coord, tile);
        ++count;
      }
  return count;
}

Steps BrushStroke::State::sweepTip(const Stamp& s, const Stamp* last, std::vector<Coord>& influenced,
                                   std::vector<Coord>& blended) {
  const double band = editor->grid().band;
  // Where the radius changes, the least of it says what is wholly inside and the largest what is not touched.
  const double least = std::min(s.radius, s.radiusAtEnd()) * withinTip(*brush),
               largest = s.largestRadius() * aroundTip(*brush);
  const bool carving = *tool == Method::carve;
  const bool masks = editor->has(Channel::mask);
  const Tile result = carving ? Tile::outside : Tile::inside;
  const bool goesOn = last && goesOnFrom(*last, s);
  std::vector<std::pair<Coord, double>> reached;  // with the distances of their middles
  forCubes(s, largest + band, [&](Coord first, int edge, double middle) {
    const double half = halfDiagonal(edge);
    if (middle - half - largest >= band || (goesOn && liesBehind(s, first, edge))) return false;
    if (!masks && middle + half - least <= -band) {
      touched += setCube(first, edge, result);
      return false;
    }
    if (edge == 1 && editor->find(first) != Slot(result)) reached.emplace_back(first, middle);
    return true;
  });
  for (const auto& [coord, centre] : reached) {
    const Slot slot = editor->find(coord);
    std::optional<MaskCover> cover;
    if (masks) cover = coverOf(coord, largest);
    if (cover && cover->whole) continue;
    if (!cover && centre + kHalfDiagonal - least <= -band) {
      touched += setCube(coord, 1, result);
      continue;
    }
    if (blendsWith && !blendsWith.find(coord).isTile()) {
      blended.push_back(coord);
      continue;
    }
    ++touched;
    FloatBrick* mine = slot.isTile() || cover ? nullptr : editor->own(coord);
    swept.push_back(
        {slot, mine ? mine : editor->newBrick(coord), cover ? std::make_unique<MaskCover>(*cover) : nullptr, {}});
    if (swept.size() < kSweptAtOnce) continue;
    computeSwept(s, influenced);
    if (seen) co_yield Steps::kPause;
  }
  computeSwept(s, influenced);
}

// Bricks of a stamp have nothing to do with one another.
void BrushStroke::State::computeSwept(const Stamp& s, std::vector<Coord>& influenced) {
  const float band = editor->grid().band;
  const bool carving = *tool == Method::carve;
  const Precision precision = editor->base().store()->precision();
  const bool straight = std::abs(s.radiusAtEnd() - s.radius) <= static_cast<double>(kGrows) * (s.b - s.a).norm();
  parallelBlocks(
      swept.size(), swept.size() >= kParallelSwept ? threads : 1,
      [&](size_t begin, size_t end) {
        BrickValues scratch;
        for (size_t i = begin; i < end; ++i) {
          Swept& each = swept[i];
          FloatBrick& target = *each.brick;
          // The next ones come from memory while this one is computed. (Written out: clay/surface says why.)
          if (i + 1 < end) {
            const Brick* next[2] = {swept[i + 1].was.brick(), swept[i + 1].brick};
            for (const Brick* brick : next)
              for (size_t line = 0; brick && line < brickBytes(precision); line += 64)
                __builtin_prefetch(reinterpret_cast<const std::byte*>(brick) + line);
          }
          const float* source = each.was.values(scratch, band);
          float distance[kBrickVoxels], most = 0;
          tipDistances(*brush, s, target.coord, distance);
          if (brush->tip == Tip::ball && !each.cover && straight)
            each.exact = each.was.isTile() || !meetAtAnAngle(source, distance, carving ? -1.0f : 1.0f, band, kMeets);
          each.change =
              carving ? takeAwaySolid(distance, band, source, target) : layOnSolid(distance, band, source, target);
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

// Computes bricks (sorted) from the clay as it is now. Of many those are seen that are done.
Steps BrushStroke::State::work(std::span<const Stamp> images, std::vector<Coord> coords,
                               std::vector<Coord>& influenced) {
  if (coords.empty()) co_return;
  const bool inSteps = coords.size() > kBricksAStep;
  const Version was = inSteps ? commit() : Version();
  Sampler field = was ? Sampler(was) : Sampler(*editor);
  if (inSteps && !safe) safe = was;
  for (Steps each = method->begin(field, images, coords); each.next();)
    if (inSteps) co_yield Steps::kPause;
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
  std::vector<Result> results;
  std::vector<Coord> changed, drifted;
  std::optional<ChangeInParts> seenChange;
  if (inSteps) seenChange.emplace(*editor, coords);
  for (size_t from = 0, to; from < coords.size(); from = to) {
    to = std::min(from + kBricksAStep, coords.size());
    const std::span<const Coord> some = std::span(coords).subspan(from, to - from);
    results.assign(some.size(), {});
    for (size_t i = 0; i < some.size(); ++i) {
      results[i].brick = editor->newBrick(some[i]);
      if (masks) results[i].cover = coverOf(some[i], largest);
    }
    parallelBlocks(
        some.size(), coords.size() >= kParallelFrom ? threads : 1,
        [&](size_t begin, size_t end) {
          Sampler mine = field;
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
    for (size_t i = 0; i < some.size(); ++i) {
      const Result& r = results[i];
      if (!r.change.changed) {
        editor->recycle(r.brick);
        continue;
      }
      const Renew renew = masks ? std::max(method->leaves(), Renew::slopes) : method->leaves();
      if (trail.change(some[i], method->lasting() ? 0 : r.most, renew)) drifted.push_back(some[i]);
      changed.push_back(some[i]);
      if (seenChange)
        seenChange->link(from + i, r.brick, r.change.inBand);
      else
        editor->link(r.brick, r.change.inBand);
    }
    if (!seenChange) continue;
    seenChange->done(to);
    co_yield Steps::kPause;
  }
  touched += coords.size();
  computed = coords.size();
  // The surface may have come nearer to a neighbour that is a tile yet: redistancing makes the brick if so.
  const std::vector<Coord> near = withNeighbours(changed);
  influenced.insert(influenced.end(), near.begin(), near.end());
  if (!drifted.empty())
    for (Steps each = redistanceBricks(trail.takeNow(drifted)); each.next();) co_yield Steps::kPause;
  if (inSteps) collect();
}

Steps BrushStroke::State::computeBegun(std::vector<Coord>& influenced) {
  if (begun.empty()) co_return;
  const std::vector<Stamp> images = std::exchange(begun, {});
  const double moved = std::exchange(begunMove, 0);
  begunCount = 0;
  for (Steps each = work(images, reached(images, moved), influenced); each.next();) co_yield Steps::kPause;
}

Steps BrushStroke::State::workOnPart(const Part& part, bool together, std::vector<Coord>& influenced) {
  const std::vector<Stamp>& images = part.images;
  const double move = method->moves(images);
  if (!std::isfinite(move)) {
    for (Steps each = work(images, reached(images), influenced); each.next();) co_yield Steps::kPause;
    co_return;
  }
  // Where each of them moves clay a little they are computed together: they look at the same bricks.
  if (!begun.empty() && !goesAlong(images, move))
    for (Steps each = computeBegun(influenced); each.next();) co_yield Steps::kPause;
  {
    Sampler field(*editor);
    method->follow(field, images);
  }
  if (part.first || begun.empty()) ++begunCount;
  begun.insert(begun.end(), images.begin(), images.end());
  begunMove += move;
  const bool enough = part.last && begunCount == kTogether;
  if (together && !enough && goesAlong(images, move)) {
    begunOnce = true;
    co_return;
  }
  for (Steps each = computeBegun(influenced); each.next();) co_yield Steps::kPause;
}

Steps BrushStroke::State::workInParts(std::span<const Stamp> images, bool together, std::vector<Coord>& influenced) {
  const int parts = method->parts(images);
  for (int i = 0; i < parts; ++i) {
    Part part{{images.begin(), images.end()}, i == 0, i == parts - 1};
    if (parts > 1) part.images = method->part(images, i, parts);
    if (i > 0) {
      Sampler field(*editor);
      part.images = method->placed(field, part.images);
    }
    for (Steps each = workOnPart(part, together, influenced); each.next();) co_yield Steps::kPause;
  }
}

Steps BrushStroke::State::redistanceBricks(Trail::Work work) {
  const bool inSteps = work.bricks.size() > redistancing.atOnce;
  const Version was = inSteps ? commit() : Version();
  const Sampler field = was ? Sampler(was) : Sampler(*editor);
  for (const RedistancePart& part :
       redistanceParts(std::move(work.bricks), std::move(work.renew), editor->grid().band, redistancing)) {
    (void)linkSettled(*editor, redistancePart(field, *editor, part, threads, redistancing));
    if (inSteps) co_yield Steps::kPause;
  }
}

Steps BrushStroke::State::redistanceDue(size_t most) {
  if (trail.due() == 0) co_return;
  const Version was = seen = beforeChange();
  for (Steps each = redistanceBricks(trail.take(most)); each.next();) co_yield Steps::kPause;
  carry(was, nullptr, {});
  seen = {};
}

// What has to be done before these images are applied: bricks of the applications before that these cannot be computed
// with; and where what the method keeps has grown too large, that it goes on from the clay as it is now.
Steps BrushStroke::State::prepare(std::span<const Stamp> images) {
  if (!method) co_return;
  const bool full = method->full();
  if (!begun.empty() && (full || (method->parts(images) == 1 && !goesAlong(images, method->moves(images))))) {
    std::vector<Coord> influenced;
    for (Steps each = computeBegun(influenced); each.next();) co_yield Steps::kPause;
    trail.touch(stamps, std::move(influenced));
    co_yield Steps::kPause;
  }
  if (!full) co_return;
  trail.follow(stamps);
  while (trail.due() > 0) {
    for (Steps each = redistanceDue(redistancing.atOnce); each.next();) co_yield Steps::kPause;
    co_yield Steps::kPause;
  }
  method->beginAnew(commit());
  collect();
}

BrushStroke::BrushStroke(Version base, std::shared_ptr<const Brush> brush, Version start, int threads)
    : state_(std::make_unique<State>(std::move(base), std::move(brush), std::move(start), threads)) {}
BrushStroke::~BrushStroke() = default;

void BrushStroke::apply(std::span<const Stamp> images) {
  while (step(images)) {
  }
}

bool BrushStroke::step(std::span<const Stamp> given) {
  State& s = *state_;
  if (!s.inWork) {
    if (given.empty() || given.size() > kMostImages) throw Error("a stamp has 1 to 64 images");
    for (const Stamp& each : given) checkStamp(each);
    s.inWork.emplace(s.wallLimit ? s.applicationWithinWalls(quantised(given)) : s.application(quantised(given)));
  }
  try {
    if (s.inWork->next()) return true;
  } catch (...) {
    s.inWork.reset();
    s.seen = {};
    if (s.safe) s.editor.emplace(std::exchange(s.safe, {}));
    throw;
  }
  s.inWork.reset();
  s.safe = {};
  return false;
}

// One after the other: what one image cuts may be the far side of another.
Steps BrushStroke::State::applicationWithinWalls(std::vector<Stamp> images) {
  for (size_t i = 0; i < images.size(); ++i)
    for (const Stamp& allowed : wallLimit->allowed(*editor, images[i], i))
      for (Steps each = application(quantised(std::span(&allowed, 1))); each.next();) co_yield Steps::kPause;
}

Steps BrushStroke::State::application(std::vector<Stamp> images) {
  for (Steps each = prepare(images); each.next();) co_yield Steps::kPause;
  if (method) {
    Sampler field(*editor);
    images = method->placed(field, images);
  }
  const Version was = beforeChange();
  seen = was;  // until what goes along with the clay has gone along
  std::vector<Coord> influenced;
  // what a mask covers in part depends on the order of images
  const bool blends = images.size() > 1 && editor->has(Channel::mask);
  if (tool && !blends) {
    // Cutting away one thing after the other gives the same in any order.
    std::vector<Coord> blended;
    const bool large = std::any_of(images.begin(), images.end(), [&](const Stamp& each) {
      return each.largestRadius() * aroundTip(*brush) >= (blendsWith ? kLargeBlended : kLargeTip);
    });
    if (large) safe = seen = commit();
    const std::vector<Stamp> last = std::exchange(sweptBefore, {});
    for (size_t i = 0; i < images.size(); ++i)
      for (Steps each = sweepTip(images[i], i < last.size() ? &last[i] : nullptr, influenced, blended); each.next();)
        co_yield Steps::kPause;
    std::sort(blended.begin(), blended.end());
    blended.erase(std::unique(blended.begin(), blended.end()), blended.end());
    for (Steps each = work(images, std::move(blended), influenced); each.next();) co_yield Steps::kPause;
    seen = was;
    if (brush->tip == Tip::ball && !editor->has(Channel::mask)) sweptBefore = images;
  } else if (method) {
    // What goes along with clay is looked at application by application.
    for (Steps each = workInParts(images, !was, influenced); each.next();) co_yield Steps::kPause;
  }
  const uint64_t number = ++stamps;
  trail.touch(number, std::move(influenced));
  // What is computed together is touched again together.
  const uint64_t behind = static_cast<uint64_t>(brush->quality.trail) + (begunOnce ? kTogether : 0);
  if (number > behind) trail.follow(number - behind);
  if (trail.due() >= std::max(kBatch, computed / 2))
    for (Steps each = redistanceBricks(trail.take(SIZE_MAX)); each.next();) co_yield Steps::kPause;
  carry(was, tool ? nullptr : method.get(), images);
  for (const Operation& each : brush->operations)
    if (each.property != Property::distance) applyToChannels(*editor, *brush, each, images, laidShares);
  seen = {};
}

Version BrushStroke::publish() {
  return state_->seen ? state_->seen : state_->commit();
}

Version BrushStroke::finish() {
  State& s = *state_;
  if (s.inWork) s.inWork->finish();
  s.inWork.reset();
  s.safe = {};
  std::vector<Coord> influenced;
  s.computeBegun(influenced).finish();
  s.trail.touch(s.stamps, std::move(influenced));
  s.trail.follow(s.stamps);
  s.redistanceDue(SIZE_MAX).finish();
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
