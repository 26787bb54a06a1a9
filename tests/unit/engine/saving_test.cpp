// Documents come back from their files, journals bring back what was not saved.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/saving/thumbnail.h"
#include "engine/session/recovery.h"
#include "engine/text/document_text.h"
#include "io/records/document_file.h"
#include "io/records/journal_file.h"
#include "tests/unit/engine/saving_rig.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;
using Keeping = SavingRig;

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const Error& e) {
    return e.what();
  }
  return "it was done";
}

TEST_F(Keeping, TextComesBackAsItWas) {
  const Document document = fullDocument();
  const std::string text = documentText(document, {{11, 1}, {12, 2}, {11, 1}}, {77});
  const DocumentText read = readDocumentText(text, "it");
  EXPECT_EQ(read.clay, (std::vector<ClayKey>{{11, 1}, {12, 2}, {11, 1}}));
  EXPECT_EQ(read.meshes, (std::vector<io::RecordId>{77}));
  Document filled = read.document;
  for (size_t i = 0; i < 3; ++i) filled.pieces[i].version = document.pieces[i].version;
  EXPECT_EQ(documentText(filled, read.clay, read.meshes), text);
  EXPECT_EQ(read.document.pieces[0].materials, document.pieces[0].materials);
  EXPECT_EQ(text.find("materials", text.find("\"id\":2")), text.find("materials", text.find("\"id\":3")))
      << "what has none says nothing of them";
  for (size_t cut = 0; cut < text.size(); cut += 7)
    EXPECT_THROW((void)readDocumentText(text.substr(0, cut), "it"), Error) << cut;
  for (const auto& [from, to] : {std::pair{"\"active\":1", "\"active\":9"},
                                 {"\"turn\":[1.0", "\"turn\":[0.9"},
                                 {"\"id\":2", "\"id\":1"},
                                 {"\"kind\":\"plane\"", "\"kind\":\"plan\""}}) {
    std::string wrong = text;
    const size_t at = wrong.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    wrong.replace(at, std::string_view(from).size(), to);
    EXPECT_THROW((void)readDocumentText(wrong, "it"), Error) << to;
  }
}

TEST_F(Keeping, ADocumentIsSavedAndOpened) {
  const Document document = fullDocument();
  saveDocument(folder / "a.argil", document);
  const OpenedDocument opened = openDocument(folder / "a.argil");
  EXPECT_TRUE(opened.notes.empty());
  const Document& back = *opened.states.at(opened.done).document;
  EXPECT_EQ(told(back), told(document));
  EXPECT_NE(back.parts[0].felt, nullptr);
  EXPECT_EQ(back.pieces[0].version.store(), back.pieces[2].version.store()) << "copies share their clay again";
}

TEST_F(Keeping, AFileUnderAThirdNameKnowsTheFirst) {
  Session session(fullDocument());
  const auto documentRecords = std::make_shared<DocumentRecords>();
  std::shared_ptr<const Base> base;
  std::vector<uint64_t> stamps;
  for (const char* name : {"a.argil", "b.argil", "c.argil"}) {
    stroke(session, uint64_t(stamps.size()) + 1);
    base = saveDocument(folder / name,
                        {session.states(), session.undoSteps(), {}, documentRecords, base, {}, newWriter()});
    stamps.push_back(base->stamp);
  }
  const auto third = io::DocumentFile::open(folder / "c.argil", false);
  EXPECT_GT(third->sharedWith(stamps[0]), 1u) << "a journal on the first file is not recovered with the third";
  EXPECT_GT(third->sharedWith(stamps[1]), third->sharedWith(stamps[0]));
  EXPECT_EQ(third->sharedWith(stamps[0] + 1), 0u);
}

