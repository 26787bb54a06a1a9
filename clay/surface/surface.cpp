#include "clay/surface/surface.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <unordered_map>

#include "clay/base/block_pool.h"
#include "clay/base/hash.h"
#include "clay/base/parallel.h"
#include "clay/store/brick_set.h"
#include "clay/store/region_slots.h"
#include "clay/store/sampler.h"
#include "clay/store/tree_view.h"
#include "clay/surface/brick_extraction.h"
#include "clay/surface/vertex_channels.h"

namespace argil::clay {

namespace {

constexpr uint64_t kLowZ = 0x0101010101010101ull;  // z = 0 of each row of a region's words

// Bit y·8 + z of word x: a brick of a region.
using RegionBits = std::array<uint64_t, 8>;

// A mesh, how its cells number their vertices, and behind them in one block all that it spans.
struct Held : BrickMesh {
  CellTable table;
};
using HeldPtr = std::shared_ptr<Held>;

// The meshes of a region's bricks, by slices of x that are there as far as they are used: most regions hold a sheet of
// surface, and a small model a corner of eight regions.
class HeldTable {
 public:
  [[nodiscard]] const HeldPtr& operator[](size_t i) const {
    const auto& slice = slices_[i >> 6];
    return slice ? (*slice)[i & 63] : none_;
  }
  [[nodiscard]] HeldPtr& at(size_t i) {
    auto& slice = slices_[i >> 6];
    if (!slice) slice = std::make_unique<std::array<HeldPtr, 64>>();
    return (*slice)[i & 63];
  }

 private:
  static inline const HeldPtr none_;
  std::array<std::unique_ptr<std::array<HeldPtr, 64>>, 8> slices_;
};

struct Region {
  HeldTable held;
  int count = 0;
  // Of the update that runs: vertices are not there yet; bricks whose vertices are others now.
  std::atomic<bool> pending = false;
  RegionBits changed{};
};

// What an update does in one region.
struct Task {
  Coord region;
  RegionBits wanted{};             // bricks whose vertices may be others now
  std::array<Region*, 8> lower{};  // its own and those dx·4 + dy·2 + dz lower, or null
  uint64_t firstSerial = 0;
  // Filled in:
  RegionBits looked{}, gone{};
  std::vector<BrickMeshPtr> changed;
  // what differs in quads alone, not to be put in before all others have read what was
  std::vector<std::pair<int, HeldPtr>> replaced;
  int64_t vertices = 0, quads = 0, readBeyond = 0;  // what came on top
};

// A thread at work.
struct Worker {
  ExtractionBuffer& buffer;
  BlockPool::Share memory;
};

// Tasks by region, cheap to find again.
class TaskList {
 public:
  Task& at(Coord region) {
    if (tasks_.empty() || region != lastRegion_) {
      lastRegion_ = region;
      last_ = index_.try_emplace(region, tasks_.size()).first->second;
      if (last_ == tasks_.size()) tasks_.emplace_back().region = region;
    }
    return tasks_[last_];
  }
  // The brick's vertices are to be looked at, and the quads that may use them.
  void want(Coord brick) { at(brick >> 3).wanted[static_cast<size_t>(brick.x & 7)] |= bitOf(brick); }
  static uint64_t bitOf(Coord brick) { return uint64_t{1} << ((brick.y & 7) * 8 + (brick.z & 7)); }

  // The same of all bricks dx, dy, dz (k = dx·4 + dy·2 + dz) lower than those of a region, by words.
  void wantLower(Coord region, int k, const RegionBits& bricks) {
    const int dx = k >> 2, dy = (k >> 1) & 1, dz = k & 1;
    for (int x = 0; x < 8; ++x) {
      const uint64_t word = bricks[static_cast<size_t>(x)];
      if (word == 0) continue;
      // What stays in the region, and what passes its lower face, along y and then along z.
      const uint64_t alongY[2] = {dy ? word >> 8 : word, dy ? word << 56 : 0};
      for (int py = 0; py < 2; ++py) {
        const uint64_t alongZ[2] = {dz ? alongY[py] >> 1 & ~(kLowZ << 7) : alongY[py],
                                    dz ? (alongY[py] & kLowZ) << 7 : 0};
        for (int pz = 0; pz < 2; ++pz)
          if (alongZ[pz] != 0)
            at(region - Coord{x < dx, py, pz}).wanted[static_cast<size_t>((x - dx) & 7)] |= alongZ[pz];
      }
    }
  }

