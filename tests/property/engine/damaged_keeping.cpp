// Documents and journals that were cut, flipped or overwritten anywhere: what is whole opens, with a closed surface, or a sentence says why.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "clay/mesh_topology.h"
#include "clay/primitives.h"
#include "clay/store.h"
#include "clay/surface.h"
#include "engine/keeper.h"
#include "engine/kept_document.h"
#include "engine/random.h"
#include "engine/recovery.h"
#include "engine/session.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

class DamagedKeeping : public testing::Test {
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
    first.add(part);
    KeeperOptions options;
    options.folder = folder / "state";
    options.syncS = 0.001;
    Keeper keeper(options, [](const std::string& trouble) { EXPECT_EQ(trouble, ""); });
    Session session(std::move(first));
    const auto archive = std::make_shared<Archive>();
    keeper.begin(session.states(), 0, archive, nullptr, newWriter());
    keeper.flush();
    session.setWatch(&keeper);
    for (uint64_t i = 0; i < 8; ++i) {
      Random random(i);
      Tool tool;
      tool.radiusMm = 2;
      tool.id = std::array{"carve", "add", "smooth"}[i % 3];
      session.beginStroke(tool);
      Vec3d at = 10 * random.inBall().normalized();
      for (int k = 0; k < 30; ++k, at += 0.4 * random.inBall()) session.addPoint(0.001 * k, at);
      if (i < 7) session.endStroke();
      keeper.flush();
    }
    for (const auto& each : fs::directory_iterator(folder / "state")) journal = bytesOf(each.path());
    session.endStroke();
    SaveRequest request{session.states(), session.undoSteps(), {}, archive, nullptr, {}, newWriter()};
    (void)saveDocument(folder / "whole.argil", request);
    document = bytesOf(folder / "whole.argil");
    session.setWatch(nullptr);
  }
  void TearDown() override { fs::remove_all(folder); }

  static std::string bytesOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static std::string damaged(std::string bytes, Random& random) {
    const size_t at = random.below(bytes.size());
    switch (random.below(4)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      case 2:
        for (size_t i = at; i < std::min(bytes.size(), at + 1 + random.below(20000)); ++i) bytes[i] = static_cast<char>(random.below(256));
        break;
      default:
        bytes.erase(at, 1 + random.below(5000));
    }
    return bytes;
  }
  static void expectSound(const Document& read) {
    for (const Piece& piece : read.pieces) {
      clay::Surface surface(false);
      surface.update(piece.version);
      if (surface.quadCount() == 0) continue;
      EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed());
    }
  }
  static size_t rounds() {
    const char* longer = std::getenv("ARGIL_LONG");
    return longer && *longer == '1' ? 1000 : 120;
  }

  fs::path folder;
  std::string journal, document;
};

TEST_F(DamagedKeeping, documentsOpenOrSayWhy) {
  size_t whole = 0, mended = 0, refused = 0;
  for (size_t i = 0; i < rounds(); ++i) {
    SCOPED_TRACE(i);
    Random random(1000 + i);
    const fs::path file = folder / "damaged.argil";
    std::ofstream(file, std::ios::binary | std::ios::trunc) << damaged(document, random);
    try {
      const OpenedDocument opened = openDocument(file);
      expectSound(*opened.states.at(opened.done).document);
      // What is gone back to may be damaged too: then that is said.
      Session session(opened.states, opened.done);
      session.setReader([&](uint64_t kept, const Document& near) { return readState(*opened.archive, opened.base, {}, kept, near); });
      for (size_t step = 0; step < opened.states.size(); step += 3) {
        try {
          session.goTo(step);
          expectSound(*session.document());
        } catch (const Error& e) {
          EXPECT_GT(std::string(e.what()).size(), 10u);
        }
      }
      (opened.notes.empty() ? whole : mended)++;
    } catch (const Error& e) {
      ++refused;
      EXPECT_NE(std::string(e.what()).find("damaged.argil"), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
  std::printf("  %zu opened as they were or in an undamaged part, %zu mended, %zu refused with a sentence\n", whole, mended, refused);
  EXPECT_GT(whole + mended, rounds() / 3);
}

TEST_F(DamagedKeeping, journalsGiveWhatIsIntactOrSayWhy) {
  size_t whole = 0, part = 0, refused = 0;
  for (size_t i = 0; i < rounds(); ++i) {
    SCOPED_TRACE(i);
    Random random(5000 + i);
    const fs::path file = folder / "damaged.journal";
    std::ofstream(file, std::ios::binary | std::ios::trunc) << damaged(journal, random);
    try {
      Recovered recovered = recover(file);
      Session session(recovered.document.states, recovered.document.done);
      replay(session, recovered.strokes);
      expectSound(*session.document());
      (recovered.document.notes.empty() ? whole : part)++;
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
