#pragma once
// Clay with a channel set by a function of the place, for tests.

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "clay/store/editor.h"
#include "clay/store/version.h"

namespace argil::haptics::testing {

/// `version` with a channel that is what `value` says at each voxel coordinate of the band.
inline clay::Version painted(const clay::Version& version, clay::Channel channel,
                             const std::function<uint8_t(Coord)>& value) {
  clay::Editor editor(version);
  version.forEachBrick([&](const clay::Brick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> values{};
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < version.grid().band)
        values[size_t(i)] = value(brick.coord * clay::kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7});
    editor.setChannel(channel, brick.coord, values);
  });
  return editor.commit();
}

}  // namespace argil::haptics::testing