  // With those regions whose quads alone may change, in order.
  std::vector<Task> finish() {
    for (size_t i = 0, count = tasks_.size(); i < count; ++i) {
      const RegionBits wanted = tasks_[i].wanted;
      const Coord region = tasks_[i].region;
      const uint64_t all =
          wanted[0] | wanted[1] | wanted[2] | wanted[3] | wanted[4] | wanted[5] | wanted[6] | wanted[7];
      for (int k = 1; k < 8; ++k) {
        uint64_t last = k & 4 ? wanted[7] : all;
        if (k & 2) last &= uint64_t{0xff} << 56;
        if (k & 1) last &= kLowZ << 7;
        if (last != 0) at(region + Coord{k >> 2, (k >> 1) & 1, k & 1});
      }
    }
    std::sort(tasks_.begin(), tasks_.end(), [](const Task& a, const Task& b) { return a.region < b.region; });
    return std::move(tasks_);
  }

 private:
  std::vector<Task> tasks_;
  std::unordered_map<Coord, size_t, CoordHash> index_;
  Coord lastRegion_;
  size_t last_ = 0;
};

// Regions whose bricks can have a vertex.
void addRegions(Link link, int level, Coord first, TaskList& tasks) {
  if (isTile(link)) return;
  if (level == 1) {
    for (int k = 0; k < 8; ++k) tasks.at((first >> 3) - Coord{k >> 2, (k >> 1) & 1, k & 1});
    return;
  }
  const int step = 1 << (3 * (level - 1));
  for (int i = 0; i < 512; ++i)
    addRegions(reinterpret_cast<const Node*>(link)->child[i], level - 1,
               first + Coord{i >> 6, (i >> 3) & 7, i & 7} * step, tasks);
}

// Bricks of a region that can have a vertex: both signs among them and those one step higher.
RegionBits crossedBricks(const RegionSlots& slots) {
  // Bit z of [x][y]; first tiles and bricks by themselves, then together with those one step higher.
  unsigned inside[9][9] = {}, outside[9][9] = {};
  struct Place {
    const Brick* brick;
    int x, y, z;
  };
  Place places[9 * 9 * 9];
  int count = 0;
  for (int x = 0; x < 9; ++x)
    for (int y = 0; y < 9; ++y)
      for (int z = 0; z < 9; ++z) {
        const Slot slot = slots.at(x, y, z);
        if (const Brick* brick = slot.brick()) {
          __builtin_prefetch(brick->inside);
          places[count++] = {brick, x, y, z};
        } else {
          (slot.tile() == Tile::inside ? inside : outside)[x][y] |= 1u << z;
        }
      }
  // From the words themselves, which reading the signs needs next: a line fewer of each brick than by its two flags.
  for (int i = 0; i < count; ++i) {
    const auto& [brick, x, y, z] = places[i];
    uint64_t any = 0, all = ~uint64_t{0};
    for (const uint64_t word : brick->inside) any |= word, all &= word;
    inside[x][y] |= unsigned{any != 0} << z;
    outside[x][y] |= unsigned{all != ~uint64_t{0}} << z;
  }
  const auto together = [](unsigned(&bits)[9][9], int x, int y) {
    const unsigned all = bits[x][y] | bits[x][y + 1] | bits[x + 1][y] | bits[x + 1][y + 1];
    return (all | all >> 1) & 0xff;
  };
  RegionBits crossed{};
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      crossed[static_cast<size_t>(x)] |= uint64_t{together(inside, x, y) & together(outside, x, y)} << (y * 8);
  return crossed;
}

// Bit dx·4 + dy·2 + dz: the bricks differ in a voxel that cells of the brick dx, dy, dz lower have as a corner.
unsigned changedFor(Slot before, Slot after) {
  if (before.isTile() || after.isTile()) return 0xff;
  uint64_t d[8];
  BrickValues was, is;
  differingVoxels(before.brick()->values(was), after.brick()->values(is), d);
  const uint64_t all = d[0] | d[1] | d[2] | d[3] | d[4] | d[5] | d[6] | d[7];
  const auto bits = [](uint64_t word) {
    return unsigned{word != 0} | unsigned{(word & kLowZ) != 0} << 1 | unsigned{(word & 0xff) != 0} << 2 |
           unsigned{(word & 1) != 0} << 3;
  };
  return bits(all) | bits(d[0]) << 4;
}

template <class T>
bool sameBytes(std::span<const T> a, const T* b) {
  return a.empty() || std::memcmp(a.data(), b, a.size_bytes()) == 0;
}

}  // namespace

struct Surface::State {
  bool normals;
  Grade grade;
  Version version;
  std::unordered_map<Coord, std::unique_ptr<Region>, CoordHash> regions;
  BlockPool::Owner pool = BlockPool::make();
  SurfacePaint paint;
  uint64_t nextSerial = 1;
  uint64_t vertexCount = 0, quadCount = 0, bricksThatReadBeyond = 0;

