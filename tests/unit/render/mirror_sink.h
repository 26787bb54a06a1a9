#pragma once
// Buffers on the CPU that a layout writes into, and the triangles that drawing them would show.

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <stdexcept>
#include <vector>

#include "render/surface/surface_layout.h"

namespace argil::render::test {

class MirrorSink : public UploadSink {
 public:
  void reserve(uint32_t vertexCount, uint32_t indexCount) override {
    vertices.resize(std::max<size_t>(vertices.size(), vertexCount));
    // Never written, never drawn: an index that points nowhere.
    indices.resize(std::max<size_t>(indices.size(), indexCount), UINT32_MAX);
  }
  void writeVertices(uint32_t first, std::span<const SurfaceVertex> data) override {
    if (size_t(first) + data.size() > vertices.size()) throw std::out_of_range("vertices past the reserved end");
    if (checked_) once(writtenVertices_, first, data.size());
    std::copy(data.begin(), data.end(), vertices.begin() + first);
    bytes += data.size_bytes();
  }
  void writeIndices(uint32_t first, std::span<const uint32_t> data) override {
    if (size_t(first) + data.size() > indices.size()) throw std::out_of_range("indices past the reserved end");
    if (checked_) once(writtenIndices_, first, data.size());
    std::copy(data.begin(), data.end(), indices.begin() + first);
    bytes += data.size_bytes();
  }

  /// From the first call on, what is written twice between two calls is refused: the device copies the writes of an
  /// update in any order.
  void beginUpdate() {
    checked_ = true;
    writtenVertices_.clear();
    writtenIndices_.clear();
  }

  /// Every triangle that the draws show, in vertex units, empty ones left out, sorted.
  [[nodiscard]] std::vector<std::array<std::array<int32_t, 3>, 3>> drawn(
      const SurfaceLayout& layout,
      const std::function<int(const ChunkDraw&)>& level = [](const ChunkDraw&) { return 0; }) const {
    std::vector<std::array<std::array<int32_t, 3>, 3>> all;
    for (const ChunkDraw& draw : layout.draws()) {
      const ChunkDraw::Range& range = draw.at(level(draw));
      for (uint32_t i = range.firstIndex; i < range.firstIndex + range.indexCount; i += 3) {
        const uint32_t a = indices.at(i), b = indices.at(i + 1), c = indices.at(i + 2);
        if (a == b && b == c) continue;
        const auto corner = [&](uint32_t index) {
          const SurfaceVertex& v = vertices.at(index);
          return std::array<int32_t, 3>{v.x, v.y, v.z};
        };
        all.push_back({corner(a), corner(b), corner(c)});
      }
    }
    std::sort(all.begin(), all.end());
    return all;
  }

  std::vector<SurfaceVertex> vertices;
  std::vector<uint32_t> indices;
  uint64_t bytes = 0;

 private:
  using Written = std::map<size_t, size_t>;  // begin → end
  static void once(Written& written, size_t first, size_t count) {
    const auto next = written.lower_bound(first);
    if (next != written.end() && next->first < first + count) throw std::logic_error("written twice in one update");
    if (next != written.begin() && std::prev(next)->second > first)
      throw std::logic_error("written twice in one update");
    written[first] = first + count;
  }
  Written writtenVertices_, writtenIndices_;
  bool checked_ = false;
};

/// The same triangles as the surface itself has them, rounded as vertices are.
template <class Triangles>
std::vector<std::array<std::array<int32_t, 3>, 3>> inUnits(const Triangles& triangles) {
  std::vector<std::array<std::array<int32_t, 3>, 3>> all;
  for (const auto& triangle : triangles) {
    std::array<std::array<int32_t, 3>, 3> out;
    for (int i = 0; i < 3; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        out[i][axis] = int32_t(std::floor(double(triangle[i][axis]) * kUnitsPerVoxel + 0.5));
      }
    }
    all.push_back(out);
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace argil::render::test
