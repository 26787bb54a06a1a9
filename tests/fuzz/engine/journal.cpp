// A journal of steps, painted clay among them, and a stroke that was cut off, damaged anywhere: what is intact is
// recovered and done again, or an Error says why.
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/autosave.h"
#include "engine/session/recovery.h"
#include "engine/tools/tool_table.h"
#include "tests/fuzz/patched_file.h"

namespace {

using namespace argil;

std::string madeJournal() {
  const tests::MemoryFolder folder;
  clay::Grid grid;
  grid.voxelMm = 1;
  engine::AutosaveOptions options;
  options.folder = folder / "journals";
  engine::Autosave autosave(options, [](const std::string& trouble) { tests::require(trouble.empty()); });
  engine::Session session(engine::Document::of(clay::makeSphere(clay::Store::make(), grid, {0, 0, 0}, 5)));
  autosave.begin(session.states(), 0, std::make_shared<engine::DocumentRecords>(), nullptr, "fuzz");
  autosave.flush();
  session.setWatch(&autosave);
  for (int stroke = 0; stroke < 3; ++stroke) {
    engine::Tool tool = engine::standardTool(*engine::findTool(stroke == 1 ? "paint" : "carve"));
    tool.radiusMm = 2;
    session.beginStroke(tool);
    for (int i = 0; i < 5; ++i) {
      engine::PathPoint point{0.01 * i, {double(i), 5, double(stroke)}};
      point.pressure = 0.2 * (i + 1);
      if (stroke == 2) point.rotation = Eigen::Quaterniond(1, 0.1 * i, 0, 0).normalized();
      session.addPoint(point);
    }
    if (stroke < 2) session.endStroke();
    autosave.flush();
  }
  std::string content;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "journals"))
    content = tests::contentOf(entry.path());
  session.setWatch(nullptr);
  return content;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static tests::MemoryFolder folder;
  static const std::string whole = madeJournal();
  const auto path = folder / "input.journal";
  folder.clear();
  tests::ByteInput input(data, size);
  tests::write(path, tests::patched(input, whole));
  try {
    engine::Recovered recovered = engine::recover(path);
    const engine::OpenedDocument& opened = recovered.document;
    tests::require(opened.done < opened.states.size() && opened.states[opened.done].document != nullptr);
    engine::Session session(opened.states, opened.done);
    (void)engine::replay(session, recovered.strokes);
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
