#pragma once
// What a Surface holds, and what its updates are made of. This folder's own.

#include <algorithm>
#include <atomic>
#include <bit>
#include <unordered_map>

#include "clay/base/block_pool.h"
#include "clay/surface/brick_extraction.h"
#include "clay/surface/surface.h"
#include "clay/surface/vertex_channels.h"

namespace argil::clay {

inline constexpr uint64_t kLowZ = 0x0101010101010101ull;  // z = 0 of each row of a region's words

// Bit y·8 + z of word x: a brick of a region.
using RegionBits = std::array<uint64_t, 8>;

// A mesh, how its cells number their vertices, and behind them in one block all that it spans.
struct HeldMesh : BrickMesh {
  CellTable table;
};
using HeldPtr = std::shared_ptr<HeldMesh>;

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

  [[nodiscard]] uint64_t bytes() const {
    uint64_t sum = 0;
    for (const auto& slice : slices_) sum += slice ? sizeof(*slice) : 0;
    return sum;
  }

 private:
  static inline const HeldPtr none_;
  std::array<std::unique_ptr<std::array<HeldPtr, 64>>, 8> slices_;
};

struct SurfaceRegion {
  HeldTable held;
  int count = 0;
  // Of the update that runs: vertices are not there yet; bricks whose vertices are others now.
  std::atomic<bool> pending = false;
  RegionBits changed{};
};

// What an update does in one region.
struct RegionTask {
  Coord region;
  RegionBits wanted{};                    // bricks whose vertices may be others now
  std::array<SurfaceRegion*, 8> lower{};  // its own and those dx·4 + dy·2 + dz lower, or null
  uint64_t firstSerial = 0;
  // Filled in:
  RegionBits looked{}, gone{};
  std::vector<BrickMeshPtr> changed;
  // what differs in quads alone, not to be put in before all others have read what was
  std::vector<std::pair<int, HeldPtr>> replaced;
  bool keep = false;
  std::vector<std::pair<int, HeldPtr>> before;  // what stood where something else does now, null included; if `keep`
  int64_t vertices = 0, quads = 0, readBeyond = 0;  // what came on top
};

// What update() from one version to another replaces, both ways.
struct ReplacedMeshes {
  uint64_t from = 0, to = 0;  // versions' ids
  std::vector<std::pair<Coord, HeldPtr>> meshes = {};
  uint64_t bytes = 0, bytesThere = 0;  // of these meshes, and of those that stand in their places
  // What comes on top when both change places: known, so that no mesh is looked at for it.
  int64_t vertices = 0, quads = 0, readBeyond = 0;
};

inline constexpr uint64_t kBytesOfQuad = 32;  // with its vertex and its part of the head
[[nodiscard]] uint64_t bytesOf(const HeldMesh& held);

// A thread at work.
struct SurfaceWorker {
  ExtractionBuffer& buffer;
  BlockPool::Share memory;
};

// Tasks by region, cheap to find again.
class RegionTasks {
 public:
  RegionTask& at(Coord region) {
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
  std::vector<RegionTask> finish() {
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
    std::sort(tasks_.begin(), tasks_.end(),
              [](const RegionTask& a, const RegionTask& b) { return a.region < b.region; });
    return std::move(tasks_);
  }

 private:
  std::vector<RegionTask> tasks_;
  std::unordered_map<Coord, size_t, CoordHash> index_;
  Coord lastRegion_;
  size_t last_ = 0;
};

// surface.cpp extracts, surface_changes.cpp tells where, surface_kept.cpp goes back.
struct Surface::State {
  bool normals;
  Grade grade;
  Version version;
  std::unordered_map<Coord, std::unique_ptr<SurfaceRegion>, CoordHash> regions;
  BlockPool::Owner pool = BlockPool::make();
  SurfacePaint paint;
  uint64_t nextSerial = 1;
  uint64_t vertexCount = 0, quadCount = 0, bricksThatReadBeyond = 0;
  std::vector<ReplacedMeshes> kept;  // the newest last

  SurfaceRegion* region(Coord at) const {
    const auto it = regions.find(at);
    return it == regions.end() ? nullptr : it->second.get();
  }
  const HeldMesh* find(Coord brick) const {
    const SurfaceRegion* in = region(brick >> 3);
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
  RegionTasks allRegions(const Version& next) const;
  RegionTasks changedRegions(const Version& next) const;
  void extractRegionVertices(RegionTask& task, bool whole, SurfaceWorker& worker);
  void followVertices(RegionTask& task, int index, const Coord& brick, SurfaceWorker& worker);
  void extractRegionQuads(RegionTask& task, SurfaceWorker& worker);
  void extract(const Version& next, int threads, bool keepBefore, SurfaceDelta& delta);
  void follow(std::vector<RegionTask> tasks, bool whole, int threads, SurfaceDelta& delta, ReplacedMeshes* replaced);
  std::vector<ReplacedMeshes>::iterator findKept(const Version& next);
  void swap(ReplacedMeshes& replaced, SurfaceDelta& delta);
  void keep(ReplacedMeshes replaced, uint64_t most);
};

}  // namespace argil::clay