TEST_F(Keeping, HistoryIsSavedAndGoneBackTo) {
  const fs::path file = folder / "h.argil";
  std::vector<std::string> tale;
  {
    Session session(fullDocument());
    for (uint64_t i = 1; i <= 6; ++i) stroke(session, i);
    session.change("Move", [](Document& d) { d.pieces[0].pose.translation.x() += 1; });
    session.goTo(5);
    SaveRequest request{session.states(), 5,  {"{\"v\":1}", {}}, std::make_shared<DocumentRecords>(),
                        nullptr,          {}, newWriter()};
    const auto base = saveDocument(file, request);
    EXPECT_EQ(base->stamp, io::DocumentFile::open(file, false)->stamp());
    for (const HistoryState& state : session.states()) tale.push_back(told(*state.document));
  }
  OpenedDocument opened = openDocument(file);
  EXPECT_EQ(opened.face.face, "{\"v\":1}");
  ASSERT_EQ(opened.states.size(), 8u);
  EXPECT_EQ(opened.states[7].label, "Move");
  Session session(opened.states, opened.done);
  session.setReader([&](uint64_t kept, const Document& near) {
    return readState(*opened.documentRecords, opened.base, {}, kept, near);
  });
  for (const size_t to : {4u, 0u, 7u, 2u, 5u}) {
    const DocumentPtr before = session.document();
    session.goTo(to);
    EXPECT_EQ(told(*session.document()), tale[to]) << to;
    EXPECT_EQ(session.document()->parts[0].mesh, before->parts[0].mesh)
        << "a mesh is read once, however many steps have it";
    EXPECT_EQ(session.document()->parts[0].felt, before->parts[0].felt);
  }
  // Only what is new is written by the next save.
  const uintmax_t before = fs::file_size(file);
  stroke(session, 40);
  SaveRequest again{session.states(), session.undoSteps(), {}, opened.documentRecords, opened.base, {}, newWriter()};
  const auto base = saveDocument(file, again);
  EXPECT_EQ(io::DocumentFile::open(file, false)->save(), 2u);
  EXPECT_LT(fs::file_size(file) - before, before / 2);
  const OpenedDocument third = openDocument(file);
  EXPECT_EQ(told(*third.states[third.done].document), told(*session.document()));
  EXPECT_EQ(third.face.face, "{\"v\":1}") << "what is not given stays";
  // Another program wrote it meanwhile.
  EXPECT_THROW((void)saveDocument(file, again), Error);
  // Under another name all of it goes along, steps that are not in memory too.
  Session lazy(third.states, third.done);
  SaveRequest other{lazy.states(), lazy.undoSteps(), {}, third.documentRecords, third.base, {}, newWriter()};
  (void)saveDocument(folder / "other.argil", other);
  fs::remove(file);
  OpenedDocument copy = openDocument(folder / "other.argil");
  ASSERT_EQ(copy.states.size(), third.states.size());
  Session walked(copy.states, copy.done);
  walked.setReader(
      [&](uint64_t kept, const Document& near) { return readState(*copy.documentRecords, copy.base, {}, kept, near); });
  walked.goTo(2);
  EXPECT_EQ(told(*walked.document()), tale[2]);
}

TEST_F(Keeping, AJournalBringsBackStepsAndTheStrokeThatWasCutOff) {
  const fs::path journals = folder / "journals";
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  for (uint64_t i = 1; i <= 4; ++i) stroke(kept.session, i);
  kept.session.change(
      "Move", [](Document& d) { d.pieces[0].pose.translation.x() += 1; }, "m");
  kept.session.change(
      "Move", [](Document& d) { d.pieces[0].pose.translation.x() += 1; }, "m");
  kept.session.undo();
  kept.session.undo();
  stroke(kept.session, 9);
  stroke(kept.session, 10, false);
  const fs::path journal = kept.crash(folder / "crashed.journal");
  kept.session.endStroke();

  const Recoverable told1 = examine(journal);
  EXPECT_TRUE(told1.midStroke);
  EXPECT_TRUE(told1.file.empty());
  EXPECT_EQ(told1.steps, 5u) << "four away from the beginning, and the one that was cut off";
  Recovered recovered = recover(journal);
  EXPECT_TRUE(recovered.document.notes.empty());
  ASSERT_EQ(recovered.strokes.size(), 1u);
  Session session(recovered.document.states, recovered.document.done);
  session.setReader([&](uint64_t id, const Document& near) {
    return readState(*recovered.document.documentRecords, nullptr, recovered.sources, id, near);
  });
  EXPECT_EQ(replay(session, recovered.strokes), 0u);
  EXPECT_EQ(told(*session.document()), told(*kept.session.document()));
  EXPECT_EQ(session.history(), kept.session.history());
  for (size_t i = 0; i <= kept.session.undoSteps(); ++i) {
    session.goTo(i);
    kept.session.goTo(i);
    EXPECT_EQ(told(*session.document()), told(*kept.session.document())) << i;
  }
  EXPECT_EQ(kept.trouble, "");
}

