#pragma once
// Documents to keep, and a session whose program crashes: for the tests of keeping and of recovery.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/text/document_text.h"

namespace argil::engine {

namespace fs = std::filesystem;

class SavingRig : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-keeping-" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  static clay::Version ball(double radiusMm = 12) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radiusMm);
  }

  static Document fullDocument() {
    Document document;
    Piece piece;
    piece.name = "Körper \"A\"";
    piece.version = ball();
    piece.pose.translation = {1.25, -3, 1e-9};
    piece.pose.rotation = Eigen::AngleAxisd(0.3, Vec3d(1, 2, 3).normalized());
    piece.colour = {0.1f, 0.2f, 0.3f};
    piece.material.stiffnessNmm = 0.7;
    piece.materials = {{"rubber", piece.material, std::array{0.1f, 0.1f, 0.1f}}, {"", haptics::Material(), {}}};
    document.add(piece);
    Piece hidden;
    hidden.version = ball(5);
    hidden.visible = false;
    hidden.locked = true;
    document.add(hidden);
    Piece copy = document.pieces[0];
    copy.id = 0;
    copy.name.clear();
    document.add(copy);
    Part part;
    auto mesh = std::make_shared<clay::TriangleMesh>();
    mesh->positions = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
    mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    part.mesh = mesh;
    document.add(part);
    Guide plane;
    plane.feel = Guide::Feel::lock;
    document.add(plane);
    Guide curve;
    curve.kind = Guide::Kind::curve;
    curve.pointsMm = {{0, 0, 0}, {1, 2, 3}, {0.1, 0.2, 1e7}};
    curve.closed = true;
    document.add(curve);
    document.symmetry.x = true;
    document.symmetry.pose.translation = {0.5, 0, 0};
    return document;
  }

  // All that a document is, clay by its hash.
  static std::string told(const Document& document) {
    std::vector<ClayKey> clay;
    std::vector<io::RecordId> meshes;
    for (const Piece& piece : document.pieces) clay.push_back({piece.version.hash() >> 12, 0});
    for (const Part& part : document.parts)
      meshes.push_back(part.mesh->positions.size() * 1000 + part.mesh->triangles.size());
    return documentText(document, clay, meshes);
  }

  static void stroke(Session& session, uint64_t seed, bool end = true) {
    Random random(seed);
    Tool tool;
    tool.radiusMm = 2;
    tool.id = std::array{"carve", "add", "smooth"}[seed % 3];
    session.beginStroke(tool);
    Vec3d at = 12 * random.inBall().normalized();
    for (int i = 0; i < 20; ++i) {
      session.addPoint(0.001 * i, at);
      at += 0.5 * random.inBall();
      if (i == 9) session.liftTool();
    }
    if (end) session.endStroke();
  }

  fs::path folder;
};

// A session with an autosave, whose program "crashes": its journal is copied away while it lives.
struct Kept {
  explicit Kept(Document first, const fs::path& journals) : session(std::move(first)) {
    AutosaveOptions options;
    options.folder = journals;
    options.syncS = 0.01;
    autosave = std::make_unique<Autosave>(options, [this](const std::string& text) { trouble = text; });
    autosave->begin(session.states(), 0, documentRecords, nullptr, writer);
    session.setWatch(autosave.get());
  }
  ~Kept() { session.setWatch(nullptr); }
  fs::path crash(const fs::path& to) {
    autosave->flush();
    for (const auto& entry : fs::directory_iterator(journals())) {
      if (entry.path().extension() == ".journal") fs::copy_file(entry.path(), to, fs::copy_options::overwrite_existing);
    }
    return to;
  }
  [[nodiscard]] fs::path journals() const { return folder; }
  fs::path folder;
  Session session;
  std::shared_ptr<DocumentRecords> documentRecords = std::make_shared<DocumentRecords>();
  std::string writer = newWriter();
  std::string trouble;
  std::unique_ptr<Autosave> autosave;
};

}  // namespace argil::engine
