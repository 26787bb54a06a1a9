#pragma once
// How a version comes out of its records: the work behind ClayRecords::read. For this module's files alone.

#include <functional>
#include <span>
#include <vector>

#include "clay/store/editor.h"
#include "io/records/clay_records.h"
#include "io/records/clay_repair.h"
#include "io/records/node_body.h"

namespace argil::io {

/// Calls back with each of `ids` (any order) that is there and sound and has that id: (index in ids, the record). An id
/// that stands twice is there once.
void fetchRecords(RecordSource& source, std::span<const RecordId> ids,
                  const std::function<void(size_t, const RecordView&)>& each);

/// One reading. Level by level the nodes, then all bricks in order of their ids while other threads unpack, then the
/// tree is built in its own order.
class ClayReading {
 public:
  /// `base`: what the new version is made from.
  ClayReading(ClayRecords& memo, RecordSource& source, const clay::Version& base, Job* job);
  ~ClayReading();

  /// `nearRoot`: the root of the base's records, 0 when it has none.
  ReadClay run(RecordId root, RecordId nearRoot, uint32_t owner, int threads, const OlderBricks* repair);

 private:
  struct Item {  // a node
    RecordId id = 0;
    RecordId nearId = 0;  // of the base's node at this place
    int level = 0;
    Coord first;
    clay::TreePlace base;             // what the base has there
    std::optional<clay::Tile> under;  // what its parent put there before
    bool there = false;
    NodeBody body;
    std::optional<NodeBody> near;
    PlaceSet kept{};        // places where the base has the same
    size_t firstChild = 0;  // of those that are not kept: in items_, or in bricks_ for level 1
  };
  struct Place {  // a brick
    RecordId id = 0;
    Coord coord;
    clay::Brick* brick = nullptr;  // until it is linked
    uint64_t serial = 0;           // once it is linked
    bool sound = false;
  };
  class Unpacking;

  void loadNodes(size_t begin, size_t end);
  void compareNear(size_t begin, size_t end);
  [[nodiscard]] static RecordId nearIdAt(const Item& item, int place);
  void expand(size_t item);
  void loadBricks(int threads);
  void setTile(const clay::TreePlace& at, clay::Tile tile);
  void build();
  [[nodiscard]] std::vector<LostBlock> fillFromOlder(const OlderBricks& repair, ReadClay& read);
  [[nodiscard]] bool teach(size_t item, const clay::TreePlace& place);

  ClayRecords& memo_;
  RecordSource& source_;
  clay::Version base_;
  clay::Editor editor_;
  Job* job_;
  bool repairing_ = false;
  uint32_t owner_ = 0;
  std::vector<Item> items_;
  std::vector<Place> bricks_;
  std::vector<size_t> lostNodes_;  // in items_
};

}  // namespace argil::io
