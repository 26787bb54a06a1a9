// Saved documents on the command line: made, looked at, drawn, converted, recovered; and what is wrong with a file is
// one line.

#include "tests/e2e/support/command.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "clay/mesh/mesh_topology.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "io/models/model_file.h"

namespace argil::tests {
namespace {

using testing::Test;

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Documents : public Test {
 protected:
  void SetUp() override {
    script = scratch / "s.json";
    write(script, R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":8}}],
      "strokes":[{"tool":"carve","radius_mm":3,"path":[[0,-6,0,8],[1,6,0,8]]},{"tool":"add","radius_mm":2,"path":[[0,0,-8,0]]}]})");
    document = scratch / "d.argil";
    const Outcome made = argil({"sculpt", script.string(), "-o", document.string()});
    ASSERT_EQ(made.code, 0) << made.err;
  }
  Scratch scratch;
  fs::path script, document;
};

TEST_F(Documents, AreInspectedDrawnAndWorkedOn) {
  const Outcome seen = argil({"inspect", document.string()});
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_TRUE(has(seen.out, "2 steps of history") && has(seen.out, "closed      yes")) << seen.out;
  EXPECT_EQ(argil({"render", document.string(), "-o", (scratch / "p.png").string(), "--size", "320x200"}).code, 0);
  EXPECT_GT(fs::file_size(scratch / "p.png"), 1000u);
  // Strokes on what was saved, into another file: the same as all strokes at once, or it would not be what was saved.
  const fs::path more = scratch / "more.json", first = scratch / "first.argil", second = scratch / "second.argil",
                 rest = scratch / "rest.json";
  write(
      more,
      R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":8}}],"strokes":[{"tool":"carve","radius_mm":3,"path":[[0,-6,0,8],[1,6,0,8]]}]})");
  write(rest, R"({"argil":1,"units":"mm","strokes":[{"tool":"add","radius_mm":2,"path":[[0,0,-8,0]]}]})");
  ASSERT_EQ(argil({"sculpt", more.string(), "-o", first.string()}).code, 0);
  const Outcome on = argil({"sculpt", rest.string(), "-i", first.string(), "-o", second.string()});
  ASSERT_EQ(on.code, 0) << on.err;
  const auto hash = [](const fs::path& file) {
    const std::string json = argil({"inspect", "--json", file.string()}).out;
    const size_t at = json.find("\"hash\"");
    return at == std::string::npos ? json : json.substr(at, 30);
  };
  EXPECT_EQ(hash(second), hash(document));
}

// Whoever writes the model, sculpt at once or convert later: the same bytes.
TEST_F(Documents, GoOutTheSameBySculptAndConvert) {
  for (const char* ending : {"stl", "ply", "3mf", "glb", "obj"}) {
    const fs::path at = scratch / (std::string("at-once.") + ending),
                   later = scratch / (std::string("later.") + ending);
    ASSERT_EQ(argil({"sculpt", script.string(), "-o", at.string()}).code, 0);
    ASSERT_EQ(argil({"convert", document.string(), later.string()}).code, 0);
    EXPECT_EQ(slurp(at), slurp(later)) << ending;
  }
}

TEST_F(Documents, GoOutInEveryFormatAndComeBackClosed) {
  for (const char* ending : {"3mf", "stl", "obj", "ply", "glb", "drc", "vdb", "argil"}) {
    const fs::path out = scratch / (std::string("out.") + ending);
    const Outcome made = argil({"convert", document.string(), out.string()});
    ASSERT_EQ(made.code, 0) << ending << ": " << made.err;
    const Outcome seen = argil({"inspect", out.string()});
    EXPECT_EQ(seen.code, 0) << seen.err;
    EXPECT_TRUE(has(seen.out, "closed      yes")) << ending << ": " << seen.out;
  }
  const Outcome copied = argil({"convert", document.string(), (scratch / "copy.argil").string()});
  EXPECT_TRUE(has(copied.out, "without the 2 steps of history")) << copied.out;
  EXPECT_TRUE(has(argil({"inspect", (scratch / "copy.argil").string()}).out, "0 steps of history"));
  const Outcome few = argil({"convert", document.string(), (scratch / "few.3mf").string(), "--reduce", "1000"});
  EXPECT_EQ(few.code, 0) << few.err;
  EXPECT_TRUE(has(few.out, "to 1000 triangles") || has(few.out, "to 998 triangles") || has(few.out, "to 999 triangles"))
      << few.out;
  EXPECT_TRUE(has(argil({"inspect", (scratch / "few.3mf").string()}).out, "closed      yes"));
  EXPECT_EQ(argil({"convert", document.string(), (scratch / "x.stl").string(), "--reduce", "10", "--error", "1"}).code,
            2);
  EXPECT_EQ(argil({"convert", document.string(), (scratch / "x.vdb").string(), "--reduce", "10"}).code, 2);
  EXPECT_EQ(argil({"convert", document.string(), (scratch / "x.vdb").string(), "--recentre"}).code, 2);
  EXPECT_EQ(argil({"convert", document.string(), (scratch / "x.stl").string(), "--draco"}).code, 2);
}

TEST_F(Documents, GoOutForADestination) {
  // As many triangles as a destination may find too many.
  const auto coarse = nlohmann::json::parse(argil({"inspect", document.string(), "--json"}).out);
  const double voxel = double(coarse.at("pieces")[0].at("voxel_mm")) / 4;
  const std::string model = (scratch / "coarse.ply").string(), fine = (scratch / "fine.argil").string();
  ASSERT_EQ(argil({"convert", document.string(), model}).code, 0);
  ASSERT_EQ(argil({"convert", model, fine, "--voxel", std::to_string(voxel)}).code, 0);
  const auto to = [&](const char* name, std::vector<std::string> options) {
    std::vector<std::string> all{"convert", fine, (scratch / name).string()};
    all.insert(all.end(), options.begin(), options.end());
    return argil(all);
  };
  for (const auto& [name, use] : {std::pair{"a.3mf", "slicer"},
                                  {"b.glb", "blender"},
                                  {"c.glb", "game"},
                                  {"d.glb", "web"},
                                  {"e.vdb", "archive"},
                                  {"e.3mf", "archive"}})
    ASSERT_EQ(to(name, {"--for", use}).code, 0) << use;
  EXPECT_LT(fs::file_size(scratch / "d.glb"), fs::file_size(scratch / "b.glb") / 2) << "packed";
  const auto seen = [&](const char* name) {
    const Outcome o = argil({"inspect", (scratch / name).string(), "--json"});
    return nlohmann::json::parse(o.out).at("mesh");
  };
  EXPECT_GT(seen("b.glb").at("triangles"), 100000) << "the document is fine enough for the test";
  EXPECT_LE(seen("c.glb").at("triangles"), 100000);
  EXPECT_NEAR(double(seen("c.glb").at("low_mm")[0]) + double(seen("c.glb").at("high_mm")[0]), 0, 0.01);
  EXPECT_EQ(to("f.stl", {"--for", "game"}).code, 2);
  EXPECT_TRUE(has(to("f.stl", {"--for", "game"}).err, "--for game writes .glb"));
  EXPECT_TRUE(has(to("f.stl", {"--for", "moon"}).err, "slicer, blender, game, web, textured, cad, archive"));
  ASSERT_EQ(to("g.glb", {"--for", "game", "--reduce", "2000"}).code, 0);
  EXPECT_LE(seen("g.glb").at("triangles"), 2000) << "what is said goes before";
}

TEST_F(Documents, WhatImportMovedIsPutBack) {
  write(scratch / "far.obj",
        "v 5e9 0 0\nv 5000000100 0 0\nv 5e9 100 0\nv 5e9 0 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const std::string far = (scratch / "far.obj").string(), out = (scratch / "back.obj").string();
  const std::string kept = (scratch / "kept.argil").string();
  ASSERT_EQ(argil({"convert", far, kept, "--voxel", "2"}).code, 0);
  for (const std::string& from : {far, kept}) {
    std::vector<std::string> words{"convert", from, out, "--put-back", "--overwrite"};
    if (from == far) words.insert(words.end(), {"--voxel", "2"});
    const Outcome made = argil(words);
    ASSERT_EQ(made.code, 0) << made.err;
    const auto mesh = nlohmann::json::parse(argil({"inspect", out, "--json"}).out).at("mesh");
    EXPECT_NEAR(mesh.at("low_mm")[0], 5e9, 3);
    EXPECT_NEAR(mesh.at("high_mm")[0], 5e9 + 100, 6);
  }
  fs::remove(out);
  EXPECT_EQ(argil({"convert", far, out, "--put-back"}).code, 2) << "nothing moves it on the plain way";
  EXPECT_EQ(argil({"convert", kept, (scratch / "x.argil").string(), "--put-back"}).code, 2);
  EXPECT_EQ(argil({"convert", kept, out, "--put-back", "--recentre"}).code, 2);
}

TEST_F(Documents, DamageAndNewerFilesAreOneLine) {
  write(scratch / "no.argil", "nothing of the kind");
  Outcome o = argil({"inspect", (scratch / "no.argil").string()});
  EXPECT_EQ(o.code, 2) << o.err;
  EXPECT_TRUE(has(o.err, "no.argil")) << o.err;
  o = argil({"inspect", (scratch / "gone.argil").string()});
  EXPECT_EQ(o.code, 2) << o.err;
  // A place in the middle of the file: repaired and told.
  std::string bytes = slurp(document);
  for (size_t i = bytes.size() / 2; i < bytes.size() / 2 + 3000; ++i) bytes[i] = '?';
  write(scratch / "hurt.argil", bytes);
  o = argil({"inspect", (scratch / "hurt.argil").string()});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(has(o.out, "closed      yes")) << o.out;
  EXPECT_EQ(slurp(scratch / "hurt.argil"), bytes) << "looking changes nothing";
  // Nothing left to mend.
  write(scratch / "stump.argil", slurp(document).substr(0, 9000));
  o = argil({"inspect", (scratch / "stump.argil").string()});
  EXPECT_EQ(o.code, 2) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

TEST_F(Documents, RecoverListsAndRefuses) {
  setenv("ARGIL_STATE", (scratch / "state").c_str(), 1);
  const Outcome none = argil({"recover"});
  EXPECT_EQ(none.code, 0) << none.err;
  EXPECT_TRUE(has(none.out, "nothing to recover")) << none.out;
  write(scratch / "x.journal", "no journal");
  const Outcome bad = argil({"recover", (scratch / "x.journal").string(), "-o", (scratch / "y.argil").string()});
  EXPECT_NE(bad.code, 0);
  EXPECT_FALSE(fs::exists(scratch / "y.argil"));
  unsetenv("ARGIL_STATE");
}

TEST_F(Documents, RecoverLeavesOutTheLastStrokeAndFindsAMovedFile) {
  const fs::path journals = scratch / "state" / "journal", journal = journals / "1.journal";
  setenv("ARGIL_STATE", (scratch / "state").c_str(), 1);
  {
    // A session that ended by a crash when two strokes were known by their samples alone.
    engine::OpenedDocument opened = engine::openDocument(document);
    engine::AutosaveOptions options;
    options.folder = journals;
    engine::Autosave autosave(options, [](const std::string&) {});
    engine::Session session(opened.states, opened.done);
    autosave.begin(opened.states, opened.done, opened.documentRecords, opened.base, engine::newWriter());
    autosave.flush();
    session.setWatch(&autosave);
    {
      const engine::DocumentRecords::Lock lock = opened.documentRecords->lock();
      for (const double z : {7.0, -7.0}) {
        engine::Tool tool;
        tool.id = "add";
        tool.radiusMm = 2;
        session.beginStroke(tool);
        for (int i = 0; i < 5; ++i) session.addPoint(0.01 * i, {0.3 * i, 0, z});
        session.endStroke();
      }
      autosave.flush();
      for (const auto& each : fs::directory_iterator(journals)) fs::copy_file(each.path(), scratch / "kept");
    }
    session.setWatch(nullptr);
  }
  fs::rename(scratch / "kept", journal);
  const Outcome listed = argil({"recover"});
  EXPECT_EQ(listed.code, 0) << listed.err;
  EXPECT_TRUE(has(listed.out, "2 steps") && has(listed.out, "--without-last")) << listed.out;
  const fs::path all = scratch / "all.argil", without = scratch / "without.argil", moved = scratch / "moved.argil";
  Outcome o = argil({"recover", journal.string(), "-o", all.string()});
  EXPECT_EQ(o.code, 0) << o.err;
  const std::string saved = slurp(document), recovered = slurp(all);
  o = argil({"recover", journal.string(), "-o", all.string()});
  EXPECT_TRUE(o.code == 2 && has(o.err, "all.argil: exists already")) << o.err;
  for (const fs::path& input : {document, journal}) {
    o = argil({"recover", journal.string(), "-o", input.string(), "--overwrite"});
    EXPECT_TRUE(o.code == 2 && has(o.err, "is the input")) << o.err;
  }
  EXPECT_TRUE(slurp(document) == saved && slurp(all) == recovered);
  o = argil({"recover", journal.string(), "-o", without.string(), "--without-last"});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(has(o.out, "left out")) << o.out;
  EXPECT_TRUE(has(argil({"inspect", all.string()}).out, "4 steps of history"));
  EXPECT_TRUE(has(argil({"inspect", without.string()}).out, "3 steps of history"));
  fs::rename(document, moved);
  EXPECT_TRUE(has(argil({"recover"}).out, "--base")) << "the saved file is missing";
  const fs::path back = scratch / "back.argil";
  o = argil({"recover", journal.string(), "-o", back.string()});
  EXPECT_EQ(o.code, 1);
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  o = argil({"recover", journal.string(), "-o", back.string(), "--base", all.string()});
  EXPECT_EQ(o.code, 2) << "another document";
  EXPECT_FALSE(fs::exists(back));
  o = argil({"recover", journal.string(), "-o", back.string(), "--base", moved.string()});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(has(argil({"inspect", back.string()}).out, "4 steps of history"));
  // The clay is in the saved file alone: the journal has nothing that could be repaired, and says so.
  o = argil({"recover", journal.string(), "-o", (scratch / "repaired.argil").string(), "--repair"});
  EXPECT_EQ(o.code, 2);
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_FALSE(fs::exists(scratch / "repaired.argil"));
  unsetenv("ARGIL_STATE");
}

// Straight from one mesh format to another: each triangle of this PLY has corners of its own.
TEST(ConvertedMeshes, LooseTrianglesOfAPlyAreOneBodyOfA3mf) {
  const Scratch scratch;
  std::ofstream ply(scratch / "loose.ply");
  ply << "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n0 9 0\n9 0 0\n0 0 0\n9 0 0\n0 0 9\n0 0 0\n0 0 9\n0 9 0\n9 0 0\n0 9 0\n0 0 9\n"
         "3 0 1 2\n3 3 4 5\n3 6 7 8\n3 9 10 11\n";
  ply.close();
  const Outcome made = argil({"convert", (scratch / "loose.ply").string(), (scratch / "whole.3mf").string()});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("4 triangles, 4 vertices"), std::string::npos) << made.out;
  const io::ModelFile read = io::readModel(scratch / "whole.3mf");
  EXPECT_EQ(read.objects.at(0).mesh.positions.size(), 4u);
  EXPECT_TRUE(clay::checkTopology(read.objects.at(0).mesh).closed());
}

// Two boxes that share a face, as the halves of a cut do: each is closed, and stays so in every format.
TEST(ConvertedMeshes, BodiesThatTouchStayApart) {
  const Scratch scratch;
  std::ofstream obj(scratch / "halves.obj");
  for (int half = 0; half < 2; ++half) {
    obj << "o half" << half << "\n";
    for (int i = 0; i < 8; ++i)
      obj << "v " << 9 * (half + (i & 1)) << ' ' << 7 * (i >> 1 & 1) << ' ' << (i >> 2) << '\n';
    for (const auto& [a, b, c, d] : std::vector<std::array<int, 4>>{
             {1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}})
      obj << "f " << a + 8 * half << ' ' << b + 8 * half << ' ' << c + 8 * half << ' ' << d + 8 * half << '\n';
  }
  obj.close();
  for (const char* ending : {"obj", "3mf", "ply", "glb", "stl"}) {
    const fs::path out = scratch / (std::string("out.") + ending);
    ASSERT_EQ(argil({"convert", (scratch / "halves.obj").string(), out.string()}).code, 0);
    const Outcome seen = argil({"inspect", out.string()});
    EXPECT_NE(seen.out.find("closed      yes: a 2-manifold\n"), std::string::npos) << ending << ": " << seen.out;
    EXPECT_NE(seen.out.find("24 on 16 vertices, 2 bodies"), std::string::npos) << ending << ": " << seen.out;
    EXPECT_EQ(seen.out.find("note"), std::string::npos) << ending << ": " << seen.out;
  }
}

}  // namespace
}  // namespace argil::tests
