// Documents that go to others and come from others: a copy without history holds nothing of it, and what a newer Argil
// wrote is read and never written over.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/models/load_document.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/session/workbench.h"
#include "io/records/blob.h"
#include "io/records/document_facts.h"
#include "io/records/document_file.h"
#include "io/records/sqlite.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class Sharing : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-sharing-" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  static std::string bytesOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static void stroke(Session& session, uint64_t seed, const char* tool) {
    Random random(seed);
    Tool in;
    in.radiusMm = 2;
    in.id = tool;
    session.beginStroke(in);
    Vec3d at = 10 * random.inBall().normalized();
    for (int i = 0; i < 20; ++i, at += 0.5 * random.inBall()) session.addPoint(0.001 * i, at);
    session.endStroke();
  }

  // Three steps, of which the last one is undone; the newest document stands on the second.
  void saveWithHistory(const fs::path& file) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    Document first = Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 10));
    Piece secret;
    secret.name = "SecretPiece";
    secret.version = clay::makeSphere(clay::Store::make(), grid, Vec3d(30, 0, 0), 4);
    first.add(secret);
    Session session(std::move(first));
    stroke(session, 1, "carve");
    session.change("RemoveTheSecret", [](Document& document) { document.pieces.pop_back(); });
    stroke(session, 2, "add");
    session.undo();
    newest = session.document();
    (void)saveDocument(
        file,
        {session.states(), session.undoSteps(), {}, std::make_shared<DocumentRecords>(), nullptr, {}, newWriter()});
  }

  static json blob(io::RecordSource& source, io::BlobKind kind, io::RecordId id) {
    const std::vector<std::byte> bytes = io::getBlob(kind, id, source, size_t{1} << 20);
    return json::parse(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }

  enum class In { nothing, head, newest, older };
  // As a newer Argil would leave it: with a key that is not known, in a file of a later schema.
  static void addKey(const fs::path& path, In where, int schema) {
    {
      const auto file = io::DocumentFile::open(path, true);
      json head = blob(*file, io::BlobKind::head, file->head());
      io::RecordIds ids;
      ids.atLeast(file->nextId());
      io::RecordSet held = file->held();
      const auto transaction = file->begin();
      const auto put = [&](io::BlobKind kind, const json& value) {
        const std::string text = value.dump();
        return io::putBlob(kind, std::as_bytes(std::span(text)), ids, held, *transaction);
      };
      if (where == In::head) head["mood"] = "cheerful";
      if (where == In::newest || where == In::older) {
        json& entry = head["states"][where == In::newest ? head["done"].get<size_t>() : 0]["id"];
        json state = blob(*file, io::BlobKind::state, entry.get<uint64_t>());
        state["pieces"][0]["glaze"] = 0.5;
        state["pieces"][0]["grid"]["warp"] = {1, 2};
        entry = put(io::BlobKind::state, state);
      }
      const io::RecordId id = put(io::BlobKind::head, head);
      transaction->commit(id, ids.next());
    }
    io::Database database(path, "it");
    io::DocumentFacts facts = io::readFacts(database, "it");
    facts.schema = schema;
    io::writeFacts(database, facts, "it");
  }

  static std::string refusal(const std::function<void()>& what) {
    try {
      what();
    } catch (const Error& e) {
      return e.what();
    }
    return "it was done";
  }

  fs::path folder;
  DocumentPtr newest;
};

