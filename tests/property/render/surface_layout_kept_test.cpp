// What an operation on a whole piece replaced stays in the buffers until it comes back: whatever happens in between,
// what is drawn is the surface.

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "tests/unit/render/field_surface.h"
#include "tests/unit/render/mirror_sink.h"

namespace argil::render {
namespace {

using clay::Combination;
using clay::Version;

clay::Grid millimetres() {
  clay::Grid grid;
  grid.voxelMm = 1;
  return grid;
}

Version ball(const Vec3d& at, double radius) {
  return clay::makeSphere(clay::Store::make(), millimetres(), at, radius);
}

// Balls of some 27 000 quads each, far apart.
Version balls(int count, double radius = 38) {
  Version all = ball({0, 0, 0}, radius);
  for (int i = 1; i < count; ++i) all = combine(all, ball({200.0 * i, 0, 0}, radius), Combination::join);
  return all;
}
Version without(const Version& clay, int which) {
  return combine(clay, ball({200.0 * which, 0, 0}, 45), Combination::cut);
}

// Corners with their normals and paint.
using Corner = std::array<uint32_t, 5>;

class PaintedSink : public test::MirrorSink {
 public:
  void reserve(uint32_t vertexCount, uint32_t indexCount) override {
    MirrorSink::reserve(vertexCount, indexCount);
    paint.resize(vertices.size(), kUnpainted);
  }
  void writePaint(uint32_t first, std::span<const PackedPaint> data) override {
    ASSERT_LE(first + data.size(), paint.size());
    std::copy(data.begin(), data.end(), paint.begin() + first);
    bytes += data.size_bytes();
  }
  [[nodiscard]] std::vector<std::array<Corner, 3>> picture(const SurfaceLayout& layout, int level) const {
    std::vector<std::array<Corner, 3>> all;
    for (const ChunkDraw& draw : layout.draws()) {
      const ChunkDraw::Range& range = draw.at(level);
      EXPECT_TRUE(level == 0 || draw.levels[size_t(level)].made);
      for (uint32_t i = range.firstIndex; i < range.firstIndex + range.indexCount; i += 3) {
        if (indices.at(i) == indices.at(i + 1)) continue;
        std::array<Corner, 3> corners;
        for (uint32_t k = 0; k < 3; ++k) {
          const SurfaceVertex& v = vertices.at(indices.at(i + k));
          uint32_t normal;
          static_assert(sizeof normal == sizeof v.normal);
          std::memcpy(&normal, &v.normal, sizeof normal);
          corners[k] = {uint32_t(v.x), uint32_t(v.y), uint32_t(v.z), normal, paint.at(indices.at(i + k))};
        }
        all.push_back(corners);
      }
    }
    std::sort(all.begin(), all.end());
    return all;
  }
  std::vector<PackedPaint> paint;
};

struct Drawn {
  PaintedSink sink;
  BufferRanges ranges;
  SurfaceLayout layout{ranges};

