// Saving, opening, recovering: what a workbench does with files of its own.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "engine/session/workbench_state.h"
#include "io/bytes/input.h"
#include "io/records/journal_file.h"

namespace argil::engine {
namespace {

std::filesystem::path journalFolderOf(const Workbench::Options& options) {
  return options.journalFolder.empty() ? io::journalFolder() : options.journalFolder;
}

// Where windows tell each other what they have open.
std::filesystem::path presenceFolderOf(const Workbench::Options& options) {
  return journalFolderOf(options).parent_path() / "open";
}

std::filesystem::path withEnding(std::filesystem::path file) {
  if (file.extension() != ".argil") file += ".argil";
  return file;
}

}  // namespace

void Workbench::State::begin(Document document, bool saved) {
  Begin how;
  how.states = {{.label = {}, .document = std::make_shared<const Document>(std::move(document))}};
  how.saved = saved;
  begin(std::move(how));
}

void Workbench::State::begin(Begin how) {
  if (loop) cutShort("Another document was opened");
  // What may fail comes first: then the document in work stays.
  auto fresh = std::make_unique<Session>(how.states, how.done);
  auto begun = how.documentRecords ? std::move(how.documentRecords) : std::make_shared<DocumentRecords>();
  if (session) session->setWatch(nullptr);
  loop.reset();
  session = std::move(fresh);
  idleTold = keptTold = 0;
  documentRecords = std::move(begun);
  base = std::move(how.base);
  writer = how.writer.empty() ? newWriter() : std::move(how.writer);
  sources = std::move(how.sources);
  continued = std::move(how.continued);
  file = std::move(how.file);
  fileName = std::move(how.name);
  readOnly = std::move(how.readOnly);
  announce();
  if (presence && presence->elsewhere()) tellElsewhere();
  face = how.face.empty() ? nullptr : std::make_shared<const std::string>(std::move(how.face));
  records.reset();
  savedDocument.reset();
  if (how.saved) savedDocument = how.states.at(how.done).document;
  ++opened;
  session->setReader([this](uint64_t kept, const Document& near) { return readSaved(kept, near); });
  if (options.journal || autosave) guardedOnce(autosaveTrouble, [this] { beginSaving(); });
  surfaces.forget();
  historyOf = UINT64_MAX;
  makeLoop();
  latency.clear();
}

void Workbench::State::beginSaving() {
  if (!autosave) makeAutosave();
  records = autosave->begin(session->states(), session->undoSteps(), documentRecords, base, writer,
                            std::exchange(continued, std::nullopt), sources);
  session->setWatch(autosave.get());
  if (options.journal && !finding) findRecoverable();
}

void Workbench::State::makeAutosave() {
  AutosaveOptions keep;
  keep.folder = journalFolderOf(options);
  keep.unnamed = !options.journal;
  autosave = std::make_unique<Autosave>(keep, [this](const std::string& trouble) {
    if (!trouble.empty()) tell(Message::Level::error, trouble);
    const std::lock_guard lock(mutex);
    journalTrouble = trouble;
  });
}

DocumentPtr Workbench::State::readSaved(uint64_t kept, const Document& near) {
  const DocumentPtr document = autosave ? readStep(*autosave, *documentRecords, records, kept, near)
                                        : readState(*documentRecords, base, sources, kept, near);
  if (base && kept == base->state) savedDocument = document;
  return document;
}

// Called between strokes, when steps have come or gone and four times a second.
void Workbench::State::keepUndoBudget() {
  undoOf = session->steps();
  undo = budget.keep(*session, [this](const DocumentPtr& document) { return autosave ? autosave->kept(document) : 0; });
  if (undo.over && !autosave) guardedOnce(autosaveTrouble, [this] { beginSaving(); });
  const auto trouble = [this] {
    const std::lock_guard lock(mutex);
    return !journalTrouble.empty();
  };
  if (!undo.over) {
    undoTold = false;
  } else if (!undoTold && trouble()) {
    undoTold = true;
    tell(Message::Level::warning,
         fmt::format("Undo takes {:.1f} GiB of memory, more than the {:.1f} GiB that it may: steps cannot go to the "
                     "disk while the journal cannot be written. Make room there, or close the document.",
                     std::ldexp(double(undo.bytes), -30), std::ldexp(double(budget.bytes()), -30)));
  }
}

void Workbench::State::findRecoverable() {
  const std::filesystem::path folder = journalFolderOf(options);
  finding = std::make_unique<BackgroundJob>([this, folder](Job&) {
    auto found = std::make_shared<const std::vector<Recoverable>>(engine::recoverable(folder));
    const std::lock_guard lock(mutex);
    recoverable = std::move(found);
  });
}

// Of the file that this document has, by whatever name.
bool Workbench::State::isOwn(const std::filesystem::path& target) const {
  std::error_code ignored;
  return !file.empty() && (target == file || std::filesystem::equivalent(target, file, ignored));
}

void Workbench::State::announce() {
  presence.reset();  // first, or it would be found
  if (!file.empty()) presence.emplace(file, presenceFolderOf(options));
}

void Workbench::State::tellElsewhere() {
  tell(Message::Level::warning,
       fmt::format("{} is open in another window too: only the window that saves first can save under this name.",
                   io::displayName(file)));
}

// Both windows know of each other: the one that was there first finds out here.
void Workbench::State::followPresence() {
  if (!presence) return;
  const bool before = presence->elsewhere();
  if (presence->look() && !before) tellElsewhere();
}

void Workbench::State::requireNotElsewhere(const std::filesystem::path& target) const {
  if (!isOwn(target) && io::DocumentPresence(target, presenceFolderOf(options)).elsewhere()) {
    throw Error(fmt::format("{} is open in another window: save under another name, or close it there first",
                            io::displayName(target)));
  }
}

void Workbench::State::save(std::filesystem::path target, const SaveExtras& extras) {
  if (saving) {
    saveNext = {std::move(target), extras};
    return;
  }
  if (target.empty()) target = file;
  if (target.empty()) throw Error("the document has no file yet: save it under a name");
  target = withEnding(std::move(target));
  const bool own = isOwn(target);
  if (own && !readOnly.empty()) {
    ++refused;
    refusal = readOnly;
    throw Error(readOnly);
  }
  requireNotElsewhere(target);
  auto request = std::make_shared<SaveRequest>();
  request->states = session->states();
  request->done = session->undoSteps();
  // Symmetry is switched without a step: the state in work is the document as it is.
  if (HistoryState& at = request->states[request->done]; at.document != session->document())
    at = {at.label, session->document(), 0};
  request->face = {extras.face, extras.thumbnail};
  request->documentRecords = documentRecords;
  request->base = base;
  request->sources = sources;
  if (records) request->sources = {records};
  request->writer = writer;
  saving = true;
  if (autosave) autosave->saving(target);
  const auto next = [this] {
    saving = false;
    if (auto asked = std::exchange(saveNext, std::nullopt)) save(std::move(asked->first), asked->second);
  };
  begin("Saving " + target.filename().string(),
        [this, request, target, own, next, at = opened](Job& job) -> std::function<void()> {
          const auto failed = [=, this](const std::string& why) {
            if (at == opened) {
              if (own && !why.empty()) {
                ++refused;
                refusal = why;
              }
              if (autosave) autosave->saving({});
            }
            next();
          };
          std::shared_ptr<const Base> made;
          try {
            made = saveDocument(target, *request, &job);
          } catch (const Cancelled&) {
            post([=] { failed({}); });
            throw;
          } catch (const std::exception& e) {
            const std::string why = fmt::format("Not saved: {}", e.what());
            post([=] { failed(why); });
            throw Error(why, Error::Kind::work);
          }
          return [this, request, target, made, at, next] {
            const bool safe = made->unflushed.empty();
            if (safe)
              tell(Message::Level::done, fmt::format("Saved {}.", io::displayName(target)));
            else
              tell(Message::Level::warning, fmt::format("Not safe yet: {}", made->unflushed));
            if (at == opened) {  // else another document is in work by now
              base = made;
              file = target;
              fileName.clear();
              readOnly.clear();
              announce();
              if (!request->face.face.empty()) face = std::make_shared<const std::string>(request->face.face);
              // Until a save is on the disk the document counts as unsaved, and its journal goes on without counting on
              // it.
              if (safe) savedDocument = request->states[request->done].document;
              if (autosave && safe) autosave->saved(made);
            }
            next();
          };
        });
}

void Workbench::save(const SaveExtras& extras) {
  state_->post([s = state_.get(), extras] { s->save({}, extras); });
}

void Workbench::saveAs(const std::filesystem::path& file, const SaveExtras& extras) {
  state_->post([s = state_.get(), file, extras] { s->save(std::filesystem::absolute(file), extras); });
}

void Workbench::State::saveCopy(std::filesystem::path target, const SaveExtras& extras) {
  target = withEnding(std::move(target));
  if (isOwn(target))
    throw Error(fmt::format("{} is the document in work: give the copy another name", io::displayName(target)));
  requireNotElsewhere(target);
  const size_t left = session->undoSteps() + session->redoSteps();
  begin("Saving a copy as " + target.filename().string(),
        [=, this, document = session->document()](Job& job) -> std::function<void()> {
          try {
            saveDocument(target, *document, &job, {extras.face, extras.thumbnail});
          } catch (const Cancelled&) {
            throw;
          } catch (const std::exception& e) {
            throw Error(fmt::format("The copy was not saved: {}", e.what()), Error::Kind::work);
          }
          return [=, this] {
            tell(Message::Level::done, fmt::format("Saved {}: the document as it is, without its {} step{} of history.",
                                                   io::displayName(target), left, left == 1 ? "" : "s"));
          };
        });
}

void Workbench::saveCopy(const std::filesystem::path& file, const SaveExtras& extras) {
  state_->post([s = state_.get(), file, extras] { s->saveCopy(std::filesystem::absolute(file), extras); });
}

void Workbench::openSaved(const std::filesystem::path& file) {
  state_->begin("Opening " + file.filename().string(), [=, s = state_.get()](Job& job) -> std::function<void()> {
    auto opened = std::make_shared<OpenedDocument>(openDocument(std::filesystem::absolute(file), &job));
    return [=, ready = s->prepare(opened->states[opened->done].document->pieces)] {
      State::Begin how;
      how.states = std::move(opened->states);
      how.done = opened->done;
      how.face = std::move(opened->face.face);
      how.documentRecords = std::move(opened->documentRecords);
      how.base = std::move(opened->base);
      how.readOnly = opened->readOnly;
      how.saved = how.base != nullptr || !how.readOnly.empty();
      if (how.saved) how.file = std::filesystem::absolute(file);
      s->begin(std::move(how));
      for (const std::string& note : opened->notes) s->tell(Message::Level::warning, note);
      if (!opened->readOnly.empty()) s->tell(Message::Level::warning, opened->readOnly);
      if (opened->steps > 0) {
        s->tell(Message::Level::done, fmt::format("{} holds {} step{} of its history, and so what was taken out in "
                                                  "them; \"Save a copy without history\" leaves it out.",
                                                  io::displayName(file), opened->steps, opened->steps == 1 ? "" : "s"));
      }
    };
  });
}

std::shared_ptr<const std::vector<Recoverable>> Workbench::recoverable() const {
  const std::lock_guard lock(state_->mutex);
  return state_->recoverable;
}

void Workbench::recover(const Recoverable& what, const RecoverChoice& choice) {
  state_->begin("Recovering", [=, s = state_.get()](Job& job) -> std::function<void()> {
    auto recovered = std::make_shared<Recovered>(engine::recover(what.journal, &job, choice));
    OpenedDocument& document = recovered->document;
    // Before anything takes the journal's place: it goes when a new one with all that came of the strokes is on the
    // disk.
    const size_t leftOut = replay(*recovered, &job);
    return [=, ready = s->prepare(document.states[document.done].document->pieces)] {
      State::Begin how;
      OpenedDocument& from = recovered->document;
      how.states = std::move(from.states);
      how.done = from.done;
      how.documentRecords = std::move(from.documentRecords);
      how.base = std::move(from.base);
      if (how.base)
        how.file = how.base->path;
      else  // It is another file by now, or gone: the work keeps the name, and asks for one when it is saved.
        how.name = recovered->file.filename().string();
      how.writer = recovered->writer;
      how.sources = std::move(recovered->sources);
      how.continued = std::move(recovered->continued);
      s->begin(std::move(how));
      s->tell(Message::Level::done, recovered->sentence);
      for (const std::string& note : from.notes) s->tell(Message::Level::warning, note);
      if (leftOut > 0)
        s->tell(Message::Level::warning, fmt::format("{} stroke{} could not be repeated and {} left out.", leftOut,
                                                     leftOut == 1 ? "" : "s", leftOut == 1 ? "is" : "are"));
      const std::lock_guard lock(s->mutex);
      if (!s->recoverable) return;
      auto left = *s->recoverable;
      std::erase_if(left, [&](const Recoverable& each) { return each.journal == what.journal; });
      s->recoverable = std::make_shared<const std::vector<Recoverable>>(std::move(left));
    };
  });
}

void Workbench::discard(const Recoverable& what) {
  state_->post(
      [s = state_.get(), what] {
        io::JournalReader(what.journal, true).remove();
        const std::lock_guard lock(s->mutex);
        if (!s->recoverable) return;
        auto left = *s->recoverable;
        std::erase_if(left, [&](const Recoverable& each) { return each.journal == what.journal; });
        s->recoverable = std::make_shared<const std::vector<Recoverable>>(std::move(left));
      },
      false);
}

void Workbench::leaveJournal() {
  const std::lock_guard lock(state_->mutex);
  state_->leaveJournal = true;
}

}  // namespace argil::engine
