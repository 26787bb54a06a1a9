#pragma once
// A number that a person can set, as a row of a table: panels, scripts, presets and shortcuts are made from these rows.

#include <algorithm>
#include <string_view>

namespace argil::engine {

/// `Owner` is the struct that holds the number. Names are for people, ids for files and scripts.
template <class Owner>
struct Parameter {
  std::string_view id, name, help, unit;  ///< unit: "mm", "N", "%", "°" or empty. help: one sentence.
  double low = 0, high = 1, standard = 0; ///< In the unit.
  bool logarithmic = false;               ///< Spans powers of ten: sliders are logarithmic.
  double (*get)(const Owner&) = nullptr;
  void (*set)(Owner&, double) = nullptr;  ///< Expects low to high.

  void change(Owner& owner, double value) const { set(owner, std::clamp(value, low, high)); }
};

}  // namespace argil::engine
