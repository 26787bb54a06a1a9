#pragma once
// What tools read from files, without a file.

#include <vector>

#include "clay/brush/stamp_shape.h"
#include "clay/field/primitives.h"
#include "clay/import/height_image.h"
#include "clay/store/store.h"
#include "engine/tools/tool_table.h"

namespace argil::tests {

/// A cross of 64×64 pixels.
inline std::shared_ptr<const clay::HeightImage> crossImage() {
  std::vector<uint8_t> grey(64 * 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) grey[size_t(y * 64 + x)] = (x > 24 && x < 40) || (y > 24 && y < 40) ? 255 : 0;
  return std::make_shared<const clay::HeightImage>(64, 64, grey);
}

/// A rounded block.
inline std::shared_ptr<const clay::StampShape> slab() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  static const auto shape =
      clay::StampShape::of(clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), {20, 14, 10}, 2));
  return shape;
}

/// Gives a tool the image or the shape that it needs.
inline void giveFile(engine::Tool& tool) {
  if (engine::rowOf(tool).file == engine::ToolFile::image) tool.content.image = crossImage();
  if (engine::rowOf(tool).file == engine::ToolFile::shape) tool.content.shape = slab();
}

}  // namespace argil::tests
