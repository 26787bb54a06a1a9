// The history of a document as a sequence of models, for time-lapses.

#include <fmt/format.h>

#include <algorithm>

#include "clay/base/error.h"
#include "clay/base/work_part.h"
#include "engine/models/model_files.h"
#include "engine/saving/saved_document.h"
#include "io/bytes/input.h"
#include "io/models/added_formats.h"
#include "io/models/model_writer.h"

namespace argil::engine {

namespace {

// Nothing that a model shows has changed.
bool looksAlike(const Document& a, const Document& b) {
  return std::equal(
      a.pieces.begin(), a.pieces.end(), b.pieces.begin(), b.pieces.end(), [](const Piece& x, const Piece& y) {
        return x.id == y.id && x.version == y.version && x.visible == y.visible && x.colour == y.colour &&
               x.pose.translation == y.pose.translation && x.pose.rotation.coeffs() == y.pose.rotation.coeffs();
      });
}

}  // namespace

std::string writeHistory(const std::filesystem::path& file, const std::filesystem::path& document,
                         const ModelExport& what, Job* job) {
  const std::string ending = io::endingOf(file), frameEnding = io::frameEndingOf(ending);
  if (io::endingOf(document) != ".argil")
    throw Error(
        fmt::format("{}: {} is written of the steps of an Argil document; give one", io::displayName(file), ending));
  OpenedDocument opened = openDocument(document, job);
  std::vector<DocumentPtr> states;
  // From the newest back: each is read as what differs from the one after it.
  DocumentPtr near = opened.states[opened.done].document;
  for (size_t i = opened.done + 1; i-- > 0;) {
    DocumentPtr state = opened.states[i].document;
    if (!state && opened.states[i].kept == 0) break;  // older ones are not in the file
    if (!state) state = readState(*opened.documentRecords, opened.base, {}, opened.states[i].kept, *near);
    if (states.empty() || !looksAlike(*state, *states.back())) states.push_back(state);
    near = state;
  }
  std::reverse(states.begin(), states.end());
  // Before the first clay there is nothing to be written.
  std::erase_if(states, [&](const DocumentPtr& state) {
    return std::none_of(state->pieces.begin(), state->pieces.end(), [&](const Piece& piece) {
      return (what.piece == 0 ? !what.visibleOnly || piece.visible : piece.id == what.piece) && piece.version &&
             piece.version.stats().bricks > 0;
    });
  });
  if (states.empty()) throw Error(fmt::format("{}: there is no clay in it", io::displayName(document)));
  const clay::WorkPart all(job);
  const auto count = static_cast<uint32_t>(states.size());
  const int digits = std::max(4, static_cast<int>(std::to_string(count).size()));
  for (uint32_t i = 0; i < count; ++i) {
    all.step(static_cast<double>(i) / count);
    const std::vector<io::ModelObject> objects = modelOf(*states[i], what);
    const std::filesystem::path frame =
        file.parent_path() / fmt::format("{}-{:0{}}{}", file.stem().string(), i + 1, digits, frameEnding);
    io::WriteOptions options;
    options.extension = ending;
    (void)io::writeModel(frame, {objects, {}, i, count}, options);
    states[i].reset();
  }
  return fmt::format("{} files written, {}-{:0{}}{} to {:0{}}.", count, file.stem().string(), 1, digits, frameEnding,
                     count, digits);
}

}  // namespace argil::engine
