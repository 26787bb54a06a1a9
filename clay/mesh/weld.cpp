#include "clay/mesh/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

constexpr size_t kFirstSlots = 1024;
/// Slots asked for ahead of their use: enough to hide the way to memory, few enough to stay in the first cache.
constexpr size_t kBatch = 64;

/// Finalizer of MurmurHash3: every input bit reaches every output bit.
uint64_t mix(uint64_t x) {
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdull;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53ull;
  x ^= x >> 33;
  return x;
}

uint64_t hashOf(const Vec3d& p) {
  // Adding zero makes -0 into 0, so that equal coordinates have equal bits.
  uint64_t h = mix(std::bit_cast<uint64_t>(p.x() + 0.0) + 0x9e3779b97f4a7c15ull);
  h = mix(h ^ std::bit_cast<uint64_t>(p.y() + 0.0));
  return mix(h ^ (std::bit_cast<uint64_t>(p.z() + 0.0) + 0x9e3779b97f4a7c15ull));
}

}  // namespace

VertexWelder::VertexWelder() : slots_(kFirstSlots, 0) {}

uint32_t VertexWelder::add(const Vec3d& position) {
  return place(position, hashOf(position));
}

void VertexWelder::add(std::span<const Vec3d> positions, std::span<uint32_t> indices) {
  std::array<uint64_t, kBatch> hashes;
  for (size_t begin = 0; begin < positions.size(); begin += kBatch) {
    const size_t count = std::min(kBatch, positions.size() - begin);
    for (size_t i = 0; i < count; ++i) {
      hashes[i] = hashOf(positions[begin + i]);
      __builtin_prefetch(&slots_[hashes[i] & (slots_.size() - 1)]);
    }
    for (size_t i = 0; i < count; ++i) indices[begin + i] = place(positions[begin + i], hashes[i]);
  }
}

uint32_t VertexWelder::place(const Vec3d& position, uint64_t hash) {
  const uint64_t mark = hash & 0xffffffff00000000ull;
  const size_t mask = slots_.size() - 1;
  size_t at = hash & mask;
  for (; slots_[at] != 0; at = (at + 1) & mask) {
    if ((slots_[at] & 0xffffffff00000000ull) != mark) continue;
    const auto index = uint32_t(slots_[at]) - 1;
    if (positions_[index] == position) return index;
  }
  if (positions_.size() >= UINT32_MAX - 1) {
    throw Error("a mesh of more than 4 294 967 294 vertices cannot be held: reduce or split it", Error::Kind::work);
  }
  const auto index = uint32_t(positions_.size());
  slots_[at] = mark | (uint64_t(index) + 1);
  positions_.push_back(position);
  if (positions_.size() * 2 > slots_.size()) grow();
  return index;
}

void VertexWelder::grow() {
  std::vector<uint64_t> bigger(slots_.size() * 2, 0);
  const size_t mask = bigger.size() - 1;
  for (const uint64_t slot : slots_) {
    if (slot == 0) continue;
    // The slot holds the upper half of the hash only; the position tells the lower one.
    size_t at = hashOf(positions_[uint32_t(slot) - 1]) & mask;
    while (bigger[at] != 0) at = (at + 1) & mask;
    bigger[at] = slot;
  }
  slots_ = std::move(bigger);
}

std::vector<Vec3d> VertexWelder::take() {
  std::vector<Vec3d> result = std::move(positions_);
  *this = VertexWelder();
  return result;
}

TriangleMesh weldExact(const TriangleMesh& mesh) {
  VertexWelder welder;
  TriangleMesh result;
  result.triangles.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<Vec3d, 3> corners = {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
    welder.add(corners, result.triangles.emplace_back());
  }
  result.positions = welder.take();
  return result;
}

TriangleMesh weldOpenEdges(const TriangleMesh& mesh) {
  // The higher ends of edges, by the lower one. Counts are kept two places up, so that filling the list moves each
  // start to its final place.
  std::vector<uint32_t> first(mesh.positions.size() + 2), higher;
  const auto forEachEdge = [&](const auto& use) {
    for (const auto& [a, b, c] : mesh.triangles) {
      if (a == b || b == c || c == a) continue;
      use(std::min(a, b), std::max(a, b));
      use(std::min(b, c), std::max(b, c));
      use(std::min(c, a), std::max(c, a));
    }
  };
  size_t edges = 0;
  forEachEdge([&](uint32_t low, uint32_t) { ++first[size_t(low) + 2], ++edges; });
  if (edges > UINT32_MAX)
    throw Error("a mesh of more than 1 431 655 765 triangles cannot be held: reduce or split it", Error::Kind::work);
  std::partial_sum(first.begin(), first.end(), first.begin());
  higher.resize(edges);
  forEachEdge([&](uint32_t low, uint32_t high) { higher[first[size_t(low) + 1]++] = high; });

  std::vector<bool> open(mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto begin = higher.begin() + first[v], end = higher.begin() + first[v + 1];
    std::sort(begin, end);
    for (auto at = begin; at != end;) {
      const auto next = std::find_if(at, end, [&](uint32_t other) { return other != *at; });
      if (next - at == 1) open[v] = open[*at] = true;
      at = next;
    }
  }

  VertexWelder welder;
  TriangleMesh result;
  std::vector<uint32_t> index(mesh.positions.size(), UINT32_MAX), welded;
  result.triangles.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<uint32_t, 3>& corners = result.triangles.emplace_back();
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = triangle[c];
      if (index[v] == UINT32_MAX) {
        const Vec3d& position = mesh.positions[v];
        const uint32_t of = open[v] ? welder.add(position) : UINT32_MAX;
        if (of < welded.size()) {
          index[v] = welded[of];
        } else {
          index[v] = uint32_t(result.positions.size());
          result.positions.push_back(position);
          if (open[v]) welded.push_back(index[v]);
        }
      }
      corners[c] = index[v];
    }
  }
  return result;
}

}  // namespace argil::clay
