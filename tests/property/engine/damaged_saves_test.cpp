// Documents and journals that were cut, flipped or overwritten anywhere: whatever opens is compared with what was made.
// Every piece is what it was at some moment or is told as repaired, with a closed surface; or a sentence says why there
// is nothing.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/session/recovery.h"
#include "engine/text/document_text.h"
#include "io/records/record.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kStrokes = 8;  // the last one is cut off in the journal
constexpr int kPoints = 30;

// All that a document is; `clay` false: but for its clay.
std::string told(const Document& document, bool clay = true) {
  std::vector<ClayKey> keys;
  std::vector<io::RecordId> meshes;
  for (const Piece& piece : document.pieces) keys.push_back({clay ? piece.version.hash() >> 12 : 1, 0});
  for (const Part& part : document.parts) {
    uint64_t sum = part.mesh->triangles.size();
    for (const Vec3d& p : part.mesh->positions) sum = 31 * sum + uint64_t(p.x() + 2 * p.y() + 3 * p.z());
    meshes.push_back(sum % 1000003);
  }
  return documentText(document, keys, meshes);
}

struct ScriptedStroke {
  Tool tool;
  std::vector<Vec3d> points;
};
ScriptedStroke scripted(uint64_t number) {
  Random random(number);
  ScriptedStroke stroke;
  stroke.tool.radiusMm = 2;
  stroke.tool.id = std::array{"carve", "add", "smooth"}[number % 3];
  Vec3d at = 10 * random.inBall().normalized();
  for (int k = 0; k < kPoints; ++k, at += 0.4 * random.inBall()) stroke.points.push_back(at);
  return stroke;
}

void draw(Session& session, const ScriptedStroke& stroke, size_t count) {
  session.beginStroke(stroke.tool);
  for (size_t k = 0; k < count; ++k) session.addPoint(0.001 * double(k), stroke.points[k]);
}

