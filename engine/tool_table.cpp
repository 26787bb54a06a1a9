#include "engine/tool_table.h"

#include <algorithm>
#include <array>

namespace argil::engine {
namespace {

constexpr Parameter<Tool> kRadius{"radius", "Radius", "Radius of the ball that works on the clay.", "mm", 0.05, 200, 5, true,
                                  [](const Tool& t) { return t.radiusMm; }, [](Tool& t, double v) { t.radiusMm = v; }};
constexpr Parameter<Tool> kStrength{"strength", "Strength", "How much of the smoothing a pass does.", "%", 1, 100, 50, false,
                                    [](const Tool& t) { return 100.0 * double(t.strength); },
                                    [](Tool& t, double v) { t.strength = static_cast<float>(v / 100); }};

constexpr std::array kBall{kRadius};
constexpr std::array kSmooth{kRadius, kStrength};

constexpr std::array kTools{
    ToolRow{"carve", "Carve", "Cuts clay away where the ball goes.", "carve", "C", clay::Operation::carve, "add", kBall},
    ToolRow{"add", "Add", "Lays clay along the stroke.", "add", "A", clay::Operation::add, "carve", kBall},
    ToolRow{"smooth", "Smooth", "Evens out bumps and edges.", "smooth", "S", clay::Operation::smooth, "smooth", kSmooth},
};

}  // namespace

std::span<const ToolRow> toolTable() { return kTools; }

const ToolRow* findTool(std::string_view id) {
  const auto row = std::find_if(kTools.begin(), kTools.end(), [&](const ToolRow& each) { return each.id == id; });
  return row == kTools.end() ? nullptr : &*row;
}

Tool standardTool(const ToolRow& row) {
  Tool tool;
  tool.operation = row.operation;
  for (const Parameter<Tool>& parameter : row.parameters) parameter.change(tool, parameter.standard);
  return tool;
}

}  // namespace argil::engine
