#pragma once
// The kinds of guides as rows of a table: what a file, a list and a panel need of each. How one is felt is felt()
// (engine/document/document.h), how one is drawn and snapped to is in ui3d/studio/widgets.

#include <span>
#include <string_view>

#include "engine/document/document.h"

namespace argil::engine {

/// What of Guide::sizeMm a kind has.
enum class GuideSize : uint8_t {
  none,
  widthAndDepth,  ///< x and y: what is drawn of a plane.
  length,         ///< z: what is drawn of a line.
  edges,          ///< x, y and z.
};

struct GuideRow {
  Guide::Kind kind;
  std::string_view id;    ///< In documents; for good.
  std::string_view name;  ///< A new one is "Plane", "Plane 2", ...
  std::string_view icon;  ///< In ui3d/studio/kit/icons.
  size_t points = 0;      ///< It has at least so many in Guide::pointsMm.
  GuideSize size = GuideSize::none;
  std::span<const Guide::Feel> feels = {};  ///< What a user may choose, `seen` first; empty: it is never felt.
};

/// A row for each kind, in their order.
[[nodiscard]] std::span<const GuideRow> guideTable();
[[nodiscard]] const GuideRow& rowOf(Guide::Kind kind);

}  // namespace argil::engine
