#include "clay/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "clay/brick_extraction.h"
#include "clay/brick_set.h"
#include "clay/hash.h"
#include "clay/parallel.h"
#include "clay/sampler.h"

namespace argil::clay {

PackedNormal PackedNormal::pack(const Vec3f& n) noexcept {
  const float scale = 1.0f / (std::abs(n.x()) + std::abs(n.y()) + std::abs(n.z()));
  float u = n.x() * scale, v = n.y() * scale;
  if (n.z() < 0) {
    const float folded = (1 - std::abs(v)) * (u < 0 ? -1.0f : 1.0f);
    v = (1 - std::abs(u)) * (v < 0 ? -1.0f : 1.0f);
    u = folded;
  }
  const auto fixed = [](float x) { return static_cast<int16_t>(x * 32767.0f + (x < 0 ? -0.5f : 0.5f)); };
  return {fixed(u), fixed(v)};
}

Vec3f PackedNormal::unpack() const noexcept {
  const float x = static_cast<float>(u) / 32767.0f, y = static_cast<float>(v) / 32767.0f;
  Vec3f n(x, y, 1 - std::abs(x) - std::abs(y));
  if (n.z() < 0) {
    n.x() = (1 - std::abs(y)) * (x < 0 ? -1.0f : 1.0f);
    n.y() = (1 - std::abs(x)) * (y < 0 ? -1.0f : 1.0f);
  }
  return n.normalized();
}

namespace {

struct Vertices {
  Vertices(const std::shared_ptr<BlockPool>& pool, std::span<const Vec3f> p, std::span<const PackedNormal> n)
      : positionStorage(pool, p.size()), normalStorage(pool, n.size()), positions(positionStorage.data(), p.size()), normals(normalStorage.data(), n.size()) {
    std::uninitialized_copy(p.begin(), p.end(), positionStorage.data());
    std::uninitialized_copy(n.begin(), n.end(), normalStorage.data());
  }
  PoolArray<Vec3f> positionStorage;
  PoolArray<PackedNormal> normalStorage;
  std::span<const Vec3f> positions;
  std::span<const PackedNormal> normals;
};

template <class T>
bool sameBytes(std::span<const T> a, std::span<const T> b) {
  // Two empty ones have no bytes that may be asked for.
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

struct Entry {
  CellTable table;
  std::shared_ptr<const Vertices> vertices;
  BrickMeshPtr mesh;
};

}  // namespace

struct Surface::State {
  using Region = std::array<std::unique_ptr<Entry>, 512>;

  bool normals;
  Version version;
  std::unordered_map<Coord, std::unique_ptr<Region>, CoordHash> regions;
  uint64_t nextSerial = 1;
  uint64_t vertexCount = 0, quadCount = 0, foldedBricks = 0;

  static size_t indexIn(Coord brick) { return static_cast<size_t>((brick.x & 7) << 6 | (brick.y & 7) << 3 | (brick.z & 7)); }

  // Remembers the region of the last look-up; one per thread.
  struct Cursor {
    explicit Cursor(const State& s) : state(s) {}
    const State& state;
    Coord region{INT32_MIN, 0, 0};
    Region* found = nullptr;

    Entry* find(Coord brick) {
      if (brick >> 3 != region) {
        region = brick >> 3;
        const auto it = state.regions.find(region);
        found = it == state.regions.end() ? nullptr : it->second.get();
      }
      return found ? (*found)[indexIn(brick)].get() : nullptr;
    }
  };

  std::unique_ptr<Entry>& place(Coord brick) {
    auto& region = regions[brick >> 3];
    if (!region) region = std::make_unique<Region>();
    return (*region)[indexIn(brick)];
  }

  template <class Visit>
  void forEach(const Visit& visit) const {
    std::vector<Coord> keys;
    keys.reserve(regions.size());
    for (const auto& entry : regions) keys.push_back(entry.first);
    std::sort(keys.begin(), keys.end());
    for (const Coord key : keys)
      for (const auto& entry : *regions.at(key))
        if (entry) visit(*entry);
  }

  using QuadArray = PoolArray<std::array<VertexRef, 4>>;
  std::shared_ptr<BlockPool> pool = std::make_shared<BlockPool>();

