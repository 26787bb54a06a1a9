#include "engine/text/script_page.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "engine/text/guide_setup.h"
#include "engine/text/operation_text.h"
#include "engine/text/parameter_text.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {
namespace {

constexpr std::array kFields{
    ScriptField{"script", "argil", "1", "The format's number. Needed."},
    ScriptField{"script", "units", "\"mm\"", "Of all lengths and places. Needed."},
    ScriptField{"script", "setup", "list",
                "What there is before the first stroke: objects of one key each, every key at most once."},
    ScriptField{"script", "strokes", "list", "Strokes and operations, done in this order. Needed."},
    ScriptField{"script", "print", "object",
                "What stands in the way of printing the pieces that there are in the end: `argil sculpt` tells it, and "
                "puts it into its report."},
    ScriptField{"print", "process", "name of a way to print", "With its limits; see below. Needed."},
    ScriptField{"print", "wall_mm", "0.001 to 1000", "The thinnest wall. Left out: that of the process."},
    ScriptField{"print", "gap_mm", "0.001 to 1000", "The narrowest gap. Left out: that of the process."},
    ScriptField{"print", "outlet_mm", "0.001 to 1000",
                "The narrowest way out of a hollow. Left out: that of the process."},
    ScriptField{"setup", "voxel_mm", "0.001 to 1000",
                "Edge of a voxel. Left out: 0.5, or 256 voxels along the longest side of an import."},
    ScriptField{"setup", "bits", "16 or 32", "Of a voxel's distance; 16 takes half the memory. Left out: 32."},
    ScriptField{"setup", "quality", "\"draft\", \"balanced\", \"fine\" or object",
                "Speed against accuracy, of the clay and of every stroke that has none of its own; see below."},
    ScriptField{"setup", "block", "object",
                "A block of clay. One of block, sphere and import; none with `argil sculpt -i` or where the first step "
                "makes a piece."},
    ScriptField{"setup", "sphere", "object", "A ball of clay."},
    ScriptField{"setup", "import", "file name", "A model, made clay; relative to the script's folder."},
    ScriptField{"setup", "fit_mm", "more than 0",
                "An import is centred at zero and scaled until its longest side is this."},
    ScriptField{"setup", "up", "\"z\", \"y\" or \"custom\"",
                "The axis of an import that points up; custom: y for OBJ and OFF, z for the others. Left out: z."},
    ScriptField{"setup", "material", "object", "How the clay feels to a hand; see below."},
    ScriptField{"setup", "materials", "list", "Rows 1, 2, ... that the material tool lays, at most 254."},
    ScriptField{"setup", "guides", "list",
                "What a hand is held or drawn by; see below. Curves are kept in the document, where quads can follow "
                "them."},
    ScriptField{"block", "size_mm", "[x, y, z], each more than 0", "Edges. Needed."},
    ScriptField{"block", "round_mm", "0 to half of the shortest edge", "Radius of rounded edges. Left out: 0."},
    ScriptField{"block", "centre_mm", "[x, y, z]", "Left out: zero."},
    ScriptField{"sphere", "radius_mm", "more than 0", "Needed."},
    ScriptField{"sphere", "centre_mm", "[x, y, z]", "Left out: zero."},
    ScriptField{"materials[]", "name", "text", "Needed."},
    ScriptField{"materials[]", "colour", "\"#rrggbb\"", "Left out: that of the piece."},
    ScriptField{"materials[]", "material", "object", "Left out: as the standard feels."},
    ScriptField{"stroke", "tool", "name", "A tool of the table below. Needed."},
    ScriptField{"stroke", "inverted", "true or false",
                "The other way round, for tools that are their own opposite. Left out: false."},
    ScriptField{"stroke", "file", "file name",
                "Of the image or the shape of a tool that works with one; relative to the script's folder."},
    ScriptField{"stroke", "drive", "\"tip\" or \"hand\"",
                "tip: the tool's centre goes exactly along the path. hand: a simulated hand follows the path with a "
                "device, and the clay is cut where the servo says. Left out: tip."},
    ScriptField{"stroke", "path", "[[t_s, x, y, z], ...]",
                "Seconds and mm, at least one point; times never decrease. A point may go on with a pressure of 0 to "
                "1, with the stylus's quaternion qx, qy, qz, qw, or with both in this order. Needed."},
    ScriptField{"stroke", "onto", "[x, y, z]",
                "Lays the path onto the clay: each point moves along this direction. With press_mm."},
    ScriptField{"stroke", "press_mm", "-1000000 to 1000000",
                "So deep below the surface the ball's front comes to lie. With onto."},
    ScriptField{"stroke", "mirror", "[[px, py, pz, nx, ny, nz], ...]",
                "At most three planes, by a point and a normal, in which the stroke is repeated. With drive tip."},
    ScriptField{"stroke", "radial", "object", "Repeats the stroke around an axis. With drive tip."},
    ScriptField{"stroke", "quality", "object",
                "Numbers of Quality below that are about strokes. Left out: as the setup says."},
    ScriptField{"stroke", "piece", "name",
                "Works on this piece from here on. Left out: the one as before; the clay of the setup is \"Clay\"."},
    ScriptField{"radial", "turns", "1 to 8", "So many times. Needed."},
    ScriptField{"radial", "axis", "[px, py, pz, ax, ay, az]", "A point and a direction. Needed."},
};

constexpr std::array<std::string_view, 3> kExamples{
    R"({"argil": 1, "units": "mm",
 "setup": [{"voxel_mm": 0.5}, {"block": {"size_mm": [60, 60, 40], "round_mm": 4}}],
 "strokes": [
  {"tool": "carve", "radius_mm": 4, "path": [[0, -20, 0, 20], [1, 20, 0, 20]]},
  {"tool": "add", "radius_mm": 3, "onto": [0, 0, -1], "press_mm": 1, "path": [[0, -15, 12, 50], [1, 15, 12, 50]]},
  {"operation": "smooth-all", "passes": 2}
 ]})",
    R"({"argil": 1, "units": "mm",
 "setup": [{"voxel_mm": 0.5}, {"sphere": {"radius_mm": 20}}, {"material": {"stiffness_nmm": 0.8}},
           {"guides": [{"guide": "keep_out_plane", "at": [0, 0, -5], "direction": [0, 0, 1]}]}],
 "strokes": [
  {"tool": "carve", "radius_mm": 3, "drive": "hand", "path": [[0, -12, 0, 16], [1, 12, 0, 16]]}
 ]})",
    R"({"argil": 1, "units": "mm", "setup": [],
 "strokes": [
  {"operation": "ring", "name": "Ring"},
  {"operation": "cone", "name": "Foot", "centre_mm": [0, 0, -10]},
  {"operation": "join", "pieces": ["Ring", "Foot"], "blend_mm": 1},
  {"tool": "smooth", "radius_mm": 4, "radial": {"turns": 6, "axis": [0, 0, 0, 0, 0, 1]}, "path": [[0, 18, 0, 0, 0.5]]}
 ]})",
};

