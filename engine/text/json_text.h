#pragma once
// JSON from outside, read strictly.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace argil::engine {

/// Throws Error that names `name`, line and column for what is no JSON; for a key twice in an object (one would
/// silently win), brackets that nest deeper than 16, a number beyond any double. `what` says what it should be: "a
/// script is {...}".
[[nodiscard]] nlohmann::json parseJson(std::string_view text, const std::string& name, const std::string& what);

}  // namespace argil::engine
