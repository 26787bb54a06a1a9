#include "io/records/clay_reading.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "io/records/brick_codec.h"
#include "io/records/channel_reading.h"

namespace argil::io {

namespace {

constexpr size_t kMostNodes = size_t{1} << 19;     // 2 GiB of nodes
constexpr size_t kBatchBytes = size_t{256} << 10;  // handed to an unpacking thread at once: stays in its cache

[[noreturn]] void damaged(const std::string& what) {
  throw Error("damaged: " + what, Error::Kind::work);
}

bool inReach(Coord brick) {
  const auto in = [](int32_t c) { return c >= -clay::kBrickReach && c < clay::kBrickReach; };
  return in(brick.x) && in(brick.y) && in(brick.z);
}

size_t rankOf(const PlaceSet& set, int place) {
  size_t rank = 0;
  for (int word = 0; word < place >> 6; ++word)
    rank += static_cast<size_t>(std::popcount(set[static_cast<size_t>(word)]));
  return rank +
         static_cast<size_t>(std::popcount(set[static_cast<size_t>(place >> 6)] & ((uint64_t{1} << (place & 63)) - 1)));
}

}  // namespace

void fetchRecords(RecordSource& source, std::span<const RecordId> ids,
                  const std::function<void(size_t, const RecordView&)>& each) {
  std::vector<size_t> order(ids.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (!std::is_sorted(ids.begin(), ids.end()))
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return ids[a] < ids[b]; });
  order.erase(std::unique(order.begin(), order.end(), [&](size_t a, size_t b) { return ids[a] == ids[b]; }),
              order.end());
  std::vector<RecordId> rising(order.size());
  std::transform(order.begin(), order.end(), rising.begin(), [&](size_t i) { return ids[i]; });
  source.getMany(rising, [&](size_t index, std::span<const std::byte> bytes) {
    const auto record = parseRecord(bytes);
    if (record && record->header.id == rising[index]) each(order[index], *record);
  });
}

// Records are copied into batches by the thread that reads them, and unpacked by others; it helps when they are behind.
class ClayReading::Unpacking {
 public:
  Unpacking(uint32_t owner, float band, int threads) : owner_(owner), band_(band) {
    for (int i = 1; i < threads; ++i)
      helpers_.emplace_back([this] {
        BrickCodec codec;
        while (const auto batch = take(true)) unpack(*batch, codec);
      });
  }
  ~Unpacking() { finish(); }

  void add(Place& place, std::span<const std::byte> record) {
    filling_.parts.push_back({&place, record.size()});
    filling_.bytes.insert(filling_.bytes.end(), record.begin(), record.end());
    if (filling_.bytes.size() >= kBatchBytes) hand();
  }
  /// Returns when all is unpacked.
  void finish() {
    hand();
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    while (const auto batch = take(false)) unpack(*batch, codec_);
    helpers_.clear();
  }

 private:
  struct Batch {
    std::vector<std::byte> bytes;
    std::vector<std::pair<Place*, size_t>> parts;
  };

  void hand() {
    if (filling_.parts.empty()) return;
    size_t waiting;
    {
      const std::lock_guard lock(mutex_);
      queue_.push_back(std::move(filling_));
      waiting = queue_.size();
    }
    filling_ = {};
    changed_.notify_one();
    if (waiting > 2 * helpers_.size())
      if (const auto batch = take(false)) unpack(*batch, codec_);
  }
  std::optional<Batch> take(bool wait) {
    std::unique_lock lock(mutex_);
    if (wait) changed_.wait(lock, [&] { return ended_ || !queue_.empty(); });
    if (queue_.empty()) return std::nullopt;
    Batch batch = std::move(queue_.back());
    queue_.pop_back();
    return batch;
  }
  void unpack(const Batch& batch, BrickCodec& codec) const {
    size_t at = 0;
    for (const auto& [place, size] : batch.parts) {
      const auto record = parseRecord(std::span(batch.bytes).subspan(at, size));
      at += size;
      if (!record || record->header.id != place->id || record->header.owner != owner_) continue;
      const auto coord = codec.unpack(*record, band_, *place->brick);
      place->sound = coord && *coord == place->coord;
    }
  }

  uint32_t owner_;
  float band_;
  BrickCodec codec_;
  Batch filling_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Batch> queue_;
  bool ended_ = false;
  std::vector<std::jthread> helpers_;
};

ClayReading::ClayReading(ClayRecords& memo, RecordSource& source, const clay::Version& base, Job* job)
    : memo_(memo), source_(source), base_(base), editor_(base), job_(job) {}

ClayReading::~ClayReading() {
  for (const Place& place : bricks_)
    if (place.brick) editor_.recycle(place.brick);
}

