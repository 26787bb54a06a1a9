#pragma once
// ZIP archives written front to back, and deflate in independent blocks. For this module's files.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/atomic_file.h"

namespace argil::io {

/// Packs a block of at most kMostBytes so that blocks packed on any thread, one after the other, are one stream of
/// deflate (RFC 1951): each ends on a byte and looks back to nothing before it. One object a thread; about 0.4 MB.
class DeflateBlock {
 public:
  static constexpr size_t kMostBytes = size_t(4) << 20;
  DeflateBlock();
  ~DeflateBlock();
  DeflateBlock(const DeflateBlock&) = delete;
  DeflateBlock& operator=(const DeflateBlock&) = delete;

  /// Replaces `packed`. About 800 MB/s on the text of a mesh.
  void pack(std::string_view bytes, std::vector<std::byte>& packed);
  /// What follows the last block.
  static std::span<const std::byte> end();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes parts one after the other; ZIP64 where a number needs it. All dates are 1980-01-01, so that equal content
/// gives equal bytes. Part names are ASCII.
class ZipWriter {
 public:
  explicit ZipWriter(AtomicFile& file) : file_(file) {}

  /// A whole part, not packed; below 4 GiB.
  void add(std::string_view name, std::string_view content);

  /// A part whose size is not known yet: at most `most` bytes.
  void begin(std::string_view name, uint64_t most);
  /// A block of it, and what DeflateBlock made of that. About 10 GB/s beside the file's own speed (checksum).
  void block(std::string_view bytes, std::span<const std::byte> packed);
  void end();

  /// The table; nothing may follow.
  void finish();

 private:
  struct Entry {
    std::string name;
    uint64_t header = 0, packed = 0, size = 0;
    uint32_t crc = 0;
    uint16_t method = 0, flags = 0;
    bool wide = false;  ///< Its local header has ZIP64 fields.
  };
  void localHeader(const Entry& entry);

  AtomicFile& file_;
  std::vector<Entry> entries_;
};

}  // namespace argil::io
