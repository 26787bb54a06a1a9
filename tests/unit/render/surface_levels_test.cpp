// Levels of detail: coarser, closed, within their error, and free of cost while the clay changes.

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/rim_vertices.h"
#include "render/surface/surface_layout.h"
#include "tests/unit/clay/sharp_shapes.h"
#include "tests/unit/render/field_surface.h"
#include "tests/unit/render/mirror_sink.h"

namespace argil::render {
namespace {

using test::FieldSurface;
using test::MirrorSink;

/// A ball with a plate a voxel and a half thick and a bar: flat, curved and thin.
double shape(const Vec3d& p) {
  const double ball = (p - Vec3d(-6, 2, 1)).norm() - 17.3;
  const Vec3d q = (p - Vec3d(8, 3, 0)).cwiseAbs() - Vec3d(22, 0.75, 18);
  const Vec3d r = (p - Vec3d(0, 0, -4.5)).cwiseAbs() - Vec3d(3.2, 26, 3.7);
  return std::min({ball, q.maxCoeff(), r.maxCoeff()});
}

class Levels : public testing::Test {
 protected:
  using Place = std::array<int32_t, 3>;

  void SetUp() override {
    delta_ = surface_.update({}, {-4, -4, -4}, {3, 3, 3}, shape);
    layout_.apply(delta_, sink_);
    for (size_t i = 0; i < layout_.draws().size(); ++i) {
      for (int level = 0; level < kLevels; ++level) layout_.prepareChunk(i, level, sink_);
    }
  }
  /// How often each directed edge occurs more often than its opposite.
  std::map<std::pair<Place, Place>, int> boundary(const std::function<int(const ChunkDraw&)>& level) const {
    std::map<std::pair<Place, Place>, int> edges;
    const auto at = [&](uint32_t i) {
      const SurfaceVertex& v = sink_.vertices.at(sink_.indices.at(i));
      return Place{v.x, v.y, v.z};
    };
    for (const ChunkDraw& draw : layout_.draws()) {
      const ChunkDraw::Range& range = draw.at(level(draw));
      for (uint32_t i = range.firstIndex; i < range.firstIndex + range.indexCount; i += 3) {
        for (uint32_t n = 0; n < 3; ++n) {
          const Place a = at(i + n), b = at(i + (n + 1) % 3);
          if (a < b) ++edges[{a, b}];
          if (b < a) --edges[{b, a}];
        }
      }
    }
    std::erase_if(edges, [](const auto& edge) { return edge.second == 0; });
    return edges;
  }

