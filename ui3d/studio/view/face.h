#pragma once
// What of the studio goes into a saved document and comes back with it: where it was looked at from, cut open, and
// worked on with.

#include <string>

#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// A JSON object: camera, section, shading, the tool in hand and its numbers.
[[nodiscard]] std::string faceText(const StudioState& state, const Camera& camera);

/// Takes over what the text holds; what is missing, unknown or out of range leaves things as they are. True when the
/// camera is now where the text says.
bool applyFace(const std::string& text, StudioState& state, Camera& camera);

}  // namespace argil::studio
