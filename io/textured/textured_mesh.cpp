#include "io/textured/textured_mesh.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "clay/base/error.h"
#include "clay/unwrap/charts.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/byte_sink.h"
#include "io/bytes/input.h"
#include "io/models/draco_mesh.h"

namespace argil::io {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char *kColours = "colour", *kNormals = "normal", *kHeights = "displacement";
constexpr double kMetre = 1000;  // mm
constexpr int kUnsignedInt = 5125, kFloat = 5126, kVertices = 34962, kIndices = 34963;

// Files that appear together, as far as a file system lets them: all are written before the first gets its name.
class Together {
 public:
  ByteSink& add(const fs::path& path) {
    files_.push_back(std::make_unique<AtomicFile>(path));
    sinks_.push_back(std::make_unique<ByteSink>(*files_.back()));
    return *sinks_.back();
  }
  /// The last that was added gets its name last.
  std::vector<std::string> commit() {
    for (const auto& each : sinks_) each->flush();
    std::vector<std::string> names;
    for (const auto& each : files_) {
      each->commit();
      names.push_back(each->target().filename().string());
    }
    return names;
  }

 private:
  std::vector<std::unique_ptr<AtomicFile>> files_;
  std::vector<std::unique_ptr<ByteSink>> sinks_;
};

// Names differ: one of a name that was there is a later part of the same object for readers of OBJ.
class Names {
 public:
  std::string of(const std::string& name) {
    std::string plain = name.empty() ? "Object" : name;
    for (char& c : plain)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    std::string own = plain;
    for (int number = 2; !names_.insert(own).second; ++number) own = fmt::format("{} {}", plain, number);
    return own;
  }

