#pragma once
// The rules of glTF 2.0 (Khronos; ISO/IEC 12113), judged on the bytes of a file without any of Argil's own code.
//
// Issues have the codes and severities of Khronos' glTF validator (its list ISSUES.md), so that the two can be
// compared. What Argil does not write (samplers, cameras, skins, animations, morph targets, sparse accessors, buffers
// and pictures in other files) is an UNEXPECTED_PROPERTY here. Draco's streams are not decoded.

#include <string>
#include <string_view>
#include <vector>

namespace argil::samples {

enum class Severity { error, warning, info, hint };

struct GltfIssue {
  std::string code;
  Severity severity;
  std::string pointer;  ///< JSON pointer, or empty: the container.
  std::string message;
};

/// Judges a .glb or .gltf, which the first bytes tell. Where the JSON does not have the form that it should, no more
/// is judged; where views or accessors do not fit their bytes, contents are not. O(bytes).
[[nodiscard]] std::vector<GltfIssue> gltfIssues(std::string_view bytes);

/// One line an issue; empty without errors and warnings.
[[nodiscard]] std::string errorsAndWarnings(const std::vector<GltfIssue>& issues);

}  // namespace argil::samples
