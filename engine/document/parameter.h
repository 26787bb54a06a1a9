#pragma once
// A number that a person can set, as a row of a table: panels, scripts, presets and shortcuts are made from these rows.

#include <algorithm>
#include <span>
#include <string_view>

namespace argil::engine {

/// `Owner` is the struct that holds the number. Names are for people, ids for files and scripts.
template <class Owner>
struct Parameter {
  /// unit: "mm", "N", "%", "share" (0 to 1, which people read as per cent), "°", "colour" (0xRRGGBB), "on" (0 or 1) or
  /// empty. help: one sentence.
  std::string_view id, name, help, unit;
  double low = 0, high = 1, standard = 0;  ///< In the unit.
  bool logarithmic = false;                ///< Spans powers of ten: sliders are logarithmic.
  double (*get)(const Owner&) = nullptr;
  void (*set)(Owner&, double) = nullptr;           ///< Expects low to high.
  std::span<const std::string_view> choices = {};  ///< Names of 0, 1, …: it is one of these. Empty: a number.
  std::string_view zero = {};                      ///< Shown in place of the number 0: "automatic". Empty: the number.

  void change(Owner& owner, double value) const { set(owner, std::clamp(value, low, high)); }
};

}  // namespace argil::engine