TEST_F(Keeping, RecoveryGoesOnInAJournalOfItsOwn) {
  const fs::path journals = folder / "journals";
  fs::path journal;
  std::string wanted;
  {
    Kept kept(fullDocument(), journals);
    kept.folder = journals;
    for (uint64_t i = 1; i <= 3; ++i) stroke(kept.session, i);
    journal = kept.crash(folder / "first.journal");
    wanted = told(*kept.session.document());
  }
  EXPECT_TRUE(fs::is_empty(journals)) << "who ends orderly leaves none";
  fs::rename(journal, journals / "1.journal");
  std::vector<Recoverable> found = recoverable(journals);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].steps, 3u);
  Recovered recovered = recover(found[0].journal);
  EXPECT_THROW((void)recover(found[0].journal), Error) << "one at a time";
  {
    AutosaveOptions options;
    options.folder = journals;
    Autosave autosave(options, [](const std::string&) {});
    Session session(recovered.document.states, recovered.document.done);
    autosave.begin(recovered.document.states, recovered.document.done, recovered.document.documentRecords, nullptr,
                   recovered.writer, std::move(recovered.continued));
    session.setWatch(&autosave);
    stroke(session, 77);
    autosave.flush();
    wanted = told(*session.document());
    EXPECT_FALSE(fs::exists(journals / "1.journal"));
    session.setWatch(nullptr);
    autosave.leave();
  }
  found = recoverable(journals);
  ASSERT_EQ(found.size(), 1u);
  Recovered again = recover(found[0].journal);
  EXPECT_EQ(told(*again.document.states[again.document.done].document), wanted);
  EXPECT_EQ(again.document.states.size(), 5u) << "with the history of both";
}

// Recovered, and another document opened before the journal of busy records has begun anew: nothing is left
// to be recovered once more.
TEST_F(Keeping, ARecoveredDocumentThatIsLeftAtOnceIsNotOfferedAgain) {
  const fs::path journals = folder / "journals";
  {
    Kept kept(fullDocument(), journals);
    kept.folder = journals;
    stroke(kept.session, 1);
    kept.crash(folder / "first.journal");
  }
  fs::rename(folder / "first.journal", journals / "1.journal");
  Recovered recovered = recover(journals / "1.journal");
  AutosaveOptions options;
  options.folder = journals;
  Autosave autosave(options, [](const std::string&) {});
  const std::shared_ptr<DocumentRecords> documentRecords = recovered.document.documentRecords;
  DocumentRecords::Lock busy = documentRecords->lock();
  autosave.begin(recovered.document.states, recovered.document.done, documentRecords, nullptr, recovered.writer,
                 std::move(recovered.continued));
  std::vector<HistoryState> other(1);
  other[0].document = std::make_shared<const Document>(fullDocument());
  autosave.begin(other, 0, std::make_shared<DocumentRecords>(), nullptr, "another");
  busy.unlock();
  autosave.flush();
  autosave.leave();
  EXPECT_FALSE(fs::exists(journals / "1.journal"));
  EXPECT_EQ(recoverable(journals).size(), 0u) << "nothing was done to the other one";
}

TEST_F(Keeping, ClayOfSixteenBitsStaysSo) {
  Document document;
  Piece piece;
  clay::Grid grid;
  grid.voxelMm = 0.5;
  piece.version = clay::makeSphere(clay::Store::make(clay::Precision::fixed16), grid, Vec3d::Zero(), 8);
  document.add(piece);
  const fs::path file = folder / "fixed.argil";
  std::vector<HistoryState> states(1);
  states[0].document = std::make_shared<const Document>(document);
  (void)saveDocument(file, {states, 0, {}, std::make_shared<DocumentRecords>(), nullptr, {}, newWriter()});
  const OpenedDocument opened = openDocument(file);
  const clay::Version& read = opened.states[opened.done].document->pieces[0].version;
  EXPECT_EQ(read.stats().precision, clay::Precision::fixed16);
  EXPECT_EQ(read.hash(), piece.version.hash());
}