  FieldSurface surface_;
  clay::SurfaceDelta delta_;
  BufferRanges ranges_;
  SurfaceLayout layout_{ranges_};
  MirrorSink sink_;
};

TEST_F(Levels, EachIsCoarser) {
  ASSERT_GE(layout_.draws().size(), 8u);
  std::array<uint64_t, size_t(kLevels)> triangles{};
  for (const ChunkDraw& draw : layout_.draws()) {
    for (size_t level = 0; level < size_t(kLevels); ++level) {
      ASSERT_TRUE(draw.levels[level].made);
      triangles[level] += draw.levels[level].triangles;
    }
  }
  for (size_t level = 1; level < size_t(kLevels); ++level) EXPECT_LT(triangles[level], triangles[level - 1]);
  EXPECT_EQ(triangles[0], layout_.triangleCount());
  EXPECT_LT(triangles[1], 0.45 * double(triangles[0]));
  EXPECT_LT(triangles[3], 0.30 * double(triangles[0]));
}

TEST_F(Levels, WhateverLevelEachChunkHasTheSurfaceStaysClosed) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  for (int run = 0; run < 20; ++run) {
    std::map<Coord, int> chosen;
    for (const ChunkDraw& draw : layout_.draws()) chosen[draw.chunk] = int(random() % unsigned(kLevels));
    EXPECT_TRUE(boundary([&](const ChunkDraw& draw) { return chosen.at(draw.chunk); }).empty())
        << "seed " << kSeed << ", run " << run;
  }
  for (int level = 0; level < kLevels; ++level) {
    EXPECT_TRUE(boundary([&](const ChunkDraw&) { return level; }).empty()) << level;
  }
}

/// The fine surface of turned boxes: creases cross the sides of chunks, and vertices on them stand outside of their
/// cells.
class FineLevels : public Levels {
 protected:
  void SetUp() override {
    std::mt19937_64 random(5);
    std::array<clay::testing::TurnedBox, 4> boxes;
    for (clay::testing::TurnedBox& box : boxes) {
      box.axes = clay::testing::randomTurn(random);
      box.half = Vec3d(24, 40, 30);
    }
    const auto shape = [&](const Vec3d& p) {
      double most = -1e9;  // what lies in all of them
      for (const auto& box : boxes) most = std::max(most, box.cut(p));
      return most;
    };
    delta_ = fine_.update(clay::testing::clayOf(clay::Store::make(), 70, shape));
    layout_.apply(delta_, sink_);
    for (size_t i = 0; i < layout_.draws().size(); ++i) {
      for (int level = 0; level < kLevels; ++level) layout_.prepareChunk(i, level, sink_);
    }
  }
  clay::Surface fine_{true, clay::Grade::fine};
};

TEST_F(FineLevels, StayClosedAcrossChunksAndWithinTheirBoxes) {
  size_t outside = 0;  // of the cells that the draft has them in
  clay::Surface draft;
  draft.update(fine_.version());
  for (const auto& mesh : delta_.changed) {
    const clay::BrickMesh* other = draft.find(mesh->brick);
    if (!other) continue;
    for (size_t i = 0; i < mesh->positions.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis)
        outside +=
            other->positions[i][axis] > 7.001f && other->positions[i][axis] < 7.999f && mesh->positions[i][axis] < 7;
    }
  }
  EXPECT_GT(outside, 10u);
  constexpr unsigned kSeed = 9;
  std::mt19937 random(kSeed);
  for (int run = 0; run < 20; ++run) {
    std::map<Coord, int> chosen;
    for (const ChunkDraw& draw : layout_.draws()) chosen[draw.chunk] = int(random() % unsigned(kLevels));
    EXPECT_TRUE(boundary([&](const ChunkDraw& draw) { return chosen.at(draw.chunk); }).empty())
        << "seed " << kSeed << ", run " << run;
  }
  size_t beyond = 0;  // of the boxes that would do for the draft
  for (const ChunkDraw& draw : layout_.draws()) {
    const ChunkDraw::Range& range = draw.levels[0];
    for (uint32_t i = range.firstIndex; i < range.firstIndex + range.indexCount; ++i) {
      const uint32_t first = i - (i - range.firstIndex) % 3;
      if (sink_.indices.at(first) == sink_.indices.at(first + 1)) continue;  // room that is free
      const SurfaceVertex& v = sink_.vertices.at(sink_.indices.at(i));
      const Vec3d p = Vec3d(v.x, v.y, v.z) / kUnitsPerVoxel;
      ASSERT_GE((p - draw.min).minCoeff(), 0);
      ASSERT_GE((draw.max - p).minCoeff(), 0);
      beyond += (p - draw.min).minCoeff() < clay::kVertexReach - 1e-3 ||
                (draw.max - p).minCoeff() < clay::kVertexReach - 1e-3;
    }
  }
  EXPECT_GT(beyond, 0u);
}

TEST_F(Levels, AVertexIsStoodForByOneOfItsGroupOnItsSide) {
  std::vector<uint16_t> out;
  size_t others = 0;
  for (const auto& mesh : delta_.changed) {
    for (int level = 1; level < kLevels; ++level) {
      const int size = kGroupCells[size_t(level)];
      for (const unsigned locked : {0u, 5u}) {
        representatives(*mesh, level, locked, out);
        ASSERT_EQ(out.size(), mesh->positions.size());
        for (size_t i = 0; i < out.size(); ++i) {
          const Vec3f &p = mesh->positions[i], &q = mesh->positions[out[i]];
          EXPECT_EQ(out[out[i]], out[i]);
          EXPECT_LE((p - q).cwiseAbs().maxCoeff(), float(size));
          const bool fixed = (locked & 1u && p.x() >= 7) || (locked & 4u && p.z() >= 7);
          if (fixed) {
            EXPECT_EQ(out[i], i);
          }
          others += out[i] != i;
        }
      }
    }
  }
  EXPECT_GT(others, 10000u);
}

TEST_F(Levels, ThinPlatesDoNotCollapse) {
  // The two sides of a plate lie in the same groups: none may stand for the other.
  std::vector<uint16_t> out;
  size_t pairs = 0, wrong = 0;
  for (const auto& mesh : delta_.changed) {
    representatives(*mesh, 3, 0, out);
    for (size_t i = 0; i < out.size(); ++i) {
      const Vec3f a = mesh->normals[i].unpack(), b = mesh->normals[out[i]].unpack();
      if (std::abs(a.y()) < 0.99f) continue;
      wrong += a.y() * b.y() < -0.5f;
      ++pairs;
    }
  }
  EXPECT_LE(wrong, pairs / 100);  // where something else joins the plate
  EXPECT_GT(pairs, 500u);
}

