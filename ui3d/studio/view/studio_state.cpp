#include "ui3d/studio/view/studio_state.h"

#include <algorithm>
#include <cmath>
#include <system_error>

namespace argil::studio {

std::vector<engine::Id> StudioState::selection() const {
  std::vector<engine::Id> all;
  if (selected == 0) return all;
  all.push_back(selected);
  if (alsoSelected.beside == selected) all.insert(all.end(), alsoSelected.ids.begin(), alsoSelected.ids.end());
  return all;
}

bool StudioState::isSelected(engine::Id id) const {
  const std::vector<engine::Id> all = selection();
  return id != 0 && std::find(all.begin(), all.end(), id) != all.end();
}

void StudioState::toggleSelected(engine::Id id) {
  if (id == 0) return;
  std::vector<engine::Id> all = selection();
  if (std::erase(all, id) == 0) all.push_back(id);
  selected = all.empty() ? 0 : all.front();
  alsoSelected = {selected, {}};
  if (!all.empty()) alsoSelected.ids.assign(all.begin() + 1, all.end());
}

engine::Tool& StudioState::tool() {
  const auto found = tools.find(toolId);
  if (found != tools.end()) return found->second;
  const engine::ToolRow* row = engine::findTool(toolId);
  if (!row) {
    row = engine::findTool("carve");
    toolId = row->id;
  }
  return tools.emplace(toolId, newTool(*row)).first->second;
}

namespace {

// What the studio's tools begin with beside their rows' own values, which scripts keep to: a carving stroke by mouse or
// pen is shallow and soft, and a pass of Smooth evens out bumps as coarse as the tip.
constexpr double kSoftByPressure = 0.9, kSoftDepth = 0.25, kBuildUp = 0.2, kEvenOut = 12, kSmoothStrength = 0.75;
constexpr double kRaised = 1.5;  // times the height that a script's tool begins with
constexpr std::string_view kSoftOpposite = "clay";

void scaleLengths(const engine::ToolRow& row, engine::Tool& tool, double factor) {
  for (const auto& parameter : row.parameters)
    if (parameter.unit == "mm") parameter.change(tool, parameter.get(tool) * factor);
}

}  // namespace

engine::Tool StudioState::newTool(const engine::ToolRow& row) const {
  engine::Tool made = engine::standardTool(row);
  if (row.id == "carve") {
    made.soft = true;
    made.strengthByPressure = kSoftByPressure;
    made.depth = kSoftDepth;
  }
  if (row.id == "clay") made.depth = kBuildUp;
  made.heightMm *= kRaised;
  if (row.id == "smooth") made.evenOut = kEvenOut, made.strength = kSmoothStrength;
  if (sizedForMm != kUsualMm) scaleLengths(row, made, sizedForMm / kUsualMm);
  return made;
}

void StudioState::sizeTools(double forMm) {
  if (!(forMm > 0) || !std::isfinite(forMm) || forMm == sizedForMm) return;
  for (auto& [id, each] : tools)
    if (const engine::ToolRow* row = engine::findTool(id)) scaleLengths(*row, each, forMm / sizedForMm);
  sizedForMm = forMm;
}

// The other tool works at the size of the one in hand: a person turns the brush over, not into another.
engine::Tool StudioState::effectiveTool(bool pointer) {
  engine::Tool inHand = tool();
  inHand.soft = inHand.soft && pointer;
  const engine::ToolRow* row = engine::findTool(toolId);
  const std::string_view other = smoothing                                ? std::string_view("smooth")
                                 : inverted && engine::cutsSoftly(inHand) ? kSoftOpposite
                                 : inverted && row                        ? row->opposite
                                                                          : std::string_view();
  const engine::ToolRow* otherRow = other.empty() || other == toolId ? nullptr : engine::findTool(other);
  if (!otherRow) {
    engine::Tool turned = inHand;
    turned.inverted = inHand.inverted != (inverted && !smoothing && other == toolId);
    return turned;
  }
  const auto kept = tools.find(other);
  engine::Tool result = kept == tools.end() ? newTool(*otherRow) : kept->second;
  result.radiusMm = inHand.radiusMm;
  result.soft = result.soft && pointer;
  // As deep as the other is high.
  if (other == kSoftOpposite) result.depth = inHand.depth;
  return result;
}

void StudioState::remember(const std::filesystem::path& file) {
  std::error_code failed;
  std::filesystem::path whole = std::filesystem::absolute(file, failed).lexically_normal();
  if (failed || whole.empty()) whole = file;
  std::erase(recentFiles, whole.string());
  recentFiles.insert(recentFiles.begin(), whole.string());
  if (recentFiles.size() > kMostRecent) recentFiles.resize(kMostRecent);
  lastFolder = whole.parent_path().string();
}

uint64_t StudioState::undoBytes() const {
  return static_cast<uint64_t>(std::llround(std::ldexp(undoGiB, 30)));
}

}  // namespace argil::studio
