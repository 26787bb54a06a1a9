#pragma once
// What a reader is given, and how it complains.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "clay/base/job.h"

namespace argil::io {

/// The bytes of one file. `name` stands in messages; its ending decides where the content alone does not.
struct Input {
  std::span<const std::byte> bytes;
  std::string name;
  Job* job = nullptr;
  uint64_t packed = 0;                ///< Bytes of the file that these were unpacked from; 0: they are the file.
  std::filesystem::path folder = {};  ///< Where the file lies, for what it names beside it; empty: not looked there.

  [[nodiscard]] std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

/// A whole file in memory.
struct FileBytes {
  std::unique_ptr<std::byte[]> data;
  size_t size = 0;
  [[nodiscard]] std::span<const std::byte> bytes() const { return {data.get(), size}; }
};

/// Reads a regular file that is not empty; throws Error for anything else (missing, a folder, a device, no permission,
/// empty). The first 10 % of the job.
[[nodiscard]] FileBytes readFile(const std::filesystem::path& path, Job* job = nullptr);

/// The first bytes of a file, 4096 at most; none of what readFile refuses, which says why.
[[nodiscard]] std::string headOf(const std::filesystem::path& path);

/// Throws Error "NAME: WRONG".
[[noreturn]] void fail(const std::string& name, const std::string& wrong);

/// A piece of a file (or a file's name) as a message may show it: one line, printable, at most 40 bytes of a token.
[[nodiscard]] std::string shown(std::string_view token);
[[nodiscard]] std::string displayName(const std::filesystem::path& path);
/// A text without the byte order mark of UTF-8 that editors of Windows put before it.
[[nodiscard]] std::string_view withoutMark(std::string_view text);
/// Of a file's name, in small letters, with its dot: ".stl"; empty: none.
[[nodiscard]] std::string endingOf(const std::filesystem::path& path);

/// A name from inside a file as valid UTF-8 of one line, at most 200 bytes, blanks around it gone; "?" for what is
/// neither.
[[nodiscard]] std::string cleanName(std::string_view text);

/// Tells a job now and then how far a reader is.
class Ticker {
 public:
  explicit Ticker(const Input& input) : job_(input.job), size_(double(input.bytes.size())) {}
  /// Cheap: looks at the job once in 4096 calls. Throws Cancelled.
  void at(size_t byte) {
    if (job_ != nullptr && (++calls_ & 0xfff) == 0) job_->step(0.1 + 0.9 * double(byte) / size_);
  }

 private:
  Job* job_;
  double size_;
  uint32_t calls_ = 0;
};

}  // namespace argil::io
