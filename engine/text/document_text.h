#pragma once
// A document at one moment as text: all of it but clay and meshes, which it names by record.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/document/document.h"
#include "io/records/record.h"

namespace argil::engine {

/// Where the clay of a piece is kept.
struct ClayKey {
  io::RecordId root = 0;  ///< io::ClayRecords; 0: a piece without clay.
  uint32_t owner = 0;
  friend bool operator==(const ClayKey&, const ClayKey&) = default;
};

/// JSON of one line. `clay` one a piece, `meshes` one blob a part. Equal documents with equal keys give equal text.
/// Throws Error (kind work) for a number that is not finite.
[[nodiscard]] std::string documentText(const Document& document, const std::vector<ClayKey>& clay,
                                       const std::vector<io::RecordId>& meshes);

struct DocumentText {
  Document document;                        ///< Versions and meshes are still missing.
  std::vector<ClayKey> clay;                ///< One a piece,
  std::vector<clay::Grid> grids;            ///< one a piece,
  std::vector<clay::Precision> precisions;  ///< one a piece.
  std::vector<io::RecordId> meshes;
};
/// Any text is allowed. Throws Error that names `name` and the place in it: unknown keys, numbers out of range, ids
/// twice or beyond the next. With `unknown` the keys that are not known are left out and named there: for a text that a
/// newer Argil wrote. Whoever adds a key raises io::kDocumentSchema, so that older Argils can tell.
[[nodiscard]] DocumentText readDocumentText(std::string_view text, const std::string& name,
                                            std::vector<std::string>* unknown = nullptr);

}  // namespace argil::engine
