#include "engine/text/operation_text.h"

#include <cmath>

#include "clay/base/error.h"
#include "engine/text/parameter_text.h"

namespace argil::engine {
namespace {

using nlohmann::ordered_json;

constexpr size_t kMostPoints = 100000;

std::string nameAt(const Place& place) {
  if (place.text().empty()) place.fail("names no piece");
  return place.text();
}

Vec3d readDirection(const Place& place) {
  const Vec3d direction = place.vector();
  if (!(direction.norm() > 1e-6)) place.fail("is no direction; [0, 0, 1] is straight up");
  return direction;
}

MirrorPlane readPlane(const Place& place) {
  const auto numbers = place.items();
  if (numbers.size() != 6)
    place.fail(fmt::format("must be 6 numbers [px, py, pz, nx, ny, nz], and has {}", numbers.size()));
  MirrorPlane plane;
  for (size_t i = 0; i < 6; ++i)
    (i < 3 ? plane.pointMm : plane.normal)[Eigen::Index(i % 3)] = numbers[i].number(-kMaxMm, kMaxMm);
  if (!(plane.normal.norm() > 1e-6)) place.fail("its normal is no direction; [0, 0, 0, 1, 0, 0] is the plane x = 0");
  return plane;
}

const PieceJob& rowAt(const Place& place) {
  const Place id = place.at("operation");
  const PieceJob* row = findPieceJob(id.text());
  if (!row) {
    std::string known;
    for (const PieceJob& each : pieceJobs()) known += (known.empty() ? "" : ", ") + std::string(each.id);
    id.fail(fmt::format("unknown {}; known are {}", io::shown(id.text()), known));
  }
  return *row;
}

ordered_json list(const Vec3d& v) {
  if (!v.allFinite()) throw Error("a script cannot hold a number that is not finite", Error::Kind::work);
  return ordered_json::array({v.x(), v.y(), v.z()});
}

}  // namespace

std::vector<std::string_view> keysOf(const PieceJob& row) {
  std::vector<std::string_view> keys;
  if (row.pieces == 1) keys.push_back("piece");
  if (row.pieces > 1) keys.push_back("pieces");
  if (row.takesPlane) keys.push_back("plane");
  if (row.takesCurve) keys.insert(keys.end(), {"points", "direction", "closed"});
  if (row.takesBox) keys.push_back("box");
  if (row.makesNew()) keys.insert(keys.end(), {"name", "centre_mm", "axis"});
  return keys;
}

ScriptOperation readOperation(const Place& place) {
  if (!place.value().is_object()) place.fail("must be an object {...}");
  const PieceJob& row = rowAt(place);
  std::vector<std::string> own;
  own.reserve(row.parameters.size());
  for (const auto& parameter : row.parameters) own.push_back(keyOf(parameter));
  std::vector<std::string_view> keys = {"operation"};
  keys.insert(keys.end(), own.begin(), own.end());
  for (const std::string_view key : keysOf(row)) keys.push_back(key);
  place.keys(keys);

  ScriptOperation operation;
  operation.id = row.id;
  PieceArguments& arguments = operation.arguments = standardArguments(row, {});
  for (size_t i = 0; i < own.size(); ++i) {
    const auto& parameter = row.parameters[i];
    if (const auto value = place.maybe(own[i].c_str()))
      readValue(parameter, *value, arguments, parameter.low, parameter.high);
  }
  if (row.pieces == 1) {
    if (const auto piece = place.maybe("piece")) operation.pieces.push_back(nameAt(*piece));
  } else if (row.pieces > 1) {
    const Place pieces = place.at("pieces");
    for (const Place& piece : pieces.items()) operation.pieces.push_back(nameAt(piece));
    if (operation.pieces.size() != size_t(row.pieces))
      pieces.fail(fmt::format("must name {} pieces, and names {}", row.pieces, operation.pieces.size()));
  } else if (row.makesNew()) {
    if (const auto name = place.maybe("name")) operation.name = nameAt(*name);
    if (const auto centre = place.maybe("centre_mm")) operation.centreMm = centre->vector();
    if (const auto axis = place.maybe("axis")) operation.axis = readDirection(*axis);
  }
  if (row.takesPlane) arguments.plane = readPlane(place.at("plane"));
  if (row.takesCurve) {
    const Place points = place.at("points");
    for (const Place& point : points.items()) arguments.pointsMm.push_back(point.vector());
    if (arguments.pointsMm.empty()) points.fail("is empty; give the points [x, y, z] of it");
    if (arguments.pointsMm.size() > kMostPoints) points.fail(fmt::format("has more than {} points", kMostPoints));
    if (const auto direction = place.maybe("direction")) arguments.directionMm = readDirection(*direction);
    if (const auto closed = place.maybe("closed")) arguments.closed = closed->truth();
  }
  if (const auto box = row.takesBox ? place.maybe("box") : std::nullopt) {
    const auto numbers = box->items();
    if (numbers.size() != 6)
      box->fail(fmt::format("must be 6 numbers [lx, ly, lz, hx, hy, hz], and has {}", numbers.size()));
    auto& corners = arguments.change<LatticeValues>().boxMm.emplace();
    for (size_t i = 0; i < 6; ++i) corners[i / 3][Eigen::Index(i % 3)] = numbers[i].number(-kMaxMm, kMaxMm);
  }
  return operation;
}

ordered_json operationJson(const ScriptOperation& operation) {
  const PieceJob* row = findPieceJob(operation.id);
  if (!row) throw Error(fmt::format("there is no operation named \"{}\"", operation.id), Error::Kind::work);
  const PieceArguments& arguments = operation.arguments;
  const PieceArguments standard = standardArguments(*row, {});
  ordered_json json;
  json["operation"] = row->id;
  if (row->pieces == 1 && !operation.pieces.empty()) json["piece"] = operation.pieces.front();
  if (row->pieces > 1) json["pieces"] = operation.pieces;
  for (const auto& parameter : row->parameters) {
    const double value = parameter.get(arguments);
    if (!std::isfinite(value)) throw Error("a script cannot hold a number that is not finite", Error::Kind::work);
    if (value != parameter.get(standard)) json[keyOf(parameter)] = valueOf(parameter, arguments);
  }
  if (row->takesPlane) {
    json["plane"] = list(arguments.plane.pointMm);
    for (const auto& number : list(arguments.plane.normal)) json["plane"].push_back(number);
  }
  if (row->takesCurve) {
    auto& points = json["points"] = ordered_json::array();
    for (const Vec3d& point : arguments.pointsMm) points.push_back(list(point));
    if (arguments.directionMm != standard.directionMm) json["direction"] = list(arguments.directionMm);
    if (arguments.closed) json["closed"] = true;
  }
  if (const auto& box = arguments.get<LatticeValues>().boxMm; row->takesBox && box) {
    json["box"] = list((*box)[0]);
    for (const auto& number : list((*box)[1])) json["box"].push_back(number);
  }
  if (row->makesNew()) {
    if (!operation.name.empty()) json["name"] = operation.name;
    if (operation.centreMm != Vec3d::Zero()) json["centre_mm"] = list(operation.centreMm);
    if (operation.axis != Vec3d::UnitZ()) json["axis"] = list(operation.axis);
  }
  return json;
}

}  // namespace argil::engine
