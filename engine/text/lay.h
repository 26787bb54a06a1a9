#pragma once
// Paths of a script laid onto the clay that is there.

#include <optional>
#include <vector>

#include "clay/store/version.h"
#include "engine/text/script.h"

namespace argil::engine {

/// A stroke ready to run: its path lies where it is to be.
struct LaidStroke {
  ScriptStroke stroke;  ///< Without `onto`.
  /// Of a path that was laid: where it was written, outside; a hand comes and leaves there.
  std::optional<Vec3d> from, to;
};

/// Lays a stroke onto a version; one without `onto` comes back as it is. Where the surface breaks off (a point that
/// meets no clay, or a step in depth of more than twice the tool's radius) a new stroke begins, so that nothing is cut
/// on the way; of a stroke that breaks, parts shorter than that are left out. None when nothing meets clay.
/// Deterministic. Cost: a look at every brick, and one march through the field a point.
[[nodiscard]] std::vector<LaidStroke> lay(const clay::Version& version, const ScriptStroke& stroke);

}  // namespace argil::engine