  void makeLevels() {
    for (uint64_t i = 0; i <= SurfaceLayout::kRestPictures; ++i) layout.nextPicture();
    for (size_t i = 0; i < layout.draws().size(); ++i)
      for (int level = 0; level < kLevels; ++level) (void)layout.prepareChunk(i, level, sink);
  }
};

// All chunks hold a surface on its own, so that each of them is replaced as a whole or not at all.
TEST(SurfaceLayoutKept, WhatComesBackIsNotWrittenAgain) {
  const Version before = ball({0, 0, 0}, 100);
  const Version after = combine(before, ball({0, 0, 0}, 80), Combination::intersect);
  clay::Surface surface;
  Drawn drawn;
  drawn.layout.apply(surface.update(before), drawn.sink);
  drawn.makeLevels();
  const uint64_t quads = drawn.layout.triangleCount() / 2;
  EXPECT_EQ(drawn.layout.keptQuads(), 0u);
  drawn.layout.apply(surface.update(after, 1, true), drawn.sink);
  drawn.makeLevels();
  EXPECT_EQ(drawn.layout.keptQuads(), quads);
  const uint64_t inner = drawn.layout.triangleCount() / 2;
  for (int round = 0; round < 3; ++round) {
    drawn.sink.bytes = 0;
    drawn.layout.apply(surface.update(before), drawn.sink);
    EXPECT_EQ(drawn.layout.triangleCount(), 2 * quads);
    EXPECT_EQ(drawn.layout.keptQuads(), inner);
    for (const ChunkDraw& draw : drawn.layout.draws()) EXPECT_TRUE(draw.levels[3].made);
    drawn.layout.apply(surface.update(after), drawn.sink);
    EXPECT_EQ(drawn.sink.bytes, 0u);
    EXPECT_EQ(drawn.layout.triangleCount(), 2 * inner);
  }
  // An edit by hand is not kept, and takes nothing of what is.
  clay::BrushStroke stroke(after, clay::Brush::of(clay::Method::carve));
  stroke.apply({{80, 0, 0}, {80, 0, 0}, 5});
  drawn.layout.apply(surface.update(stroke.finish()), drawn.sink);
  EXPECT_EQ(drawn.layout.keptQuads(), quads);
  drawn.layout.clear();
  EXPECT_EQ(drawn.ranges.usedQuads(), 0u);
  EXPECT_EQ(drawn.ranges.usedVertices(), 0u);
}

TEST(SurfaceLayoutKept, OldestGoesFirstWhereAllWouldBeMoreThanIsDrawn) {
  const Version alone = ball({300, 0, 0}, 30);
  const Version both = combine(alone, ball({0, 0, 0}, 90), Combination::join);
  const Version shell = combine(both, ball({0, 0, 0}, 80), Combination::cut);
  const Version one = combine(shell, ball({0, 0, 0}, 100), Combination::cut);
  const Version smaller = combine(one, ball({300, 0, 0}, 28), Combination::intersect);
  clay::Surface surface;
  Drawn drawn;
  const auto quadsAfter = [&](const Version& version) {
    drawn.sink.bytes = 0;
    drawn.layout.apply(surface.update(version, 1, true), drawn.sink);
    return drawn.layout.triangleCount() / 2;
  };
  (void)quadsAfter(both);
  const uint64_t ofShell = quadsAfter(shell);
  const uint64_t ofOne = quadsAfter(one);
  EXPECT_GT(drawn.layout.keptQuads(), ofOne);
  EXPECT_LE(drawn.layout.keptQuads(), ofShell);
  (void)quadsAfter(smaller);
  EXPECT_EQ(drawn.layout.keptQuads(), ofOne) << "the large ball is gone, what was replaced last is there";
  EXPECT_EQ(quadsAfter(one), ofOne);
  EXPECT_EQ(drawn.sink.bytes, 0u);
}

TEST(SurfaceLayoutKept, NoMoreIsKeptThanIsAllowed) {
  const Version before = balls(3), two = without(before, 2), one = without(two, 1);
  const Version smaller = combine(before, balls(3, 37), Combination::intersect);
  for (const uint64_t most : {uint64_t{20000}, uint64_t{35000}, uint64_t{100000}}) {
    clay::Surface surface;
    PaintedSink sink;
    BufferRanges ranges;
    SurfaceLayout layout(ranges, most);
    layout.apply(surface.update(before), sink);
    const size_t room = sink.vertices.size();
    std::vector<uint64_t> kept;
    for (const Version& next : {two, one, two, before, smaller}) {
      layout.apply(surface.update(next, 1, true), sink);
      kept.push_back(layout.keptQuads());
      EXPECT_LE(kept.back(), most);
      Drawn fresh;
      fresh.layout.apply(clay::Surface().update(next), fresh.sink);
      ASSERT_EQ(sink.picture(layout, 0), fresh.sink.picture(fresh.layout, 0)) << most;
    }
    EXPECT_EQ(kept[0] > 0, most > 30000);
    EXPECT_EQ(kept[1] > 30000, most > 50000);
    // What would be too much is not laid beside what is there in the first place.
    EXPECT_EQ(double(sink.vertices.size()) > 1.7 * double(room), most > 90000);
  }
}

TEST(SurfaceLayoutKept, WhereMemoryEndsWhatIsKeptGoesFirst) {
  class Small : public PaintedSink {
   public:
    void reserve(uint32_t vertexCount, uint32_t indexCount) override {
      if (vertexCount > most) throw Error("full", Error::Kind::work);
      PaintedSink::reserve(vertexCount, indexCount);
    }
    uint32_t most = UINT32_MAX;
  } sink;
  const Version before = ball({0, 0, 0}, 90);
  const Version after = combine(before, ball({0, 0, 0}, 88), Combination::intersect);
  const auto picture = [](const Version& version) {
    Drawn fresh;
    fresh.layout.apply(clay::Surface().update(version), fresh.sink);
    return fresh.sink.picture(fresh.layout, 0);
  };
  clay::Surface surface;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  ranges.onFull([&] { return layout.dropKept(); });
  layout.apply(surface.update(before), sink);
  const auto room = uint32_t(sink.vertices.size());
  sink.most = room;
  layout.apply(surface.update(after, 1, true), sink);
  EXPECT_EQ(layout.keptQuads(), 0u);
  EXPECT_TRUE(layout.whole());
  EXPECT_EQ(sink.picture(layout, 0), picture(after));
  // And where it is another piece that needs it.
  sink.most = 3 * room;
  layout.apply(surface.update(before), sink);
  EXPECT_GT(layout.keptQuads(), 0u);
  sink.most = uint32_t(sink.vertices.size());
  SurfaceLayout other(ranges);
  const Version second = ball({0, 0, 0}, 60);
  other.apply(clay::Surface().update(second), sink);
  EXPECT_EQ(layout.keptQuads(), 0u);
  EXPECT_EQ(sink.picture(layout, 0), picture(before));
  EXPECT_EQ(sink.picture(other, 0), picture(second));
}

// Small balls, so that chunks hold a few bricks and are often replaced as a whole, beside others that are not.
TEST(SurfaceLayoutKept, RandomHistoriesDrawExactlyTheSurface) {
  constexpr unsigned kSeed = 20261126;
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-100, 100), size(5, 11), large(10, 60), one(-1, 1);
  const auto somewhere = [&] { return Vec3d(place(random), place(random), place(random)); };
  std::vector<Vec3d> surfaceOf;
  Version first;
  for (int i = 0; i < 70; ++i) {
    const Vec3d at = somewhere();
    const double radius = size(random);
    for (int k = 0; k < 4; ++k)
      surfaceOf.push_back(at + radius * Vec3d(one(random), one(random), one(random)).normalized());
    first = i == 0 ? ball(at, radius) : combine(first, ball(at, radius), Combination::join);
  }
  std::vector<Version> history = {first};
  size_t at = 0;
  clay::Surface surface;
  Drawn drawn;
  drawn.layout.apply(surface.update(history[0]), drawn.sink);
  bool hides = false;
  uint64_t ways[4] = {}, keptMost = 0, written = 0, whole = 0;
  for (int step = 0; step < 150; ++step) {
    const uint64_t before = drawn.layout.triangleCount() / 2;
    const unsigned way = random() % 8;
    bool keeps = true;
    drawn.sink.beginUpdate();
    drawn.sink.bytes = 0;
    if (way < 2 || history.size() == 1) {
      const auto how = std::array{Combination::join, Combination::cut, Combination::cut}[random() % 3];
      history.resize(at + 1);
      const bool near = random() % 2;  // a little of what is there, or much
      const Vec3d centre = near ? surfaceOf[random() % surfaceOf.size()] : somewhere();
      history.push_back(combine(history[at], ball(centre, near ? size(random) : large(random)), how));
      ++at, ++ways[0];
    } else if (way == 2) {
      // By hand, now and then with colour, or a mask that hides.
      keeps = false;
      clay::Operation operation{.property = clay::Property::distance, .method = clay::Method::carve};
      if (step > 40 && random() % 2) operation = {.property = clay::Property::mask, .method = clay::Method::set};
      clay::Brush brush;
      brush.operations = {operation};
      clay::BrushStroke stroke(history[at], std::make_shared<const clay::Brush>(brush));
      for (int k = 0; k < 5; ++k) {
        const Vec3d from = surfaceOf[random() % surfaceOf.size()];
        stroke.apply({from, from + Vec3d(2, 0, 1), 4});
      }
      history.resize(at + 1);
      history.push_back(stroke.finish());
      ++at, ++ways[1];
    } else if (way == 3) {
      hides = !hides;
      drawn.layout.hideMasked(hides, drawn.sink);
      drawn.sink.beginUpdate();
    } else {
      // As far back as it goes, or one step, or forth.
      const size_t to = way == 4 ? 0 : way < 7 ? at - (at > 0) : std::min(at + 1, history.size() - 1);
      ++ways[to < at ? 2 : 3];
      at = to;
    }
    if (random() % 3 == 0) drawn.makeLevels();
    drawn.sink.beginUpdate();
    drawn.layout.apply(surface.update(history[at], 1, keeps), drawn.sink);
    written += drawn.sink.bytes;
    keptMost = std::max(keptMost, drawn.layout.keptQuads());
    if (keeps) {
      ASSERT_LE(drawn.layout.keptQuads(), std::max(before, drawn.layout.triangleCount() / 2));
    }
    Drawn fresh;
    fresh.layout.hideMasked(hides, fresh.sink);
    fresh.layout.apply(clay::Surface().update(history[at]), fresh.sink);
    whole += fresh.sink.bytes;
    ASSERT_EQ(drawn.sink.picture(drawn.layout, 0), fresh.sink.picture(fresh.layout, 0)) << "step " << step;
    ASSERT_EQ(drawn.layout.brickCount(), fresh.layout.brickCount());
    ASSERT_EQ(drawn.layout.triangleCount(), fresh.layout.triangleCount());
    ASSERT_EQ(drawn.layout.bounds().min, fresh.layout.bounds().min);
    ASSERT_EQ(drawn.layout.bounds().max, fresh.layout.bounds().max);
    if (random() % 3) continue;
    drawn.makeLevels(), fresh.makeLevels();
    ASSERT_EQ(drawn.sink.picture(drawn.layout, 2), fresh.sink.picture(fresh.layout, 2)) << "step " << step;
  }
  std::printf("%lu operations, %lu strokes, %lu back, %lu forth; kept %lu quads at most, %.2f of all written\n",
              ways[0], ways[1], ways[2], ways[3], keptMost, double(written) / double(whole));
  for (const uint64_t count : ways) EXPECT_GT(count, 5u);
  EXPECT_GT(keptMost, 5000u);
  drawn.layout.clear();
  EXPECT_EQ(drawn.ranges.usedQuads(), 0u);
  EXPECT_EQ(drawn.ranges.usedVertices(), 0u);
}

// A surface that knows all that it ever was: meshes by brick, the same ones where nothing differs.
struct Past {
  std::map<Coord, clay::BrickMeshPtr> meshes;
  std::map<Coord, std::shared_ptr<const clay::BrickPaint>> paint;
};

clay::SurfaceDelta between(const Past& from, const Past& to, uint64_t& serials) {
  clay::SurfaceDelta delta;
  std::set<std::pair<Coord, Coord>> all;  // by chunks, as a tree has them
  for (const auto* side : {&from, &to})
    for (const auto& [brick, mesh] : side->meshes) all.emplace(brick >> kChunkBits, brick);
  for (const auto& [chunk, brick] : all) {
    const auto was = from.meshes.find(brick), is = to.meshes.find(brick);
    const auto paintOf = [&](const Past& past) {
      const auto found = past.paint.find(brick);
      return found == past.paint.end() ? nullptr : found->second;
    };
    const auto before = paintOf(from), after = paintOf(to);
    const bool changed = was == from.meshes.end() || is == to.meshes.end() || was->second != is->second;
    if (changed && is == to.meshes.end()) {
      auto none = std::make_shared<clay::BrickMesh>();
      none->brick = brick;
      none->serial = none->vertexSerial = ++serials;
      delta.changed.push_back(std::move(none));
      continue;
    }
    if (changed) delta.changed.push_back(is->second);
    if (after && (changed || before != after)) delta.painted.push_back(after);
    if (!after && before && !changed) {
      auto bare = std::make_shared<clay::BrickPaint>();
      bare->brick = brick;
      delta.painted.push_back(std::move(bare));
    }
  }
  return delta;
}

// Beside a chunk that is replaced in part, a chunk that comes back is written where its quads name vertices of that
// one: its first layers of bricks, not all of them.
TEST(SurfaceLayoutKept, BesideWhatIsReplacedInPartOnlySidesAreWritten) {
  const Version before = ball({0, 0, 0}, 200);
  const Version after = combine(before, ball({150, 100, 35}, 175), Combination::join);
  clay::Surface surface;
  Drawn drawn;
  drawn.layout.apply(surface.update(before), drawn.sink);
  drawn.layout.apply(surface.update(after, 1, true), drawn.sink);
  drawn.sink.bytes = 0;
  const clay::SurfaceDelta delta = surface.update(before);
  drawn.layout.apply(delta, drawn.sink);
  uint64_t replaced = 0;
  for (const clay::BrickMeshPtr& mesh : delta.changed)
    replaced +=
        mesh->positions.size() * sizeof(SurfaceVertex) + mesh->quads.size() * kIndicesPerQuad * sizeof(uint32_t);
  std::printf("%.2f of %.1f MB\n", double(drawn.sink.bytes) / double(replaced), double(replaced) / 1e6);
  EXPECT_LT(double(drawn.sink.bytes), 0.7 * double(replaced));
}

// Eight chunks, each with an eighth of a ball. What moves the inside of an eighth replaces its chunk alone, though the
// triangles of the next ones name its vertices.
TEST(SurfaceLayoutKept, ChunksThatNameEachOthersVertices) {
  constexpr unsigned kSeed = 1126;
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> amount(-0.4, 0.4), unit(-1, 1);
  struct Bump {
    Vec3d at;
    double amount, radius;
    int octant;  // −1: not bound to one
  };
  std::vector<std::vector<Bump>> bumps = {{}};
  std::vector<Past> history(1);
  test::FieldSurface extractor;
  uint64_t serials = uint64_t{1} << 40;
  const auto shape = [&](const std::vector<Bump>& of) {
    return [&of](const Vec3d& p) {
      double d = p.norm() - 22.3;
      for (const Bump& bump : of) {
        if (bump.octant < 0) {
          const double near = (p - bump.at).norm() / bump.radius;
          if (near < 1) d += bump.amount * (std::fmod(std::abs(p.x() + 2 * p.y() + 3 * p.z()), 5.0) - 2) * (1 - near);
          continue;
        }
        double inside = 1e9;  // how far within the eighth
        for (int k = 0; k < 3; ++k) inside = std::min(inside, ((bump.octant >> k) & 1 ? 1 : -1) * p[k]);
        d += bump.amount * std::clamp(inside - 0.2, 0.0, 1.0);
      }
      return d;
    };
  };
  // The surface's latest form, of which the extractor tells differences.
  Past latest;
  const auto extract = [&](const std::vector<Bump>& of, const Past& like) {
    for (const clay::BrickMeshPtr& mesh : extractor.update({}, {-3, -3, -3}, {2, 2, 2}, shape(of)).changed) {
      if (mesh->positions.empty() && mesh->quads.empty())
        latest.meshes.erase(mesh->brick);
      else
        latest.meshes[mesh->brick] = mesh;
    }
    Past made = latest;
    made.paint = like.paint;
    for (auto& [brick, mesh] : made.meshes) {
      const auto same = like.meshes.find(brick);
      if (same != like.meshes.end() && std::ranges::equal(same->second->positions, mesh->positions) &&
          std::ranges::equal(same->second->quads, mesh->quads))
        mesh = same->second;
      else
        made.paint.erase(brick);
    }
    return made;
  };
  history[0] = extract({}, {});
  size_t at = 0;
  Drawn drawn;
  drawn.layout.apply(between({}, history[0], serials), drawn.sink);
  bool hides = false;
  uint64_t back = 0, most = 0;
  for (int step = 0; step < 400; ++step) {
    const Past before = history[at];
    bool keeps = true;
    const unsigned way = random() % 12;
    drawn.sink.beginUpdate();
    if (way == 0 && step > 150) {
      hides = !hides;
      drawn.layout.hideMasked(hides, drawn.sink);
      drawn.sink.beginUpdate();
    } else if (way == 1 && step > 150) {
      // Some bricks get a mask, or the unseen material, or lose it.
      keeps = random() % 2;
      Past painted = history[at];
      for (const auto& [brick, mesh] : painted.meshes) {
        if (random() % 12) continue;
        auto paint = std::make_shared<clay::BrickPaint>();
        paint->brick = brick;
        clay::VertexPaint one;
        one.mask = random() % 3 ? 255 : 0, one.material = random() % 4 ? 0 : kUnseenMaterial;
        paint->vertices.assign(mesh->positions.size(), one);
        painted.paint.erase(brick);
        if (random() % 3) painted.paint.emplace(brick, std::move(paint));
      }
      bumps.resize(at + 1), history.resize(at + 1);
      bumps.push_back(bumps[at]), history.push_back(std::move(painted));
      ++at;
    } else if (way < 5 || history.size() == 1) {
      std::vector<Bump> next = bumps[at];
      if (next.size() > 12) next.resize(2);
      keeps = way > 2 || step < 2;
      if (keeps) {
        for (int octant = 0; octant < 8; ++octant)
          if (random() % 5 == 0) next.push_back({{}, amount(random), 0, octant});
      } else {
        next.push_back({22 * Vec3d(unit(random), unit(random), unit(random)).normalized(), 1.5, 6, -1});
      }
      Past made = extract(next, history[at]);
      bumps.resize(at + 1), history.resize(at + 1);
      bumps.push_back(std::move(next)), history.push_back(std::move(made));
      ++at;
    } else {
      at = way == 5 ? random() % history.size() : way < 10 ? at - (at > 0) : std::min(at + 1, history.size() - 1);
      ++back;
    }
    if (random() % 4 == 0) drawn.makeLevels();
    clay::SurfaceDelta delta = between(before, history[at], serials);
    delta.keepsBefore = keeps;
    drawn.sink.beginUpdate();
    drawn.sink.bytes = 0;
    drawn.layout.apply(delta, drawn.sink);
    most = std::max(most, drawn.layout.keptQuads());
    Drawn fresh;
    fresh.layout.hideMasked(hides, fresh.sink);
    fresh.layout.apply(between({}, history[at], serials), fresh.sink);
    ASSERT_EQ(drawn.sink.picture(drawn.layout, 0), fresh.sink.picture(fresh.layout, 0)) << "step " << step;
    if (random() % 3) continue;
    drawn.makeLevels(), fresh.makeLevels();
    ASSERT_EQ(drawn.sink.picture(drawn.layout, 2), fresh.sink.picture(fresh.layout, 2)) << "step " << step;
  }
  std::printf("%lu steps back and forth, %lu quads kept at most\n", back, most);
  EXPECT_GT(back, 30u);
  EXPECT_GT(most, 1000u);
}

}  // namespace
}  // namespace argil::render
