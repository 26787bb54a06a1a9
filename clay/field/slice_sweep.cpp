#include "clay/field/slice_sweep.h"

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>
#include <utility>

namespace argil::clay {

namespace {

constexpr int kEdge = int(kBrickEdge);

// Voxels from..to-1 of row y.
struct Run {
  int32_t y, from, to;
};
using Slice = std::vector<Run>;  // by y, then from

// The clay's rows of each layer, from the lowest to the highest.
class Slices {
 public:
  explicit Slices(const Version& version) {
    version.forEachBrick([&](const Brick& brick) { bricks_.push_back(&brick); });
    std::sort(bricks_.begin(), bricks_.end(), [](const Brick* a, const Brick* b) {
      return std::tie(a->coord.z, a->coord.y, a->coord.x) < std::tie(b->coord.z, b->coord.y, b->coord.x);
    });
    for (const Brick* each : bricks_) {
      const Coord c = each->coord;
      const Coord first{c.x * kEdge, c.y * kEdge, c.z * kEdge};
      low_ = {std::min(low_.x, first.x), std::min(low_.y, first.y), std::min(low_.z, first.z)};
      high_ = {std::max(high_.x, first.x + kEdge), std::max(high_.y, first.y + kEdge),
               std::max(high_.z, first.z + kEdge)};
    }
  }
  [[nodiscard]] bool empty() const { return bricks_.empty(); }
  [[nodiscard]] Coord low() const { return low_; }    // of the box around it
  [[nodiscard]] Coord high() const { return high_; }  // beyond it

  // Calls back with each layer, in order.
  template <class Visit>
  void forEach(const Visit& visit) const {
    std::array<Slice, kBrickEdge> layers;
    for (size_t begin = 0; begin < bricks_.size();) {
      size_t end = begin;
      const int32_t z = bricks_[begin]->coord.z;
      while (end < bricks_.size() && bricks_[end]->coord.z == z) ++end;
      for (Slice& layer : layers) layer.clear();
      for (size_t row = begin; row < end;) {
        size_t next = row;
        while (next < end && bricks_[next]->coord.y == bricks_[row]->coord.y) ++next;
        addRow(row, next, layers);
        row = next;
      }
      for (size_t k = 0; k < layers.size(); ++k) visit(z * kEdge + int32_t(k), layers[k]);
      // Layers without a surface have no clay: it is bounded. But a gap is a layer of air.
      if (end < bricks_.size())
        for (int32_t gap = (z + 1) * kEdge; gap < bricks_[end]->coord.z * kEdge; ++gap) visit(gap, Slice{});
      begin = end;
    }
  }

 private:
  // Bricks from..to of one row; what lies between two of them is as the last voxel before it says, as a tile that is
  // inside never touches one that is outside.
  void addRow(size_t from, size_t to, std::array<Slice, kBrickEdge>& layers) const {
    struct Room {
      BrickValues values;
    };
    std::vector<Room> rooms(to - from);
    std::vector<const float*> phi;
    phi.reserve(to - from);
    for (size_t i = from; i < to; ++i) phi.push_back(bricks_[i]->values(rooms[i - from].values));
    for (int z = 0; z < kEdge; ++z)
      for (int y = 0; y < kEdge; ++y) {
        bool inside = false;
        int32_t start = 0;
        for (size_t i = from; i < to; ++i) {
          const int32_t x0 = bricks_[i]->coord.x * kEdge;
          for (int x = 0; x < kEdge; ++x) {
            const bool now = phi[i - from][x * 64 + y * 8 + z] < 0;
            if (now == inside) continue;
            if (now)
              start = x0 + x;
            else
              layers[size_t(z)].push_back({bricks_[i]->coord.y * kEdge + y, start, x0 + x});
            inside = now;
          }
        }
        if (inside)  // up to the edge of what can be reached
          layers[size_t(z)].push_back(
              {bricks_[from]->coord.y * kEdge + y, start, (bricks_[to - 1]->coord.x + 1) * kEdge});
      }
  }

  std::vector<const Brick*> bricks_;
  Coord low_{std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::max(),
             std::numeric_limits<int32_t>::max()};
  Coord high_{std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::min(),
              std::numeric_limits<int32_t>::min()};
};

// Parts of a set that grows layer by layer.
class Parts {
 public:
  struct Part {
    uint32_t parent = 0;
    uint64_t voxels = 0;  // of the layers that are done
    std::array<int32_t, 3> lowest{};
  };

  uint32_t make(std::array<int32_t, 3> lowest) {
    parts_.push_back({uint32_t(parts_.size()), 0, lowest});
    return uint32_t(parts_.size() - 1);
  }
  uint32_t find(uint32_t i) {
    while (parts_[i].parent != i) i = parts_[i].parent = parts_[parts_[i].parent].parent;
    return i;
  }
  Part& operator[](uint32_t i) { return parts_[i]; }
  [[nodiscard]] size_t size() const { return parts_.size(); }
  // The lower of two is the one that was made first: layers come upwards.
  void join(uint32_t a, uint32_t b) {
    if (b < a) std::swap(a, b);
    parts_[b].parent = a;
    parts_[a].voxels += parts_[b].voxels;
  }

