#include "clay/store/store.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#include "clay/base/memory_guard.h"
#include "clay/store/tree.h"

namespace argil::clay {

namespace {
constexpr size_t kStock = 128, kNodeStock = 16;  // objects an editor takes at once: one lock for about a dab
constexpr size_t kLeastStock = 4;
constexpr size_t kShareInStock = 8;  // of what a pool has, its next chunk is this part
constexpr size_t kPage = 4096, kBlockAlignment = 64;
}  // namespace

double bytesOfClay(double area, Precision precision, double band, double slant) {
  constexpr double kBytesOfQuad = 32, kNodesOfBrick = 50;  // bytes of a brick's share of nodes
  // A brick is there where one of its voxels is in the band: it is 7 voxels wide along an axis.
  constexpr double kWidth = kBrickEdge - 1, kMiddle = 0.15;
  const double bricks = area * (2 * band + kWidth * slant + kMiddle) / kBrickVoxels;
  return bricks * (double(brickBytes(precision)) + kNodesOfBrick) + area * slant * kBytesOfQuad;
}

SlabPool::~SlabPool() {
  for (std::byte* arena : arenas_) munmap(arena, kArenaBytes + kSlabBytes);
  for (std::byte* chunk : small_) std::free(chunk);
}

size_t SlabPool::nextBytes() const {
  const size_t wanted = std::max(static_cast<size_t>(bytes_) / kShareInStock, kLeastObjects * objectBytes_);
  return wanted >= kSlabBytes ? kSlabBytes : wanted / objectBytes_ * objectBytes_;
}

uint64_t SlabPool::heapBytes() const {
  const std::lock_guard lock(arenaMutex_);
  const uint64_t slabs = arenas_.empty() ? 0 : (arenas_.size() - 1) * (kArenaBytes / kSlabBytes) + slabsInArena_;
  return bytes_ - std::min(bytes_, slabs * kSlabBytes);  // a slab may be mapped that is not adopted yet
}

SlabPool::Chunk SlabPool::map(size_t bytes) {
  std::byte* chunk = nullptr;
  if (bytes < kSlabBytes) {
    chunk = static_cast<std::byte*>(std::aligned_alloc(kBlockAlignment, bytes));
    if (!chunk) throw std::bad_alloc();
    const std::lock_guard lock(arenaMutex_);
    small_.push_back(chunk);
  } else {
    claimMemory(bytes);
    const std::lock_guard lock(arenaMutex_);
    if (arenas_.empty() || slabsInArena_ == kArenaBytes / kSlabBytes) {
      void* map = mmap(nullptr, kArenaBytes + kSlabBytes, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
      if (map == MAP_FAILED) throw std::bad_alloc();
      arenas_.push_back(static_cast<std::byte*>(map));
      slabsInArena_ = 0;
    }
    const auto base = (reinterpret_cast<uintptr_t>(arenas_.back()) + kSlabBytes - 1) & ~(kSlabBytes - 1);
    chunk = reinterpret_cast<std::byte*>(base + slabsInArena_++ * kSlabBytes);
    // One fault for a whole slab where the system grants huge pages, and never one in a kernel.
    madvise(chunk, kSlabBytes, MADV_HUGEPAGE);
  }
  for (size_t at = 0; at < bytes; at += kPage) chunk[at] = std::byte{0};
  chunk[bytes - 1] = std::byte{0};
  return {chunk, bytes};
}

void SlabPool::adopt(Chunk chunk) {
  // Lowest address last, so that it is handed out first.
  const size_t count = chunk.bytes / objectBytes_, all = bytes_ / objectBytes_ + count;
  if (all > free_.capacity()) free_.reserve(std::max(all, 2 * free_.capacity()));
  for (size_t i = count; i-- > 0;) free_.push_back(chunk.at + i * objectBytes_);
  bytes_ += chunk.bytes;
}

void SlabPool::take(size_t count, ObjectStock& stock) {
  std::vector<void*>& out = stock.free;
  if (stock.taken + count > out.capacity()) out.reserve(std::max(stock.taken + count, 2 * out.capacity()));
  while (free_.size() < count) adopt(map(nextBytes()));
  stock.taken += count;
  taken_ += count;
  out.insert(out.end(), free_.end() - static_cast<std::ptrdiff_t>(count), free_.end());
  free_.resize(free_.size() - count);
}

size_t Store::State::stockOf(uint64_t live, size_t most) {
  return std::clamp(static_cast<size_t>(live) / kShareInStock, std::min(kLeastStock, most), most);
}

void Store::State::stockBricks(ObjectStock& stock) {
  const std::lock_guard lock(mutex);
  const size_t count = stockOf(liveBricks, kStock);
  bricks.take(count, stock);
  liveBricks += count;
  taken = true;
  if (bricks.low()) due = true;
}

void Store::State::stockNodes(ObjectStock& stock) {
  const std::lock_guard lock(mutex);
  const size_t count = stockOf(liveNodes, kNodeStock);
  nodes.take(count, stock);
  liveNodes += count;
  taken = true;
  if (nodes.low()) due = true;
}

void Store::State::stockWorkBricks(ObjectStock& stock) {
  const std::lock_guard lock(mutex);
  workBricks.take(stockOf(liveBricks, kStock), stock);
}

void Store::State::giveWorkBricks(const std::vector<void*>& stock) {
  if (stock.empty()) return;
  const std::lock_guard lock(mutex);
  workBricks.give(stock);
}

void Store::State::stockChannelBricks(ObjectStock& stock) {
  const std::lock_guard lock(mutex);
  const size_t count = stockOf(liveChannelBricks, kStock);
  channelBricks.take(count, stock);
  liveChannelBricks += count;
  taken = true;
  if (channelBricks.low()) due = true;
}

void Store::State::freeAll(Freed& freed) {
  const std::lock_guard lock(mutex);
  bricks.give(freed.bricks);
  channelBricks.give(freed.channelBricks);
  nodes.give(freed.nodes);
  liveBricks -= freed.bricks.size();
  liveChannelBricks -= freed.channelBricks.size();
  liveNodes -= freed.nodes.size();
  freed = {};
}

Store::Store(Precision precision) : state_(std::make_unique<State>(precision)) {}

// No version is left, so every record waits in `dropped`; bricks and nodes go with their slabs.
Store::~Store() {
  for (VersionRecord* record : state_->dropped) delete record;
  delete state_->victim;
}

std::shared_ptr<Store> Store::make(Precision precision) {
  return std::shared_ptr<Store>(new Store(precision));
}

Precision Store::precision() const {
  return state_->precision;
}

void gatherExclusive(Link own, Link before, Link after, int level, std::vector<void*>& leaves,
                     std::vector<void*>& nodes) {
  if (isTile(own) || own == before || own == after) return;
  if (level == 0) {
    leaves.push_back(reinterpret_cast<void*>(own));
    return;
  }
  const auto* node = reinterpret_cast<const Node*>(own);
  const auto childOf = [](Link link, int i) {
    return isTile(link) ? Link{0} : reinterpret_cast<const Node*>(link)->child[i];
  };
  for (int i = 0; i < 512; ++i)
    gatherExclusive(node->child[i], childOf(before, i), childOf(after, i), level - 1, leaves, nodes);
  nodes.push_back(reinterpret_cast<void*>(own));
}

bool Store::collect(size_t maxObjects) {
  State& s = *state_;
  const std::lock_guard onlyOne(s.collecting);
  s.due = false;
  // All the room that it needs, before anything is taken apart.
  constexpr size_t kDeepest = kTreeLevels + 1;
  State::Freed freed;
  freed.bricks.reserve(maxObjects + 512);
  freed.channelBricks.reserve(maxObjects + 512);
  freed.nodes.reserve(maxObjects / 8 + kDeepest);
  s.walk.reserve(kDeepest);
  // A node's 512 links count as 8 objects: the bound is on time, and a scan of shared links frees nothing.
  size_t work = 0;
  while (work < maxObjects) {
    if (!s.victim) {
      const std::lock_guard lock(s.mutex);
      // A version with two children waits until one of them is gone: what both share of it is not told apart by a walk.
      for (size_t i = 0; i < s.dropped.size() && !s.victim; ++i) {
        if (s.dropped[i]->children.size() > 1) continue;
        s.victim = s.dropped[i];
        s.dropped[i] = s.dropped.back();
        s.dropped.pop_back();
      }
      if (!s.victim) break;
      s.victimTree = 0;
    }
    for (; s.walk.empty() && s.victimTree < kTrees; ++s.victimTree) {
      // The tree of versions may grow meanwhile, but not between these three: a child of the victim is made from a
      // handle, and it has none.
      const std::lock_guard lock(s.mutex);
      const auto tree = static_cast<size_t>(s.victimTree);
      const Link own = s.victim->roots[tree];
      const Link before = s.victim->parent ? s.victim->parent->roots[tree] : 0;
      const Link after = s.victim->children.empty() ? 0 : s.victim->children.front()->roots[tree];
      if (!isTile(own) && own != before && own != after) s.walk.push_back({own, before, after, kTreeLevels, 0});
    }
    auto& leaves = freed.leaves(s.victimTree - 1);
    while (!s.walk.empty() && work < maxObjects) {
      State::Frame& f = s.walk.back();
      const auto childOf = [](Link link, int i) {
        return isTile(link) ? Link{0} : reinterpret_cast<const Node*>(link)->child[i];
      };
      const auto* node = reinterpret_cast<const Node*>(f.own);
      bool deeper = false;
      while (f.next < 512) {
        const int i = f.next++;
        const Link own = node->child[i];
        if (isTile(own)) continue;
        const Link before = childOf(f.before, i), after = childOf(f.after, i);
        if (own == before || own == after) continue;
        if (f.level == 1) {
          leaves.push_back(reinterpret_cast<void*>(own));
          ++work;
        } else {
          s.walk.push_back({own, before, after, f.level - 1, 0});
          deeper = true;
          break;
        }
      }
      if (!deeper) {
        freed.nodes.push_back(const_cast<Node*>(node));
        work += 8;
        s.walk.pop_back();
      }
    }
    if (s.walk.empty() && s.victimTree == kTrees) {
      const std::lock_guard lock(s.mutex);
      VersionRecord* v = s.victim;
      VersionRecord* child = v->children.empty() ? nullptr : v->children.front();
      if (child) child->parent = v->parent;
      if (v->parent) {
        auto& siblings = v->parent->children;
        for (size_t i = 0; i < siblings.size(); ++i)
          if (siblings[i] == v) {
            siblings.erase(siblings.begin() + static_cast<std::ptrdiff_t>(i));
            break;
          }
        if (child) siblings.push_back(child);
      }
      delete v;
      s.victim = nullptr;
      --s.versions;
      ++work;
    }
  }
  s.freeAll(freed);
  // Stock is for a model that is being edited: what its birth took is not looked at, or a thousand pieces that lie
  // there would have a thousand stocks.
  bool edited = false;
  {
    const std::lock_guard lock(s.mutex);
    edited = std::exchange(s.taken, false) && s.collected;
    s.collected = true;
  }
  for (SlabPool* pool : {&s.bricks, &s.channelBricks, &s.nodes}) {
    size_t missing = 0, next = 0;
    {
      const std::lock_guard lock(s.mutex);
      missing = pool->missing();
    }
    if (!edited) continue;
    try {
      while (missing > 0) {
        {
          const std::lock_guard lock(s.mutex);
          next = pool->nextBytes();
        }
        const SlabPool::Chunk chunk = pool->map(next);
        const std::lock_guard lock(s.mutex);
        pool->adopt(chunk);
        missing -= std::min(missing, next);
      }
    } catch (const std::exception&) {
      break;  // Stock that there is no memory for is not needed yet.
    }
  }
  const std::lock_guard lock(s.mutex);
  bool more = s.victim != nullptr;
  for (size_t i = 0; i < s.dropped.size() && !more; ++i) more = s.dropped[i]->children.size() <= 1;
  if (more) s.due = true;
  return more;
}

bool Store::wantsCollecting() const noexcept {
  return state_->due.load(std::memory_order_relaxed);
}

Store::Usage Store::usage() const {
  const std::lock_guard lock(state_->mutex);
  Usage usage;
  usage.bricks = state_->liveBricks;
  usage.nodes = state_->liveNodes;
  usage.channelBricks = state_->liveChannelBricks;
  usage.slabBytes =
      state_->bricks.bytes() + state_->channelBricks.bytes() + state_->nodes.bytes() + state_->workBricks.bytes();
  usage.heapBytes = state_->bricks.heapBytes() + state_->channelBricks.heapBytes() + state_->nodes.heapBytes() +
                    state_->workBricks.heapBytes();
  usage.versions = state_->versions;
  usage.precision = state_->precision;
  return usage;
}

uint64_t Store::Usage::bytes() const {
  return bricks * brickBytes(precision) + channelBricks * sizeof(ChannelBrick) + nodes * sizeof(Node);
}

}  // namespace argil::clay