 private:
  std::set<std::string> names_;
};

// Of one object's files, without their kind.
std::string ownName(const fs::path& file, size_t object) {
  const std::string stem = file.stem().string();
  return object == 0 ? stem : fmt::format("{}_{}", stem, object + 1);
}

std::vector<std::string> writeObj(const fs::path& file, std::span<const TexturedObject> objects, Job* job) {
  Together files;
  const fs::path folder = file.parent_path();
  const std::string stem = file.stem().string();
  std::string materials = "# Written by Argil\n";
  for (size_t i = 0; i < objects.size(); ++i) {
    const TexturedObject& object = objects[i];
    const std::string own = ownName(file, i);
    materials += fmt::format("newmtl {}\n", own);
    const auto part = [](uint8_t c) { return c / 255.0; };
    if (!object.colours.empty())
      materials += "Kd 1 1 1\n";
    else if (const std::optional<Colour>& colour = object.colour)
      materials += fmt::format("Kd {:.6f} {:.6f} {:.6f}\n", part(colour->red), part(colour->green), part(colour->blue));
    const auto picture = [&](const std::vector<std::byte>& png, const char* what, const std::string& words) {
      if (png.empty()) return;
      const std::string name = fmt::format("{}_{}.png", own, what);
      files.add(folder / name).text({reinterpret_cast<const char*>(png.data()), png.size()});
      materials += fmt::format("{} {}\n", words, name);
    };
    picture(object.colours, kColours, "map_Kd");
    picture(object.normals, kNormals, "norm");
    picture(object.heights, kHeights, fmt::format("disp -mm {} {}", -object.heightMm, 2 * object.heightMm));
  }
  files.add(folder / (stem + ".mtl")).text(materials);

  ByteSink& out = files.add(file);
  const auto numbers = [&](const char* what, std::initializer_list<double> values) {
    out.text(what);
    for (const double each : values) {
      out.text(" ");
      out.decimal(each);
    }
    out.text("\n");
  };
  out.text(fmt::format("# Written by Argil, units: mm\nmtllib {}.mtl\n", stem));
  Names names;
  size_t vertices = 1, places = 1;  // they count from 1
  for (size_t i = 0; i < objects.size(); ++i) {
    if (job) job->step(double(i) / double(objects.size()));
    const TexturedObject& object = objects[i];
    out.text(fmt::format("o {}\nusemtl {}\n", names.of(object.name), ownName(file, i)));
    std::vector<Vec3d> normals(object.mesh.positions.size(), Vec3d::UnitZ());
    for (size_t k = 0; k < object.frames.vertices.size(); ++k)
      normals[object.frames.vertices[k]] = object.frames.normals[k];
    for (const Vec3d& p : object.mesh.positions) numbers("v", {p.x(), p.y(), p.z()});
    for (const clay::Vec2d& p : object.map.places) numbers("vt", {p.x(), p.y()});
    for (const Vec3d& n : normals) numbers("vn", {n.x(), n.y(), n.z()});
    for (size_t f = 0; f < object.mesh.quads.size(); ++f) {
      out.text("f");
      for (size_t k = 0; k < 4; ++k) {
        out.text(" ");
        out.decimal(uint64_t(vertices + object.mesh.quads[f][k]));
        out.text("/");
        out.decimal(uint64_t(places + object.map.corners[f][k]));
        out.text("/");
        out.decimal(uint64_t(vertices + object.mesh.quads[f][k]));
      }
      out.text("\n");
    }
    vertices += object.mesh.positions.size();
    places += object.map.places.size();
  }
  return files.commit();
}

// The binary part of a .glb, and what the JSON says of it.
class Glb {
 public:
  explicit Glb(std::span<const TexturedObject> objects) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "Argil"}};
    json_["scene"] = 0;
    json_["scenes"] = Json::array({{{"nodes", Json::array()}}});
    for (const char* list : {"nodes", "meshes", "accessors", "bufferViews", "materials"}) json_[list] = Json::array();
    for (const TexturedObject& each : objects) add(each);
    json_["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
  }

  void write(AtomicFile& file) const {
    std::string json = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const uint64_t size = 12 + 8 + json.size() + 8 + bytes_.size();
    if (size > UINT32_MAX)
      throw Error("the model needs more than the 4 GiB of a .glb file; give fewer quads or pixels", Error::Kind::work);
    ByteSink sink(file);
    sink.text("glTF");
    for (const uint64_t number : {uint64_t{2}, size, uint64_t{json.size()}}) sink.little(uint32_t(number));
    sink.text("JSON");
    sink.text(json);
    sink.little(uint32_t(bytes_.size()));
    sink.text({"BIN\0", 4});
    sink.text({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()});
    sink.flush();
  }

 private:
  size_t view(const void* bytes, size_t size, int target) {
    Json out = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
    if (target != 0) out["target"] = target;
    const auto* begin = static_cast<const std::byte*>(bytes);
    bytes_.insert(bytes_.end(), begin, begin + size);
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    json_["bufferViews"].push_back(std::move(out));
    return json_["bufferViews"].size() - 1;
  }
  template <class T>
  size_t accessor(const std::vector<T>& list, int component, const char* type, size_t count, int target) {
    json_["accessors"].push_back({{"bufferView", view(list.data(), list.size() * sizeof(T), target)},
                                  {"componentType", component},
                                  {"count", count},
                                  {"type", type}});
    return json_["accessors"].size() - 1;
  }
  size_t texture(const std::vector<std::byte>& png) {
    json_["images"].push_back({{"bufferView", view(png.data(), png.size(), 0)}, {"mimeType", "image/png"}});
    json_["textures"].push_back({{"source", json_["images"].size() - 1}});
    return json_["textures"].size() - 1;
  }

  void add(const TexturedObject& object) {
    Vec3d low = Vec3d::Constant(INFINITY), high = -low;
    for (const Vec3d& p : object.mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const Vec3d middle = (low + high) / 2;
    if (!((high - low).maxCoeff() / kMetre < double(std::numeric_limits<float>::max())) || !middle.allFinite())
      throw Error("the model is too large for glTF; write .obj", Error::Kind::work);
    // Our z is glTF's y, and its z is towards us; a vertex for each place on the picture, whose y goes down.
    std::vector<std::array<float, 3>> positions, normals;
    std::vector<std::array<float, 4>> tangents;
    std::vector<std::array<float, 2>> places;
    const auto turned = [](const Vec3d& d) { return std::array<float, 3>{float(d.x()), float(d.z()), float(-d.y())}; };
    std::array<float, 3> least = {INFINITY, INFINITY, INFINITY}, most = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < object.map.places.size(); ++i) {
      positions.push_back(turned((object.mesh.positions[object.frames.vertices[i]] - middle) / kMetre));
      for (size_t k = 0; k < 3; ++k) {
        least[k] = std::min(least[k], positions.back()[k]);
        most[k] = std::max(most[k], positions.back()[k]);
      }
      normals.push_back(turned(object.frames.normals[i]));
      const std::array<float, 3> t = turned(object.frames.tangents[i]);
      tangents.push_back({t[0], t[1], t[2], 1});
      places.push_back({float(object.map.places[i].x()), float(1 - object.map.places[i].y())});
    }
    std::vector<std::array<uint32_t, 3>> triangles;
    for (size_t f = 0; f < object.mesh.quads.size(); ++f) {
      std::array<Vec3d, 4> corners;
      for (size_t k = 0; k < 4; ++k) corners[k] = object.mesh.positions[object.mesh.quads[f][k]];
      for (const auto& t : clay::trianglesOf(corners))
        triangles.push_back({object.map.corners[f][t[0]], object.map.corners[f][t[1]], object.map.corners[f][t[2]]});
    }
    Json primitive;
    const size_t at = accessor(positions, kFloat, "VEC3", positions.size(), kVertices);
    json_["accessors"][at]["min"] = least;
    json_["accessors"][at]["max"] = most;
    primitive["attributes"]["POSITION"] = at;
    primitive["attributes"]["NORMAL"] = accessor(normals, kFloat, "VEC3", normals.size(), kVertices);
    primitive["attributes"]["TANGENT"] = accessor(tangents, kFloat, "VEC4", tangents.size(), kVertices);
    primitive["attributes"]["TEXCOORD_0"] = accessor(places, kFloat, "VEC2", places.size(), kVertices);
    primitive["indices"] = accessor(triangles, kUnsignedInt, "SCALAR", 3 * triangles.size(), kIndices);

    Json base = {{"metallicFactor", 0}, {"roughnessFactor", 1}};
    if (!object.colours.empty())
      base["baseColorTexture"] = {{"index", texture(object.colours)}};
    else if (const std::optional<Colour>& c = object.colour)
      base["baseColorFactor"] = {linearOf(c->red) / 65535.0, linearOf(c->green) / 65535.0, linearOf(c->blue) / 65535.0,
                                 1};
    Json material = {{"pbrMetallicRoughness", std::move(base)}};
    if (!object.normals.empty()) material["normalTexture"] = {{"index", texture(object.normals)}};
    primitive["material"] = json_["materials"].size();
    json_["materials"].push_back(std::move(material));
    const std::string name = names_.of(object.name);
    json_["scenes"][0]["nodes"].push_back(json_["nodes"].size());
    json_["nodes"].push_back({{"name", name},
                              {"mesh", json_["meshes"].size()},
                              {"translation", {middle.x() / kMetre, middle.z() / kMetre, -middle.y() / kMetre}}});
    json_["meshes"].push_back({{"name", name}, {"primitives", Json::array({std::move(primitive)})}});
  }

  Json json_;
  Names names_;
  std::vector<std::byte> bytes_;
};

}  // namespace

bool holdsTextures(const fs::path& file) {
  const std::string ending = endingOf(file);
  return ending == ".obj" || ending == ".glb";
}

std::vector<std::string> texturedNames(const fs::path& file, size_t objects) {
  std::vector<std::string> names = {file.stem().string() + ".mtl"};
  for (size_t i = 0; i < objects; ++i)
    for (const char* what : {kColours, kNormals, kHeights})
      names.push_back(fmt::format("{}_{}.png", ownName(file, i), what));
  return names;
}

std::vector<std::string> writeTextured(const fs::path& file, std::span<const TexturedObject> objects, Job* job) {
  if (endingOf(file) == ".obj") return writeObj(file, objects, job);
  AtomicFile out(file);
  Glb(objects).write(out);
  out.commit();
  return {file.filename().string()};
}

}  // namespace argil::io
