#include "ui3d/studio/view/chosen_quality.h"

namespace argil::studio {

engine::Quality chosenQuality(const StudioState& state, const engine::Document& document) {
  engine::Quality quality;
  quality.strokes = document.quality;
  quality.touch = state.touchQuality;
  quality.surface = state.surface;
  return quality;
}

render::Quality pictureOf(std::string_view preset) {
  render::Quality picture;
  if (preset == "draft") {
    picture.supersample = 1;
    picture.shadowPixels = 1024;
    picture.detailPixels = 2;
  } else if (preset == "fine") {
    picture.supersample = 3;
    picture.shadowPixels = 4096;
    picture.detailPixels = 0;
  }
  return picture;
}

bool isChosen(std::string_view preset, const StudioState& state, const engine::Document& document) {
  const engine::QualityPreset* wanted = engine::findQualityPreset(preset);
  if (!wanted) return false;
  const engine::Quality now = chosenQuality(state, document);
  return now.strokes == wanted->quality.strokes && now.touch == wanted->quality.touch &&
         now.surface == wanted->quality.surface && state.quality == pictureOf(preset);
}

}  // namespace argil::studio
