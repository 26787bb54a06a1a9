// What puts the open document away, and the question before it.

#include <utility>

#include "ui3d/studio/files/save_words.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using Answer = SaveFlow::Answer;
using Next = SaveFlow::Next;
using Stage = SaveFlow::Stage;
using To = Departure::To;

// Nothing is lost any more.
void go(Context& context, Memory& memory) {
  const Departure departure = memory.keep.departure();
  StudioState& state = context.state;
  if (departure.to != To::quit) state.selected = 0;
  switch (departure.to) {
    case To::quit:
      state.leave = true;
      break;
    case To::newDocument:
      context.bench.newDocument();
      break;
    case To::file:
      if (departure.import) {
        engine::Workbench::ImportOptions options = *departure.import;
        options.replace = true;
        context.bench.import(departure.file, options);
      } else {
        context.bench.open(departure.file);
      }
      state.remember(departure.file);
      state.shown.firstStart = false;
      break;
    case To::recovered:
      context.bench.recover(*departure.what, departure.how);
      state.shown.firstStart = false;
      break;
  }
}

void run(Context& context, Memory& memory, Next next) {
  if (next == Next::chooseName) {
    const engine::FileState file = context.bench.snapshot()->file;
    openSaveAs(context, memory, file.path.empty() ? std::string() : file.refusal);
  } else if (next == Next::save) {
    context.state.wishes.save = std::filesystem::path();
  } else if (next == Next::go) {
    go(context, memory);
  }
}

std::string_view deed(To to) {
  switch (to) {
    case To::quit:
      return "Argil is left";
    case To::newDocument:
      return "a new one is begun";
    case To::file:
      return "another one is opened";
    case To::recovered:
      return "the other one is recovered";
  }
  return "";
}

}  // namespace

void depart(Context& context, Memory& memory, Departure departure) {
  run(context, memory, memory.keep.want(std::move(departure), context.now));
}

void beginDocument(Context& context, Memory& memory, const std::filesystem::path& file) {
  // A model is looked at first: its unit, its up axis, its size.
  const FileKind* kind = kindOf(file);
  if (kind && kind->imports)
    askModel(memory, file, true, false);
  else
    depart(context, memory, {To::file, file});
}

void drawSave(Context& context, Memory& memory) {
  // In this order: what is not under way at the first look has its result at the second.
  const bool underWay = context.state.wishes.save || !context.bench.idle();
  run(context, memory, memory.keep.follow(context.bench.snapshot()->file, underWay, context.timeS));
  if (memory.keep.stage() == Stage::saving) memory.moves = true;

  const bool asking = memory.keep.stage() == Stage::asking, saving = memory.keep.stage() == Stage::saving;
  bool open = asking || saving;
  if (!kit::beginDialog("Keep", saving ? "Saving" : "Save changes?", 440, 0, &open)) return;
  const engine::FileState& file = context.now.file;
  if (saving) {
    kit::wrapped("Before " + std::string(deed(memory.keep.departure().to)) + ", " + documentName(file) + " is saved.",
                 colours().text);
    kit::gap(6);
    ImGui::SetCursorPosX(ImGui::GetWindowContentRegionMax().x - 110);
    if (kit::button("Stay", kit::Weight::plain, 110)) open = false;
    if (!open) memory.keep.stay();
    kit::endDialog(open);
    return;
  }
  kit::wrapped(documentName(file) + " has changes that no file holds. Save them before " +
                   std::string(deed(memory.keep.departure().to)) + "?",
               colours().text);
  kit::gap(10);
  constexpr float kWide = 110;
  std::optional<Answer> answer;
  ImGui::SetCursorPosX(ImGui::GetWindowContentRegionMax().x - 3 * kWide - 2 * kGap);
  if (kit::button("Don't save", kit::Weight::danger, kWide)) answer = Answer::dontSave;
  kit::tooltip("What was done since the last save is lost.", "D");
  ImGui::SameLine();
  if (kit::button("Cancel", kit::Weight::plain, kWide)) answer = Answer::cancel;
  kit::tooltip("Nothing happens.", "Escape");
  ImGui::SameLine();
  if (kit::mainButton("Save", kWide)) answer = Answer::save;
  kit::tooltip(file.path.empty() ? "Asks for a name, then goes on." : "Then goes on.", "Enter");
  // Not by the key press that brought the question.
  if (!ImGui::IsWindowAppearing()) {
    for (const ImWchar letter : ImGui::GetIO().InputQueueCharacters)
      if (letter == 'd' || letter == 'D') answer = Answer::dontSave;
  }
  if (!open) answer = Answer::cancel;
  if (answer) open = false;
  kit::endDialog(open);
  if (answer) run(context, memory, memory.keep.answer(*answer, file));
}

}  // namespace argil::studio