class DamagedSaves : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-damaged-keeping-" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder / "state");
    clay::Grid grid;
    grid.voxelMm = 0.5;
    Document first = Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 10));
    Part part;
    auto mesh = std::make_shared<clay::TriangleMesh>();
    mesh->positions = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
    mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    part.mesh = mesh;
    part.name = "jig";
    first.add(part);
    first.pieces[0].name = "body";
    Piece other;
    other.name = "lid";
    other.version = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 5);
    other.pose.translation = {30, 0, 0};
    first.add(other);
    first.active = first.pieces[0].id;
    AutosaveOptions options;
    options.folder = folder / "state";
    options.syncS = 0.001;
    Autosave autosave(options, [](const std::string& trouble) { EXPECT_EQ(trouble, ""); });
    Session session(std::move(first));
    const auto documentRecords = std::make_shared<DocumentRecords>();
    autosave.begin(session.states(), 0, documentRecords, nullptr, newWriter());
    autosave.flush();
    session.setWatch(&autosave);
    remember(session);
    for (uint64_t i = 0; i < kStrokes; ++i) {
      draw(session, scripted(i), kPoints);
      if (i + 1 < kStrokes) {
        session.endStroke();
        remember(session);
      }
      autosave.flush();
    }
    for (const auto& each : fs::directory_iterator(folder / "state")) journal = bytesOf(each.path());
    session.endStroke();
    remember(session);
    SaveRequest request{session.states(), session.undoSteps(), {}, documentRecords, nullptr, {}, newWriter()};
    (void)saveDocument(folder / "whole.argil", request);
    document = bytesOf(folder / "whole.argil");
    session.setWatch(nullptr);
  }
  void TearDown() override { fs::remove_all(folder); }

  static std::string bytesOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static constexpr size_t kRecordKnownBy = 48;  // Bytes of its head, sums of the rest among them.
  static std::string damaged(std::string bytes, Random& random) {
    const size_t at = random.below(bytes.size());
    switch (random.below(6)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      case 2:
        for (size_t i = at; i < std::min(bytes.size(), at + 1 + random.below(20000)); ++i)
          bytes[i] = static_cast<char>(random.below(256));
        break;
      case 3:
        // Sectors that did not come, or came from elsewhere in the file.
        for (size_t i = at / 512 * 512, from = random.below(bytes.size()) / 512 * 512,
                    end = std::min(bytes.size(), i + 512 * (1 + random.below(16)));
             i < end; ++i, ++from)
          bytes[i] = from < bytes.size() ? bytes[from] : 0;
        break;
      case 4:
        std::fill_n(bytes.begin() + std::ptrdiff_t(at / 512 * 512),
                    std::min<size_t>(bytes.size() - at / 512 * 512, 4096), '\0');
        break;
      default:
        bytes.erase(at, 1 + random.below(5000));
    }
    return bytes;
  }

  void remember(const Session& session) {
    documents.push_back(session.document());
    truth.push_back(told(*session.document()));
    frames.insert(told(*session.document(), false));
    for (const Piece& piece : session.document()->pieces) hashes[piece.id].insert(piece.version.hash());
  }
  [[nodiscard]] bool isTrue(const Document& read) const {
    return std::find(truth.begin(), truth.end(), told(read)) != truth.end();
  }

  // What was repaired: each piece is as it once was, or a note names it; nothing else was made up.
  void expectTrueOrTold(const Document& read, const std::vector<std::string>& notes) const {
    for (const Piece& piece : read.pieces) {
      const auto known = hashes.find(piece.id);
      ASSERT_NE(known, hashes.end()) << piece.name;
      const bool named = std::any_of(notes.begin(), notes.end(),
                                     [&](const std::string& note) { return note.starts_with(piece.name + ":"); });
      EXPECT_TRUE(known->second.contains(piece.version.hash()) || named)
          << piece.name << " is neither what it was nor told as repaired";
    }
    Document whole = read;
    if (read.parts.empty()) {
      EXPECT_TRUE(
          std::any_of(notes.begin(), notes.end(), [](const std::string& note) { return note.starts_with("jig:"); }));
      whole.parts = documents.front()->parts;
    }
    EXPECT_TRUE(frames.contains(told(whole, false))) << told(whole, false);
  }
  static bool isRepaired(const OpenedDocument& opened) {
    return std::any_of(opened.notes.begin(), opened.notes.end(),
                       [](const std::string& note) { return note.find("was repaired") != std::string::npos; });
  }

  // The document that these strokes lead to from one that is true: empty when they are not those that were drawn.
  [[nodiscard]] std::string afterStrokes(const Document& from, const std::vector<JournalStroke>& strokes) const {
    const auto at = std::find(truth.begin(), truth.end(), told(from));
    if (at == truth.end()) return {};
    auto number = size_t(at - truth.begin());
    for (size_t i = 0; i < strokes.size(); ++i, ++number) {
      if (number >= kStrokes) return {};
      const ScriptedStroke drawn = scripted(number);
      std::vector<Vec3d> points;
      for (const JournalPoint& point : strokes[i].points) {
        if (!point.lift) points.push_back(point.point.mm);
      }
      if (strokes[i].tool.id != drawn.tool.id || points.size() > drawn.points.size() ||
          !std::equal(points.begin(), points.end(), drawn.points.begin()))
        return {};
      if (points.size() == drawn.points.size()) continue;
      if (strokes[i].ended || i + 1 < strokes.size()) return {};
      Session session({{.label = {}, .document = documents[number]}}, 0);
      draw(session, drawn, points.size());
      session.endStroke();
      return told(*session.document());
    }
    return truth[number];
  }
  static void expectSound(const Document& read) {
    for (const Piece& piece : read.pieces) {
      clay::Surface surface(false);
      surface.update(piece.version);
      if (surface.quadCount() == 0) continue;
      EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed());
    }
  }
  static size_t rounds() { return tests::byTier(60, 2000); }

  fs::path folder;
  std::string journal, document;
  std::vector<DocumentPtr> documents;       // the first one, and what each stroke led to
  std::vector<std::string> truth;           // all that they are
  std::set<std::string> frames;             // the same without clay
  std::map<Id, std::set<uint64_t>> hashes;  // of each piece, at any moment
};

