#include "ui3d/cli/show_document.h"

namespace argil::cli {

void showDocument(const engine::Document& document, clay::Grade grade, render::Renderer& renderer) {
  const bool coloured = document.pieces.size() + document.parts.size() > 1;
  const auto lookOf = [&](const haptics::Pose& pose, const std::array<float, 3>& colour) {
    render::PieceLook look;
    look.rotation = pose.rotation;
    look.translationMm = pose.translation;
    if (coloured) look.colour = {colour[0], colour[1], colour[2], 1};
    return look;
  };
  for (const engine::Piece& piece : document.pieces) {
    if (!piece.visible) continue;
    clay::Surface surface(true, grade);
    renderer.update(piece.id, surface.update(piece.version, 2));
    render::PieceLook look = lookOf(piece.pose, piece.colour);
    look.materials = engine::materialColours(piece);
    look.hideMasked = piece.hideMasked;
    renderer.place(piece.id, look);
  }
  for (const engine::Part& part : document.parts) {
    if (!part.visible) continue;
    renderer.updatePart(part.id, *part.mesh);
    renderer.place(part.id, lookOf(part.pose, part.colour));
  }
}

}  // namespace argil::cli
