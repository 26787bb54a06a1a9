#include "io/models/picture.h"

#include <cstring>
#include <new>
#include <type_traits>

#include "io/bytes/input.h"
#include "io/models/reader_process.h"

namespace argil::io {

namespace {

/// Takes the rows as they come. Nothing is believed: the size is within what was asked for, and no item comes too many.
template <class Item>
class Rows {
 public:
  Rows(wire::Kind kind, size_t perPixel, int largest) : kind_(kind), perPixel_(perPixel), largest_(largest) {}

  void take(wire::Kind kind, std::span<const std::byte> payload) {
    if (kind == wire::Kind::note) return;  // That nothing confines it is told where models are opened.
    if (kind == wire::Kind::end) {
      if (wanted_ == 0 || items.size() != wanted_) failWire();
    } else if (kind == wire::Kind::picture) {
      const auto head = wireStruct<wire::Picture>(payload);
      const auto most = uint32_t(largest_);
      if (wanted_ != 0 || head.width < 1 || head.height < 1 || head.width > most || head.height > most) failWire();
      width = int(head.width);
      height = int(head.height);
      wanted_ = size_t{head.width} * head.height * perPixel_;
      items.reserve(wanted_);
    } else if (kind == kind_) {
      const size_t count = payload.size() / sizeof(Item), first = items.size();
      if (payload.size() % sizeof(Item) != 0 || count > wanted_ - first) failWire();
      if (count == 0) return;
      items.resize(first + count);
      std::memcpy(items.data() + first, payload.data(), payload.size());
      if constexpr (std::is_same_v<Item, float>) {
        for (size_t i = first; i < items.size(); ++i)
          if (!(items[i] >= 0 && items[i] <= 1)) failWire();
      }
    } else {
      failWire();
    }
  }

  int width = 0, height = 0;
  std::vector<Item> items;

 private:
  wire::Kind kind_;
  size_t perPixel_;
  int largest_;
  size_t wanted_ = 0;
};

ReaderLimits limitsFor(int largest) {
  ReaderLimits limits;
  limits.edge = largest;
  return limits;
}

}  // namespace

GreyImage readGreyImage(const std::filesystem::path& file, int largest, Job* job) {
  if (headOf(file).empty()) static_cast<void>(readFile(file));  // which says why it cannot be read at all
  Rows<float> rows(wire::Kind::levels, 1, largest);
  try {
    runReader(
        "grey", file, [&](wire::Kind kind, std::span<const std::byte> payload) { rows.take(kind, payload); }, job,
        limitsFor(largest));
  } catch (const std::bad_alloc&) {
    fail(displayName(file), "does not fit into memory; make it smaller first");
  }
  return {rows.width, rows.height, std::move(rows.items)};
}

ColourImage readColourImage(const std::filesystem::path& file, int largest, Job* job) {
  if (headOf(file).empty()) static_cast<void>(readFile(file));  // which says why it cannot be read at all
  Rows<uint8_t> rows(wire::Kind::pixels, 4, largest);
  try {
    runReader(
        "colour", file, [&](wire::Kind kind, std::span<const std::byte> payload) { rows.take(kind, payload); }, job,
        limitsFor(largest));
  } catch (const std::bad_alloc&) {
    fail(displayName(file), "does not fit into memory; make it smaller first");
  }
  return {rows.width, rows.height, std::move(rows.items)};
}

ColourImage unpackPicture(std::span<const std::byte> bytes, int largest, Job* job) {
  Rows<uint8_t> rows(wire::Kind::pixels, 4, largest);
  runReaderOn(
      "colour", bytes, "the picture",
      [&](wire::Kind kind, std::span<const std::byte> payload) { rows.take(kind, payload); }, job, limitsFor(largest));
  return {rows.width, rows.height, std::move(rows.items)};
}

}  // namespace argil::io
