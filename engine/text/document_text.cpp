#include "engine/text/document_text.h"

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/document/guide_table.h"
#include "engine/text/guide_setup.h"
#include "engine/text/json_text.h"
#include "engine/text/quality_text.h"
#include "engine/text/script_place.h"

namespace argil::engine {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

std::vector<std::pair<std::string_view, Guide::Kind>> kindsById() {
  std::vector<std::pair<std::string_view, Guide::Kind>> kinds;
  for (const GuideRow& row : guideTable()) kinds.emplace_back(row.id, row.kind);
  return kinds;
}

constexpr std::pair<std::string_view, Guide::Feel> kFeels[] = {{"seen", Guide::Feel::seen},
                                                               {"lock", Guide::Feel::lock},
                                                               {"well", Guide::Feel::well},
                                                               {"keep_out", Guide::Feel::keepOut}};

constexpr double kMostId = 4294967295.0, kMostRecord = 9007199254740992.0;  // what a JSON number holds exactly
constexpr double kMostNumber = 1e15;  // what was written must be read again: no limit of the hand applies here

template <class T, size_t n>
std::string_view nameOf(const std::pair<std::string_view, T> (&table)[n], T value) {
  for (const auto& [name, each] : table) {
    if (each == value) return name;
  }
  return {};
}

double finite(double value) {
  if (!std::isfinite(value)) throw Error("a document holds a number that is not finite", Error::Kind::work);
  return value;
}

ordered_json list(const Vec3d& v) {
  return ordered_json::array({finite(v.x()), finite(v.y()), finite(v.z())});
}
ordered_json poseJson(const haptics::Pose& pose) {
  const auto& q = pose.rotation;
  return {{"at", list(pose.translation)},
          {"turn", ordered_json::array({finite(q.w()), finite(q.x()), finite(q.y()), finite(q.z())})}};
}
ordered_json colourJson(const std::array<float, 3>& c) {
  return ordered_json::array({finite(double(c[0])), finite(double(c[1])), finite(double(c[2]))});
}

ordered_json thingJson(const Thing& thing) {
  ordered_json line;
  line["id"] = thing.id;
  line["name"] = thing.name;
  if (!thing.visible) line["visible"] = false;
  if (thing.locked) line["locked"] = true;
  return line;
}

Vec3d readVector(const Place& place) {
  const auto numbers = place.items();
  if (numbers.size() != 3) place.fail("must be 3 numbers [x, y, z]");
  Vec3d v;
  for (int i = 0; i < 3; ++i) v[i] = numbers[size_t(i)].number(-kMostNumber, kMostNumber);
  return v;
}

haptics::Pose readPose(const Place& place) {
  place.keys({"at", "turn"});
  haptics::Pose pose;
  pose.translation = readVector(place.at("at"));
  const auto turn = place.at("turn").items();
  if (turn.size() != 4) place.at("turn").fail("must be 4 numbers [w, x, y, z]");
  double q[4];
  for (size_t i = 0; i < 4; ++i) q[i] = turn[i].number(-1.000001, 1.000001);
  pose.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  if (!(std::abs(pose.rotation.norm() - 1) < 1e-6)) place.at("turn").fail("is no rotation: its length must be 1");
  return pose;
}

std::array<float, 3> readColour(const Place& place) {
  const auto parts = place.items();
  if (parts.size() != 3) place.fail("must be 3 numbers [red, green, blue]");
  std::array<float, 3> colour{};
  for (size_t i = 0; i < 3; ++i) colour[i] = static_cast<float>(parts[i].number(-kMostNumber, kMostNumber));
  return colour;
}

Id readId(const Place& place) {
  if (!place.value().is_number_unsigned()) place.fail("must be a whole number");
  return static_cast<Id>(place.number(0, kMostId));
}

io::RecordId readRecord(const Place& place) {
  if (!place.value().is_number_unsigned()) place.fail("must be a whole number");
  (void)place.number(0, kMostRecord);
  return place.value().get<io::RecordId>();
}

void readThing(const Place& place, Thing& thing) {
  thing.id = readId(place.at("id"));
  thing.name = place.at("name").text();
  if (const auto visible = place.maybe("visible")) thing.visible = visible->truth();
  if (const auto locked = place.maybe("locked")) thing.locked = locked->truth();
}

std::vector<Vec3d> readPoints(const Place& place) {
  std::vector<Vec3d> points;
  for (const Place& point : place.items()) points.push_back(readVector(point));
  return points;
}

MaterialRow readMaterialRow(const Place& place) {
  place.keys({"name", "material", "colour"});
  MaterialRow row;
  row.name = place.at("name").text();
  row.material = readMaterial(place.at("material"));
  if (const auto colour = place.maybe("colour")) row.colour = readColour(*colour);
  return row;
}

ordered_json rowJson(const MaterialRow& row) {
  ordered_json line{{"name", row.name}, {"material", materialJson(row.material)}};
  if (row.colour) line["colour"] = colourJson(*row.colour);
  return line;
}

Guide readDocumentGuide(const Place& place) {
  place.keys({"id", "name", "visible", "locked", "kind", "feel", "pose", "size", "points", "closed", "range", "force"});
  Guide guide;
  readThing(place, guide);
  guide.kind = place.at("kind").oneOf<Guide::Kind>(kindsById());
  guide.feel = place.at("feel").oneOf<Guide::Feel>(kFeels);
  guide.pose = readPose(place.at("pose"));
  guide.sizeMm = readVector(place.at("size"));
  if (const auto points = place.maybe("points")) guide.pointsMm = readPoints(*points);
  if (const auto closed = place.maybe("closed")) guide.closed = closed->truth();
  guide.rangeMm = place.at("range").number(-kMostNumber, kMostNumber);
  guide.forceN = place.at("force").number(-kMostNumber, kMostNumber);
  const size_t least = rowOf(guide.kind).points;
  if (guide.pointsMm.size() < least) place.fail(fmt::format("needs {} points", least));
  return guide;
}

clay::Grid readGrid(const Place& place) {
  place.keys({"voxel_mm", "origin", "band", "bits"});
  clay::Grid grid;
  grid.voxelMm = place.at("voxel_mm").number(1e-3, 1e3);
  grid.originMm = readVector(place.at("origin"));
  grid.band = static_cast<float>(place.at("band").number(2, 8));
  return grid;
}

// Said where it is not 32.
clay::Precision readPrecision(const Place& grid) {
  const auto bits = grid.maybe("bits");
  if (!bits) return clay::Precision::float32;
  const double number = bits->number(16, 32);
  if (number != 16 && number != 32) bits->fail("clay has 16 or 32 bits");
  return number == 16 ? clay::Precision::fixed16 : clay::Precision::float32;
}

}  // namespace

