#include "clay/store/vdb_bridge.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>

#include "clay/store/editor.h"
#include "clay/store/openvdb_grids.h"
#include "clay/store/store.h"

namespace argil::clay {

namespace {

using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;
static_assert(Leaf::DIM == kBrickEdge && Leaf::SIZE == kBrickVoxels);

constexpr size_t kStepEvery = 4096;  // bricks between two looks at the job

void step(Job* job, double from, size_t done, size_t all) {
  if (job && done % kStepEvery == 0) job->step(from + (1 - from) * double(done) / double(std::max<size_t>(all, 1)));
}

Coord brickOf(const openvdb::Coord& voxel) {
  return {voxel.x() >> kBrickBits, voxel.y() >> kBrickBits, voxel.z() >> kBrickBits};
}

/// Makes the bricks from low to high, exclusive, that lie in the given block of the tree inside: in blocks as large as
/// fit.
void fillBlock(Editor& editor, Coord low, Coord high, Coord block, int level) {
  const int edge = 1 << (3 * level);
  const Coord end = block + Coord{edge, edge, edge};
  if (end.x <= low.x || end.y <= low.y || end.z <= low.z || block.x >= high.x || block.y >= high.y || block.z >= high.z)
    return;
  if (block.x >= low.x && block.y >= low.y && block.z >= low.z && end.x <= high.x && end.y <= high.y &&
      end.z <= high.z) {
    editor.setBlock(block, level, Tile::inside);
    return;
  }
  const int child = edge / 8;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) fillBlock(editor, low, high, block + Coord{x, y, z} * child, level - 1);
    }
  }
}

/// The same for a whole cube of bricks, which need not be a block of our tree.
void fillCube(Editor& editor, Coord low, int bricks) {
  int level = 0;
  while (8 << (3 * level) <= bricks) ++level;
  const int edge = 1 << (3 * level);
  const Coord high = low + Coord{bricks, bricks, bricks}, first = Editor::blockFirst(low, level);
  for (int x = first.x; x < high.x; x += edge) {
    for (int y = first.y; y < high.y; y += edge) {
      for (int z = first.z; z < high.z; z += edge) fillBlock(editor, low, high, {x, y, z}, level);
    }
  }
}

}  // namespace

void initializeVdb() {
  static const bool once = (openvdb::initialize(), true);
  (void)once;
}

VdbGrid toVdb(const Version& version, Job* job) {
  initializeVdb();
  const float band = version.grid().band;
  auto grid = openvdb::FloatGrid::create(band);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::FloatGrid::Accessor accessor = grid->getAccessor();
  size_t done = 0;
  const size_t all = version.stats().bricks;
  version.forEachBrick([&](const Brick& brick) {
    step(job, 0, done++, all);
    const Coord first = brick.coord * kBrickEdge;
    Leaf* leaf = accessor.touchLeaf({first.x, first.y, first.z});
    float* values = leaf->buffer().data();
    Leaf::NodeMaskType active;
    brick.read(0, kBrickVoxels, values);
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (std::abs(values[i]) < band) active.setOn(openvdb::Index32(i));
    }
    leaf->setValueMask(active);
  });
  openvdb::tools::signedFloodFill(grid->tree());
  return {grid};
}

Version fromVdb(std::shared_ptr<Store> store, const Grid& grid, const VdbGrid& level, Job* job, double jobFrom) {
  initializeVdb();
  const auto source = std::static_pointer_cast<openvdb::FloatGrid>(level.grid);
  const Tree& tree = source->constTree();
  Editor editor(Version::empty(std::move(store), grid));

  // Tiles first: the bricks then link into blocks that are inside already.
  const auto requireReach = [](const openvdb::CoordBBox& box) {
    constexpr int kReach = kBrickReach * kBrickEdge;
    if (openvdb::CoordBBox(openvdb::Coord(-kReach), openvdb::Coord(kReach - 1)).isInside(box)) return;
    throw Error("the grid reaches farther than clay can, 131 072 voxels from the origin: use a larger voxel or move it",
                Error::Kind::work);
  };
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (tile.getValue() >= 0) continue;
    openvdb::CoordBBox box;
    if (!tile.getBoundingBox(box)) continue;
    requireReach(box);
    fillCube(editor, brickOf(box.min()), box.dim().x() / kBrickEdge);
  }

  size_t done = 0;
  const size_t all = job ? tree.leafCount() : 0;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    step(job, jobFrom, done++, all);
    requireReach(leaf->getNodeBoundingBox());
    editor.setVoxels(brickOf(leaf->origin()),
                     std::span<const float, kBrickVoxels>(leaf->buffer().data(), kBrickVoxels));
  }
  return editor.commit();
}

}  // namespace argil::clay
