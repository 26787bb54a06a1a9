#include "clay/settle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "clay/redistance.h"

namespace argil::clay {

void redistanceByRegion(Editor& editor, std::span<const Coord> bricks, Job* job, double jobFrom) {
  std::vector<Coord> byRegion(bricks.begin(), bricks.end());
  std::sort(byRegion.begin(), byRegion.end(), [](Coord a, Coord b) { return a >> 3 != b >> 3 ? a >> 3 < b >> 3 : a < b; });
  for (size_t begin = 0; begin < byRegion.size();) {
    size_t end = begin;
    while (end < byRegion.size() && byRegion[end] >> 3 == byRegion[begin] >> 3) ++end;
    redistance(editor, std::span(byRegion).subspan(begin, end - begin));
    begin = end;
    if (job) job->step(jobFrom + (1 - jobFrom) * double(end) / double(byRegion.size()));
  }
}

void clearChannelsOutsideBand(Editor& editor, Coord coord) {
  const float band = editor.grid().band;
  const Slot distance = editor.find(coord);
  for (const Channel channel : kAllChannels) {
    const ChannelSlot slot = editor.has(channel) ? editor.find(channel, coord) : ChannelSlot();
    if (slot == ChannelSlot()) continue;
    if (distance.isTile()) {
      editor.setChannelTile(channel, coord, false);
      continue;
    }
    std::array<uint8_t, kBrickVoxels> values;
    for (int i = 0; i < kBrickVoxels; ++i) values[static_cast<size_t>(i)] = std::abs(distance.phi(i, band)) < band ? slot.value(i) : 0;
    editor.setChannel(channel, coord, values);
  }
}

void keepChannels(Editor& editor, const Version& from) {
  const float band = editor.grid().band;
  for (const Channel channel : kAllChannels) {
    if (!from.has(channel)) continue;
    from.forEachBrick([&](const Brick& was) {
      const Slot is = editor.find(was.coord);
      const ChannelSlot slot = from.find(channel, was.coord);
      if (slot == ChannelSlot()) return;
      if (is.isTile()) {
        editor.setChannelTile(channel, was.coord, false);
        return;
      }
      std::array<uint8_t, kBrickVoxels> values;
      for (int i = 0; i < kBrickVoxels; ++i) {
        const bool both = std::abs(is.phi(i, band)) < band && std::abs(was.phi(i)) < band;
        values[static_cast<size_t>(i)] = both ? slot.value(i) : 0;
      }
      editor.setChannel(channel, was.coord, values);
    });
  }
}

}  // namespace argil::clay