TEST_F(DamagedSaves, DocumentsOpenOrSayWhy) {
  size_t whole = 0, repaired = 0, refused = 0;
  for (size_t i = 0; i < rounds(); ++i) {
    SCOPED_TRACE(i);
    Random random(1000 + i);
    const fs::path file = folder / "damaged.argil";
    std::ofstream(file, std::ios::binary | std::ios::trunc) << damaged(document, random);
    try {
      const OpenedDocument opened = openDocument(file);
      const Document& now = *opened.states.at(opened.done).document;
      expectSound(now);
      if (opened.notes.empty()) {
        EXPECT_EQ(told(now), truth.back()) << "given for what was saved last";
      } else {
        expectTrueOrTold(now, opened.notes);
      }
      // What is gone back to may be damaged too: then that is said.
      Session session(opened.states, opened.done);
      session.setReader([&](uint64_t kept, const Document& near) {
        return readState(*opened.documentRecords, opened.base, {}, kept, near);
      });
      for (size_t step = 0; step < opened.states.size(); step += 3) {
        try {
          session.goTo(step);
          expectSound(*session.document());
          if (opened.states.size() > 1) {
            EXPECT_EQ(told(*session.document()), truth.at(step)) << step;
          }
        } catch (const Error& e) {
          EXPECT_GT(std::string(e.what()).size(), 10u);
        }
      }
      (opened.notes.empty() ? whole : repaired)++;
    } catch (const Error& e) {
      ++refused;
      EXPECT_NE(std::string(e.what()).find("damaged.argil"), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
  std::printf("  %zu opened as they were or in an undamaged part, %zu repaired, %zu refused with a sentence\n", whole,
              repaired, refused);
  EXPECT_GT(whole + repaired, rounds() / 3);
}

TEST_F(DamagedSaves, JournalsGiveWhatIsIntactOrSayWhy) {
  size_t whole = 0, part = 0, refused = 0;
  for (size_t i = 0; i < rounds(); ++i) {
    SCOPED_TRACE(i);
    Random random(5000 + i);
    const fs::path file = folder / "damaged.journal";
    const std::string bytes = damaged(journal, random);
    // Nothing sound behind the first damage but what was read before it: no reader can tell that from a program that
    // ended there, in sectors that held something older.
    const auto same =
        size_t(std::mismatch(bytes.begin(), bytes.end(), journal.begin(), journal.end()).first - bytes.begin());
    const auto known = [&](size_t at) {
      return std::string_view(bytes).substr(0, same).find(std::string_view(bytes).substr(at, kRecordKnownBy)) !=
             std::string::npos;
    };
    const auto soundFrom = [&](size_t from) { return io::findRecord(std::as_bytes(std::span(bytes)), from); };
    size_t sound = soundFrom(same);
    while (sound < bytes.size() && known(sound)) sound = soundFrom(sound + 1);
    const bool cutOff = sound == bytes.size();
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
    try {
      Recovered recovered = recover(file);
      OpenedDocument& opened = recovered.document;
      const std::vector<std::string> notes = opened.notes;
      const bool repaired = isRepaired(opened);
      for (const HistoryState& state : opened.states) {
        if (!state.document) continue;
        if (repaired) {
          expectTrueOrTold(*state.document, notes);
        } else {
          EXPECT_TRUE(isTrue(*state.document)) << state.label << " never was";
        }
      }
      const std::string expected =
          repaired ? std::string() : afterStrokes(*opened.states.at(opened.done).document, recovered.strokes);
      EXPECT_EQ(replay(recovered), 0u);
      const Document& now = *opened.states.at(opened.done).document;
      expectSound(now);
      if (!repaired) {
        EXPECT_EQ(told(now), expected) << "strokes that were not drawn, or not like this";
      }
      // A file that was cut off looks as if its program had ended earlier.
      if (notes.empty()) {
        EXPECT_TRUE(told(now) == truth.back() || cutOff) << "given for all that there was";
      }
      (notes.empty() ? whole : part)++;
    } catch (const Error& e) {
      ++refused;
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
  std::printf("  %zu gave all that was in them, %zu a part, %zu refused with a sentence\n", whole, part, refused);
  EXPECT_GT(whole + part, rounds() / 3);
}

}  // namespace
}  // namespace argil::engine