void ClayReading::loadNodes(size_t begin, size_t end) {
  std::vector<RecordId> ids;
  for (size_t i = begin; i < end; ++i) ids.push_back(items_[i].id);
  fetchRecords(source_, ids, [&](size_t index, const RecordView& record) {
    Item& item = items_[begin + index];
    if (begin == 0 && owner_ == 0) owner_ = record.header.owner;
    auto node = parseNode(record);
    if (!node || record.header.owner != owner_ || node->level != item.level || node->first != item.first) return;
    bool reached = true;
    if (node->level == 1)
      forEachPlace(node->record, [&](int place) { reached &= inReach(clay::childFirst(node->first, 1, place)); });
    if (!reached) return;
    item.body = std::move(*node);
    item.there = true;
  });
  for (size_t i = begin; i < end; ++i) {
    if (items_[i].there) continue;
    if (!repairing_)
      damaged(fmt::format("{} of the clay's tree is missing or damaged", i == 0 ? "the root" : "a node"));
    if (owner_ == 0) damaged("the root of the clay's tree is lost, and nothing says whose it was");
    lostNodes_.push_back(i);
  }
}

void ClayReading::compareNear(size_t begin, size_t end) {
  std::vector<RecordId> ids;
  std::vector<size_t> of;
  for (size_t i = begin; i < end; ++i) {
    if (items_[i].nearId == 0) continue;
    ids.push_back(items_[i].nearId);
    of.push_back(i);
  }
  fetchRecords(source_, ids, [&](size_t index, const RecordView& record) {
    Item& item = items_[of[index]];
    auto node = parseNode(record);
    if (node && record.header.owner == owner_ && node->level == item.level && node->first == item.first)
      item.near = std::move(*node);
  });
  for (const size_t i : of) {
    Item& item = items_[i];
    if (!item.near) damaged("a node of the version beside it is missing or damaged");
    size_t index = 0;
    forEachPlace(item.body.record, [&](int place) {
      const RecordId id = item.body.ids[index++];
      if (nearIdAt(item, place) == id && !item.base.child(place).isTile()) add(item.kept, place);
    });
  }
}

RecordId ClayReading::nearIdAt(const Item& item, int place) {
  return item.near && holds(item.near->record, place) ? item.near->ids[rankOf(item.near->record, place)] : 0;
}

void ClayReading::expand(size_t index) {
  items_[index].firstChild = items_[index].level > 1 ? items_.size() : bricks_.size();
  size_t next = 0;
  const PlaceSet record = items_[index].body.record;
  forEachPlace(record, [&](int place) {
    const Item& item = items_[index];  // items_ grows meanwhile
    const RecordId id = item.body.ids[next++];
    if (holds(item.kept, place)) return;
    const Coord first = clay::childFirst(item.first, item.level, place);
    if (item.level > 1) {
      Item child;
      child.id = id;
      child.level = item.level - 1;
      child.first = first;
      child.base = item.base.child(place);
      if (child.base.isNode()) child.nearId = nearIdAt(item, place);
      items_.push_back(std::move(child));
    } else {
      bricks_.push_back({id, first});
    }
  });
  if (items_.size() > kMostNodes || bricks_.size() > kMostBricks)
    throw Error("the clay has more bricks than Argil can hold", Error::Kind::work);
}

void ClayReading::loadBricks(int threads) {
  std::vector<RecordId> ids(bricks_.size());
  std::transform(bricks_.begin(), bricks_.end(), ids.begin(), [](const Place& place) { return place.id; });
  Unpacking unpacking(owner_, editor_.grid().band, threads);
  size_t done = 0;
  fetchRecords(source_, ids, [&](size_t index, const RecordView& record) {
    Place& place = bricks_[index];
    place.brick = editor_.newStoredBrick(place.coord);
    unpacking.add(place, record.whole);
    if (job_ && ++done % 1024 == 0) job_->step(static_cast<double>(done) / static_cast<double>(ids.size()));
  });
  unpacking.finish();
}

void ClayReading::setTile(const clay::TreePlace& at, clay::Tile tile) {
  const Coord first = at.first();
  const auto reachable = [](int32_t c) { return std::clamp(c, -clay::kBrickReach, clay::kBrickReach - 1); };
  const Coord within{reachable(first.x), reachable(first.y), reachable(first.z)};
  if (clay::Editor::blockFirst(within, at.level()) == first) editor_.setBlock(within, at.level(), tile);
}

