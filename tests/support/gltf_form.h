#pragma once
// The form that the JSON of a glTF file must have: which properties there are, of what kind, in what range. For
// gltf_rules.cpp, which judges the rest.

#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace argil::samples {

using GltfSay = std::function<void(const std::string& code, const std::string& pointer, const std::string& message)>;

/// Tells what is wrong; `named` gets the extensions that some object has.
void judgeGltfForm(const nlohmann::json& root, const GltfSay& say, std::set<std::string>& named);

}  // namespace argil::samples
