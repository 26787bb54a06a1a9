#include "engine/models/load_document.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "clay/base/error.h"
#include "engine/saving/saved_document.h"
#include "io/bytes/input.h"
#include "io/records/document_file.h"

namespace argil::engine {
using io::endingOf;

bool holdsClay(const std::filesystem::path& file) {
  return endingOf(file) == ".argil" || endingOf(file) == ".vdb" || io::isDocument(file);
}

LoadedDocument loadDocument(const std::filesystem::path& file, const ModelImport& how, Job* job) {
  LoadedDocument loaded;
  if (endingOf(file) == ".argil" || io::isDocument(file)) {
    OpenedDocument opened = openDocument(file, job);
    loaded.document = opened.states[opened.done].document;
    loaded.steps = opened.steps;
    loaded.notes = std::move(opened.notes);
    if (!opened.readOnly.empty()) loaded.notes.push_back(std::move(opened.readOnly));
    loaded.what = "Argil document";
    return loaded;
  }
  ImportedModel imported = importModel(file, how, job);
  Document document;
  for (Guide& guide : imported.guides) document.add(std::move(guide));
  for (Part& part : imported.parts) {
    if (part.name.empty()) part.name = file.stem().string();
    document.add(std::move(part));
  }
  for (Piece& piece : imported.pieces) {
    if (piece.name.empty()) piece.name = file.stem().string();
    document.add(std::move(piece));
  }
  loaded.document = std::make_shared<const Document>(std::move(document));
  loaded.what = endingOf(file) == ".vdb" ? "level set" : "clay of a mesh";
  loaded.notes = std::move(imported.notes);
  return loaded;
}

}  // namespace argil::engine
