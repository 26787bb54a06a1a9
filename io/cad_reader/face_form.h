#pragma once
// What there is of a CAD face to construct with: its plane, its axis or its middle.

#include <TopoDS_Face.hxx>

#include <optional>

#include "io/reader/wire.h"

namespace argil::io::reader {

/// Of planes, cylinders, cones, spheres and tori by what the file says of them; of all other surfaces by what they are:
/// many programs write a cylinder as a spline, or as a line that was turned. Those have a plane, an axis of revolution
/// or a middle if 81 places of theirs, and the normals there, agree to `diagonal` / 10⁵ (and to a ten thousandth of the
/// face). None: a freely curved face, or one that reaches farther than `diagonal`, mm. Cost: some ten microseconds.
[[nodiscard]] std::optional<wire::Face> formOf(const TopoDS_Face& face, double diagonal);

}  // namespace argil::io::reader