TEST(Cone, HidesOnlyWhatFacesAwayAndNotLittle) {
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  MirrorSink sink;
  clay::Surface sphere;
  clay::Grid grid;
  grid.voxelMm = 0.1;
  layout.apply(sphere.update(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 12)), sink);
  for (size_t i = 0; i < layout.draws().size(); ++i) layout.prepareChunk(i, 0, sink);
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-600, 600);
  size_t all = 0, byEye = 0, byDirection = 0;
  for (int run = 0; run < 60; ++run) {
    const Vec3d eye(place(random), place(random), place(random)), ahead = -eye.normalized();
    for (const ChunkDraw& draw : layout.draws()) {
      ++all;
      const Vec3d half = 0.5 * (draw.max - draw.min);
      const bool perspective = draw.cone.facesAway(draw.min + half, half.norm(), eye);
      const bool parallel = draw.cone.facesAway(ahead);
      byEye += perspective;
      byDirection += parallel;
      if (!perspective && !parallel) continue;
      const ChunkDraw::Range& range = draw.levels[0];
      for (uint32_t i = range.firstIndex; i < range.firstIndex + range.indexCount; i += 3) {
        const auto corner = [&](uint32_t n) {
          const SurfaceVertex& v = sink.vertices[sink.indices[i + n]];
          return Vec3d(Vec3d(v.x, v.y, v.z) / kUnitsPerVoxel);
        };
        const Vec3d a = corner(0), normal = (corner(1) - a).cross(corner(2) - a);
        if (normal.norm() < 1e-3) continue;  // rounding turns slivers
        ASSERT_FALSE(perspective && normal.dot(a - eye) <= 0) << "seed " << kSeed << ", run " << run;
        ASSERT_FALSE(parallel && normal.dot(ahead) <= 0) << "seed " << kSeed << ", run " << run;
      }
    }
  }
  EXPECT_GT(byEye, all / 5);
  EXPECT_GT(byDirection, all / 5);
}

TEST_F(Levels, AStrokePaysNothingAndWhatChangedIsMadeAgainAfterARest) {
  const auto dented = [](const Vec3d& p) { return std::max(shape(p), 4.0 - (p - Vec3d(-20, 10, 8)).norm()); };
  const auto change = surface_.update({}, {-4, -4, -4}, {3, 3, 3}, dented);
  ASSERT_GT(change.changed.size(), 0u);

  FieldSurface other;
  BufferRanges ranges;
  SurfaceLayout without(ranges);
  MirrorSink plain;
  without.apply(other.update({}, {-4, -4, -4}, {3, 3, 3}, shape), plain);
  plain.bytes = sink_.bytes = 0;
  without.apply(other.update({}, {-4, -4, -4}, {3, 3, 3}, dented), plain);
  layout_.apply(change, sink_);
  EXPECT_EQ(sink_.bytes, plain.bytes);
  EXPECT_EQ(sink_.drawn(layout_, [](const ChunkDraw&) { return 0; }), plain.drawn(without));

  const auto missing = [&] {
    std::vector<size_t> chunks;
    for (size_t i = 0; i < layout_.draws().size(); ++i)
      if (!layout_.draws()[i].levels[2].made) chunks.push_back(i);
    return chunks;
  };
  const std::vector<size_t> changed = missing();
  ASSERT_GT(changed.size(), 0u);
  EXPECT_LT(changed.size(), layout_.draws().size() / 2);
  EXPECT_TRUE(boundary([](const ChunkDraw&) { return 2; }).empty());
  for (uint64_t picture = 0; picture < SurfaceLayout::kRestPictures; ++picture) {
    sink_.bytes = 0;
    for (const size_t chunk : changed) EXPECT_EQ(layout_.prepareChunk(chunk, 2, sink_), 0u);
    EXPECT_EQ(sink_.bytes, 0u);
    layout_.nextPicture();
  }
  for (const size_t chunk : changed) EXPECT_GT(layout_.prepareChunk(chunk, 2, sink_), 0u);
  EXPECT_TRUE(missing().empty());
  EXPECT_TRUE(boundary([](const ChunkDraw&) { return 2; }).empty());
}

TEST_F(Levels, GiveTheirRangesBack) {
  layout_.clear();
  EXPECT_EQ(ranges_.usedVertices(), 0u);
  EXPECT_EQ(ranges_.usedQuads(), 0u);
}

}  // namespace
}  // namespace argil::render
