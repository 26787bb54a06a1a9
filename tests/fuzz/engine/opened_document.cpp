// Documents with painted and masked clay, damaged anywhere: opened, repaired or refused.
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"
#include "tests/fuzz/patched_file.h"

namespace {

using namespace argil;

std::string madeDocument(const tests::MemoryFolder& folder) {
  clay::Grid grid;
  grid.voxelMm = 1;
  engine::Session session(engine::Document::of(clay::makeSphere(clay::Store::make(), grid, {0, 0, 0}, 5)));
  for (const char* id : {"paint", "mask", "material"}) {
    engine::Tool tool = engine::standardTool(*engine::findTool(id));
    tool.radiusMm = 3;
    session.beginStroke(tool);
    session.addPoint(0, {5, 0, 0});
    session.endStroke();
  }
  const auto path = folder / "whole.argil";
  engine::saveDocument(path, *session.document());
  return tests::contentOf(path);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static tests::MemoryFolder folder;
  static const std::string whole = madeDocument(folder);
  const auto path = folder / "input.argil";
  folder.clear();
  tests::ByteInput input(data, size);
  tests::write(path, tests::patched(input, whole));
  try {
    const engine::OpenedDocument opened = engine::openDocument(path);
    tests::require(opened.done < opened.states.size() && opened.states[opened.done].document != nullptr);
    tests::require(opened.base != nullptr || !opened.notes.empty());
  } catch (const Error& error) {
    tests::requireSentence(error, error.kind());
  }
  return 0;
}
