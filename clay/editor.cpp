#include "clay/editor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "clay/error.h"
#include "clay/tree.h"

namespace argil::clay {

namespace {

constexpr uint64_t kSerialBatch = 1024;  // serials taken at once: one atomic access for about ten dabs

Node* nodeOf(Link link) { return reinterpret_cast<Node*>(link); }
Brick* brickOf(Link link) { return reinterpret_cast<Brick*>(link); }

void requireReach(Coord brick) {
  if (!inReach(brick))
    throw Error(fmt::format("clay at voxel ({}, {}, {}) is out of reach: use a larger voxel or move the model's origin", brick.x * 8LL,
                            brick.y * 8LL, brick.z * 8LL));
}

}  // namespace

uint64_t Editor::Counts::bytes() const { return bricksMade * sizeof(Brick) + nodesMade * sizeof(Node); }

Editor::Editor(Version base) : base_(std::move(base)), store_(base_.store().get()), root_(base_.record()->root) {
  id_ = store_->state().nextId++;
}

Editor::~Editor() {
  if (!store_ || !changed_) return;
  std::vector<void*> bricks, nodes;
  gatherExclusive(root_, base_.record()->root, 0, kTreeLevels, bricks, nodes);
  store_->state().freeAll(bricks, nodes);
}

Slot Editor::find(Coord brick) const noexcept {
  const Coord region = brick >> 3;
  if (region != cachedRegion_) {
    if (!inReach(brick)) return Tile::outside;
    cachedRegion_ = region;
    cachedLink_ = descend(root_, brick, 1);
  }
  return slotOf(isTile(cachedLink_) ? cachedLink_ : nodeOf(cachedLink_)->child[childIndex(brick, 1)]);
}

Node* Editor::newNode(Link fill) {
  Node* node = store_->state().newNode();
  node->birth = id_;
  std::fill(std::begin(node->child), std::end(node->child), fill);
  ++counts_.nodesMade;
  return node;
}

// The link at `level` on the way to a brick, every node above it made this transaction's own.
Link* Editor::writableLink(Coord brick, int level) {
  Link* link = &root_;
  for (int at = kTreeLevels; at > level; --at) {
    if (isTile(*link)) {
      *link = reinterpret_cast<Link>(newNode(*link));
      ++nodesDelta_;
    } else if (nodeOf(*link)->birth != id_) {
      Node* copy = store_->state().newNode();
      std::memcpy(copy->child, nodeOf(*link)->child, sizeof copy->child);
      copy->birth = id_;
      ++counts_.nodesMade;
      *link = reinterpret_cast<Link>(copy);
    }
    if (at == 1) {
      cachedRegion_ = brick >> 3;
      cachedLink_ = *link;
    }
    link = &nodeOf(*link)->child[childIndex(brick, at)];
  }
  changed_ = true;
  return link;
}

// Takes a subtree out of the new version: what this transaction made goes back at once, the rest belongs to the base.
void Editor::release(Link link, int level) {
  if (isTile(link)) return;
  if (level == 0) {
    --bricksDelta_;
    if (brickOf(link)->birth == id_) store_->state().brickStock.push_back(brickOf(link));
    return;
  }
  --nodesDelta_;
  for (const Link child : nodeOf(link)->child) release(child, level - 1);
  if (nodeOf(link)->birth == id_) store_->state().nodeStock.push_back(nodeOf(link));
}

void Editor::place(Coord brick, Link link) {
  const Slot now = find(brick);
  if (slotOf(link) == now) return;
  // A region whose node is this transaction's own already needs no walk from the root.
  Link* at = !isTile(cachedLink_) && nodeOf(cachedLink_)->birth == id_ && cachedRegion_ == brick >> 3
                 ? &nodeOf(cachedLink_)->child[childIndex(brick, 1)]
                 : writableLink(brick, 0);
  release(*at, 0);
  *at = link;
  if (isTile(link)) {
    const Coord region = brick >> 3;
    if (mayCollapse_.empty() || mayCollapse_.back() >> 3 != region) mayCollapse_.push_back(brick);
  } else {
    ++bricksDelta_;
  }
}

void Editor::setTile(Coord brick, Tile tile) {
  requireReach(brick);
  place(brick, linkOf(tile));
}

bool Editor::setBlock(Coord brick, int level, Tile tile) {
  requireReach(brick);
  if (descend(root_, brick, level) == linkOf(tile)) return false;
  if (level == 0) {
    setTile(brick, tile);
    return true;
  }
  Link* link = writableLink(brick, level);
  release(*link, level);
  *link = linkOf(tile);
  cachedRegion_ = {INT32_MIN, 0, 0};
  mayCollapse_.push_back(brick);
  return true;
}

void Editor::setVoxels(Coord coord, std::span<const float, kBrickVoxels> phi) {
  requireReach(coord);
  const float band = grid().band;
  Brick* brick = newBrick(coord);
  bool inBand = false;
  std::fill(std::begin(brick->inside), std::end(brick->inside), uint64_t{0});
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (std::isnan(phi[static_cast<size_t>(i)])) {
      recycle(brick);
      throw Error("clay distance is not a number", Error::Kind::work);
    }
    const float value = std::clamp(phi[static_cast<size_t>(i)], -band, band) + 0.0f;
    brick->phi[i] = value;
    brick->inside[i >> 6] |= static_cast<uint64_t>(value < 0) << (i & 63);
    inBand |= std::abs(value) < band;
  }
  const Slot now = find(coord);
  if (inBand && now.brick() && std::memcmp(now.brick()->phi, brick->phi, sizeof brick->phi) == 0)
    recycle(brick);
  else
    link(brick, inBand);
}