  Region* region(Coord at) const {
    const auto it = regions.find(at);
    return it == regions.end() ? nullptr : it->second.get();
  }
  const Held* find(Coord brick) const {
    const Region* in = region(brick >> 3);
    return in ? in->held[static_cast<size_t>(Brick::offset(brick.x & 7, brick.y & 7, brick.z & 7))].get() : nullptr;
  }

  template <class Visit>
  void forEach(const Visit& visit) const {
    std::vector<Coord> keys;
    keys.reserve(regions.size());
    for (const auto& entry : regions) keys.push_back(entry.first);
    std::sort(keys.begin(), keys.end());
    for (const Coord key : keys)
      for (size_t i = 0; i < 512; ++i)
        if (const HeldPtr& held = regions.at(key)->held[i]) visit(*held);
  }

  HeldPtr hold(BlockPool::Share& memory, const Coord& brick, const CellTable& table, const Vec3f* positions,
               const PackedNormal* normalsHere, const std::array<VertexRef, 4>* quads);
  TaskList changedRegions(const Version& next) const;
  void extractRegionVertices(Task& task, bool whole, Worker& worker);
  void followVertices(Task& task, int index, const Coord& brick, Worker& worker);
  void extractRegionQuads(Task& task, Worker& worker);
  void follow(std::vector<Task> tasks, bool whole, int threads, SurfaceDelta& delta);
};

// A mesh in one block of memory. Null `quads` leaves them to be written.
HeldPtr Surface::State::hold(BlockPool::Share& memory, const Coord& brick, const CellTable& table,
                             const Vec3f* positions, const PackedNormal* normalsHere,
                             const std::array<VertexRef, 4>* quads) {
  const size_t n = table.vertices, q = table.quads, s = table.specials.size(), c = table.sharp.size();
  const size_t tail = n * (sizeof(Vec3f) + (normals ? sizeof(PackedNormal) : 0)) + q * sizeof(*quads) +
                      s * sizeof(CellTable::Special) + c * sizeof(uint16_t);
  TailPlace memoryHere{memory, tail};
  HeldPtr held = std::allocate_shared<Held>(TailAllocator<Held>(memoryHere));
  std::byte* at = memoryHere.at;
  const auto place = [&at]<class T>(const T* from, size_t count) {
    T* to = reinterpret_cast<T*>(at);
    if (from) std::memcpy(static_cast<void*>(to), from, count * sizeof(T));
    at += count * sizeof(T);
    return std::span<const T>(to, count);
  };
  held->brick = brick;
  held->positions = place(positions, n);
  held->normals = place(normalsHere, normals ? n : 0);
  held->quads = place(quads, q);
  held->table = table;
  held->table.specials = place(table.specials.data(), s);
  held->table.sharp = place(table.sharp.data(), c);
  return held;
}

// Bricks whose cells may have other vertices now: a cell reads its own brick and those one step higher; one with a
// folded face also reads the cell beyond, one with a kink all around; the fine grade reads around every brick.
TaskList Surface::State::changedRegions(const Version& next) const {
  TaskList tasks;
  // Of the region at hand, by how much lower: bricks with a change for those.
  Coord region{INT32_MIN, 0, 0};
  std::array<RegionBits, 8> changes{};
  const auto flush = [&] {
    for (int k = 0; k < 8; ++k) tasks.wantLower(region, k, changes[static_cast<size_t>(k)]);
    changes = {};
  };
  Version::forEachDifference(version, next, [&](Coord brick, Slot before, Slot after) {
    if (grade == Grade::fine) {
      for (const Coord step : kAroundSteps) tasks.want(brick + step);
      return;
    }
    if (brick >> 3 != region) {
      flush();
      region = brick >> 3;
    }
    for (unsigned left = changedFor(before, after); left != 0; left &= left - 1)
      changes[static_cast<size_t>(std::countr_zero(left))][static_cast<size_t>(brick.x & 7)] |= TaskList::bitOf(brick);
    if (bricksThatReadBeyond == 0) return;
    for (const Coord step : kAroundSteps) {
      // Folded faces of lower bricks look at layers that changedFor() has told of.
      if (grade == Grade::draft && step.x <= 0 && step.y <= 0 && step.z <= 0) continue;
      const Held* held = find(brick + step);
      if (held && held->table.readsBeyond) tasks.want(brick + step);
    }
  });
  flush();
  return tasks;
}

void Surface::State::extractRegionVertices(Task& task, bool whole, Worker& worker) {
  Region& region = *task.lower[0];
  const RegionSlots slots(version, task.region);
  Sampler field(version);
  if (whole) {
    task.wanted = crossedBricks(slots);
    for (size_t i = 0; i < 512 && region.count > 0; ++i)
      if (region.held[i]) task.wanted[i >> 6] |= uint64_t{1} << (i & 63);
  }
  uint16_t bricks[512 + kListPadding];
  const int count = listBits(task.wanted.data(), bricks);
  // Signs are read some bricks ahead, so that voxels are there when they are needed.
  constexpr int kAhead = 4;
  std::array<BrickInput, kAhead> inputs;
  const auto read = [&](int i) {
    if (i >= count) return;
    BrickInput& input = inputs[static_cast<size_t>(i % kAhead)];
    slots.corner(bricks[i] >> 6, bricks[i] >> 3 & 7, bricks[i] & 7, input.slots);
    input.step = field.step();
    readSigns(input);
    readRows(input);
    // What was there: its counters, head and cells.
    if (const Held* before = region.held[bricks[i]].get())
      for (int line = -1; line < 4; ++line) __builtin_prefetch(reinterpret_cast<const std::byte*>(before) + 64 * line);
  };
  for (int i = 0; i < kAhead; ++i) read(i);
  for (int i = 0; i < count; ++i) {
    const int index = bricks[i];
    const Coord brick = task.region * 8 + Coord{index >> 6, index >> 3 & 7, index & 7};
    extractVertices(field, brick, inputs[static_cast<size_t>(i % kAhead)], normals, grade, worker.buffer);
    read(i + kAhead);
    followVertices(task, index, brick, worker);
  }
}

// Puts the vertices in the buffer, or their absence, in the place of those that were.
void Surface::State::followVertices(Task& task, int index, const Coord& brick, Worker& worker) {
  Region& region = *task.lower[0];
  const auto set = [index](RegionBits& bits) { bits[static_cast<size_t>(index >> 6)] |= uint64_t{1} << (index & 63); };
  const ExtractionBuffer& buffer = worker.buffer;
  const CellTable& table = buffer.table;
  if (table.vertices == 0 && !region.held[static_cast<size_t>(index)]) return;
  HeldPtr& held = region.held.at(static_cast<size_t>(index));
  if (table.vertices > 0) set(task.looked);
  if (held) {
    // Quads follow the signs, which vertices do not tell all of: they are looked at even where these are the same.
    if (table.vertices > 0 && held->table == table && sameBytes(held->positions, buffer.positions.data()) &&
        sameBytes(held->normals, buffer.normals.data()))
      return;
    task.vertices -= held->table.vertices;
    task.quads -= static_cast<int64_t>(held->quads.size());
    task.readBeyond -= held->table.readsBeyond;
    --region.count;
  }
  set(region.changed);
  if (table.vertices == 0) {
    set(task.gone);
    held.reset();
    return;
  }
  held = hold(worker.memory, brick, table, buffer.positions.data(), buffer.normals.data(), nullptr);
  held->serial = held->vertexSerial = task.firstSerial + static_cast<uint64_t>(index);
  ++region.count;
  task.vertices += table.vertices;
  task.quads += table.quads;
  task.readBeyond += table.readsBeyond;
}

void Surface::State::extractRegionQuads(Task& task, Worker& worker) {
  const std::array<Region*, 8>& lower = task.lower;
  ExtractionBuffer& buffer = worker.buffer;
  const auto changedAt = [&](int k, int x) {
    return lower[static_cast<size_t>(k)] ? lower[static_cast<size_t>(k)]->changed[static_cast<size_t>(x)] : 0;
  };
  // Bricks with a change in themselves or one lower along y and z.
  const auto spread = [&](int k, int x) {
    const auto toZ = [](uint64_t here, uint64_t below) { return (here << 1 & ~kLowZ) | (below >> 7 & kLowZ); };
    const auto toY = [](uint64_t here, uint64_t below) { return here << 8 | below >> 56; };
    const uint64_t w = changedAt(k, x), z = changedAt(k + 1, x), y = changedAt(k + 2, x), yz = changedAt(k + 3, x);
    const uint64_t atY = w | toY(w, y);
    return atY | toZ(atY, z | toY(z, yz));
  };
  const RegionSlots slots(version, task.region);
  Region& own = *task.lower[0];
  for (int x = 0; x < 8; ++x) {
    const auto in = static_cast<size_t>(x);
    const uint64_t wanted = task.looked[in] | task.gone[in] | spread(0, x) | (x > 0 ? spread(0, x - 1) : spread(4, 7));
    for (uint64_t left = wanted; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left), y = bit >> 3, z = bit & 7;
      if (task.gone[in] >> bit & 1) {
        auto none = std::make_shared<BrickMesh>();
        none->brick = task.region * 8 + Coord{x, y, z};
        none->serial = none->vertexSerial = task.firstSerial + static_cast<uint64_t>(x * 64 + bit);
        task.changed.push_back(std::move(none));
        continue;
      }
      HeldPtr held = own.held[static_cast<size_t>(x * 64 + bit)];
      if (!held) continue;
      std::array<VertexSource, 8> sources;
      for (int k = 0; k < 8; ++k) {
        const int lx = x - (k >> 2), ly = y - ((k >> 1) & 1), lz = z - (k & 1);
        const Region* r = lower[static_cast<size_t>((lx < 0) * 4 + (ly < 0) * 2 + (lz < 0))];
        const Held* source = r ? r->held[static_cast<size_t>(Brick::offset(lx & 7, ly & 7, lz & 7))].get() : nullptr;
        if (source) sources[static_cast<size_t>(k)] = {&source->table, source->positions.data()};
      }
      BrickInput input;
      slots.corner(x, y, z, input.slots);
      readSigns(input);
      extractQuads(input.signs, sources, buffer);
      if (own.changed[in] >> bit & 1) {
        std::copy_n(buffer.quads.data(), held->quads.size(), const_cast<std::array<VertexRef, 4>*>(held->quads.data()));
      } else {
        if (sameBytes(held->quads, buffer.quads.data())) continue;
        HeldPtr other = hold(worker.memory, held->brick, held->table, held->positions.data(), held->normals.data(),
                             buffer.quads.data());
        other->serial = task.firstSerial + static_cast<uint64_t>(512 + x * 64 + bit);
        other->vertexSerial = held->vertexSerial;
        task.replaced.emplace_back(x * 64 + bit, other);
        held = std::move(other);
      }
      task.changed.push_back(std::move(held));
    }
  }
}

