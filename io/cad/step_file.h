#pragma once
// STEP files: smooth solids for CAD.

#include <span>
#include <string>

#include "clay/base/job.h"
#include "io/bytes/atomic_file.h"
#include "io/cad/cad_body.h"

namespace argil::io {

/// AP214 in mm (ISO 10303-214, written as ISO 10303-21 says): a product for each body, with a solid
/// for each of its parts that hangs together, cavities within it; one B-spline face a patch. What patches share
/// (corners, sides, control points) is in the file once, so that no gap can open between them. Numbers with 17 digits:
/// the very doubles. Throws Error for no body and what is not finite, Cancelled.
void writeStep(AtomicFile& file, const std::string& name, std::span<const CadBody> bodies, Job* job = nullptr);

}  // namespace argil::io
