#include "ui3d/studio/files/save_words.h"

namespace argil::studio {

std::string documentName(const engine::FileState& file) {
  if (!file.path.empty()) return file.path.filename().string();
  return file.name.empty() ? "Untitled" : file.name;
}

std::string windowTitle(const engine::FileState& file) {
  if (file.path.empty() && !file.unsaved) return "Argil";
  return documentName(file) + (file.unsaved ? "*" : "") + " — Argil";
}

namespace {

Keeping keeping(const engine::FileState& file, Moment at) {
  if (file.saving) return {"Saving…"};
  if (!file.unsaved && !file.readOnly.empty()) return {"Opened for reading only"};
  if (!file.unsaved) return {file.path.empty() ? "Nothing to save" : "Saved " + momentWords(writtenAt(file.path), at)};
  if (!file.journalTrouble.empty()) return {"Not saved, and the journal fails", true};
  return {file.path.empty() ? "Not saved yet; the journal keeps it" : "Changed; the journal keeps it"};
}

}  // namespace

Keeping savingWords(const engine::FileState& file, Moment at) {
  Keeping words = keeping(file, at);
  if (file.elsewhere) words = {words.words + "; open in another window too", true};
  return words;
}

}  // namespace argil::studio
