#pragma once
// Paths of a script laid onto the clay that is there.

#include <optional>

#include "clay/version.h"
#include "engine/script.h"

namespace argil::engine {

/// A stroke ready to run: its path lies where it is to be.
struct LaidStroke {
  ScriptStroke stroke;              ///< Without `onto`; its path is empty when it met no clay at all.
  std::optional<Vec3d> from, to;    ///< Of a path that was laid: where it was written, outside; a hand comes and leaves there.
};

/// Lays a stroke onto a version; a stroke without `onto` comes back as it is. Deterministic. Cost: one march through the
/// field a point.
[[nodiscard]] LaidStroke lay(const clay::Version& version, const ScriptStroke& stroke);

}  // namespace argil::engine
