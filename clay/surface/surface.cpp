#include "clay/surface/surface.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <iterator>
#include <utility>

#include "clay/base/error.h"
#include "clay/base/hash.h"
#include "clay/base/job_scope.h"
#include "clay/base/parallel.h"
#include "clay/store/region_slots.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface_state.h"

namespace argil::clay {

namespace {

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

template <class T>
bool sameBytes(std::span<const T> a, const T* b) {
  return a.empty() || std::memcmp(a.data(), b, a.size_bytes()) == 0;
}

}  // namespace

// A mesh in one block of memory. Null `quads` leaves them to be written.
HeldPtr Surface::State::hold(BlockPool::Share& memory, const Coord& brick, const CellTable& table,
                             const Vec3f* positions, const PackedNormal* normalsHere,
                             const std::array<VertexRef, 4>* quads) {
  const size_t n = table.vertices, q = table.quads, s = table.specials.size(), c = table.sharp.size();
  const size_t tail = n * (sizeof(Vec3f) + (normals ? sizeof(PackedNormal) : 0)) + q * sizeof(*quads) +
                      s * sizeof(CellTable::Special) + c * sizeof(uint16_t);
  TailPlace memoryHere{memory, tail};
  HeldPtr held = std::allocate_shared<HeldMesh>(TailAllocator<HeldMesh>(memoryHere));
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

void Surface::State::extractRegionVertices(RegionTask& task, bool whole, SurfaceWorker& worker) {
  SurfaceRegion& region = *task.lower[0];
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
    if (const HeldMesh* before = region.held[bricks[i]].get())
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
void Surface::State::followVertices(RegionTask& task, int index, const Coord& brick, SurfaceWorker& worker) {
  SurfaceRegion& region = *task.lower[0];
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
  if (task.keep) task.before.emplace_back(index, std::move(held));
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

void Surface::State::extractRegionQuads(RegionTask& task, SurfaceWorker& worker) {
  const std::array<SurfaceRegion*, 8>& lower = task.lower;
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
  SurfaceRegion& own = *task.lower[0];
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
        const SurfaceRegion* r = lower[static_cast<size_t>((lx < 0) * 4 + (ly < 0) * 2 + (lz < 0))];
        const HeldMesh* source =
            r ? r->held[static_cast<size_t>(Brick::offset(lx & 7, ly & 7, lz & 7))].get() : nullptr;
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

void Surface::State::follow(std::vector<RegionTask> tasks, bool whole, int threads, SurfaceDelta& delta,
                            ReplacedMeshes* replaced) {
  for (RegionTask& task : tasks) {
    task.keep = replaced != nullptr;
    std::unique_ptr<SurfaceRegion>& region = regions[task.region];
    if (!region) region = std::make_unique<SurfaceRegion>();
    task.lower[0] = region.get();
    region->pending = true;
    task.firstSerial = nextSerial;
    nextSerial += 2 * 512;
  }
  for (RegionTask& task : tasks)
    for (int k = 1; k < 8; ++k)
      task.lower[static_cast<size_t>(k)] = region(task.region - Coord{k >> 2, (k >> 1) & 1, k & 1});
  // A thread takes a run of regions and makes both vertices and quads of each while they are in its cache. Quads need
  // the vertices of lower regions, which may be in the hands of another thread; then they come later.
  if (tasks.size() < 32) threads = 1;
  constexpr size_t kMostInARun = 4;
  std::atomic<size_t> next = 0;
  std::atomic<bool> failed = false;
  const Job* const job = JobScope::current();
  const auto ready = [](const RegionTask& task) {
    return std::none_of(task.lower.begin(), task.lower.end(),
                        [](const SurfaceRegion* r) { return r && r->pending.load(std::memory_order_acquire); });
  };
  const auto work = [&] {
    thread_local std::unique_ptr<ExtractionBuffer> buffer = std::make_unique_for_overwrite<ExtractionBuffer>();
    SurfaceWorker worker{*buffer, BlockPool::Share(*pool)};
    std::vector<RegionTask*> later;
    const auto tryLater = [&] {
      std::erase_if(later, [&](RegionTask* task) { return ready(*task) && (extractRegionQuads(*task, worker), true); });
    };
    for (;;) {
      size_t begin = next.load(std::memory_order_relaxed), end;
      do end = begin + std::clamp<size_t>((tasks.size() - begin) / (4 * static_cast<size_t>(threads)), 1, kMostInARun);
      while (begin < tasks.size() && !next.compare_exchange_weak(begin, end, std::memory_order_relaxed));
      if (begin >= tasks.size()) break;
      for (size_t i = begin; i < end; ++i) {
        if (job && job->cancelled()) throw Cancelled();
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
  for (const RegionTask& task : tasks) changed += task.changed.size();
  delta.changed.reserve(changed);
  for (RegionTask& task : tasks) {
    std::move(task.changed.begin(), task.changed.end(), std::back_inserter(delta.changed));
    for (auto& [index, held] : task.replaced) {
      HeldPtr before = std::exchange(task.lower[0]->held.at(static_cast<size_t>(index)), std::move(held));
      if (task.keep) task.before.emplace_back(index, std::move(before));
    }
    std::sort(task.before.begin(), task.before.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [index, held] : task.before) {
      const HeldPtr& there = task.lower[0]->held[static_cast<size_t>(index)];
      replaced->bytes += held ? bytesOf(*held) : 0;
      replaced->bytesThere += there ? bytesOf(*there) : 0;
      replaced->meshes.emplace_back(task.region * 8 + Coord{index >> 6, index >> 3 & 7, index & 7}, std::move(held));
    }
    vertexCount += static_cast<uint64_t>(task.vertices);
    quadCount += static_cast<uint64_t>(task.quads);
    bricksThatReadBeyond += static_cast<uint64_t>(task.readBeyond);
    if (replaced) {
      replaced->vertices -= task.vertices;
      replaced->quads -= task.quads;
      replaced->readBeyond -= task.readBeyond;
    }
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

SurfaceDelta Surface::update(const Version& version, int threads, bool keepBefore) {
  State& s = *state_;
  SurfaceDelta delta;
  delta.grid = version.grid();
  try {
    if (const auto kept = s.findKept(version); kept != s.kept.end()) {
      s.swap(*kept, delta);
      s.version = version;
      delta.keepsBefore = true;
    } else {
      s.extract(version, threads, keepBefore, delta);
    }
    s.paint.follow(version, *this, delta);
  } catch (...) {
    // Half of it is no surface: the next update starts anew.
    *this = Surface(s.normals, s.grade);
    throw;
  }
  return delta;
}

void Surface::State::extract(const Version& next, int threads, bool keepBefore, SurfaceDelta& delta) {
  const bool whole = !version || version.store() != next.store() || !(version.grid() == next.grid());
  RegionTasks tasks = whole ? allRegions(next) : changedRegions(next);
  const Version before = std::exchange(version, next);
  const uint64_t quads = quadCount;
  if (whole || !keepBefore) {
    follow(tasks.finish(), whole, threads, delta, nullptr);
    return;
  }
  ReplacedMeshes replaced{.from = next.id(), .to = before.id()};
  follow(tasks.finish(), whole, threads, delta, &replaced);
  keep(std::move(replaced), kBytesOfQuad * std::max(quads, quadCount));
  delta.keepsBefore = findKept(before) != kept.end();
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

Surface::Usage Surface::usage() const {
  const BlockPool::Usage blocks = state_->pool->usage();
  uint64_t tables = 0;
  for (const auto& entry : state_->regions) tables += sizeof(SurfaceRegion) + entry.second->held.bytes();
  return {blocks.bytes + tables, blocks.heapBytes + tables};
}

const BrickMesh* Surface::find(Coord brick) const {
  return state_->find(brick);
}

void Surface::forEach(const std::function<void(const BrickMesh&)>& visit) const {
  state_->forEach([&](const HeldMesh& held) { visit(held); });
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