TEST_F(Sharing, ACopyWithoutHistoryHoldsNothingThatWasTakenOut) {
  const fs::path file = folder / "all.argil", copy = folder / "copy.argil";
  saveWithHistory(file);
  const OpenedDocument opened = openDocument(file);
  EXPECT_EQ(opened.steps, 3u);
  saveDocument(copy, *opened.states[opened.done].document);
  const OpenedDocument back = openDocument(copy);
  EXPECT_EQ(back.steps, 0u);
  ASSERT_EQ(back.states.size(), 1u);
  EXPECT_EQ(back.states[0].document->pieces[0].version.hash(), newest->pieces[0].version.hash());

  // Every record that is somewhere in the bytes of the copy is one that the document needs.
  const auto inCopy = io::DocumentFile::open(copy, false);
  io::RecordSet live;
  {
    DocumentRecords documentRecords;
    documentRecords.mark(*inCopy, back.states[0].kept, live);
  }
  io::markBlob(*inCopy, inCopy->head(), live);
  const io::RecordSet held = inCopy->held();
  for (io::RecordId id = 1; id < inCopy->nextId(); ++id) EXPECT_EQ(held.contains(id), live.contains(id)) << id;
  const std::string bytes = bytesOf(copy);
  const auto scanned = std::as_bytes(std::span(bytes));
  size_t found = 0;
  for (size_t at = 0; (at = io::findRecord(scanned, at)) < scanned.size(); ++found) {
    const auto record = io::parseRecord(scanned.subspan(at));
    ASSERT_TRUE(record);
    EXPECT_TRUE(live.contains(record->header.id)) << "there are more than its tables say";
    at += record->whole.size();
  }
  EXPECT_GT(found, 100u);
  // sqlite.org/fileformat2.html, "The Database Header": the number of free pages.
  EXPECT_EQ(bytes.substr(36, 4), std::string(4, '\0'));
  for (const char* word : {"SecretPiece", "RemoveTheSecret", "Carve", "Add"})
    EXPECT_EQ(bytes.find(word), std::string::npos) << word;

  // Of the records of the whole document those that the newest state does not need are not there, whatever they are
  // called.
  const auto inFile = io::DocumentFile::open(file, false);
  io::RecordSet kept;
  {
    DocumentRecords documentRecords;
    documentRecords.mark(*inFile, opened.states[opened.done].kept, kept);
  }
  const io::RecordSet all = inFile->held();
  size_t gone = 0, shared = 0;
  std::vector<std::byte> record;
  for (io::RecordId id = 1; id < inFile->nextId(); ++id) {
    if (!all.contains(id) || !inFile->get(id, record)) continue;
    const auto parsed = io::parseRecord(record);
    ASSERT_TRUE(parsed);
    if (parsed->header.kind != io::RecordKind::brick) continue;
    const std::string body(reinterpret_cast<const char*>(parsed->body.data()), parsed->body.size());
    const bool there = bytes.find(body) != std::string::npos;
    if (kept.contains(id)) {
      EXPECT_TRUE(there) << "this test would not find a brick";
      ++shared;
    } else {
      EXPECT_FALSE(there) << "brick " << id << " was taken out";
      ++gone;
    }
  }
  EXPECT_GT(gone, 20u);
  EXPECT_GT(shared, 20u);
  // It grew from nothing that anybody else has.
  EXPECT_TRUE(inCopy->lineage().empty());
  EXPECT_EQ(inCopy->sharedWith(inFile->stamp()), 0u);
}

TEST_F(Sharing, WhatANewerArgilWroteIsOpenedForReadingOnly) {
  const int newer = io::kDocumentSchema + 1;
  for (const In where : {In::head, In::newest, In::older}) {
    SCOPED_TRACE(int(where));
    const fs::path file = folder / ("newer" + std::to_string(int(where)) + ".argil");
    saveWithHistory(file);
    addKey(file, where, newer);
    const std::string before = bytesOf(file);
    const OpenedDocument opened = openDocument(file);
    EXPECT_TRUE(opened.notes.empty());
    EXPECT_THAT(opened.readOnly, AllOf(HasSubstr("newer Argil"), HasSubstr("reading only"), HasSubstr("another name"),
                                       HasSubstr(where == In::head ? "mood" : "pieces[0].glaze")));
    EXPECT_EQ(opened.readOnly.find("unknown key"), std::string::npos);
    EXPECT_EQ(opened.base, nullptr);
    EXPECT_EQ(opened.steps, 3u);
    ASSERT_EQ(opened.states.size(), 1u);
    EXPECT_EQ(opened.states[0].document->pieces[0].version.hash(), newest->pieces[0].version.hash());
    const LoadedDocument loaded = loadDocument(file, {});
    ASSERT_EQ(loaded.notes.size(), 1u);
    EXPECT_EQ(loaded.notes[0], opened.readOnly);
    // Under another name it is a document of this Argil.
    const fs::path other = folder / "other.argil";
    (void)saveDocument(other, {opened.states, 0, {}, opened.documentRecords, opened.base, {}, newWriter()});
    const OpenedDocument ours = openDocument(other);
    EXPECT_EQ(ours.readOnly, "");
    EXPECT_EQ(ours.states[0].document->pieces[0].version.hash(), newest->pieces[0].version.hash());
    EXPECT_EQ(bytesOf(file), before);
    fs::remove(other);
  }
}

