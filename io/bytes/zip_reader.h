#pragma once
// ZIP archives in memory: a table of parts, each unpacked and checked when asked for. For this module's files.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/input.h"

namespace argil::io {

/// Reads the archives that packages are made of (ECMA-376 part 2, "OPC"; PKWARE APPNOTE 6.3.9): stored and deflated
/// parts, ZIP64, sizes behind the data. Refused: several volumes, encryption, anything after the end of the archive,
/// and what lies about its sizes. Nothing is ever written under a name of the archive.
class ZipReader {
 public:
  struct Part {
    std::string name;     ///< With '/' between folders and none at its beginning; no "." and "..".
    uint64_t packed = 0;  ///< Bytes in the archive.
    uint64_t size = 0;    ///< Bytes that it says it has when unpacked.
    uint64_t header = 0;  ///< Where its local header stands.
    uint32_t crc = 0;
    uint16_t method = 0;
    uint16_t flags = 0;
  };

  /// Reads the table; `input` must outlive the reader. Memory: a small multiple of the table. Throws Error that names
  /// the file, also when all parts together, or one, would be more than archives may unpack to (unpack_limit.h): before
  /// any is.
  explicit ZipReader(const Input& input);

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// The part of that name, upper and lower case alike as OPC says; null when there is none.
  [[nodiscard]] const Part* find(std::string_view name) const;
  /// Unpacked; its length and checksum are as the table says. Throws Error: before memory is taken when the sizes
  /// cannot be true or are beyond the limits, and for what is damaged.
  [[nodiscard]] FileBytes read(const Part& part);

 private:
  [[nodiscard]] uint64_t little(uint64_t at, int bytes) const;
  void readTable();
  void readEnd(uint64_t& entries, uint64_t& begin, uint64_t& size) const;
  uint64_t readEntry(uint64_t at, uint64_t end);
  [[noreturn]] void damaged(const std::string& what) const;

  const Input& input_;
  std::vector<Part> parts_;
  std::vector<uint32_t> byName_;  ///< Indices of parts_, in the order of their names in lower case.
  uint64_t unpacked_ = 0;
};

}  // namespace argil::io
