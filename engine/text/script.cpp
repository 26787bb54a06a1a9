#include "engine/text/script.h"

#include <fmt/format.h>
#include <array>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "clay/base/error.h"
#include "engine/document/random.h"
#include "engine/text/json_text.h"
#include "engine/text/operation_text.h"
#include "engine/text/parameter_text.h"
#include "engine/text/quality_text.h"
#include "engine/text/script_place.h"
#include "engine/text/tool_text.h"
#include "engine/tools/tool_table.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"

namespace argil::engine {
namespace {

using nlohmann::json;

constexpr double kMaxSeconds = 1e6;
constexpr double kMinVoxelMm = 1e-3, kMaxVoxelMm = 1e3;

// Names as in a script.
constexpr std::pair<std::string_view, Up> kUps[] = {{"z", Up::z}, {"y", Up::y}, {"custom", Up::custom}};
constexpr std::pair<std::string_view, Drive> kDrives[] = {{"tip", Drive::tip}, {"hand", Drive::hand}};

ClaySetup readBlock(const Place& place) {
  place.keys({"size_mm", "round_mm", "centre_mm"});
  BlockSetup block;
  block.sizeMm = place.at("size_mm").vector();
  if (!(block.sizeMm.minCoeff() > 0)) place.at("size_mm").fail("each side must be more than 0");
  if (const auto round = place.maybe("round_mm")) block.roundMm = round->number(0, block.sizeMm.minCoeff() / 2);
  if (const auto centre = place.maybe("centre_mm")) block.centreMm = centre->vector();
  return block;
}

ClaySetup readSphere(const Place& place) {
  place.keys({"radius_mm", "centre_mm"});
  SphereSetup sphere;
  sphere.radiusMm = place.at("radius_mm").positive();
  if (const auto centre = place.maybe("centre_mm")) sphere.centreMm = centre->vector();
  return sphere;
}

MaterialRow readMaterialRow(const Place& place) {
  place.keys({"name", "colour", "material"});
  MaterialRow row;
  row.name = place.at("name").text();
  if (const auto colour = place.maybe("colour")) {
    const uint32_t rgb = readColour(*colour);
    row.colour = {static_cast<float>(rgb >> 16) / 255, static_cast<float>(rgb >> 8 & 255) / 255,
                  static_cast<float>(rgb & 255) / 255};
  }
  if (const auto material = place.maybe("material")) row.material = readMaterial(*material);
  return row;
}

json materialRowJson(const MaterialRow& row) {
  json out{{"name", row.name}, {"material", materialJson(row.material)}};
  if (row.colour) {
    const auto [red, green, blue] = bytesOf(*row.colour);
    out["colour"] = fmt::format("#{:02x}{:02x}{:02x}", red, green, blue);
  }
  return out;
}

void readSetup(const Place& item, Script& script) {
  item.keys(
      {"voxel_mm", "bits", "quality", "fit_mm", "up", "block", "sphere", "import", "material", "materials", "guides"});
  if (item.value().size() != 1) item.fail("must hold exactly one key");
  const auto once = [&](bool already) {
    if (already) item.fail("is there twice; remove one");
  };
  if (const auto voxel = item.maybe("voxel_mm")) {
    once(script.voxelMm.has_value());
    script.voxelMm = voxel->number(kMinVoxelMm, kMaxVoxelMm);
  } else if (const auto bits = item.maybe("bits")) {
    once(script.precision != clay::Precision::float32);
    const double number = bits->number(16, 32);
    if (number != 16 && number != 32) bits->fail("clay has 16 or 32 bits a voxel");
    if (number == 16) script.precision = clay::Precision::fixed16;
  } else if (const auto quality = item.maybe("quality")) {
    once(script.quality.has_value());
    script.quality = readQuality(*quality);
  } else if (const auto fit = item.maybe("fit_mm")) {
    once(script.fitMm.has_value());
    script.fitMm = fit->positive();
  } else if (const auto up = item.maybe("up")) {
    once(script.up != Up::z);
    script.up = up->oneOf<Up>(kUps);
  } else if (const auto material = item.maybe("material")) {
    once(!(script.material == haptics::Material()));
    script.material = readMaterial(*material);
  } else if (const auto rows = item.maybe("materials")) {
    once(!script.materials.empty());
    for (const Place& row : rows->items()) script.materials.push_back(readMaterialRow(row));
    if (script.materials.size() > kMaxMaterialRows)
      rows->fail(fmt::format("has {} rows; {} is the most", script.materials.size(), kMaxMaterialRows));
  } else if (const auto guides = item.maybe("guides")) {
    once(!script.guides.empty());
    for (const Place& guide : guides->items()) script.guides.push_back(readGuide(guide));
    if (script.guides.size() > haptics::kMaxGuides)
      guides->fail(fmt::format("more than {} guides", haptics::kMaxGuides));
  } else {
    if (script.clay.index() != 0) item.fail("the clay is already chosen; keep one of block, sphere, import");
    if (const auto block = item.maybe("block")) {
      script.clay = readBlock(*block);
    } else if (const auto sphere = item.maybe("sphere")) {
      script.clay = readSphere(*sphere);
    } else {
      const Place file = item.at("import");
      if (file.text().empty()) file.fail("names no file");
      script.clay = ImportSetup{file.text()};
    }
  }
}

// Limits of a wish, or of one that is not to be changed, by their keys.
template <class Wish>
auto printLimits(Wish& wish) {
  return std::array{std::pair("wall_mm", &wish.wallMm), std::pair("gap_mm", &wish.gapMm),
                    std::pair("outlet_mm", &wish.outletMm)};
}

PrintWish readPrint(const Place& place) {
  place.keys({"process", "wall_mm", "gap_mm", "outlet_mm"});
  PrintWish wish;
  const Place process = place.at("process");
  wish.process = process.text();
  try {
    static_cast<void>(printProcess(wish.process));
  } catch (const Error& error) {
    process.fail(error.what());
  }
  for (const auto& [key, limit] : printLimits(wish)) {
    if (const auto given = place.maybe(key)) *limit = given->number(kLeastPrintLimitMm, kMostPrintLimitMm);
  }
  return wish;
}

// [t, x, y, z], then a pressure, a quaternion, or both.
PathPoint readPoint(const Place& row) {
  const auto numbers = row.items();
  const size_t count = numbers.size();
  if (count != 4 && count != 5 && count != 8 && count != 9)
    row.fail(fmt::format(
        "must be 4 numbers [t_s, x, y, z] (5, 8 or 9 with a pressure, a quaternion or both), and has {}", count));
  PathPoint point;
  point.timeS = numbers[0].number(-kMaxSeconds, kMaxSeconds);
  for (int axis = 0; axis < 3; ++axis) point.mm[axis] = numbers[size_t(axis) + 1].number(-kMaxMm, kMaxMm);
  if (count % 2 == 1) point.pressure = numbers[4].number(0, 1);
  if (count >= 8) {
    Eigen::Vector4d q;
    for (int i = 0; i < 4; ++i) q[i] = numbers[count - 4 + size_t(i)].number(-1e3, 1e3);
    if (!(q.norm() > 1e-6)) row.fail("its quaternion is no rotation; 0, 0, 0, 1 is upright");
    point.rotation = Eigen::Quaterniond(q);
  }
  return point;
}

ScriptStroke readStroke(const Place& place, const StrokeQuality& usual) {
  checkToolKeys(place, {"drive", "onto", "press_mm", "mirror", "radial", "piece", "path"});
  ScriptStroke stroke;
  stroke.tool = readTool(place, usual);
  if (const auto drive = place.maybe("drive")) stroke.drive = drive->oneOf<Drive>(kDrives);
  if (place.maybe("onto") || place.maybe("press_mm")) {
    stroke.onto = Onto{place.at("onto").vector(), place.at("press_mm").number(-kMaxMm, kMaxMm)};
    if (stroke.onto->direction.isZero()) place.at("onto").fail("is no direction; [0, 0, -1] is straight down");
  }
  stroke.images = readImages(place, "mirror");
  for (const char* key : {"mirror", "radial"}) {
    const auto repeated = place.maybe(key);
    if (repeated && stroke.drive != Drive::tip) repeated->fail("goes with \"drive\": \"tip\" only");
  }
  if (const auto piece = place.maybe("piece")) {
    stroke.piece = piece->text();
    if (stroke.piece.empty()) piece->fail("names no piece");
  }
  const auto rows = place.at("path").items();
  if (rows.empty()) place.at("path").fail("is empty; give at least one [t_s, x, y, z]");
  stroke.path.reserve(rows.size());
  for (const Place& row : rows) {
    const PathPoint point = readPoint(row);
    if (!stroke.path.empty() && point.timeS < stroke.path.back().timeS) {
      row.fail(fmt::format("its time {} s comes before the last one's {} s", point.timeS, stroke.path.back().timeS));
    }
    stroke.path.push_back(point);
  }
  return stroke;
}

json list(const Vec3d& v) {
  return json::array({v.x(), v.y(), v.z()});
}

template <class T>
std::string_view nameOf(std::span<const std::pair<std::string_view, T>> table, T wanted) {
  for (const auto& [name, value] : table) {
    if (value == wanted) return name;
  }
  return {};
}

void checkFinite(bool finite) {
  if (!finite) throw Error("a script cannot hold a number that is not finite", Error::Kind::work);
}

}  // namespace

Script parseScript(std::string_view text, const std::string& name) {
  const json root =
      parseJson(text, name, "a script is {\"argil\": 1, \"units\": \"mm\", \"setup\": [...], \"strokes\": [...]}");
  const Place place(root, name, "");
  place.keys({"argil", "units", "setup", "strokes", "print"});
  const Place format = place.at("argil");
  if (!format.value().is_number_integer() || format.value() != 1) format.fail("this program reads scripts of format 1");
  if (place.at("units").text() != "mm") place.at("units").fail("must be \"mm\"");
  Script script;
  if (const auto setup = place.maybe("setup")) {
    for (const Place& item : setup->items()) readSetup(item, script);
  }
  const StrokeQuality usual = script.quality.value_or(Quality()).strokes;
  const auto strokes = place.at("strokes").items();
  script.strokes.reserve(strokes.size());
  for (const Place& step : strokes) {
    if (!step.value().is_object() || !step.value().contains("operation")) {
      script.strokes.push_back(readStroke(step, usual));
      continue;
    }
    script.operations.push_back(readOperation(step));
    script.operations.back().before = script.strokes.size();
  }
  if (const auto print = place.maybe("print")) script.print = readPrint(*print);
  return script;
}

void Script::use(const Quality& given) {
  const StrokeQuality was = quality.value_or(Quality()).strokes;
  for (ScriptStroke& stroke : strokes)
    if (stroke.tool.quality == was) stroke.tool.quality = given.strokes;
  quality = given;
}

std::string formatScript(const Script& script) {
  json setup = json::array();
  if (script.voxelMm) setup.push_back({{"voxel_mm", *script.voxelMm}});
  if (script.precision == clay::Precision::fixed16) setup.push_back({{"bits", 16}});
  if (script.quality) setup.push_back({{"quality", qualityJson(*script.quality)}});
  if (script.fitMm) setup.push_back({{"fit_mm", *script.fitMm}});
  if (script.up != Up::z) setup.push_back({{"up", nameOf<Up>(kUps, script.up)}});
  if (const auto* block = std::get_if<BlockSetup>(&script.clay)) {
    checkFinite(block->sizeMm.allFinite() && std::isfinite(block->roundMm) && block->centreMm.allFinite());
    setup.push_back(
        {{"block",
          {{"size_mm", list(block->sizeMm)}, {"round_mm", block->roundMm}, {"centre_mm", list(block->centreMm)}}}});
  } else if (const auto* sphere = std::get_if<SphereSetup>(&script.clay)) {
    checkFinite(std::isfinite(sphere->radiusMm) && sphere->centreMm.allFinite());
    setup.push_back({{"sphere", {{"radius_mm", sphere->radiusMm}, {"centre_mm", list(sphere->centreMm)}}}});
  } else if (const auto* import = std::get_if<ImportSetup>(&script.clay)) {
    setup.push_back({{"import", import->file.string()}});
  }
  if (!(script.material == haptics::Material())) setup.push_back({{"material", materialJson(script.material)}});
  if (!script.materials.empty()) {
    json rows = json::array();
    for (const MaterialRow& row : script.materials) rows.push_back(materialRowJson(row));
    setup.push_back({{"materials", rows}});
  }
  if (!script.guides.empty()) {
    json guides = json::array();
    for (const GuideSetup& guide : script.guides) guides.push_back(guideJson(guide));
    setup.push_back({{"guides", guides}});
  }
  const StrokeQuality usual = script.quality.value_or(Quality()).strokes;
  std::string text = "{\"argil\": 1, \"units\": \"mm\", \"setup\": " + setup.dump() + ", \"strokes\": [";
  size_t operation = 0;
  const auto putOperations = [&](size_t before) {
    for (; operation < script.operations.size() && script.operations[operation].before <= before; ++operation)
      text += (text.back() == '[' ? "\n" : ",\n") + operationJson(script.operations[operation]).dump();
  };
  for (size_t i = 0; i < script.strokes.size(); ++i) {
    const ScriptStroke& stroke = script.strokes[i];
    putOperations(i);
    nlohmann::ordered_json line;
    putTool(line, stroke.tool, usual);
    line["drive"] = nameOf<Drive>(kDrives, stroke.drive);
    if (stroke.onto) {
      checkFinite(stroke.onto->direction.allFinite() && std::isfinite(stroke.onto->pressMm));
      line["onto"] = list(stroke.onto->direction);
      line["press_mm"] = stroke.onto->pressMm;
    }
    putImages(line, stroke.images, "mirror");
    if (!stroke.piece.empty()) line["piece"] = stroke.piece;
    auto& path = line["path"] = nlohmann::ordered_json::array();
    for (const PathPoint& point : stroke.path) {
      checkFinite(std::isfinite(point.timeS) && point.mm.allFinite());
      auto& row =
          path.emplace_back(nlohmann::ordered_json::array({point.timeS, point.mm.x(), point.mm.y(), point.mm.z()}));
      checkFinite(std::isfinite(point.pressure) && (!point.rotation || point.rotation->coeffs().allFinite()));
      if (point.pressure != 1) row.push_back(point.pressure);
      if (point.rotation)
        for (int j = 0; j < 4; ++j) row.push_back(point.rotation->coeffs()[j]);
    }
    text += (text.back() == '[' ? "\n" : ",\n") + line.dump();
  }
  putOperations(SIZE_MAX);
  text += "\n]";
  if (script.print) {
    nlohmann::ordered_json print{{"process", script.print->process}};
    for (const auto& [key, limit] : printLimits(*script.print)) {
      if (!*limit) continue;
      checkFinite(std::isfinite(**limit));
      print[key] = **limit;
    }
    text += ", \"print\": " + print.dump();
  }
  return text + "}\n";
}

void writeScript(const std::filesystem::path& path, const Script& script) {
  const std::string text = formatScript(script);
  io::AtomicFile file(path);
  file.write(std::as_bytes(std::span(text)));
  file.commit();
}

Script randomScript(uint64_t seed, const RandomScriptOptions& options) {
  Random random(seed);
  Script script;
  script.strokes.resize(options.strokes);
  for (ScriptStroke& stroke : script.strokes) {
    const uint64_t drawn = random.below(options.smooth ? 3 : 2);
    stroke.tool = scriptTool(*findTool(drawn == 0 ? "carve" : drawn == 1 ? "add" : "smooth"));
    stroke.tool.radiusMm = random.between(options.minRadiusMm, options.maxRadiusMm);
    if (drawn == 2) stroke.tool.strength = random.between(0.1, 1);
    // Directions need not be even, only equal everywhere: no trigonometry.
    Vec3d direction = random.inBall();
    const double length = std::sqrt(direction.dot(direction));
    direction = length > 0.01 ? Vec3d(direction / length) : Vec3d(0, 0, 1);
    Vec3d at = direction * options.reachMm * random.between(0.7, 1);
    const size_t points = 1 + random.below(options.maxPoints);
    for (size_t i = 0; i < points; ++i) {
      stroke.path.push_back({0.01 * double(i), options.centreMm + at});
      const size_t kind = random.below(16);
      if (kind == 0) continue;  // the same place again
      const double step = kind == 1 ? options.reachMm : 2 * stroke.tool.radiusMm;
      const Vec3d next = at + step * random.inBall();
      if (next.dot(next) <= options.reachMm * options.reachMm) at = next;
    }
  }
  return script;
}

}  // namespace argil::engine