void ClayReading::build() {
  for (Item& item : items_) {
    if (!item.there) continue;
    const auto tileAt = [&](int place) {
      return holds(item.body.inside, place) ? clay::Tile::inside : clay::Tile::outside;
    };
    PlaceSet changed{};
    if (item.base.isTile()) {
      // From what most of it is.
      size_t count = 0;
      for (const uint64_t word : item.body.inside) count += static_cast<size_t>(std::popcount(word));
      const clay::Tile most = count > 256 ? clay::Tile::inside : clay::Tile::outside;
      if (most != item.under.value_or(item.base.tile())) setTile(item.base, most);
      if (item.level > 1)
        for (size_t i = 0; i < item.body.ids.size(); ++i) items_[item.firstChild + i].under = most;
      for (size_t word = 0; word < 8; ++word)
        changed[word] =
            most == clay::Tile::inside ? ~(item.body.inside[word] | item.body.record[word]) : item.body.inside[word];
      forEachPlace(changed, [&](int place) { setTile(item.base.child(place), tileAt(place)); });
    } else {
      for (size_t word = 0; word < 8; ++word) changed[word] = ~item.body.record[word];
      forEachPlace(changed, [&](int place) {
        const clay::TreePlace before = item.base.child(place);
        if (!before.isTile() || before.tile() != tileAt(place)) setTile(before, tileAt(place));
      });
    }
  }
  for (Place& place : bricks_) {
    if (!place.sound) continue;
    place.serial = place.brick->serial;
    editor_.link(std::exchange(place.brick, nullptr));
  }
}

// Puts older bricks where the version's own are lost; what nothing was found for comes back.
std::vector<LostBlock> ClayReading::fillFromOlder(const OlderBricks& repair, ReadClay& read) {
  std::vector<LostBlock> blocks, still;
  for (const Place& place : bricks_)
    if (!place.sound) blocks.push_back({place.coord, 0});
  read.bricksLost = blocks.size();
  for (const size_t lost : lostNodes_) blocks.push_back({items_[lost].first, items_[lost].level});
  read.blocksLost = lostNodes_.size();
  uint64_t inPlace = 0, inBlocks = 0;
  BrickCodec codec;
  std::vector<std::byte> bytes;
  for (const LostBlock& block : blocks) {
    const int32_t edge = 1 << (3 * block.level);
    std::vector<std::pair<Coord, RecordId>> found;
    repair.bricksIn(owner_, block.first, edge, [&](Coord coord, RecordId id) {
      const Coord d = coord - block.first;
      if (inReach(coord) && std::min({d.x, d.y, d.z}) >= 0 && std::max({d.x, d.y, d.z}) < edge)
        found.emplace_back(coord, id);
    });
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : a.second > b.second;
    });
    std::optional<Coord> filled;
    for (const auto& [coord, id] : found) {
      if (filled == coord || !source_.get(id, bytes)) continue;
      const auto record = parseRecord(bytes);
      if (!record || record->header.owner != owner_) continue;
      clay::Brick* brick = editor_.newStoredBrick(coord);
      if (codec.unpack(*record, editor_.grid().band, *brick) != coord) {
        editor_.recycle(brick);
        continue;
      }
      editor_.link(brick);
      filled = coord;
      ++(block.level == 0 ? inPlace : inBlocks);
    }
    if (block.level > 0 || !filled) still.push_back(block);
    if (job_) job_->step(1);
  }
  if (read.bricksLost > 0)
    read.notes.push_back(
        fmt::format("{} of {} bricks of the clay were damaged: {} were taken from an earlier state, {} were filled "
                    "from the clay around them",
                    read.bricksLost, bricks_.size(), inPlace, read.bricksLost - inPlace));
  if (read.blocksLost > 0)
    read.notes.push_back(
        fmt::format("{} blocks of the clay were lost: {} bricks in them were found, what lies between was guessed from "
                    "the clay around it",
                    read.blocksLost, inBlocks));
  return still;
}

// True when what stands there is to the bit what the node's record says, so that the record can stand for it.
bool ClayReading::teach(size_t index, const clay::TreePlace& place) {
  const Item& item = items_[index];
  if (!item.there || place.level() != item.level) return false;
  if (!place.isNode() && index != 0) return false;
  bool same = true;
  size_t child = item.firstChild;
  for (int i = 0; i < 512; ++i) {
    const clay::TreePlace now = place.child(i);
    if (!holds(item.body.record, i)) {
      same = same && now.isTile() && (now.tile() == clay::Tile::inside) == holds(item.body.inside, i);
    } else if (!holds(item.kept, i)) {
      if (item.level > 1)
        same = teach(child, now) && same;
      else
        same = now.brick() && now.brick()->serial == bricks_[child].serial && same;
      ++child;
    }
  }
  if (same) memo_.nodes_.set(ClayRecords::keyOf(place, owner_), item.id);
  return same;
}

