#include "clay/store/editor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/kernels/fixed_brick.h"
#include "clay/store/tree.h"

namespace argil::clay {

namespace {

constexpr uint64_t kSerialBatch = 1024;  // serials taken at once: one atomic access for about ten dabs

Node* nodeOf(Link link) {
  return reinterpret_cast<Node*>(link);
}
Brick* brickOf(Link link) {
  return reinterpret_cast<Brick*>(link);
}

void requireReach(Coord brick) {
  if (!inReach(brick))
    throw Error(fmt::format("clay at voxel ({}, {}, {}) is out of reach: use a larger voxel or move the model's origin",
                            brick.x * 8LL, brick.y * 8LL, brick.z * 8LL));
}

}  // namespace

uint64_t Editor::Counts::bytes() const {
  return bricksMade * brickBytes(precision) + channelBricksMade * sizeof(ChannelBrick) + nodesMade * sizeof(Node);
}

Editor::Editor(Version base) : base_(std::move(base)), store_(base_.store().get()) {
  for (size_t i = 0; i < trees_.size(); ++i) trees_[i].root = base_.record()->roots[i];
  trees_[kDistanceTree].distances = true;
  id_ = store_->state().nextId++;
  step_ = base_.record()->step;
  counts_.precision = store_->precision();
}

Editor::~Editor() {
  if (!store_) return;
  if (changed_)
    for (size_t i = 0; i < trees_.size(); ++i)
      gatherExclusive(trees_[i].root, base_.record()->roots[i], 0, kTreeLevels,
                      i == kDistanceTree ? stock_.bricks.free : stock_.channelBricks.free, stock_.nodes.free);
  giveBack();
}

// All that was not used goes back to the store.
void Editor::giveBack() {
  Store::State::Freed freed{std::move(stock_.bricks.free), std::move(stock_.channelBricks.free),
                            std::move(stock_.nodes.free)};
  store_->state().giveWorkBricks(stock_.work.free);
  stock_ = {};
  store_->state().freeAll(freed);
}

Link Editor::linkAt(const Tree& tree, Coord brick) const noexcept {
  const Coord region = brick >> 3;
  Link link = tree.cachedLink;
  if (region != tree.cachedRegion) {  // Left as it is: others may be reading.
    if (!inReach(brick)) return 0;
    link = descend(tree.root, brick, 1);
  }
  return isTile(link) ? link : nodeOf(link)->child[childIndex(brick, 1)];
}

Slot Editor::find(Coord brick) const noexcept {
  return slotOf(linkAt(trees_[kDistanceTree], brick));
}
ChannelSlot Editor::find(Channel channel, Coord brick) const noexcept {
  return channelSlotOf(linkAt(treeOfChannel(channel), brick));
}
bool Editor::has(Channel channel) const noexcept {
  return treeOfChannel(channel).root != 0;
}

Node* Editor::takeNode() {
  if (stock_.nodes.free.empty()) store_->state().stockNodes(stock_.nodes);
  auto* node = static_cast<Node*>(stock_.nodes.free.back());
  stock_.nodes.free.pop_back();
  return node;
}

ChannelBrick* Editor::takeChannelBrick() {
  if (stock_.channelBricks.free.empty()) store_->state().stockChannelBricks(stock_.channelBricks);
  auto* brick = static_cast<ChannelBrick*>(stock_.channelBricks.free.back());
  stock_.channelBricks.free.pop_back();
  return brick;
}

Node* Editor::newNode(Link fill) {
  Node* node = takeNode();
  node->birth = id_;
  std::fill(std::begin(node->child), std::end(node->child), fill);
  ++counts_.nodesMade;
  return node;
}

// The link at `level` on the way to a brick, every node above it made this transaction's own.
Link* Editor::writableLink(Tree& tree, Coord brick, int level) {
  Link* link = &tree.root;
  for (int at = kTreeLevels; at > level; --at) {
    if (isTile(*link)) {
      *link = reinterpret_cast<Link>(newNode(*link));
      ++nodesDelta_;
    } else if (nodeOf(*link)->birth != id_) {
      Node* copy = takeNode();
      std::memcpy(copy->child, nodeOf(*link)->child, sizeof copy->child);
      copy->birth = id_;
      ++counts_.nodesMade;
      *link = reinterpret_cast<Link>(copy);
    }
    if (at == 1) {
      tree.cachedRegion = brick >> 3;
      tree.cachedLink = *link;
    }
    link = &nodeOf(*link)->child[childIndex(brick, at)];
  }
  changed_ = true;
  return link;
}

// Takes a subtree out of the new version: what this transaction made goes back at once, the rest belongs to the base.
void Editor::release(const Tree& tree, Link link, int level) {
  if (isTile(link)) return;
  if (level == 0 && tree.distances) {
    --bricksDelta_;
    if (brickOf(link)->birth == id_) stock_.bricks.free.push_back(brickOf(link));
    return;
  }
  if (level == 0) {
    --channelDelta_;
    auto* brick = reinterpret_cast<ChannelBrick*>(link);
    if (brick->birth == id_) stock_.channelBricks.free.push_back(brick);
    return;
  }
  --nodesDelta_;
  for (const Link child : nodeOf(link)->child) release(tree, child, level - 1);
  if (nodeOf(link)->birth == id_) stock_.nodes.free.push_back(nodeOf(link));
}

void Editor::place(Tree& tree, Coord brick, Link link) {
  if (linkAt(tree, brick) == link) return;
  // A region whose node is this transaction's own already needs no walk from the root.
  Link* at = !isTile(tree.cachedLink) && nodeOf(tree.cachedLink)->birth == id_ && tree.cachedRegion == brick >> 3
                 ? &nodeOf(tree.cachedLink)->child[childIndex(brick, 1)]
                 : writableLink(tree, brick, 0);
  release(tree, *at, 0);
  *at = link;
  if (isTile(link)) {
    const Coord region = brick >> 3;
    if (tree.mayCollapse.empty() || tree.mayCollapse.back() >> 3 != region) tree.mayCollapse.push_back(brick);
  } else {
    ++(tree.distances ? bricksDelta_ : channelDelta_);
  }
}

void Editor::setTile(Coord brick, Tile tile) {
  requireReach(brick);
  place(trees_[kDistanceTree], brick, linkOf(tile));
}

void Editor::setChannelTile(Channel channel, Coord brick, bool full) {
  requireReach(brick);
  place(treeOfChannel(channel), brick, full);
}

void Editor::setChannel(Channel channel, Coord coord, std::span<const uint8_t, kBrickVoxels> values) {
  requireReach(coord);
  const uint8_t first = values[0];
  if ((first == 0 || first == 255) &&
      std::all_of(values.begin(), values.end(), [first](uint8_t v) { return v == first; })) {
    place(treeOfChannel(channel), coord, first == 255);
    return;
  }
  Tree& tree = treeOfChannel(channel);
  const ChannelBrick* now = find(channel, coord).brick();
  if (now && std::memcmp(now->value, values.data(), kBrickVoxels) == 0) return;
  ChannelBrick* brick = now && now->birth == id_ ? const_cast<ChannelBrick*>(now) : takeChannelBrick();
  std::memcpy(brick->value, values.data(), kBrickVoxels);
  if (brick == now) return;
  brick->serial = nextSerial();
  brick->birth = id_;
  brick->coord = coord;
  ++counts_.channelBricksMade;
  place(tree, coord, reinterpret_cast<Link>(brick));
}

uint64_t Editor::nextSerial() {
  if (serial_ == serialEnd_) {
    serial_ = store_->state().nextSerial.fetch_add(kSerialBatch);
    serialEnd_ = serial_ + kSerialBatch;
  }
  return serial_++;
}

bool Editor::setBlock(Coord brick, int level, Tile tile) {
  requireReach(brick);
  Tree& tree = trees_[kDistanceTree];
  if (descend(tree.root, brick, level) == linkOf(tile)) return false;
  if (level == 0) {
    setTile(brick, tile);
    return true;
  }
  Link* link = writableLink(tree, brick, level);
  release(tree, *link, level);
  *link = linkOf(tile);
  tree.cachedRegion = {INT32_MIN, 0, 0};
  tree.mayCollapse.push_back(brick);
  return true;
}

void Editor::setVoxels(Coord coord, std::span<const float, kBrickVoxels> phi) {
  requireReach(coord);
  const float band = grid().band;
  FloatBrick* brick = newBrick(coord);
  bool inBand = false;
  std::fill(std::begin(brick->inside), std::end(brick->inside), uint64_t{0});
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (std::isnan(phi[static_cast<size_t>(i)])) {
      recycle(brick);
      throw Error("clay distance is not a number", Error::Kind::work);
    }
    const float value = std::clamp(phi[static_cast<size_t>(i)], -band, band) + 0.0f;
    brick->value[i] = value;
    brick->inside[i >> 6] |= static_cast<uint64_t>(value < 0) << (i & 63);
    inBand |= std::abs(value) < band;
  }
  const Slot now = find(coord);
  BrickValues scratch;
  if (step_ == 0 && inBand && now.brick() &&
      std::memcmp(now.brick()->values(scratch), brick->value, sizeof brick->value) == 0)
    recycle(brick);
  else
    link(brick, inBand);
}