std::string documentText(const Document& document, const std::vector<ClayKey>& clay,
                         const std::vector<io::RecordId>& meshes) {
  ordered_json root;
  root["pieces"] = ordered_json::array();
  for (size_t i = 0; i < document.pieces.size(); ++i) {
    const Piece& piece = document.pieces[i];
    ordered_json line = thingJson(piece);
    if (piece.version) {
      const clay::Grid& grid = piece.version.grid();
      line["clay"] = {{"root", clay.at(i).root}, {"owner", clay.at(i).owner}};
      line["grid"] = {
          {"voxel_mm", finite(grid.voxelMm)}, {"origin", list(grid.originMm)}, {"band", finite(double(grid.band))}};
      if (piece.version.stats().precision == clay::Precision::fixed16) line["grid"]["bits"] = 16;
    }
    line["pose"] = poseJson(piece.pose);
    if (!piece.fileOffsetMm.isZero(0)) line["file_offset"] = list(piece.fileOffsetMm);
    line["colour"] = colourJson(piece.colour);
    line["material"] = materialJson(piece.material);
    if (piece.hideMasked) line["hide_masked"] = true;
    for (const MaterialRow& row : piece.materials) line["materials"].push_back(rowJson(row));
    root["pieces"].push_back(std::move(line));
  }
  root["parts"] = ordered_json::array();
  for (size_t i = 0; i < document.parts.size(); ++i) {
    const Part& part = document.parts[i];
    ordered_json line = thingJson(part);
    line["mesh"] = meshes.at(i);
    line["pose"] = poseJson(part.pose);
    line["colour"] = colourJson(part.colour);
    line["material"] = materialJson(part.material);
    root["parts"].push_back(std::move(line));
  }
  root["guides"] = ordered_json::array();
  for (const Guide& guide : document.guides) {
    ordered_json line = thingJson(guide);
    line["kind"] = rowOf(guide.kind).id;
    line["feel"] = nameOf(kFeels, guide.feel);
    line["pose"] = poseJson(guide.pose);
    line["size"] = list(guide.sizeMm);
    if (!guide.pointsMm.empty()) {
      for (const Vec3d& point : guide.pointsMm) line["points"].push_back(list(point));
    }
    if (guide.closed) line["closed"] = true;
    line["range"] = finite(guide.rangeMm);
    line["force"] = finite(guide.forceN);
    root["guides"].push_back(std::move(line));
  }
  root["symmetry"] = {{"x", document.symmetry.x},
                      {"y", document.symmetry.y},
                      {"z", document.symmetry.z},
                      {"pose", poseJson(document.symmetry.pose)},
                      {"turns", document.symmetry.turns}};
  if (!(document.quality == StrokeQuality())) root["quality"] = strokeQualityJson(document.quality);
  root["active"] = document.active;
  root["next_id"] = document.nextId;
  return root.dump(-1, ' ', false, json::error_handler_t::replace);
}