 private:
  std::vector<Part> parts_;
};

// Calls back with each pair of runs of neighbouring rows that share a column.
template <class Visit>
void forEachMeeting(const Slice& a, const Slice& b, int32_t shift, const Visit& visit) {
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const int32_t ya = a[i].y + shift, yb = b[j].y;
    if (ya < yb) {
      ++i;
    } else if (yb < ya) {
      ++j;
    } else {
      if (a[i].from < b[j].to && b[j].from < a[i].to) visit(i, j);
      if (a[i].to < b[j].to)
        ++i;
      else
        ++j;
    }
  }
}

// One of the two sets, clay or air, on its way upwards.
class Sweep {
 public:
  // `met`: two parts are one from layer z on; before they are joined.
  template <class Met>
  void add(int32_t z, Slice&& slice, const Met& met) {
    labels_.resize(slice.size());
    for (size_t i = 0; i < slice.size(); ++i) labels_[i] = parts.make({slice[i].from, slice[i].y, z});
    // First with the layer below, so that what begins here is told from what goes on.
    forEachMeeting(below_, slice, 0, [&](size_t i, size_t j) { unite(belowLabels_[i], labels_[j], z, met); });
    forEachMeeting(slice, slice, 1, [&](size_t i, size_t j) { unite(labels_[i], labels_[j], z, met); });
    for (size_t i = 0; i < slice.size(); ++i)
      parts[parts.find(labels_[i])].voxels += uint64_t(slice[i].to - slice[i].from);
    below_ = std::move(slice);
    std::swap(belowLabels_, labels_);
  }
  Parts parts;

 private:
  template <class Met>
  void unite(uint32_t a, uint32_t b, int32_t z, const Met& met) {
    a = parts.find(a), b = parts.find(b);
    if (a == b) return;
    met(a, b, z);
    parts.join(a, b);
  }

  Slice below_;
  std::vector<uint32_t> labels_, belowLabels_;
};

// What a layer has beside the clay, within a box with a voxel of air around it.
Slice airOf(const Slice& clay, Coord low, Coord high) {
  Slice air;
  size_t i = 0;
  for (int32_t y = low.y; y < high.y; ++y) {
    int32_t from = low.x;
    for (; i < clay.size() && clay[i].y == y; ++i) {
      if (clay[i].from > from) air.push_back({y, from, clay[i].from});
      from = clay[i].to;
    }
    if (from < high.x) air.push_back({y, from, high.x});
  }
  return air;
}

}  // namespace

SliceReport sweepSlices(const Version& version, const WorkPart& part, uint64_t leastVoxels, int leastLayers) {
  SliceReport report;
  const Slices slices(version);
  if (slices.empty()) return report;
  const Grid& grid = version.grid();
  const double voxel = grid.voxelMm, volume = voxel * voxel * voxel;
  const Coord low{slices.low().x - 1, slices.low().y - 1, slices.low().z - 1},
      high{slices.high().x + 1, slices.high().y + 1, slices.high().z + 1};
  const auto placeOf = [&](const std::array<int32_t, 3>& v) { return grid.toWorld(Vec3d(v[0], v[1], v[2])); };

  Sweep clay, air;
  int32_t bed = std::numeric_limits<int32_t>::max();  // the lowest layer with clay
  const uint32_t outside = 0;                         // the first part of the air
  const auto clayMet = [&](uint32_t a, uint32_t b, int32_t z) {
    // The part that began higher was alone until now.
    const Parts::Part& later = clay.parts[std::max(a, b)];
    if (z - later.lowest[2] < leastLayers || later.lowest[2] == bed || later.voxels < leastVoxels) return;
    report.islands.push_back({placeOf(later.lowest), voxel * (z - later.lowest[2])});
  };
  const auto airMet = [&](uint32_t a, uint32_t b, int32_t z) {
    const uint32_t rest = air.parts.find(outside);
    if (a != rest && b != rest) return;
    const Parts::Part& trap = air.parts[a == rest ? b : a];
    if (z - trap.lowest[2] < leastLayers || trap.voxels < leastVoxels) return;
    report.traps.push_back(
        {placeOf(trap.lowest), volume * double(trap.voxels), grid.toWorld(Vec3d(0, 0, z)).z(), false});
  };

  // The layer below all is the outside, and so is the rim of each layer.
  const auto addAir = [&](int32_t z, const Slice& of) { air.add(z, airOf(of, low, high), airMet); };
  addAir(low.z, {});
  int32_t done = 0;
  slices.forEach([&](int32_t z, const Slice& slice) {
    report.runs += slice.size();
    if (!slice.empty()) bed = std::min(bed, z);
    addAir(z, slice);
    clay.add(z, Slice(slice), clayMet);
    if (++done % 16 == 0) part.step(double(z - low.z) / double(high.z - low.z));
  });
  addAir(high.z - 1, {});

  // What never met anything: other bodies, which stand on their own, and closed hollows.
  for (uint32_t i = 0; i < clay.parts.size(); ++i)
    if (clay.parts.find(i) == i && clay.parts[i].lowest[2] != bed && clay.parts[i].voxels >= leastVoxels)
      report.islands.push_back({placeOf(clay.parts[i].lowest), 0});
  for (uint32_t i = 0; i < air.parts.size(); ++i)
    if (air.parts.find(i) == i && i != air.parts.find(outside) && air.parts[i].voxels >= leastVoxels)
      report.traps.push_back({placeOf(air.parts[i].lowest), volume * double(air.parts[i].voxels), 0, true});
  const auto lower = [](const auto& a, const auto& b) { return a.at.z() < b.at.z(); };
  std::stable_sort(report.islands.begin(), report.islands.end(), lower);
  std::stable_sort(report.traps.begin(), report.traps.end(), lower);
  return report;
}

}  // namespace argil::clay
