#pragma once
// Files that other people's libraries parse are parsed in a process of its own, which may die alone.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "clay/base/job.h"
#include "io/reader/wire.h"

namespace argil::io {

struct ReaderLimits {
  uint64_t memoryBytes = uint64_t{4} << 30;  ///< Address space of the process, and what it may send.
  double seconds = 120;                      ///< Of its CPU time, and twice that on the clock.
  int edge = 1024;                           ///< Pixels along an edge of a picture.
};

/// The program that reads this: what ARGIL_READER names, else beside the running program argil-reader, or
/// argil-reader-cad for "cad". Throws Error when it is not there.
[[nodiscard]] std::filesystem::path readerProgram(std::string_view what);
/// Whether STEP and IGES can be read: this program was built where OpenCASCADE was.
[[nodiscard]] bool readsCad();

/// Starts `argil-reader WHAT FILE` (or argil-reader-cad) without forking, gives it the limits, lets it open nothing to
/// write, and calls back with each message that it sends: its kind and its payload, of which nothing was checked but
/// the length; `end` comes last. Throws Error with the sentence that the reader sent, or one that says that the file
/// made it run out of memory, time or crash; Cancelled (it is killed). It has ended when this returns or throws. Any
/// thread but the servo's.
void runReader(const std::string& what, const std::filesystem::path& file,
               const std::function<void(wire::Kind, std::span<const std::byte>)>& take, Job* job = nullptr,
               const ReaderLimits& limits = {});

/// The same for bytes in memory, which the process is given as its standard input; `name` stands for the file in
/// sentences. Throws Error (work) when no memory can be shared with it.
void runReaderOn(const std::string& what, std::span<const std::byte> bytes, const std::string& name,
                 const std::function<void(wire::Kind, std::span<const std::byte>)>& take, Job* job = nullptr,
                 const ReaderLimits& limits = {});

/// For fuzz targets: while one lives, runReader of this thread starts no process but takes `spoken`, all that a reader
/// sends behind its magic, in pieces of a few bytes; where that ends too early the Error is that of garbage.
class SpokenReader {
 public:
  explicit SpokenReader(std::span<const std::byte> spoken);
  ~SpokenReader();
  SpokenReader(const SpokenReader&) = delete;
  SpokenReader& operator=(const SpokenReader&) = delete;
};

/// Text from the reader as a message or a name may have it: one line, no control characters.
[[nodiscard]] std::string wireText(std::span<const std::byte> payload);

/// A struct at the beginning of a payload, and what follows. Throws Error when it is too short.
template <class Struct>
[[nodiscard]] Struct wireStruct(std::span<const std::byte> payload, std::span<const std::byte>* rest = nullptr);
/// For callbacks: throws the Error for a stream that does not keep to the rules. runReader puts the file's name before
/// every Error of its callback.
[[noreturn]] void failWire();

template <class Struct>
Struct wireStruct(std::span<const std::byte> payload, std::span<const std::byte>* rest) {
  static_assert(std::is_trivially_copyable_v<Struct>);
  Struct value;
  if (payload.size() < sizeof value) failWire();
  std::memcpy(&value, payload.data(), sizeof value);
  if (rest != nullptr) *rest = payload.subspan(sizeof value);
  return value;
}

}  // namespace argil::io
