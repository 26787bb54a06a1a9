#pragma once
// A tool that is a formula, as a text: in plugins, and in scripts and journals, which so need no plugin.

#include <nlohmann/json.hpp>

#include "engine/text/script_place.h"
#include "engine/tools/added_tools.h"

namespace argil::engine {

/// Numbers as plugins name them, not checked. Throws Error that names the place.
[[nodiscard]] std::vector<AddedTool::Number> readNumbers(const Place& place);
/// All but its id and its plugin.
[[nodiscard]] nlohmann::ordered_json formulaToolJson(const AddedTool& tool);
/// `others`: keys that may stand beside. Throws Error that names the place: for what cannot be read and what no program
/// could use.
[[nodiscard]] AddedTool readFormulaTool(const Place& place, std::string id,
                                        std::initializer_list<std::string_view> others = {});
/// The same of a tool whose work is not looked at yet.
[[nodiscard]] AddedTool readToolFacts(const Place& place, std::string id,
                                      std::initializer_list<std::string_view> others = {});
/// Throws Error that names the place for a tool that no program could use.
void requireTool(const Place& place, const AddedTool& tool);

}  // namespace argil::engine
