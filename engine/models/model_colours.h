#pragma once
// What colours a model has, on the clay that was made of it.

#include <array>
#include <optional>
#include <vector>

#include "clay/import/mesh_colours.h"
#include "clay/surface/surface.h"
#include "engine/document/document.h"
#include "io/models/model_file.h"

namespace argil::engine {

/// The clay with the colours of an object, which has its mesh or has left it elsewhere; its mask and materials as they
/// were. Where the object has one colour at most: the same version, as one is the piece's own. Throws as
/// clay::withMeshColours.
[[nodiscard]] clay::Version withColours(clay::Version version, const clay::TriangleMesh& mesh,
                                        const io::ModelObject& object, const clay::WorkPart& part);

/// The colour that clay of an object gets as a whole, of the mean of its colours; none for an object without colours,
/// and where pictures leave some of it uncovered, which would look as if the mean lay there.
[[nodiscard]] std::optional<std::array<float, 3>> pieceColourOf(const io::ModelObject& object,
                                                                const std::optional<io::Colour>& mean);

/// Colour of each vertex of a piece's surface; white where nobody chose one. Empty where nothing is painted and no
/// material has a colour.
[[nodiscard]] std::vector<io::Colour> vertexColoursOf(const clay::Surface& surface, const Piece& piece);

/// As pieces and parts have it; alpha is left out.
[[nodiscard]] std::array<float, 3> colourOf(const io::Colour& colour);
[[nodiscard]] io::Colour colourOf(const std::array<float, 3>& colour);
/// The piece's colour where the user or a file chose one; none for that of a new piece, without which files are
/// written.
[[nodiscard]] std::optional<std::array<float, 3>> chosenColour(const Piece& piece);
/// The same for files.
[[nodiscard]] std::optional<io::Colour> fileColourOf(const Piece& piece);

}  // namespace argil::engine
