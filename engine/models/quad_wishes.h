#pragma once
// What a person wishes of the quads of a piece, beside their count: along curve guides, more where it is masked.

#include <string>
#include <vector>

#include "clay/cage/cage_maker.h"
#include "engine/models/model_files.h"

namespace argil::engine {

/// What `what` asks for, in the piece's own mm: closed curves among the visible guides.
[[nodiscard]] clay::CageWishes wishesFor(const Document& document, const Piece& piece, const ModelExport& what);

/// Sentences of what became of it; none where nothing was asked for.
[[nodiscard]] std::vector<std::string> wishWords(const Document& document, const Piece& piece, const ModelExport& what,
                                                 const clay::WishesMet& met);

}  // namespace argil::engine