std::string cell(std::string_view text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

void fields(std::string& page, std::string_view where) {
  page += "\n| key | values | what it is |\n|---|---|---|\n";
  for (const ScriptField& field : kFields)
    if (field.where == where)
      page += fmt::format("| `{}` | {} | {} |\n", field.key, cell(field.values), cell(field.help));
}

// What a script may say of a tool: lengths and angles are not held to the range of a slider.
std::string toolValues(const Parameter<Tool>& parameter) {
  if (parameter.id == "radius") return "more than 0 mm";
  if (parameter.unit == "mm") return "0 to 1000000 mm";
  if (parameter.unit == "°") return "-360 to 360 °";
  return valuesOf(parameter);
}

template <class Owner>
std::string standardOf(const Parameter<Owner>& parameter) {
  const auto value = scriptValue(parameter, parameter.standard);
  return value.is_number() ? fmt::format("{:g}", parameter.standard) : value.dump();
}

void tools(std::string& page) {
  // Numbers that many tools have are told once, where they mean the same.
  std::vector<std::pair<std::string, std::vector<std::string_view>>> rows;
  for (const ToolRow& tool : toolTable())
    for (const auto& parameter : tool.parameters) {
      const std::string line = fmt::format("| `{}` | {} | {} | {} |", keyOf(parameter), cell(toolValues(parameter)),
                                           standardOf(parameter), cell(parameter.help));
      auto at = rows.begin();
      while (at != rows.end() && at->first != line) ++at;
      if (at == rows.end()) at = rows.insert(rows.end(), {line, {}});
      at->second.push_back(tool.id);
    }
  page += "\n| tool | what it does | its opposite |\n|---|---|---|\n";
  for (const ToolRow& tool : toolTable())
    page += fmt::format("| `{}` | {} | {} |\n", tool.id, cell(tool.help),
                        tool.opposite.empty()      ? ""
                        : tool.opposite == tool.id ? "`\"inverted\": true`"
                                                   : fmt::format("`{}`", tool.opposite));
  page += "\nNumbers of tools. What is left out is as the tool begins; `radius_mm` is needed always.\n";
  page += "\n| key | values | begins as | what it is | of |\n|---|---|---|---|---|\n";
  for (const auto& [line, ids] : rows)
    page += line +
            fmt::format(" {} |\n", ids.size() == toolTable().size() ? "all" : fmt::format("{}", fmt::join(ids, ", ")));
}

void operations(std::string& page) {
  std::string_view group;
  for (const PieceJob& row : pieceJobs()) {
    if (row.group != group) page += fmt::format("\n### {}\n", row.group);
    group = row.group;
    std::string keys;
    for (const std::string_view key : keysOf(row)) keys += (keys.empty() ? " Takes `" : ", `") + std::string(key) + "`";
    page += fmt::format("\n`{}`: {}{}\n", row.id, row.help, keys.empty() ? "" : keys + ".");
    if (row.parameters.empty()) continue;
    page += "\n| key | values | left out | what it is |\n|---|---|---|---|\n";
    for (const auto& parameter : row.parameters)
      page += fmt::format("| `{}` | {} | {} | {} |\n", keyOf(parameter), cell(valuesOf(parameter)),
                          standardOf(parameter), cell(parameter.help));
  }
}

}  // namespace

