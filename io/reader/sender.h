#pragma once
// The reader's mouth: messages to standard output, many in one write.

#include <cstring>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "io/reader/wire.h"

namespace argil::io::reader {

class Sender {
 public:
  /// To standard output; ends the process when nobody listens.
  Sender();
  /// To somebody in this process, who gets it in pieces: for fuzz targets.
  explicit Sender(std::function<void(std::span<const std::byte>)> listener);
  void flush();

  void plain(wire::Kind kind) { message(kind, {}, {}); }
  void text(wire::Kind kind, std::string_view text) {
    const bool counts = kind == wire::Kind::note || kind == wire::Kind::metadata;
    if (!counts || ++texts_ <= wire::kMostTexts) message(kind, {}, bytesOf(text.substr(0, wire::kMostText)));
  }
  void note(std::string_view sentence) { text(wire::Kind::note, sentence); }
  /// A struct of wire.h and a name.
  template <class Struct>
  void named(wire::Kind kind, const Struct& value, std::string_view name) {
    message(kind, std::as_bytes(std::span(&value, 1)), bytesOf(name.substr(0, wire::kMostText)));
  }
  /// In as many messages as it takes.
  template <class T>
  void array(wire::Kind kind, std::span<const T> items) {
    constexpr size_t kMost = wire::kMostBytes / sizeof(T);
    for (; !items.empty(); items = items.subspan(std::min(kMost, items.size())))
      message(kind, std::as_bytes(items.first(std::min(kMost, items.size()))), {});
  }

 private:
  static std::span<const std::byte> bytesOf(std::string_view text) { return std::as_bytes(std::span(text)); }
  void message(wire::Kind kind, std::span<const std::byte> first, std::span<const std::byte> second);
  void put(std::span<const std::byte> bytes);

  std::function<void(std::span<const std::byte>)> listener_;
  std::vector<std::byte> buffer_;
  size_t used_ = 0;
  uint32_t texts_ = 0;
};

}  // namespace argil::io::reader