DocumentText readDocumentText(std::string_view text, const std::string& name, std::vector<std::string>* unknown) {
  const json root = parseJson(text, name, "a document's state");
  const Place place(root, name, "", unknown);
  place.keys({"pieces", "parts", "guides", "symmetry", "quality", "active", "next_id"});
  DocumentText read;
  Document& document = read.document;
  document.nextId = readId(place.at("next_id"));
  std::set<Id> ids;
  const auto checkId = [&](const Place& at, Id id) {
    if (id == 0 || id >= document.nextId || !ids.insert(id).second)
      at.fail(fmt::format("the id {} is 0, twice there or beyond the next", id));
  };
  for (const Place& at : place.at("pieces").items()) {
    at.keys({"id", "name", "visible", "locked", "clay", "grid", "pose", "colour", "material", "materials",
             "hide_masked", "file_offset"});
    Piece piece;
    readThing(at, piece);
    checkId(at, piece.id);
    ClayKey key;
    clay::Grid grid;
    clay::Precision precision = clay::Precision::float32;
    if (const auto clay = at.maybe("clay")) {
      clay->keys({"root", "owner"});
      key = {readRecord(clay->at("root")), readId(clay->at("owner"))};
      grid = readGrid(at.at("grid"));
      precision = readPrecision(at.at("grid"));
    }
    read.clay.push_back(key);
    read.grids.push_back(grid);
    read.precisions.push_back(precision);
    piece.pose = readPose(at.at("pose"));
    piece.colour = readColour(at.at("colour"));
    piece.material = readMaterial(at.at("material"));
    if (const auto offset = at.maybe("file_offset")) piece.fileOffsetMm = readVector(*offset);
    if (const auto hide = at.maybe("hide_masked")) piece.hideMasked = hide->truth();
    if (const auto rows = at.maybe("materials")) {
      for (const Place& row : rows->items()) piece.materials.push_back(readMaterialRow(row));
      if (piece.materials.size() > kMaxMaterialRows)
        rows->fail(fmt::format("has {} rows; a voxel names one of {}", piece.materials.size(), kMaxMaterialRows));
    }
    document.pieces.push_back(std::move(piece));
  }
  for (const Place& at : place.at("parts").items()) {
    at.keys({"id", "name", "visible", "locked", "mesh", "pose", "colour", "material"});
    Part part;
    readThing(at, part);
    checkId(at, part.id);
    read.meshes.push_back(readRecord(at.at("mesh")));
    part.pose = readPose(at.at("pose"));
    part.colour = readColour(at.at("colour"));
    part.material = readMaterial(at.at("material"));
    document.parts.push_back(std::move(part));
  }
  for (const Place& at : place.at("guides").items()) {
    document.guides.push_back(readDocumentGuide(at));
    checkId(at, document.guides.back().id);
  }
  const Place symmetry = place.at("symmetry");
  symmetry.keys({"x", "y", "z", "pose", "turns"});
  document.symmetry = {symmetry.at("x").truth(), symmetry.at("y").truth(), symmetry.at("z").truth(),
                       readPose(symmetry.at("pose"))};
  if (const auto turns = symmetry.maybe("turns")) document.symmetry.turns = int(turns->number(1, kMostTurns));
  if (const auto quality = place.maybe("quality")) document.quality = readStrokeQuality(*quality);
  document.active = readId(place.at("active"));
  if (document.active != 0 && !document.piece(document.active)) place.at("active").fail("names no piece");
  return read;
}

}  // namespace argil::engine
