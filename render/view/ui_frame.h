#pragma once
// Flat panels over the picture, as triangles: what an immediate-mode interface hands over each frame.

#include <array>
#include <cstdint>
#include <vector>

namespace argil::render {

struct UiVertex {
  float x = 0, y = 0;  ///< Interface units from the top left corner.
  float u = 0, v = 0;
  uint32_t rgba = 0;  ///< sRGB, red in the lowest byte, straight alpha.
};
static_assert(sizeof(UiVertex) == 20);

struct UiCommand {
  std::array<float, 4> clip{};  ///< Left, top, right, bottom in interface units.
  uint32_t texture = 0;         ///< 0: the font.
  uint32_t firstIndex = 0, indexCount = 0, firstVertex = 0;
};

/// One frame of panels. Blended in sRGB over the finished picture, as the makers of interfaces expect.
struct UiFrame {
  float width = 0, height = 0;  ///< Interface units; stretched over the whole picture.
  std::vector<UiVertex> vertices;
  std::vector<uint16_t> indices;
  std::vector<UiCommand> commands;
  [[nodiscard]] bool empty() const { return commands.empty(); }
};

}  // namespace argil::render