TEST_F(Keeping, WhatWasSavedNeedsNoRecovery) {
  const fs::path journals = folder / "journals", file = folder / "s.argil";
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  stroke(kept.session, 1);
  SaveRequest request{kept.session.states(), 1, {}, kept.documentRecords, nullptr, {}, kept.writer};
  kept.autosave->saving(file);
  auto base = saveDocument(file, request);
  // Killed between the save and what the journal hears of it.
  fs::create_directories(folder / "a");
  kept.crash(folder / "a" / "1.journal");
  EXPECT_TRUE(recoverable(folder / "a").empty());
  EXPECT_TRUE(fs::is_empty(folder / "a"));
  kept.autosave->saved(base);
  kept.crash(folder / "a" / "2.journal");
  EXPECT_TRUE(recoverable(folder / "a").empty());
  stroke(kept.session, 2);
  kept.crash(folder / "a" / "3.journal");
  EXPECT_LT(fs::file_size(folder / "a" / "3.journal"), fs::file_size(file))
      << "what the file holds is not written again";
  ASSERT_EQ(recoverable(folder / "a").size(), 1u);
  {
    const Recovered recovered = recover(folder / "a" / "3.journal");
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), told(*kept.session.document()));
    EXPECT_EQ(recovered.file, file);
    ASSERT_NE(recovered.document.base, nullptr);
  }
  // Undone to what was saved: nothing to recover either.
  kept.session.undo();
  kept.crash(folder / "a" / "4.journal");
  EXPECT_EQ(examine(folder / "a" / "4.journal").steps, 0u);
  // The file goes: the journal says what it misses.
  fs::remove(file);
  try {
    (void)recover(folder / "a" / "3.journal");
    FAIL() << "its clay was in the file";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("s.argil"));
  }
}

TEST_F(Keeping, AJournalBegunAnewStandsForTheOneBeforeIt) {
  const fs::path journals = folder / "journals", left = folder / "left";
  fs::create_directories(left);
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  stroke(kept.session, 1);
  kept.crash(left / "000000000000001.journal");
  stroke(kept.session, 2);
  SaveRequest request{kept.session.states(), 2, {}, kept.documentRecords, nullptr, {}, kept.writer};
  kept.autosave->saved(saveDocument(folder / "x.argil", request));
  stroke(kept.session, 3);
  kept.crash(left / "000000000000002.journal");
  // And the beginning of one that never was.
  std::ofstream(left / "000000000000003.journal", std::ios::binary)
      << std::ifstream(left / "000000000000001.journal", std::ios::binary).rdbuf();
  fs::resize_file(left / "000000000000003.journal", 5000);
  const std::vector<Recoverable> found = recoverable(left);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].journal, left / "000000000000002.journal");
  EXPECT_EQ(found[0].steps, 1u);
  EXPECT_EQ(std::distance(fs::directory_iterator(left), {}), 1);
}

TEST_F(Keeping, WorkIsSavedThoughItsFileIsGoneOrNotOursAnyMore) {
  const fs::path file = folder / "f.argil", other = folder / "o.argil";
  Session session(fullDocument());
  stroke(session, 1);
  const auto documentRecords = std::make_shared<DocumentRecords>();
  const std::string writer = newWriter();
  const auto base = saveDocument(file, {session.states(), 1, {}, documentRecords, nullptr, {}, writer});
  stroke(session, 2);
  const SaveRequest request{session.states(), 2, {}, documentRecords, base, {}, writer};
  const auto expectAll = [&](const fs::path& saved) {
    const OpenedDocument opened = openDocument(saved);
    EXPECT_TRUE(opened.notes.empty());
    EXPECT_EQ(told(*opened.states.at(opened.done).document), told(*session.document()));
    EXPECT_EQ(opened.states.size(), 3u);
  };
  // Somebody else saved under its name, and has saved once too: refused in place, whole under another name, and no step
  // is read from it.
  saveDocument(file, Document::of(ball(3)));
  ASSERT_EQ(io::DocumentFile::open(file, false)->save(), 1u);
  EXPECT_THAT(refusal([&] { (void)saveDocument(file, request); }),
              AllOf(HasSubstr("f.argil"), HasSubstr("save under another name")));
  EXPECT_EQ(told(*openDocument(file).states[0].document), told(Document::of(ball(3)))) << "it was written to";
  (void)saveDocument(other, request);
  expectAll(other);
  EXPECT_THROW((void)readState(*documentRecords, base, {}, base->state, *session.document()), Error);
  // Deleted: made again, or saved elsewhere.
  fs::remove(file);
  (void)saveDocument(file, request);
  expectAll(file);
  fs::remove(file);
  fs::remove(other);
  (void)saveDocument(other, request);
  expectAll(other);
  // No document any more: elsewhere.
  std::ofstream(file) << "something else";
  fs::remove(other);
  (void)saveDocument(other, request);
  expectAll(other);
}

// A window that has a document open, with what it needs to save it.
struct Opened {
  explicit Opened(const fs::path& file)
      : document(openDocument(file)), session(document.states, document.done), base(document.base) {
    session.setReader([this](uint64_t kept, const Document& near) {
      return readState(*document.documentRecords, base, {}, kept, near);
    });
  }
  void save(const fs::path& file) {
    base = saveDocument(file, {session.states(), session.undoSteps(), {}, document.documentRecords, base, {}, writer});
  }
  OpenedDocument document;
  Session session;
  std::shared_ptr<const Base> base;
  std::string writer = newWriter();
};