std::span<const ScriptField> scriptFields() {
  return kFields;
}
std::span<const std::string_view> scriptExamples() {
  return kExamples;
}

std::string scriptPage() {
  std::string page = R"(# Scripts

A script is a JSON file that holds clay, strokes and operations. `argil sculpt SCRIPT -o OUT` runs it, the studio opens it like a document, and
`argil sculpt --record FILE` writes one. Lengths and places are millimetres, times seconds, forces newtons; z points up. The same script gives the same
clay on every computer. A key that is unknown, missing or there twice, and a number out of its range, is told in one line that names the place
(`strokes[3].path[7]`); then nothing is written. A stroke that changed nothing is told too.

This page is printed by `argil tools --scripts`, from the tables by which scripts are read; `argil tools --demo TOOL` prints a script for each tool.

A groove, a ridge laid onto the clay, and the whole smoothed:

```json
)";
  page += fmt::format(
      "{}\n```\n\nA hand that feels what it carves, above a plane that it cannot pass:\n\n```json\n{}\n```\n\n"
      "New pieces that become one:\n\n```json\n{}\n```\n\n## The script\n",
      kExamples[0], kExamples[1], kExamples[2]);
  fields(page, "script");
  page += "\n`print`:\n";
  fields(page, "print");
  page +=
      "\nWays to print, as `argil inspect --print` knows them:\n\n| name | | walls, mm | gaps, mm | "
      "ways out, mm |\n|---|---|---|---|---|\n";
  for (const PrintProcess& each : printProcesses())
    page += fmt::format("| `{}` | {} | {:g} | {:g} | {} |\n", each.id, each.name, each.wallMm, each.gapMm,
                        each.outletMm > 0 ? fmt::format("{:g}", each.outletMm) : "–");
  page += "\n## Setup\n";
  fields(page, "setup");
  page += "\n`block`:\n";
  fields(page, "block");
  page += "\n`sphere`:\n";
  fields(page, "sphere");
  page += "\nA row of `materials`:\n";
  fields(page, "materials[]");
  page += "\nA `material`, any of:\n\n| key | values |\n|---|---|\n";
  for (const MaterialKey& key : materialKeys())
    page += fmt::format("| `{}` | {:g} to {:g} |\n", key.key, key.least, key.most);
  page +=
      "\n`dynamic_friction` is no more than `static_friction`. The keys end in their units: `nmm` N/mm, `nmm2` N/mm², "
      "`nsmm` N·s/mm.\n";
  page +=
      "\nA guide, `{\"guide\": NAME, ...}`. All keys of its kind are needed but `closed` and `inside`, which are false "
      "when left out; every kind may have "
      "`while_buttons`, the buttons (1, 2, 4, ... added up) that must be held.\n\n| guide | keys |\n|---|---|\n";
  for (const GuideKind& kind : guideKinds())
    page += fmt::format("| `{}` | {} |\n", kind.name,
                        kind.keys.empty() ? "" : fmt::format("`{}`", fmt::join(kind.keys, "`, `")));
  page +=
      "\n`at`, `points` and `direction` are [x, y, z] or lists of such; a `keep_out_plane` is free on the side of its "
      "direction. `force_n` is 0 to 10000, "
      "`stiffness_nmm` 0 to 10000 N/mm, `drag_nsmm` 0 to 1000 N·s/mm, lengths are more than 0.\n";
  page +=
      "\n## Quality\n\nA preset's name, or an object: `\"preset\"` and what is to differ from it; without a preset it "
      "differs from what stands in the third column. docs/tradeoff.md has what each number buys.\n\n"
      "| key | values | left out | about | what it is |\n|---|---|---|---|---|\n";
  for (const QualityAxis& axis : qualityAxes())
    page += fmt::format("| `{}` | {} | {} | {} | {} |\n", keyOf(axis.row), cell(valuesOf(axis.row)),
                        standardOf(axis.row), nameOf(axis.part), cell(axis.row.help));
  page += "\n## Strokes\n";
  fields(page, "stroke");
  page += "\n`radial`:\n";
  fields(page, "radial");
  page += "\nand the numbers of the tool:\n\n## Tools\n";
  tools(page);
  page += R"(
## Operations

Steps between strokes, in the same list: `{"operation": "shell", "inner_mm": 2}`. What they take besides their numbers:
`"piece": "Clay"` (left out: the one that is worked on); `"pieces": ["Clay", "Ring"]`;
`"plane": [px, py, pz, nx, ny, nz]`, a point and a normal; `"points": [[x, y, z], ...]` of a curve or of a lattice
(z fastest, then y, then x), with `"direction": [x, y, z]` along which a curve goes through the clay and
`"closed": true`;
`"box": [lx, ly, lz, hx, hy, hz]`, in mm of the piece, that the points of a lattice begin as; and of a new piece its
`"name": "Ring"`, `"centre_mm": [x, y, z]` and `"axis": [x, y, z]`, where its z axis points. A name that is taken gets a
number.
)";
  operations(page);
  return page;
}

}  // namespace argil::engine