ReadClay ClayReading::run(RecordId root, RecordId nearRoot, uint32_t owner, int threads, const OlderBricks* repair) {
  owner_ = owner;
  repairing_ = repair != nullptr;
  ReadClay read;
  if (root == 0) damaged("the clay has no root");
  if (root == nearRoot) {
    read.version = base_;
    return read;
  }
  Item top;
  top.id = root;
  top.nearId = nearRoot;
  top.level = clay::kTreeLevels;
  top.first = clay::treeFirst();
  top.base = clay::TreePlace::root(base_);
  items_.push_back(std::move(top));
  for (size_t begin = 0; begin < items_.size();) {
    const size_t end = items_.size();
    loadNodes(begin, end);
    compareNear(begin, end);
    for (size_t i = begin; i < end; ++i)
      if (items_[i].there) expand(i);
    begin = end;
    if (job_) job_->step(0);
  }
  loadBricks(threads);
  const auto lost = static_cast<size_t>(
      std::count_if(bricks_.begin(), bricks_.end(), [](const Place& place) { return !place.sound; }));
  if (lost > 0 && !repair)
    damaged(fmt::format("{} of {} bricks of the clay are missing or damaged", lost, bricks_.size()));
  build();
  std::vector<LostBlock> blocks;
  if (repair) blocks = fillFromOlder(*repair, read);
  read.version = repairClay(editor_.commit(), blocks);
  for (const Place& place : bricks_)
    if (place.serial != 0) memo_.bricks_.set({place.serial}, place.id);
  (void)teach(0, clay::TreePlace::root(read.version));
  return read;
}

namespace {

// What a root's record says: a version with channels, or its distances themselves.
struct Root {
  ClayHead head;
  bool channels = false;
  uint32_t owner = 0;
};

Root headOf(RecordSource& source, RecordId root) {
  std::vector<std::byte> bytes;
  if (root != 0 && source.get(root, bytes))
    if (const auto record = parseRecord(bytes);
        record && record->header.id == root && record->header.kind == RecordKind::clay) {
      const auto head = parseClayHead(*record);
      if (!head) damaged("the root of the clay's trees says nothing that can be");
      return {*head, true, record->header.owner};
    }
  ClayHead head;
  head.distances = root;
  return {head, false, 0};
}

}  // namespace

void ClayRecords::readChannels(RecordSource& source, const ClayHead& head, const ClayHead& nearHead,
                               const clay::Version& near, RecordId root, uint32_t owner, bool repairing, Job* job,
                               ReadClay& read) {
  if (head.channels == std::array<RecordId, clay::kChannels>{} && nearHead.channels == head.channels) return;
  ChannelReading channels(*this, source, read.version, near, owner, repairing, job);
  read.version = channels.run(head, nearHead, read);
  if (root != head.distances && channels.exact() &&
      nodes_.find(keyOf(clay::TreePlace::root(read.version), owner)) == head.distances)
    nodes_.set(keyOf(read.version, owner), root);
}

ReadClay ClayRecords::read(RecordSource& source, RecordId root, const clay::Grid& grid,
                           std::shared_ptr<clay::Store> store, Job* job, int threads, const OlderBricks* repair,
                           uint32_t owner) {
  const Root found = headOf(source, root);
  if (found.channels && owner == 0) owner = found.owner;
  const clay::Version empty = clay::Version::empty(std::move(store), grid);
  ReadClay read = ClayReading(*this, source, empty, job).run(found.head.distances, 0, owner, threads, repair);
  readChannels(source, found.head, {}, empty, root, owner, repair != nullptr, job, read);
  return read;
}

ReadClay ClayRecords::readNear(RecordSource& source, RecordId root, const clay::Version& near, RecordId nearRoot,
                               Job* job) {
  if (root == nearRoot) return {near, 0, 0, {}};
  const Root found = headOf(source, root), beside = headOf(source, nearRoot);
  const uint32_t owner = found.channels ? found.owner : beside.owner;
  ReadClay read =
      ClayReading(*this, source, near, job).run(found.head.distances, beside.head.distances, owner, 1, nullptr);
  readChannels(source, found.head, beside.head, near, root, owner, false, job, read);
  return read;
}

void markLive(RecordSource& source, RecordId root, RecordSet& live) {
  std::vector<RecordId> level;
  const Root top = headOf(source, root);
  if (top.channels) live.add(root);
  if (!live.contains(top.head.distances)) level.push_back(top.head.distances);
  for (const RecordId id : top.head.channels)
    if (id != 0 && !live.contains(id)) level.push_back(id);
  for (bool first = true; !level.empty(); first = false) {
    std::vector<RecordId> next;
    size_t whole = 0;
    fetchRecords(source, level, [&](size_t, const RecordView& record) {
      const auto node = parseNode(record);
      if (!node || (first && node->level != clay::kTreeLevels)) return;
      ++whole;
      live.add(record.header.id);
      for (const RecordId id : node->ids) {
        if (node->level == 1)
          live.add(id);
        else if (!live.contains(id))
          next.push_back(id);
      }
    });
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    if (whole != level.size()) damaged("a node of the clay's tree is missing or damaged");
    level = std::move(next);
  }
}

}  // namespace argil::io