TEST_F(Sharing, AWorkbenchSaysThatAFileIsForReadingOnly) {
  const fs::path file = folder / "newer.argil";
  saveWithHistory(file);
  Workbench::Options options;
  options.journal = options.realtime = false;
  Workbench bench(options);
  const auto opens = [&] {
    const uint64_t before = bench.snapshot()->file.opened;
    bench.open(file);
    return until([&] { return bench.snapshot()->file.opened != before && bench.idle(); });
  };
  ASSERT_TRUE(opens());
  EXPECT_EQ(bench.snapshot()->file.readOnly, "");
  addKey(file, In::newest, io::kDocumentSchema + 1);
  ASSERT_TRUE(opens());
  EXPECT_EQ(bench.snapshot()->file.path, file);
  EXPECT_THAT(bench.snapshot()->file.readOnly, HasSubstr("reading only"));
  saveWithHistory(folder / "ours.argil");
  fs::rename(folder / "ours.argil", file);
  ASSERT_TRUE(opens());
  EXPECT_EQ(bench.snapshot()->file.readOnly, "");
}

TEST_F(Sharing, RecordsOfASaveEndWhereThoseOfTheNextBegin) {
  const fs::path file = folder / "grows.argil";
  saveWithHistory(file);
  OpenedDocument opened = openDocument(file);
  const std::shared_ptr<const Base> base = opened.base;
  Session session(opened.states, opened.done);
  stroke(session, 9, "add");
  (void)saveDocument(file, {session.states(), session.undoSteps(), {}, opened.documentRecords, base, {}, newWriter()});
  std::vector<std::byte> record;
  ASSERT_TRUE(io::DocumentFile::open(file, false)->get(base->next, record)) << "the next save begins with it";
  const std::shared_ptr<io::RecordSource> records = recordsOf(base);
  EXPECT_TRUE(records->get(base->next - 1, record));
  EXPECT_FALSE(records->get(base->next, record));
}

TEST_F(Sharing, ANewerFileInWhichAllIsUnderstoodIsOneToWorkIn) {
  const fs::path file = folder / "newer.argil";
  saveWithHistory(file);
  addKey(file, In::nothing, io::kDocumentSchema + 1);
  const OpenedDocument opened = openDocument(file);
  EXPECT_EQ(opened.readOnly, "");
  ASSERT_EQ(opened.states.size(), 4u);
  Session session(opened.states, opened.done);
  stroke(session, 5, "add");
  (void)saveDocument(file,
                     {session.states(), session.undoSteps(), {}, opened.documentRecords, opened.base, {}, newWriter()});
  EXPECT_EQ(openDocument(file).steps, 3u);
  EXPECT_EQ(io::DocumentFile::open(file, false)->schema(), io::kDocumentSchema + 1);
}

TEST_F(Sharing, KeysThatNobodyWroteAreAnError) {
  for (const In where : {In::head, In::newest}) {
    const fs::path file = folder / "strange.argil";
    saveWithHistory(file);
    addKey(file, where, io::kDocumentSchema);
    if (where == In::head) {
      EXPECT_THAT(refusal([&] { (void)openDocument(file); }),
                  AllOf(HasSubstr("strange.argil"), HasSubstr("unknown key")));
    } else {
      // Its clay is had back as from a damaged file: nothing is saved over.
      const OpenedDocument opened = openDocument(file);
      EXPECT_EQ(opened.base, nullptr);
      ASSERT_FALSE(opened.notes.empty());
      EXPECT_THAT(opened.notes[0], AllOf(HasSubstr("strange.argil"), HasSubstr("unknown key")));
    }
    fs::remove(file);
  }
}

}  // namespace
}  // namespace argil::engine
