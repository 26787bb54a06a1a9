#pragma once
// The sentence on objects of a file that have no triangles. A header alone: the reader process links no module.

#include <algorithm>
#include <span>
#include <string>

namespace argil::io {

/// Says which objects were left out because they have no triangles, by their names, of which some may be empty; at
/// least one.
[[nodiscard]] inline std::string emptyObjects(std::span<const std::string> names) {
  constexpr size_t kMostNamed = 5;
  const auto shownName = [](const std::string& name) {
    return name.empty() ? std::string("one without a name") : name;
  };
  if (names.size() == 1)
    return (names[0].empty() ? std::string("an object without a name") : "the object " + names[0]) +
           " has no triangles and was left out";
  std::string list;
  for (const std::string& name : names.first(std::min(kMostNamed, names.size())))
    list += (list.empty() ? "" : ", ") + shownName(name);
  if (names.size() > kMostNamed) list += " and others";
  return std::to_string(names.size()) + " objects have no triangles and were left out: " + list;
}

}  // namespace argil::io