void Surface::State::follow(std::vector<Task> tasks, bool whole, int threads, SurfaceDelta& delta) {
  for (Task& task : tasks) {
    std::unique_ptr<Region>& region = regions[task.region];
    if (!region) region = std::make_unique<Region>();
    task.lower[0] = region.get();
    region->pending = true;
    task.firstSerial = nextSerial;
    nextSerial += 2 * 512;
  }
  for (Task& task : tasks)
    for (int k = 1; k < 8; ++k)
      task.lower[static_cast<size_t>(k)] = region(task.region - Coord{k >> 2, (k >> 1) & 1, k & 1});
  // A thread takes a run of regions and makes both vertices and quads of each while they are in its cache. Quads need
  // the vertices of lower regions, which may be in the hands of another thread; then they come later.
  if (tasks.size() < 32) threads = 1;
  constexpr size_t kMostInARun = 4;
  std::atomic<size_t> next = 0;
  std::atomic<bool> failed = false;
  const auto ready = [](const Task& task) {
    return std::none_of(task.lower.begin(), task.lower.end(),
                        [](const Region* r) { return r && r->pending.load(std::memory_order_acquire); });
  };
  const auto work = [&] {
    thread_local std::unique_ptr<ExtractionBuffer> buffer = std::make_unique_for_overwrite<ExtractionBuffer>();
    Worker worker{*buffer, BlockPool::Share(*pool)};
    std::vector<Task*> later;
    const auto tryLater = [&] {
      std::erase_if(later, [&](Task* task) { return ready(*task) && (extractRegionQuads(*task, worker), true); });
    };
    for (;;) {
      size_t begin = next.load(std::memory_order_relaxed), end;
      do end = begin + std::clamp<size_t>((tasks.size() - begin) / (4 * static_cast<size_t>(threads)), 1, kMostInARun);
      while (begin < tasks.size() && !next.compare_exchange_weak(begin, end, std::memory_order_relaxed));
      if (begin >= tasks.size()) break;
      for (size_t i = begin; i < end; ++i) {
        extractRegionVertices(tasks[i], whole, worker);
        tasks[i].lower[0]->pending.store(false, std::memory_order_release);
        tryLater();
        if (ready(tasks[i]))
          extractRegionQuads(tasks[i], worker);
        else
          later.push_back(&tasks[i]);
      }
    }
    for (; !later.empty() && !failed.load(std::memory_order_relaxed); tryLater())
      if (!ready(*later.front())) std::this_thread::yield();
  };
  parallelBlocks(
      static_cast<size_t>(threads), threads,
      [&](size_t, size_t) {
        try {
          work();
        } catch (...) {
          failed = true;
          throw;
        }
      },
      1);

  size_t changed = 0;
  for (const Task& task : tasks) changed += task.changed.size();
  delta.changed.reserve(changed);
  for (Task& task : tasks) {
    std::move(task.changed.begin(), task.changed.end(), std::back_inserter(delta.changed));
    for (auto& [index, held] : task.replaced) task.lower[0]->held.at(static_cast<size_t>(index)) = std::move(held);
    vertexCount += static_cast<uint64_t>(task.vertices);
    quadCount += static_cast<uint64_t>(task.quads);
    bricksThatReadBeyond += static_cast<uint64_t>(task.readBeyond);
    task.lower[0]->changed = {};
    if (task.lower[0]->count == 0) regions.erase(task.region);
  }
}

