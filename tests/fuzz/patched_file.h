#pragma once
// A file as an input describes it: its own bytes, or a sound file that was damaged. The fuzzer need not know what a
// whole one looks like.

#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/fuzz/record_input.h"
#include "tests/fuzz/require.h"

namespace argil::tests {

/// A folder in memory that goes with the program.
class MemoryFolder {
 public:
  MemoryFolder() {
    std::string pattern = std::filesystem::exists("/dev/shm")
                              ? "/dev/shm/argil-fuzz-XXXXXX"
                              : (std::filesystem::temp_directory_path() / "argil-fuzz-XXXXXX").string();
    require(mkdtemp(pattern.data()) != nullptr);
    path_ = pattern;
  }
  ~MemoryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }
  /// Removes what is there, but not the folder.
  void clear() const {
    for (const auto& entry : std::filesystem::directory_iterator(path_)) std::filesystem::remove_all(entry.path());
  }

 private:
  std::filesystem::path path_;
};

inline std::string contentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// An even first byte: the rest is the file. Odd: `whole`, damaged at places: (offset in 3 bytes, length, bytes)...; a
/// length of 0 cuts it there, of 255 tears 4096 bytes out.
inline std::string patched(ByteInput& input, const std::string& whole) {
  const auto text = [](std::span<const std::byte> bytes) {
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  if (input.byte() % 2 == 0) return std::string(text(input.rest()));
  std::string file = whole;
  while (!input.empty() && !file.empty()) {
    const size_t low = input.two(), at = (low | size_t{input.byte()} << 16) % file.size();
    const uint8_t length = input.byte();
    if (length == 0)
      file.resize(at);
    else if (length == 255)
      file.erase(at, 4096);
    else
      file.replace(at, std::min<size_t>(length, file.size() - at), text(input.some(length)));
  }
  return file;
}

inline void write(const std::filesystem::path& file, std::string_view content) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << content;
}

}  // namespace argil::tests
