#pragma once
// What colours a model has, on the clay that was made of it.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "clay/import/mesh_colours.h"
#include "clay/surface/surface.h"
#include "engine/document/document.h"
#include "io/models/model_file.h"

namespace argil::engine {

/// Colours of a mesh as files have them: one a vertex, or one a triangle, which go first; both may be empty.
struct FileColours {
  std::span<const io::Colour> vertices = {};
  std::span<const io::Colour> triangles = {};
  /// More than one: what the colour of a whole piece cannot say.
  [[nodiscard]] bool several() const;
};

/// The clay with these colours, its mask and materials as they were. Without several colours: the same version, as one
/// is the piece's own. Throws as clay::withMeshColours.
[[nodiscard]] clay::Version withColours(clay::Version version, const clay::TriangleMesh& mesh,
                                        const FileColours& colours, const clay::WorkPart& part);

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
