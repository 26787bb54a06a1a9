#pragma once
// Tools and strokes as text: in scripts and journals.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/document/stroke_images.h"
#include "engine/document/tool.h"
#include "engine/text/script_place.h"

namespace argil::engine {

/// Adds to an object "tool" and what differs from the tool that its row begins with; the radius always. Its quality
/// only where it is not `usual`.
void putTool(nlohmann::ordered_json& object, const Tool& tool, const StrokeQuality& usual = {});
/// Keys that an object may have beside `others` when it holds a tool. Throws Error for any other, and for a tool that
/// there is none of.
void checkToolKeys(const Place& place, std::vector<std::string_view> others);
/// Throws Error for what is missing, unknown or out of range. Files are not read: see tool_file.h.
[[nodiscard]] Tool readTool(const Place& place, const StrokeQuality& usual = {});

/// "mirror" (`mirrorKey`) and "radial", where there are any.
void putImages(nlohmann::ordered_json& object, const StrokeImages& images, const char* mirrorKey);
[[nodiscard]] StrokeImages readImages(const Place& place, const char* mirrorKey);

}  // namespace argil::engine