  BrickMeshPtr makeMesh(Coord brick, std::shared_ptr<const Vertices> vertices, QuadArray quads) {
    auto mesh = std::allocate_shared<BrickMesh>(PoolAllocator<BrickMesh>(pool));
    mesh->brick = brick;
    mesh->serial = nextSerial++;
    if (vertices) {
      mesh->positions = vertices->positions;
      mesh->normals = vertices->normals;
      mesh->vertexStorage = std::move(vertices);
    }
    mesh->quadStorage = std::move(quads);
    mesh->quads = {mesh->quadStorage.data(), mesh->quadStorage.size()};
    return mesh;
  }

  std::vector<Coord> changedBricks(const Version& next);
  void followVertices(std::span<const Coord> bricks, int threads, BrickSet& quadBricks, std::vector<Coord>& gone);
  void followQuads(std::span<const Coord> bricks, int threads, std::span<const Coord>& gone, SurfaceDelta& delta);
  void follow(std::span<const Coord> bricks, int threads, SurfaceDelta& delta);
};

// Both signs among a brick and those one step higher.
bool mayBeCrossed(Sampler& field, Coord brick) {
  Slot slots[2][2][2];
  field.corner(brick, slots);
  bool inside = false, outside = false;
  for (int i = 0; i < 8; ++i) {
    const Slot slot = slots[i >> 2][(i >> 1) & 1][i & 1];
    inside |= slot.isTile() ? slot.tile() == Tile::inside : slot.brick()->anyInside != 0;
    outside |= slot.isTile() ? slot.tile() == Tile::outside : slot.brick()->anyOutside != 0;
  }
  return inside && outside;
}

// Bricks of a whole model that can have a vertex: both signs among them and the bricks one step higher. By bits, region by
// region: each brick is looked at once.
std::vector<Coord> crossedBricks(const Version& version) {
  std::vector<Coord> regions;
  version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < 8; ++i) {
      const Coord region = (brick.coord - Coord{i >> 2, (i >> 1) & 1, i & 1}) >> 3;
      if (regions.empty() || regions.back() != region) regions.push_back(region);
    }
  });
  std::sort(regions.begin(), regions.end());
  regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
  std::vector<Coord> crossed;
  Sampler field(version);
  for (const Coord region : regions) {
    // Bit z of [x][y]; first each brick, then together with those one step higher.
    unsigned inside[9][9] = {}, outside[9][9] = {};
    for (int x = 0; x < 9; ++x)
      for (int y = 0; y < 9; ++y)
        for (int z = 0; z < 9; ++z) {
          const Slot slot = field.slot(region * 8 + Coord{x, y, z});
          const bool in = slot.isTile() ? slot.tile() == Tile::inside : slot.brick()->anyInside != 0;
          const bool out = slot.isTile() ? slot.tile() == Tile::outside : slot.brick()->anyOutside != 0;
          inside[x][y] |= static_cast<unsigned>(in) << z;
          outside[x][y] |= static_cast<unsigned>(out) << z;
        }
    const auto together = [](unsigned (&bits)[9][9], int x, int y) {
      const unsigned all = bits[x][y] | bits[x][y + 1] | bits[x + 1][y] | bits[x + 1][y + 1];
      return all | all >> 1;
    };
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (unsigned left = together(inside, x, y) & together(outside, x, y) & 0xff; left != 0; left &= left - 1)
          crossed.push_back(region * 8 + Coord{x, y, std::countr_zero(left)});
  }
  return crossed;
}