Coord Editor::blockFirst(Coord brick, int level) {
  const Coord origin{kBrickOrigin, kBrickOrigin, kBrickOrigin};
  return ((brick + origin) >> (3 * level)) * (1 << (3 * level)) - origin;
}

Brick* Editor::newBrick(Coord coord) {
  Brick* brick = store_->state().newBrick();
  if (serial_ == serialEnd_) {
    serial_ = store_->state().nextSerial.fetch_add(kSerialBatch);
    serialEnd_ = serial_ + kSerialBatch;
  }
  brick->serial = serial_++;
  brick->birth = id_;
  brick->coord = coord;
  ++counts_.bricksMade;
  return brick;
}

void Editor::recycle(Brick* brick) {
  --counts_.bricksMade;
  store_->state().brickStock.push_back(brick);
}

void Editor::link(Brick* brick, bool inBand) {
  const Coord coord = brick->coord;
  if (inBand) {
    uint64_t any = 0, all = ~uint64_t{0};
    for (const uint64_t word : brick->inside) {
      any |= word;
      all &= word;
    }
    brick->anyInside = any != 0;
    brick->anyOutside = all != ~uint64_t{0};
    place(coord, reinterpret_cast<Link>(brick));
    return;
  }
  const Tile tile = brick->phi[0] < 0 ? Tile::inside : Tile::outside;
  if (find(coord) != Slot(brick)) recycle(brick);
  place(coord, linkOf(tile));
}

Brick* Editor::own(Coord coord) noexcept {
  const Brick* brick = find(coord).brick();
  return brick && brick->birth == id_ ? const_cast<Brick*>(brick) : nullptr;
}

// Nodes whose children have all become one tile turn into that tile, upwards as far as it goes.
void Editor::collapse(Coord brick) {
  for (int level = 1; level <= kTreeLevels; ++level) {
    const Link link = descend(root_, brick, level);
    if (isTile(link)) {
      continue;  // the block itself was made a tile: its parent may follow
    }
    const Node* node = nodeOf(link);
    const Link first = node->child[0];
    if (!isTile(first) || !std::all_of(std::begin(node->child), std::end(node->child), [first](Link c) { return c == first; })) return;
    Link* at = writableLink(brick, level);
    release(*at, level);
    *at = first;
  }
}

Version Editor::commit() {
  if (!changed_) {
    store_ = nullptr;
    return base_;
  }
  std::sort(mayCollapse_.begin(), mayCollapse_.end());
  for (const Coord brick : mayCollapse_) collapse(brick);
  auto* record = new VersionRecord;
  record->grid = base_.grid();
  record->id = id_;
  record->root = root_;
  record->stats.bricks = base_.stats().bricks + static_cast<uint64_t>(bricksDelta_);
  record->stats.nodes = base_.stats().nodes + static_cast<uint64_t>(nodesDelta_);
  record->parent = const_cast<VersionRecord*>(base_.record());
  record->store = base_.store();
  store_ = nullptr;
  return makeVersion(record);
}

}  // namespace argil::clay
