#include "render/view/scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace argil::render {
namespace {

constexpr double kLeastGridPixels = 16;
constexpr double kBarPart = 0.2;  ///< Of the picture's width.
constexpr double kSlack = 1e-9;   ///< Relative: 10 mm computed as 9.999999999 is 10 mm.

}  // namespace

double roundLengthUp(double mm) {
  const double power = std::pow(10, std::floor(std::log10(mm) + kSlack));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (mm <= step * power * (1 + kSlack)) return step * power;
  }
  return 10 * power;
}

double roundLengthDown(double mm) {
  const double power = std::pow(10, std::floor(std::log10(mm) + kSlack));
  for (const double step : {5.0, 2.0}) {
    if (mm >= step * power * (1 - kSlack)) return step * power;
  }
  return power;
}

std::string lengthLabel(double mm) {
  const char* unit = "mm";
  double value = mm;
  if (mm < 1 - kSlack) {
    unit = "µm";
    value = mm * 1000;
  } else if (mm >= 1000 * (1 - kSlack)) {
    unit = "m";
    value = mm / 1000;
  }
  char text[64];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
}

double interfaceScale(int height) {
  return std::max(1.0, height / 720.0);
}

GridSpacing gridSpacing(const View& view, int height) {
  const double mmPerPixel = view.heightAtTarget() / height;
  const double minor = roundLengthUp(kLeastGridPixels * interfaceScale(height) * mmPerPixel);
  const double mantissa = minor / std::pow(10, std::floor(std::log10(minor) + kSlack));
  return {minor, minor * (mantissa > 1.5 && mantissa < 3 ? 5 : 10)};
}

ScaleBar scaleBar(const View& view, int width, int height) {
  const double mmPerPixel = view.heightAtTarget() / height;
  const double mm = roundLengthDown(kBarPart * width * mmPerPixel);
  return {mm, mm / mmPerPixel};
}

}  // namespace argil::render