TEST_F(Keeping, OfTwoWindowsWithOneDocumentTheSecondToSaveNeedsAnotherName) {
  const fs::path file = folder / "x.argil";
  saveDocument(file, fullDocument());
  Opened first(file), second(file);
  stroke(first.session, 1);
  stroke(second.session, 2);
  second.save(file);
  EXPECT_THAT(refusal([&] { first.save(file); }), HasSubstr("another name"));
  first.save(folder / "y.argil");
  // What both began with is read from the file still, though the other one saved into it; what the other one made never
  // is.
  const std::string other = told(*second.session.document());
  first.session.goTo(0);
  EXPECT_EQ(told(*first.session.document()), told(fullDocument()));
  EXPECT_EQ(told(*Opened(file).session.document()), other);
  // Under its new name it goes on.
  stroke(first.session, 3);
  first.save(folder / "y.argil");
  EXPECT_EQ(told(*Opened(folder / "y.argil").session.document()), told(*first.session.document()));
}

TEST_F(Keeping, AFileThatWasPutBackFromACopyIsNotWrittenInto) {
  const fs::path file = folder / "x.argil", older = folder / "older", newer = folder / "newer";
  saveDocument(file, fullDocument());
  fs::copy_file(file, older);
  Opened window(file);
  stroke(window.session, 1);
  window.save(file);
  fs::copy_file(file, newer);
  stroke(window.session, 2);
  for (const bool renamed : {false, true}) {
    fs::copy_file(older, renamed ? folder / "new" : file, fs::copy_options::overwrite_existing);
    if (renamed) fs::rename(folder / "new", file);
    EXPECT_THAT(refusal([&] { window.save(file); }), HasSubstr("another name"));
    EXPECT_EQ(told(*Opened(file).session.document()), told(fullDocument()));
  }
  // A copy of the very save is as good as the file.
  fs::copy_file(newer, file, fs::copy_options::overwrite_existing);
  window.save(file);
  EXPECT_EQ(told(*Opened(file).session.document()), told(*window.session.document()));
}

TEST_F(Keeping, TheOtherNameOfAFileKeepsWhatItHas) {
  const fs::path file = folder / "x.argil", link = folder / "link.argil";
  saveDocument(file, fullDocument());
  fs::create_hard_link(file, link);
  Opened first(file), second(link);
  stroke(first.session, 1);
  stroke(second.session, 2);
  first.save(file);
  EXPECT_EQ(told(*Opened(link).session.document()), told(fullDocument()));
  second.save(link);
  stroke(first.session, 3);
  first.save(file);
  EXPECT_EQ(told(*Opened(file).session.document()), told(*first.session.document()));
  EXPECT_EQ(told(*Opened(link).session.document()), told(*second.session.document()));
}

TEST_F(Keeping, AJournalReadsOfItsFileOnlyWhatThatHadThen) {
  const fs::path journals = folder / "journals", file = folder / "s.argil";
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  kept.autosave->saved(
      saveDocument(file, {kept.session.states(), 0, {}, kept.documentRecords, nullptr, {}, kept.writer}));
  stroke(kept.session, 1);
  const fs::path journal = kept.crash(folder / "1.journal");
  // Another window saved into the file: all is there still, and saved elsewhere.
  Opened window(file);
  for (uint64_t i = 20; i < 24; ++i) stroke(window.session, i);
  window.save(file);
  {
    const Recovered recovered = recover(journal);
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), told(*kept.session.document()));
    EXPECT_EQ(recovered.document.base, nullptr);
    ASSERT_FALSE(recovered.document.notes.empty());
    EXPECT_THAT(recovered.document.notes.front(), HasSubstr("another name"));
    // New records must not get ids that those in the file have.
    Session session(recovered.document.states, recovered.document.done);
    stroke(session, 30);
    (void)saveDocument(folder / "r.argil", {session.states(),
                                            session.undoSteps(),
                                            {},
                                            recovered.document.documentRecords,
                                            nullptr,
                                            recovered.sources,
                                            recovered.writer});
    EXPECT_EQ(told(*Opened(folder / "r.argil").session.document()), told(*session.document()));
  }
  // Another document has the name: none of its clay comes in, and it is said.
  Document other = Document::of(ball(9));
  for (int i = 0; i < 3; ++i) other.add(Piece(fullDocument().pieces[0]));
  saveDocument(file, other);
  EXPECT_THAT(refusal([&] { (void)recover(journal); }), AllOf(HasSubstr("s.argil"), HasSubstr("replaced")));
}

