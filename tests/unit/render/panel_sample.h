#pragma once
// Panels made by hand.

#include <array>
#include <cstdint>

#include "render/view/ui_frame.h"

namespace argil::render::test {

inline uint32_t rgba(int r, int g, int b, int a = 255) {
  return uint32_t(r) | uint32_t(g) << 8 | uint32_t(b) << 16 | uint32_t(a) << 24;
}

inline UiFrame emptyPanels(int width, int height) {
  UiFrame frame;
  frame.width = float(width);
  frame.height = float(height);
  return frame;
}

/// A rectangle as a command of its own, with the whole of a texture on it.
inline void addRectangle(UiFrame& frame, const std::array<float, 4>& box, uint32_t colour, uint32_t texture = 0) {
  UiCommand command;
  command.clip = {0, 0, frame.width, frame.height};
  command.texture = texture;
  command.firstIndex = uint32_t(frame.indices.size());
  command.firstVertex = uint32_t(frame.vertices.size());
  command.indexCount = 6;
  for (int i = 0; i < 4; ++i) {
    const bool right = i == 1 || i == 2, low = i >= 2;
    frame.vertices.push_back({box[right ? 2 : 0], box[low ? 3 : 1], float(right), float(low), colour});
  }
  for (const uint16_t index : {0, 1, 2, 0, 2, 3}) frame.indices.push_back(index);
  frame.commands.push_back(command);
}

}  // namespace argil::render::test
