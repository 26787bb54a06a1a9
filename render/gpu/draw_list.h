#pragma once
// Commands of indirect draws, written by the CPU for one picture. Only for the .cpp files of render/.

#include <array>
#include <vector>

#include "render/gpu/gpu.h"

namespace argil::render {

/// Buffers of draw commands, a set for each of the pictures that may be under way at once.
class DrawList {
 public:
  explicit DrawList(Gpu& gpu) : gpu_(gpu) {}

  /// Before the first draw of a picture: commands of kPictures pictures ago are done. Takes memory for so many, in the
  /// pictures that follow too: later there may be none.
  void nextPicture(size_t commands);
  /// Draws `commands` with as few calls as the device allows; returns how many.
  uint64_t draw(VkCommandBuffer buffer, const std::vector<VkDrawIndexedIndirectCommand>& commands);
  [[nodiscard]] uint64_t bytes() const;

 private:
  static constexpr size_t kPictures = 3;
  struct Page {
    Buffer buffer;
    uint32_t used = 0;
  };
  void addPage(std::vector<Page>& pages);

  Gpu& gpu_;
  std::array<std::vector<Page>, kPictures> pages_;
  size_t picture_ = 0;
};

}  // namespace argil::render
