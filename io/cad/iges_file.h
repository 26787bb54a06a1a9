#pragma once
// IGES files: smooth solids for CAD programs that read no STEP.

#include <span>
#include <string>

#include "clay/base/job.h"
#include "io/bytes/atomic_file.h"
#include "io/cad/cad_body.h"

namespace argil::io {

/// IGES 5.3 in mm: a manifold solid (entity 186) for each part of a body that hangs together, cavities within it; one
/// B-spline face (128) a patch, sides (126) and corners shared between faces. Letters of names that are not ASCII
/// become '_', as the format has none. Throws Error for no body, more than 9 999 999 lines and what is not finite;
/// Cancelled.
void writeIges(AtomicFile& file, const std::string& name, std::span<const CadBody> bodies, Job* job = nullptr);

}  // namespace argil::io
