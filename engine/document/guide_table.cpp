#include "engine/document/guide_table.h"

#include <array>

namespace argil::engine {
namespace {

using Feel = Guide::Feel;

constexpr std::array kAllFeels{Feel::seen, Feel::lock, Feel::well, Feel::keepOut};
constexpr std::array kNoSides{Feel::seen, Feel::lock, Feel::well};  // what has no side cannot keep the tool out
constexpr std::array kSolid{Feel::seen, Feel::keepOut};

constexpr std::array kGuides = {
    GuideRow{
        .kind = Guide::Kind::plane,
        .id = "plane",
        .name = "Plane",
        .icon = "plane",
        .size = GuideSize::widthAndDepth,
        .feels = kAllFeels,
    },
    GuideRow{
        .kind = Guide::Kind::line,
        .id = "line",
        .name = "Line",
        .icon = "line",
        .size = GuideSize::length,
        .feels = kNoSides,
    },
    GuideRow{
        .kind = Guide::Kind::point,
        .id = "point",
        .name = "Point",
        .icon = "point",
        .feels = kNoSides,
    },
    GuideRow{
        .kind = Guide::Kind::curve,
        .id = "curve",
        .name = "Curve",
        .icon = "curve",
        .points = 2,
        .feels = kNoSides,
    },
    GuideRow{
        .kind = Guide::Kind::keepOutBox,
        .id = "keep_out_box",
        .name = "Box",
        .icon = "box",
        .size = GuideSize::edges,
        .feels = kSolid,
    },
    GuideRow{
        .kind = Guide::Kind::ruler,
        .id = "ruler",
        .name = "Ruler",
        .icon = "ruler",
        .points = 2,
    },
    GuideRow{
        .kind = Guide::Kind::angle,
        .id = "angle",
        .name = "Angle",
        .icon = "angle",
        .points = 3,
    },
};

constexpr bool inOrder() {
  for (size_t i = 0; i < kGuides.size(); ++i)
    if (kGuides[i].kind != static_cast<Guide::Kind>(i)) return false;
  return true;
}
static_assert(inOrder());

}  // namespace

std::span<const GuideRow> guideTable() {
  return kGuides;
}

const GuideRow& rowOf(Guide::Kind kind) {
  return kGuides[static_cast<size_t>(kind)];
}

}  // namespace argil::engine
