#pragma once
// Numbers of a table's rows as scripts and journals hold them.

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/document/parameter.h"
#include "engine/text/script_place.h"

namespace argil::engine {

/// The id with its unit: "radius_mm", "angle_deg", "full_force_n", "from_percent", "below_mm3".
template <class Owner>
std::string keyOf(const Parameter<Owner>& parameter) {
  std::string key(parameter.id);
  std::replace(key.begin(), key.end(), '-', '_');
  if (parameter.unit == "mm") return key + "_mm";
  if (parameter.unit == "mm³") return key + "_mm3";
  if (parameter.unit == "°") return key + "_deg";
  if (parameter.unit == "N") return key + "_n";
  if (parameter.unit == "%") return key + "_percent";
  return key;
}

/// A number, one of the choices, true or false, or "#rrggbb": what a script has for `value`.
template <class Owner>
nlohmann::ordered_json scriptValue(const Parameter<Owner>& parameter, double value) {
  if (!parameter.choices.empty()) return parameter.choices[size_t(value)];
  if (parameter.unit == "on") return value >= 0.5;
  if (parameter.unit == "colour") return fmt::format("#{:06x}", uint32_t(value));
  return value;
}

template <class Owner>
nlohmann::ordered_json valueOf(const Parameter<Owner>& parameter, const Owner& owner) {
  return scriptValue(parameter, parameter.get(owner));
}

/// 0xrrggbb. Throws Error for anything but "#rrggbb".
[[nodiscard]] uint32_t readColour(const Place& place);

/// Numbers lie between low and high. Throws Error for what is not as asked.
template <class Owner>
void readValue(const Parameter<Owner>& parameter, const Place& place, Owner& owner, double low, double high) {
  if (!parameter.choices.empty()) {
    for (size_t i = 0; i < parameter.choices.size(); ++i) {
      if (place.text() == parameter.choices[i]) return parameter.set(owner, double(i));
    }
    place.fail(fmt::format("unknown {}; known are {}", io::shown(place.text()), fmt::join(parameter.choices, ", ")));
  }
  if (parameter.unit == "on") return parameter.set(owner, place.truth());
  if (parameter.unit == "colour") return parameter.set(owner, readColour(place));
  parameter.set(owner, place.number(low, high));
}

/// What may be given, for people: "0.01 to 100 mm", "true | false".
template <class Owner>
std::string valuesOf(const Parameter<Owner>& parameter) {
  if (!parameter.choices.empty()) return fmt::format("{}", fmt::join(parameter.choices, " | "));
  if (parameter.unit == "on") return "true | false";
  if (parameter.unit == "colour") return "#rrggbb";
  return fmt::format("{:g} to {:g}{}", parameter.low, parameter.high,
                     parameter.unit == "share" || parameter.unit.empty() ? "" : " " + std::string(parameter.unit));
}

}  // namespace argil::engine
