#include "engine/models/quad_wishes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptics/scene/polyline.h"

namespace argil::engine {

namespace {

constexpr double kMostPlaces = 100000;  // along a curve

std::vector<const Guide*> curvesOf(const Document& document) {
  std::vector<const Guide*> curves;
  for (const Guide& each : document.guides)
    if (each.kind == Guide::Kind::curve && each.visible) curves.push_back(&each);
  return curves;
}

}  // namespace

clay::CageWishes wishesFor(const Document& document, const Piece& piece, const ModelExport& what) {
  clay::CageWishes wishes;
  wishes.maskDensity = what.maskDensity;
  if (!what.alongGuides) return wishes;
  for (const Guide* each : curvesOf(document)) {
    if (!each->closed || each->pointsMm.size() < 3) continue;
    const haptics::Polyline curve(each->pointsMm, true);
    const double step = std::max(piece.version.grid().voxelMm, curve.lengthMm() / kMostPlaces);
    const auto count = std::max<size_t>(3, static_cast<size_t>(std::ceil(curve.lengthMm() / step)));
    clay::GuideLoop& loop = wishes.guides.emplace_back();
    for (size_t i = 0; i < count; ++i)
      loop.emplace_back(piece.pose.rotation.inverse() *
                        (curve.at(curve.lengthMm() * double(i) / double(count)).point - piece.pose.translation));
  }
  return wishes;
}

std::vector<std::string> wishWords(const Document& document, const Piece& piece, const ModelExport& what,
                                   const clay::WishesMet& met) {
  std::vector<std::string> words;
  if (what.alongGuides) {
    const std::vector<const Guide*> curves = curvesOf(document);
    const auto open =
        static_cast<size_t>(std::ranges::count_if(curves, [](const Guide* each) { return !each->closed; }));
    const size_t off = curves.size() - open - std::min(met.guides, curves.size() - open);
    const auto plural = [](size_t count) { return count == 1 ? "" : "s"; };
    std::string text;
    if (met.guides > 0)
      text =
          fmt::format("edges follow {:.0f} % of {} closed curve{}, {:.3g} mm",
                      100 * std::min(1.0, met.onGuidesMm / met.guidesMm), met.guides, plural(met.guides), met.guidesMm);
    else
      text = "there is no closed curve on its surface, among the guides that are shown, to be followed";
    if (open > 0)
      text +=
          fmt::format("; {} open curve{} not: close {}", open, open == 1 ? " is" : "s are", open == 1 ? "it" : "them");
    if (off > 0 && met.guides > 0)
      text += fmt::format("; {} curve{} off its surface", off, off == 1 ? " lies" : "s lie");
    words.push_back(fmt::format("{}: {}.", piece.name, text));
  }
  if (what.maskDensity != 1)
    words.push_back(
        met.maskDensity > 0
            ? fmt::format("{}: where it is masked lie {:.2g} times as many quads a mm².", piece.name, met.maskDensity)
            : fmt::format("{}: no part of it is masked, or all of it: quads are even.", piece.name));
  return words;
}

}  // namespace argil::engine