Coord Editor::blockFirst(Coord brick, int level) {
  const Coord origin{kBrickOrigin, kBrickOrigin, kBrickOrigin};
  return ((brick + origin) >> (3 * level)) * (1 << (3 * level)) - origin;
}

// The next of a stock that is not empty.
template <class Form>
Form* Editor::prepared(ObjectStock& stock, Coord coord, float step) {
  auto* brick = static_cast<Form*>(stock.free.back());
  stock.free.pop_back();
  brick->step = step;
  brick->serial = nextSerial();
  brick->birth = id_;
  brick->coord = coord;
  ++counts_.bricksMade;
  return brick;
}

FloatBrick* Editor::newBrick(Coord coord) {
  if (step_ == 0) return static_cast<FloatBrick*>(newStoredBrick(coord));
  if (stock_.work.free.empty()) store_->state().stockWorkBricks(stock_.work);
  return prepared<FloatBrick>(stock_.work, coord, 0);
}

Brick* Editor::newStoredBrick(Coord coord) {
  if (stock_.bricks.free.empty()) store_->state().stockBricks(stock_.bricks);
  if (step_ == 0) return prepared<FloatBrick>(stock_.bricks, coord, 0);
  return prepared<FixedBrick>(stock_.bricks, coord, step_);
}

void Editor::recycle(Brick* brick) {
  --counts_.bricksMade;
  (brick->step == step_ ? stock_.bricks : stock_.work).free.push_back(brick);
}

