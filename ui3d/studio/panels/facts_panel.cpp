// What the document holds and costs; what the picture costs.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/view/chosen_quality.h"

namespace argil::studio {

namespace {

// draft, balanced, fine; none of them where a row differs.
void presetRow(Context& context) {
  std::vector<std::string_view> names;
  int chosen = -1;
  for (const engine::QualityPreset& preset : engine::qualityPresets()) {
    if (isChosen(preset.id, context.state, *context.now.document)) chosen = int(names.size());
    names.push_back(preset.name);
  }
  if (kit::segmented("preset", names, chosen))
    runAction(context, "quality." + std::string(engine::qualityPresets()[size_t(chosen)].id));
  kit::wrapped(chosen < 0 ? "Set by hand." : std::string(engine::qualityPresets()[size_t(chosen)].help), colours().dim);
}

}  // namespace

void qualityPanel(Context& context, Memory& memory) {
  presetRow(context);
  if (drawRows(pictureRows(), context.state).changed) context.bench.setSurface(context.state.surface);
  drawRows(qualityRows(), context.state.quality);
  engine::Quality quality = chosenQuality(context.state, *context.now.document);
  const auto strokes = strokeQualityRows();
  const auto spacing = strokes.first(1);  // The one that a sculptor knows.
  kit::heading("Strokes");
  if (drawRows(spacing, quality).changed) context.bench.setQuality(quality.strokes);
  const FrameFigures& f = context.state.figures;
  kit::heading("What it costs");
  kit::fact("Frame", kit::written(f.frameMs) + " ms, " + (f.still ? "full picture" : "thinned while moving"));
  kit::fact("Triangles", kit::counted(f.triangles));
  if (!kit::fold("Advanced", memory.qualityOpen, "Limits of strokes and times of each pass, for developers.")) return;
  if (drawRows(strokes.subspan(1), quality).changed) context.bench.setQuality(quality.strokes);
  if (memory.frameMs.size() > 1) {
    std::vector<float> sorted = memory.frameMs;
    std::sort(sorted.begin(), sorted.end());
    kit::fact("p50 · p99",
              kit::written(sorted[sorted.size() / 2]) + " · " + kit::written(sorted[sorted.size() * 99 / 100]) + " ms");
  }
  double most = 0;
  for (const render::PassTime& pass : f.passes) most = std::max(most, pass.us);
  const float width = ImGui::GetContentRegionAvail().x;
  for (const render::PassTime& pass : f.passes) {
    kit::fact(pass.name, kit::written(pass.us / 1000) + " ms");
    kit::bar(most > 0 ? pass.us / most : 0, width, 4);
  }
  kit::gap(4);
  kit::fact("Uploaded", kit::bytes(f.uploadedBytes));
  kit::fact("On the device", kit::bytes(f.deviceBytes));
  kit::fact("Sample to screen", kit::written(f.sampleToScreenMs) + " ms");
  if (!f.deviceName.empty()) kit::wrapped(f.deviceName, colours().dim);
}

void factsPanel(Context& context, Memory& memory) {
  const engine::Snapshot& now = context.now;
  const engine::Document& document = *now.document;
  uint64_t bricks = 0;
  for (const engine::Piece& piece : document.pieces) bricks += piece.version ? piece.version.stats().bricks : 0;
  const render::Box box = context.renderer.bounds();
  const auto size = [](const Vec3d& s) {
    return kit::written(s.x()) + " × " + kit::written(s.y()) + " × " + kit::written(s.z()) + " mm";
  };
  if (!box.empty()) kit::fact("Size of what is seen", size(box.size()));
  kit::fact("Pieces · parts · guides", std::to_string(document.pieces.size()) + " · " +
                                           std::to_string(document.parts.size()) + " · " +
                                           std::to_string(document.guides.size()));
  kit::fact("Triangles", kit::counted(context.renderer.triangleCount()));
  kit::fact("Clay and undo", kit::bytes(now.clayBytes));
  kit::fact("Steps, done of all",
            std::to_string(now.done) + " of " + std::to_string(now.history ? now.history->size() : 0));
  kit::fact("Undo takes", kit::bytes(now.undo.bytes));
  if (drawRows(undoRows(), context.state).changed) context.bench.setUndoBudget(context.state.undoBytes());
  for (const engine::Piece& piece : document.pieces) {
    kit::heading(piece.name);
    if (!piece.version) continue;
    const clay::VersionStats stats = piece.version.stats();
    if (const render::Box own = context.renderer.bounds(piece.id); !own.empty()) kit::fact("Size", size(own.size()));
    kit::fact("Voxel", kit::written(piece.version.grid().voxelMm) + " mm");
    kit::fact("Memory", kit::bytes(stats.bytes()));
  }
  if (!kit::fold("Advanced", memory.factsOpen, "Counts and times of the document, for developers.")) return;
  kit::fact("Bricks of 512 voxels", kit::counted(bricks));
  kit::fact("Steps in memory · on disk", kit::counted(now.undo.inMemory) + " · " + kit::counted(now.undo.onDisk));
  kit::fact("Strokes · points", kit::counted(now.strokes) + " · " + kit::counted(now.points));
  kit::fact("Versions", kit::counted(now.versions));
  kit::fact("Edit, p50 · p99", kit::written(now.editP50Us / 1000) + " · " + kit::written(now.editP99Us / 1000) + " ms");
}

}  // namespace argil::studio
