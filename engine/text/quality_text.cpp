#include "engine/text/quality_text.h"

#include <vector>

#include "clay/base/error.h"
#include "engine/text/parameter_text.h"

namespace argil::engine {
namespace {

using nlohmann::ordered_json;

bool ofStrokes(const QualityAxis& axis) {
  return axis.part == QualityPart::strokes;
}

ordered_json differing(const Quality& quality, bool (*wanted)(const QualityAxis&)) {
  const Quality standard;
  ordered_json axes = ordered_json::object();
  for (const QualityAxis& axis : qualityAxes())
    if (wanted(axis) && axis.row.get(quality) != axis.row.get(standard))
      axes[keyOf(axis.row)] = valueOf(axis.row, quality);
  return axes;
}

void readAxes(const Place& place, bool (*wanted)(const QualityAxis&), bool named, Quality& quality) {
  std::vector<std::string> keys;
  for (const QualityAxis& axis : qualityAxes())
    if (wanted(axis)) keys.push_back(keyOf(axis.row));
  std::vector<std::string_view> known(keys.begin(), keys.end());
  if (named) known.push_back("preset");
  place.keys(known);
  for (const QualityAxis& axis : qualityAxes()) {
    if (!wanted(axis)) continue;
    if (const auto value = place.maybe(keyOf(axis.row).c_str()))
      readValue(axis.row, *value, quality, axis.row.low, axis.row.high);
  }
  try {
    quality.strokes.check();
  } catch (const Error& error) {
    place.fail(error.what());
  }
}

Quality presetAt(const Place& place) {
  const QualityPreset* preset = findQualityPreset(place.text());
  if (!preset) place.fail(fmt::format("unknown {}; known are {}", io::shown(place.text()), presetNames()));
  return preset->quality;
}

}  // namespace

ordered_json strokeQualityJson(const StrokeQuality& quality) {
  Quality all;
  all.strokes = quality;
  return differing(all, ofStrokes);
}

StrokeQuality readStrokeQuality(const Place& place) {
  Quality quality;
  readAxes(place, ofStrokes, false, quality);
  return quality.strokes;
}

ordered_json qualityJson(const Quality& quality) {
  for (const QualityPreset& preset : qualityPresets())
    if (preset.quality == quality) return preset.id;
  return differing(quality, [](const QualityAxis&) { return true; });
}

Quality readQuality(const Place& place) {
  if (place.value().is_string()) return presetAt(place);
  Quality quality;
  if (const auto preset = place.maybe("preset")) quality = presetAt(*preset);
  readAxes(
      place, [](const QualityAxis&) { return true; }, true, quality);
  return quality;
}

}  // namespace argil::engine