Surface::Surface(bool normals, Grade grade) : state_(std::make_unique<State>()) {
  state_->normals = normals;
  state_->grade = grade;
}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

SurfaceDelta Surface::update(const Version& version, int threads) {
  State& s = *state_;
  SurfaceDelta delta;
  delta.grid = version.grid();
  TaskList tasks;
  // Another model: all that stood is looked at again, together with all that stands.
  const bool whole = !s.version || s.version.store() != version.store() || !(s.version.grid() == version.grid());
  if (whole) {
    addRegions(version.record()->roots[kDistanceTree], kTreeLevels, treeFirst(), tasks);
    for (const auto& entry : s.regions) tasks.at(entry.first);
  } else {
    tasks = s.changedRegions(version);
  }
  s.version = version;
  try {
    s.follow(tasks.finish(), whole, threads, delta);
    s.paint.follow(version, *this, delta);
  } catch (...) {
    // Half of it is no surface: the next update starts anew.
    *this = Surface(s.normals, s.grade);
    throw;
  }
  return delta;
}

const Version& Surface::version() const {
  return state_->version;
}
uint64_t Surface::vertexCount() const {
  return state_->vertexCount;
}
uint64_t Surface::quadCount() const {
  return state_->quadCount;
}

const BrickMesh* Surface::find(Coord brick) const {
  return state_->find(brick);
}

void Surface::forEach(const std::function<void(const BrickMesh&)>& visit) const {
  state_->forEach([&](const Held& held) { visit(held); });
}

uint64_t Surface::hash() const {
  Hasher hasher;
  forEach([&](const BrickMesh& mesh) {
    hasher.add(&mesh.brick, sizeof mesh.brick);
    hasher.add(mesh.positions.data(), mesh.positions.size_bytes());
    hasher.add(mesh.normals.data(), mesh.normals.size_bytes());
    hasher.add(mesh.quads.data(), mesh.quads.size_bytes());
  });
  return hasher.value();
}

}  // namespace argil::clay
