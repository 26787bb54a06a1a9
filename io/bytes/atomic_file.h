#pragma once
// A file that appears whole or not at all.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace argil::io {

/// Writes to a temporary file in the folder of `target`. commit() flushes it to the disk and renames it over the
/// target; destruction without commit() removes it, so that after any error or cancel nothing is left and the old file
/// stands. A link is followed; the permissions of a file that is replaced are kept. One thread.
class AtomicFile {
 public:
  /// Throws Error when the folder is missing or cannot be written, or when `target` is a folder, a device or a file
  /// that may not be written.
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Throws Error (kind work): no space, I/O error.
  void write(std::span<const std::byte> bytes);
  /// Durable once it returns: the file is flushed, renamed, and its folder flushed. Throws Error (kind work); the
  /// target is then the old one, unless inPlace(). `mayReplace` false: throws as well when there is a file of that name
  /// by now.
  void commit(bool mayReplace = true);
  /// The file has its name. When commit() threw all the same, the folder could not be flushed: a power cut may bring
  /// the old file back.
  [[nodiscard]] bool inPlace() const { return fd_ < 0 && temporary_.empty(); }

  [[nodiscard]] uint64_t bytes() const { return bytes_; }
  [[nodiscard]] const std::filesystem::path& target() const { return target_; }
  /// Until commit(): for a library that writes the file itself, and has closed it by then.
  [[nodiscard]] const std::filesystem::path& temporary() const { return temporary_; }

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  int fd_ = -1;
  uint64_t bytes_ = 0;
};

}  // namespace argil::io
