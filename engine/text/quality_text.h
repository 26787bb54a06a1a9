#pragma once
// Qualities as scripts, documents and journals hold them.

#include <nlohmann/json.hpp>

#include "engine/document/quality.h"
#include "engine/text/script_place.h"

namespace argil::engine {

/// Axes of strokes that differ from what a quality begins as.
[[nodiscard]] nlohmann::ordered_json strokeQualityJson(const StrokeQuality& quality);
/// What is left out is as a quality begins. Throws Error for what is unknown or out of range.
[[nodiscard]] StrokeQuality readStrokeQuality(const Place& place);

/// A preset's id, or an object of axes that differ from what a quality begins as.
[[nodiscard]] nlohmann::ordered_json qualityJson(const Quality& quality);
/// "fine" or {"preset": "fine", "spacing": 0.05}; without a preset it begins as a quality begins. Throws Error for what
/// is unknown or out of range.
[[nodiscard]] Quality readQuality(const Place& place);

}  // namespace argil::engine