// Bricks whose cells may have other vertices now: a cell reads its own brick and those one step higher; one with a folded
// face also reads the cell beyond.
std::vector<Coord> Surface::State::changedBricks(const Version& next) {
  BrickSet set;
  Cursor cursor(*this);
  const auto add = [&](Coord brick) {
    for (int i = 0; i < 8; ++i) set.add(brick - Coord{i >> 2, (i >> 1) & 1, i & 1});
    if (foldedBricks == 0) return;
    for (int i = 0; i < 27; ++i) {
      const Coord step{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
      if (step.x <= 0 && step.y <= 0 && step.z <= 0) continue;
      const Entry* entry = cursor.find(brick + step);
      if (entry && entry->table.folded) set.add(brick + step);
    }
  };
  if (!version) return crossedBricks(next);
  Version::forEachDifference(version, next, [&](Coord brick, Slot, Slot) { add(brick); });
  // Most bricks of an edit see one sign only, then and now.
  std::vector<Coord> changed = set.sorted();
  Sampler field(next);
  std::erase_if(changed, [&](Coord brick) { return !cursor.find(brick) && !mayBeCrossed(field, brick); });
  return changed;
}

// Vertices of `bricks`; then `quadBricks` are those whose quads may be others now, `gone` those that lost their surface.
void Surface::State::followVertices(std::span<const Coord> bricks, int threads, BrickSet& quadBricks, std::vector<Coord>& gone) {
  struct Found {
    CellTable table;
    std::shared_ptr<const Vertices> vertices;
    bool changed = false;
  };
  std::vector<Found> found(bricks.size());
  parallelBlocks(bricks.size(), threads, [&](size_t begin, size_t end) {
    Sampler field(version);
    Cursor cursor(*this);
    const auto scratch = std::make_unique_for_overwrite<VertexBuffer>();
    for (size_t i = begin; i < end; ++i) {
      extractVertices(field, bricks[i], normals, found[i].table, *scratch);
      const std::span<const Vec3f> positions = scratch->usedPositions();
      const std::span<const PackedNormal> normalsHere = normals ? scratch->usedNormals() : std::span<const PackedNormal>();
      const Entry* old = cursor.find(bricks[i]);
      if (positions.empty()) {
        found[i].changed = old != nullptr;
      } else if (old && old->table == found[i].table && sameBytes(old->vertices->positions, positions) && sameBytes(old->vertices->normals, normalsHere)) {
        found[i].vertices = old->vertices;
      } else {
        found[i].changed = true;
        found[i].vertices = std::allocate_shared<const Vertices>(PoolAllocator<Vertices>(pool), pool, positions, normalsHere);
      }
    }
  });
  // Quads follow their own signs, and the vertices of their brick and of those one step lower.
  for (size_t i = 0; i < bricks.size(); ++i) {
    Found& f = found[i];
    if (f.vertices) quadBricks.add(bricks[i]);
    if (!f.changed) continue;
    for (int k = 1; k < 8; ++k) quadBricks.add(bricks[i] + Coord{k >> 2, (k >> 1) & 1, k & 1});
    std::unique_ptr<Entry>& entry = place(bricks[i]);
    if (entry) {
      vertexCount -= entry->table.vertices;
      foldedBricks -= entry->table.folded;
    }
    if (!f.vertices) {
      quadCount -= entry->mesh->quads.size();
      entry.reset();
      gone.push_back(bricks[i]);
      continue;
    }
    if (!entry) entry = std::make_unique<Entry>();
    vertexCount += f.table.vertices;
    foldedBricks += f.table.folded;
    entry->table = std::move(f.table);
    entry->vertices = std::move(f.vertices);
  }
}

void Surface::State::followQuads(std::span<const Coord> bricks, int threads, std::span<const Coord>& gone, SurfaceDelta& delta) {
  struct Made {
    Entry* entry = nullptr;
    QuadArray quads;
  };
  std::vector<Made> made(bricks.size());
  parallelBlocks(bricks.size(), threads, [&](size_t begin, size_t end) {
    Sampler field(version);
    Cursor cursor(*this);
    const auto buffer = std::make_unique_for_overwrite<QuadBuffer>();
    for (size_t i = begin; i < end; ++i) {
      Entry* entry = cursor.find(bricks[i]);
      if (!entry) continue;
      std::array<VertexSource, 8> sources;
      for (int k = 0; k < 8; ++k) {
        const Entry* lower = k == 0 ? entry : cursor.find(bricks[i] - Coord{k >> 2, (k >> 1) & 1, k & 1});
        if (lower) sources[static_cast<size_t>(k)] = {&lower->table, lower->vertices->positions.data()};
      }
      extractQuads(field, bricks[i], sources, *buffer);
      const std::span<const std::array<VertexRef, 4>> scratch = buffer->used();
      const BrickMesh* old = entry->mesh.get();
      if (old && old->vertexStorage == entry->vertices && std::equal(scratch.begin(), scratch.end(), old->quads.begin(), old->quads.end())) continue;
      made[i].entry = entry;
      made[i].quads = QuadArray(pool, scratch.size());
      std::uninitialized_copy(scratch.begin(), scratch.end(), made[i].quads.data());
    }
  });
  const auto before = [](Coord a, Coord b) { return std::pair(a >> 3, a) < std::pair(b >> 3, b); };
  for (size_t i = 0; i < made.size(); ++i) {
    while (!gone.empty() && before(gone.front(), bricks[i])) {
      delta.changed.push_back(makeMesh(gone.front(), nullptr, {}));
      gone = gone.subspan(1);
    }
    Entry* entry = made[i].entry;
    if (!entry) continue;
    if (entry->mesh) quadCount -= entry->mesh->quads.size();
    quadCount += made[i].quads.size();
    entry->mesh = makeMesh(bricks[i], entry->vertices, std::move(made[i].quads));
    delta.changed.push_back(entry->mesh);
  }
}

void Surface::State::follow(std::span<const Coord> bricks, int threads, SurfaceDelta& delta) {
  // In slices, so that what passes between the steps stays in the cache.
  const size_t slice = 1024 * static_cast<size_t>(threads);
  BrickSet quadSet;
  std::vector<Coord> gone;
  for (size_t at = 0; at < bricks.size(); at += slice)
    followVertices(bricks.subspan(at, std::min(slice, bricks.size() - at)), threads, quadSet, gone);
  const std::vector<Coord> quadBricks = quadSet.sorted();
  std::span<const Coord> goneLeft(gone);
  delta.changed.reserve(delta.changed.size() + gone.size() + quadBricks.size());
  for (size_t at = 0; at < quadBricks.size(); at += slice)
    followQuads(std::span(quadBricks).subspan(at, std::min(slice, quadBricks.size() - at)), threads, goneLeft, delta);
  for (const Coord brick : goneLeft) delta.changed.push_back(makeMesh(brick, nullptr, {}));
}

Surface::Surface(bool normals) : state_(std::make_unique<State>()) { state_->normals = normals; }
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

SurfaceDelta Surface::update(const Version& version, int threads) {
  State& s = *state_;
  SurfaceDelta delta;
  delta.grid = version.grid();
  std::vector<Coord> bricks;
  if (s.version && (s.version.store() != version.store() || !(s.version.grid() == version.grid()))) {
    // Another model: all that stood is looked at again, together with all that stands.
    BrickSet all;
    s.forEach([&](const Entry& entry) { all.add(entry.mesh->brick); });
    s.version = Version();
    for (const Coord brick : s.changedBricks(version)) all.add(brick);
    bricks = all.sorted();
  } else {
    bricks = s.changedBricks(version);
  }
  s.version = version;
  s.follow(bricks, threads, delta);
  return delta;
}

const Version& Surface::version() const { return state_->version; }
uint64_t Surface::vertexCount() const { return state_->vertexCount; }
uint64_t Surface::quadCount() const { return state_->quadCount; }

const BrickMesh* Surface::find(Coord brick) const {
  const Entry* entry = State::Cursor(*state_).find(brick);
  return entry ? entry->mesh.get() : nullptr;
}

void Surface::forEach(const std::function<void(const BrickMesh&)>& visit) const {
  state_->forEach([&](const Entry& entry) { visit(*entry.mesh); });
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

TriangleMesh Surface::toMesh() const {
  TriangleMesh mesh;
  mesh.positions.reserve(vertexCount());
  mesh.triangles.reserve(2 * quadCount());
  std::unordered_map<Coord, uint32_t, CoordHash> first;
  const Grid& grid = state_->version.grid();
  forEach([&](const BrickMesh& brick) {
    first[brick.brick] = static_cast<uint32_t>(mesh.positions.size());
    const Vec3d origin = (brick.brick * kBrickEdge).toVec3d();
    for (const Vec3f& p : brick.positions) mesh.positions.push_back(grid.toWorld(origin + p.cast<double>()));
  });
  forEach([&](const BrickMesh& brick) {
    std::array<uint32_t, 8> base{};
    for (int k = 0; k < 8; ++k) {
      const auto it = first.find(brick.brick - Coord{k & 1, (k >> 1) & 1, k >> 2});
      if (it != first.end()) base[static_cast<size_t>(k)] = it->second;
    }
    for (const auto& quad : brick.quads) {
      std::array<uint32_t, 4> v;
      for (size_t i = 0; i < 4; ++i) v[i] = base[quad[i] >> kVertexRefBits] + (quad[i] & kVertexRefIndex);
      mesh.triangles.push_back({v[0], v[1], v[2]});
      mesh.triangles.push_back({v[0], v[2], v[3]});
    }
  });
  return mesh;
}

}  // namespace argil::clay
