#include "clay/brush_channels.h"

#include "clay/error.h"

namespace argil::clay {

bool hasPaint(const Editor& editor) { return editor.has(Channel::cover) || editor.has(Channel::material); }

void carryChannels(Editor&, const Version&, const Brush&, const DistanceMethod*, std::span<const Stamp>, std::span<const Coord>) {}

void applyToChannels(Editor&, const Brush&, const Operation&, std::span<const Stamp>) { throw Error("no brush paints yet"); }

}  // namespace argil::clay