TEST_F(Keeping, AJournalHoldsAllOnceItsFileIsAnothersOrGone) {
  const fs::path journals = folder / "journals", file = folder / "s.argil";
  for (const bool removed : {false, true}) {
    Kept kept(fullDocument(), journals);
    kept.folder = journals;
    stroke(kept.session, 1);
    kept.autosave->saved(
        saveDocument(file, {kept.session.states(), 1, {}, kept.documentRecords, nullptr, {}, kept.writer}));
    stroke(kept.session, 2);
    kept.autosave->flush();
    if (removed)
      fs::remove(file);
    else
      saveDocument(file, Document::of(ball(9)));
    // Nothing more is made: the file is looked after all the same.
    const fs::path journal = kept.crash(folder / "1.journal");
    const Recovered recovered = recover(journal);
    EXPECT_EQ(recovered.document.states.size(), 3u);
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), told(*kept.session.document()));
    fs::remove(journal);
  }
}

TEST_F(Keeping, ALongHistoryKeepsItsPlaces) {
  const fs::path journals = folder / "journals";
  Kept kept(Document::of(ball(5)), journals);
  kept.folder = journals;
  for (int i = 0; i < 130; ++i)
    kept.session.change("Move " + std::to_string(i), [](Document& d) { d.pieces[0].pose.translation.x() += 1; });
  kept.autosave->flush();
  kept.session.goTo(121);
  const Recovered recovered = recover(kept.crash(folder / "l.journal"));
  EXPECT_EQ(recovered.document.states[recovered.document.done].document->pieces[0].pose.translation.x(), 121);
  EXPECT_EQ(recovered.document.states[recovered.document.done].label, "Move 120");
  EXPECT_EQ(recovered.document.states.size() - recovered.document.done, 10u) << "what can be redone";
}

TEST_F(Keeping, AJournalThatCannotBeWrittenIsToldAndTriedAgain) {
  const fs::path journals = folder / "journals";
  std::ofstream(folder / "journals").put('x');  // a file where the folder should be
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  stroke(kept.session, 1);
  kept.autosave->flush();
  EXPECT_THAT(kept.trouble, HasSubstr("journal"));
  fs::remove(journals);
  stroke(kept.session, 2, false);
  kept.autosave->flush();
  EXPECT_EQ(kept.trouble, "");
  const Recovered recovered = recover(kept.crash(folder / "c.journal"));
  EXPECT_EQ(recovered.strokes.size(), 1u);
  kept.session.endStroke();
  Session session(recovered.document.states, recovered.document.done);
  replay(session, recovered.strokes);
  EXPECT_EQ(told(*session.document()), told(*kept.session.document()));
}

TEST_F(Keeping, TheFacesPictureStaysWithTheFileUntilThereIsAnother) {
  Session session(fullDocument());
  SaveRequest request;
  request.documentRecords = std::make_shared<DocumentRecords>();
  request.writer = newWriter();
  const fs::path file = folder / "a.argil";
  const auto save = [&](std::vector<std::byte> thumbnail) {
    request.states = session.states();
    request.done = session.undoSteps();
    request.face.thumbnail = std::move(thumbnail);
    request.base = saveDocument(file, request);
  };
  // Longer than one record.
  const auto picture = [](size_t bytes, int seed) {
    std::vector<std::byte> result(bytes);
    for (size_t i = 0; i < bytes; ++i) result[i] = std::byte((i * 7 + size_t(seed)) & 0xff);
    return result;
  };
  save(picture(200'000, 1));
  EXPECT_EQ(thumbnailOf(file), picture(200'000, 1));
  for (uint64_t i = 1; i <= 3; ++i) {
    stroke(session, i);
    save({});
    EXPECT_EQ(thumbnailOf(file), picture(200'000, 1)) << i;
    EXPECT_EQ(openDocument(file).face.thumbnail, picture(200'000, 1)) << i;
  }
  stroke(session, 4);
  save(picture(1'000, 2));
  EXPECT_EQ(thumbnailOf(file), picture(1'000, 2));
  stroke(session, 5);
  save({});
  EXPECT_EQ(thumbnailOf(file), picture(1'000, 2));
}

}  // namespace
}  // namespace argil::engine
