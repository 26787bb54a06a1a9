#pragma once
// Round lengths for grids and scale bars.

#include <string>

#include "render/view/view.h"

namespace argil::render {

/// The smallest of 1, 2, 5 · 10^n mm that is at least `mm`; `mm` > 0.
[[nodiscard]] double roundLengthUp(double mm);
/// The largest of 1, 2, 5 · 10^n mm that is at most `mm`; `mm` > 0.
[[nodiscard]] double roundLengthDown(double mm);
/// "10 mm", "200 µm", "5 m": a round length in the unit that gives the shortest number. UTF-8.
[[nodiscard]] std::string lengthLabel(double mm);

/// Lines of the ground's grid in mm: both round, major a multiple of minor.
struct GridSpacing {
  double minor = 1, major = 10;
};
/// Minor lines at least 16 interface pixels apart in the plane through the target.
[[nodiscard]] GridSpacing gridSpacing(const View& view, int height);

/// What the scale bar stands for, and its length in pixels: at most a fifth of the picture's width.
struct ScaleBar {
  double mm = 1, pixels = 1;
};
[[nodiscard]] ScaleBar scaleBar(const View& view, int width, int height);

/// Interface pixels grow with the picture: 1 up to a height of 720, 2 at 1440.
[[nodiscard]] double interfaceScale(int height);

}  // namespace argil::render