void Editor::link(Brick* brick) {
  uint64_t any = 0, all = ~uint64_t{0};
  for (const uint64_t word : brick->inside) {
    any |= word;
    all &= word;
  }
  brick->anyInside = any != 0;
  brick->anyOutside = all != ~uint64_t{0};
  place(trees_[kDistanceTree], brick->coord, reinterpret_cast<Link>(brick));
}

void Editor::link(FloatBrick* brick, bool inBand) {
  if (step_ != 0) {
    pack(brick, inBand);
    return;
  }
  if (inBand) {
    link(static_cast<Brick*>(brick));
    return;
  }
  const Coord coord = brick->coord;
  const Tile tile = brick->value[0] < 0 ? Tile::inside : Tile::outside;
  if (find(coord) != Slot(brick)) recycle(brick);
  place(trees_[kDistanceTree], coord, linkOf(tile));
}

// What stands there is written in place if it is this transaction's own: as floats are, so that batching changes
// nothing.
void Editor::pack(FloatBrick* brick, bool inBand) {
  const Coord coord = brick->coord;
  int16_t codes[kBrickVoxels];
  inBand = inBand && packDistances(brick->value, grid().band, codes);
  const auto* now = static_cast<const FixedBrick*>(find(coord).brick());
  if (!inBand) {
    place(trees_[kDistanceTree], coord, linkOf(brick->value[0] < 0 ? Tile::inside : Tile::outside));
  } else if (!now || std::memcmp(now->code, codes, sizeof codes) != 0) {
    auto* stored =
        now && now->birth == id_ ? const_cast<FixedBrick*>(now) : static_cast<FixedBrick*>(newStoredBrick(coord));
    std::memcpy(stored->code, codes, sizeof codes);
    std::memcpy(stored->inside, brick->inside, sizeof stored->inside);
    link(static_cast<Brick*>(stored));
  }
  recycle(static_cast<Brick*>(brick));
}

FloatBrick* Editor::own(Coord coord) noexcept {
  if (step_ != 0) return nullptr;
  const Brick* brick = find(coord).brick();
  return brick && brick->birth == id_ ? static_cast<FloatBrick*>(const_cast<Brick*>(brick)) : nullptr;
}

// Nodes whose children have all become one tile turn into that tile, upwards as far as it goes.
void Editor::collapse(Tree& tree, Coord brick) {
  for (int level = 1; level <= kTreeLevels; ++level) {
    const Link link = descend(tree.root, brick, level);
    if (isTile(link)) {
      continue;  // the block itself was made a tile: its parent may follow
    }
    const Node* node = nodeOf(link);
    const Link first = node->child[0];
    if (!isTile(first) ||
        !std::all_of(std::begin(node->child), std::end(node->child), [first](Link c) { return c == first; }))
      return;
    Link* at = writableLink(tree, brick, level);
    release(tree, *at, level);
    *at = first;
  }
}

Version Editor::commit() {
  if (!changed_) {
    giveBack();
    store_ = nullptr;
    return base_;
  }
  for (Tree& tree : trees_) {
    std::sort(tree.mayCollapse.begin(), tree.mayCollapse.end());
    for (const Coord brick : tree.mayCollapse) collapse(tree, brick);
  }
  auto record = std::make_unique<VersionRecord>();
  record->grid = base_.grid();
  record->step = step_;
  record->id = id_;
  for (size_t i = 0; i < trees_.size(); ++i) record->roots[i] = trees_[i].root;
  record->stats.precision = base_.stats().precision;
  record->stats.bricks = base_.stats().bricks + static_cast<uint64_t>(bricksDelta_);
  record->stats.nodes = base_.stats().nodes + static_cast<uint64_t>(nodesDelta_);
  record->stats.channelBricks = base_.stats().channelBricks + static_cast<uint64_t>(channelDelta_);
  record->parent = const_cast<VersionRecord*>(base_.record());
  record->store = base_.store();
  Version made = makeVersion(std::move(record));
  giveBack();
  store_ = nullptr;
  return made;
}

}  // namespace argil::clay
