#pragma once
// Small meshes, files in memory and in a folder of their own, and what an Error must look like: for tests of meshes.

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

#include "clay/base/error.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::samples {

/// Corners (±1, ±1, ±1) · half, facing outwards: volume (2 half)³.
inline clay::TriangleMesh cube(double half = 1, const Vec3d& middle = Vec3d::Zero()) {
  clay::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(middle + half * Vec3d((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

inline std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text));
}

template <class T>
void append(std::string& bytes, T value, bool bigEndian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (bigEndian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// A folder that goes with its test.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "argil-test-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] size_t entries() const {
    const std::filesystem::directory_iterator all(path_);
    return size_t(std::distance(begin(all), end(all)));
  }

 private:
  std::filesystem::path path_;
};

inline std::string slurp(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void spill(const std::filesystem::path& path, std::string_view content) {
  std::ofstream(path, std::ios::binary) << content;
}

/// What `work` throws as an Error of one line; fails the test when it throws none.
template <class Work>
std::string errorOf(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    const std::string sentence = error.what();
    EXPECT_EQ(sentence.find_first_of("\r\n"), std::string::npos) << sentence;
    EXPECT_GT(sentence.size(), 10u) << sentence;
    return sentence;
  }
  ADD_FAILURE() << "no Error was thrown";
  return {};
}

/// Folder of the real meshes; empty when ARGIL_DATA is unset.
inline std::filesystem::path meshData() {
  const char* root = std::getenv("ARGIL_DATA");
  return root == nullptr ? std::filesystem::path() : std::filesystem::path(root) / "mesh";
}

}  // namespace argil::samples
