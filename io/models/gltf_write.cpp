// glTF 2.0 (Khronos, ISO/IEC 12113), in one file: .glb, or .gltf with its buffer inside. Metres, y up.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "io/models/draco_mesh.h"
#include "io/models/format_table.h"

namespace argil::io {

namespace {

using Json = nlohmann::ordered_json;
using Bytes = std::span<const std::byte>;
using Emit = std::function<void(Bytes)>;

constexpr double kMetre = 1000;   // mm
constexpr size_t kPiece = 16384;  // elements between two looks at the job
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126, kVertices = 34962, kIndices = 34963;
constexpr const char* kHere = "@buffer@";  // where the buffer goes in a .gltf

[[noreturn]] void failWork(const std::string& what) {
  throw Error(what, Error::Kind::work);
}

/// About the middle of the object, which its node's translation names: 32-bit numbers are finest there. Our z is glTF's
/// y, and its z is towards us.
Placement placementAbout(const Vec3d& middleMm) {
  return {[middleMm](const Vec3d& p) {
            const Vec3d at = (p - middleMm) / kMetre;
            return FilePoint{float(at.x()), float(at.z()), float(-at.y())};
          },
          [middleMm](const FilePoint& p) -> Vec3d {
            return middleMm + kMetre * Vec3d(double(p[0]), -double(p[2]), double(p[1]));
          },
          [](const FilePoint& d) {
            return FilePoint{d[0], d[2], -d[1]};
          }};
}

Vec3d middleOf(const ModelObject& object) {
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  for (const Vec3d& p : object.mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec3d middle = (low + high) / 2;
  if (!((high - low).maxCoeff() / kMetre < double(std::numeric_limits<float>::max())) || !middle.allFinite())
    failWork("the model is too large for glTF; write .obj");
  return middle;
}

/// What follows the JSON: pieces that are written one after the other, each a buffer view.
class Document {
 public:
  Document(const ModelView& model, const WriteOptions& options, WriteReport& report, Job* job)
      : options_(options), report_(report), job_(job) {
    report.vertices = report.triangles = 0;
    json_["asset"] = {{"version", "2.0"}, {"generator", "Argil"}};
    for (const auto& [key, value] : model.metadata) json_["asset"]["extras"][key] = value;
    json_["scene"] = 0;
    json_["scenes"] = Json::array({{{"nodes", Json::array()}}});
    for (const char* list : {"nodes", "meshes", "accessors", "bufferViews"}) json_[list] = Json::array();
    if (options.draco) json_["extensionsUsed"] = json_["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    for (const ModelObject& object : model.objects) {
      if (!object.mesh.triangles.empty()) add(object);
    }
    done_ = 0;
  }

  [[nodiscard]] uint64_t bytes() const { return bytes_; }
  [[nodiscard]] std::string text(const Json& buffer) {
    json_["buffers"] = Json::array({buffer});
    return json_.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  void emit(const Emit& to) {
    for (const auto& each : pieces_) each(to);
  }

 private:
  void add(const ModelObject& object) {
    const Vec3d middle = middleOf(object);
    const Placement placement = placementAbout(middle);
    Json primitive = options_.draco ? addPacked(object, placement) : addPlain(object, placement);
    const bool plain = object.vertexColours.empty() && object.triangleColours.empty();
    primitive["material"] = materialOf(plain ? object.colour.value_or(Colour()) : Colour());
    Json node;
    if (!object.name.empty()) node["name"] = object.name;
    node["mesh"] = json_["meshes"].size();
    node["translation"] = {middle.x() / kMetre, middle.z() / kMetre, -middle.y() / kMetre};
    Json mesh;
    if (!object.name.empty()) mesh["name"] = object.name;
    mesh["primitives"] = Json::array({std::move(primitive)});
    json_["scenes"][0]["nodes"].push_back(json_["nodes"].size());
    json_["nodes"].push_back(std::move(node));
    json_["meshes"].push_back(std::move(mesh));
  }

  size_t materialOf(const Colour& colour) {
    const std::array<uint8_t, 4> key = {colour.red, colour.green, colour.blue, colour.alpha};
    const auto [at, isNew] = materials_.try_emplace(key, materials_.size());
    if (isNew) {
      const auto part = [](uint8_t c) { return linearOf(c) / 65535.0; };
      Json material = {
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {part(colour.red), part(colour.green), part(colour.blue), colour.alpha / 255.0}},
            {"metallicFactor", 0},
            {"roughnessFactor", 1}}}};
      if (colour.alpha != 255) material["alphaMode"] = "BLEND";
      json_["materials"].push_back(std::move(material));
    }
    return at->second;
  }

  [[nodiscard]] Normals normals() const { return options_.weld ? Normals::joined : Normals::creased; }

  size_t addView(uint64_t size, int target, std::function<void(const Emit&)> piece) {
    Json view = {{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    const uint64_t padding = (4 - size % 4) % 4;
    pieces_.push_back([piece = std::move(piece), padding](const Emit& to) {
      piece(to);
      const std::array<std::byte, 4> zero{};
      to(Bytes(zero).first(padding));
    });
    bytes_ += size + padding;
    json_["bufferViews"].push_back(std::move(view));
    return json_["bufferViews"].size() - 1;
  }

  size_t addAccessor(Json&& accessor, std::optional<size_t> view) {
    if (view) accessor["bufferView"] = *view;
    json_["accessors"].push_back(std::move(accessor));
    return json_["accessors"].size() - 1;
  }

  static Json positions(uint64_t count, const FilePoint& low, const FilePoint& high) {
    return {{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}, {"min", low}, {"max", high}};
  }
  static Json colours(uint64_t count) {
    return {{"componentType", kUnsignedShort}, {"normalized", true}, {"count", count}, {"type", "VEC4"}};
  }
  static Json normals(uint64_t count) { return {{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}}; }
  static Json indices(uint64_t triangles) {
    return {{"componentType", kUnsignedInt}, {"count", 3 * triangles}, {"type", "SCALAR"}};
  }

  Json addPacked(const ModelObject& object, const Placement& placement) {
    auto stream = std::make_shared<DracoStream>(
        packDraco({&object, 1}, placement, options_.quantization, DracoFor::gltf, normals(), job_));
    note(stream->points, stream->triangles, stream->coordinateMm, stream->distanceMm);
    Json primitive, ids;
    primitive["attributes"]["POSITION"] = addAccessor(positions(stream->points, stream->low, stream->high), {});
    ids["POSITION"] = stream->position;
    if (stream->colour >= 0) {
      primitive["attributes"]["COLOR_0"] = addAccessor(colours(stream->points), {});
      ids["COLOR_0"] = stream->colour;
    }
    primitive["attributes"]["NORMAL"] = addAccessor(normals(stream->points), {});
    ids["NORMAL"] = stream->normal;
    primitive["indices"] = addAccessor(indices(stream->triangles), {});
    const size_t view = addView(stream->bytes().size(), 0, [stream](const Emit& to) { to(stream->bytes()); });
    primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", std::move(ids)}};
    return primitive;
  }

  // Positions and colours are written out of the object when their turn comes; normals and points that were split are
  // kept until then.
  Json addPlain(const ModelObject& object, const Placement& placement) {
    const auto points = std::make_shared<SurfacePoints>(pointsOf(object, normals()));
    const std::vector<Vec3d>& places = object.mesh.positions;
    const auto& triangles = points->triangles.empty() ? object.mesh.triangles : points->triangles;
    const uint64_t count = points->count(object);
    const auto place = [points, &places](uint64_t i) -> const Vec3d& {
      return places[points->vertex.empty() ? i : points->vertex[i]];
    };
    FilePoint low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    double coordinate = 0;
    for (uint64_t i = 0; i < count; ++i) {
      const FilePoint at = placement.toFile(place(i));
      for (size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], at[k]);
        high[k] = std::max(high[k], at[k]);
      }
      coordinate = std::max(coordinate, (placement.toMm(at) - place(i)).cwiseAbs().maxCoeff());
    }
    note(count, triangles.size(), coordinate, 0);
    Json primitive;
    primitive["attributes"]["POSITION"] = addAccessor(
        positions(count, low, high),
        addArray<FilePoint>(count, kVertices, [place, placement](uint64_t i) { return placement.toFile(place(i)); }));
    primitive["attributes"]["NORMAL"] =
        addAccessor(normals(count), addArray<FilePoint>(count, kVertices, [points, placement](uint64_t i) {
                      return placement.directionToFile(points->normals[i]);
                    }));
    if (!points->colours.empty()) {
      primitive["attributes"]["COLOR_0"] =
          addAccessor(colours(count), addArray<std::array<uint16_t, 4>>(count, kVertices, [points](uint64_t i) {
                        const Colour& c = points->colours[i];
                        return std::array<uint16_t, 4>{linearOf(c.red), linearOf(c.green), linearOf(c.blue),
                                                       uint16_t(c.alpha * 257)};
                      }));
    }
    primitive["indices"] =
        addAccessor(indices(triangles.size()),
                    addArray<std::array<uint32_t, 3>>(triangles.size(), kIndices,
                                                      [points, &triangles](uint64_t i) { return triangles[i]; }));
    return primitive;
  }

  template <class T, class At>
  size_t addArray(uint64_t count, int target, const At& at) {
    return addView(count * sizeof(T), target, [this, count, at](const Emit& to) {
      std::vector<T> piece;
      for (uint64_t i = 0; i < count; i += kPiece) {
        piece.clear();
        for (uint64_t j = i; j < std::min<uint64_t>(i + kPiece, count); ++j) piece.push_back(at(j));
        to(std::as_bytes(std::span<const T>(piece)));
        done_ += piece.size() * sizeof(T);
        if (job_ != nullptr) job_->step(double(done_) / double(bytes_));
      }
    });
  }

  void note(uint64_t vertices, uint64_t triangles, double coordinateMm, double distanceMm) {
    report_.vertices += vertices;
    report_.triangles += triangles;
    report_.rounding = std::max(report_.rounding, coordinateMm);
    report_.deviation = std::max(report_.deviation, distanceMm);
  }

  const WriteOptions& options_;
  WriteReport& report_;
  Job* job_;
  Json json_;
  std::map<std::array<uint8_t, 4>, size_t> materials_;
  std::vector<std::function<void(const Emit&)>> pieces_;
  uint64_t bytes_ = 0, done_ = 0;
};

/// Three bytes become four letters; what is left of one piece waits for the next.
class Base64 {
 public:
  explicit Base64(ByteSink& sink) : sink_(sink) {}
  void add(Bytes bytes) {
    for (const std::byte b : bytes) {
      word_ = word_ << 8 | uint32_t(b);
      if (++count_ == 3) letters();
    }
    sink_.text(text_);
    text_.clear();
  }
  void end() {
    if (count_ == 0) return;
    const int missing = 3 - count_;
    word_ <<= 8 * missing;
    letters();
    text_.replace(text_.size() - size_t(missing), size_t(missing), size_t(missing), '=');
    sink_.text(text_);
  }

 private:
  void letters() {
    static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (const int shift : {18, 12, 6, 0}) text_ += kLetters[word_ >> shift & 63];
    word_ = 0;
    count_ = 0;
  }

  ByteSink& sink_;
  std::string text_;
  uint32_t word_ = 0;
  int count_ = 0;
};

}  // namespace

void writeGlb(AtomicFile& file, const ModelView& model, const WriteOptions& options, WriteReport& report, Job* job) {
  Document document(model, options, report, job);
  std::string json = document.text({{"byteLength", document.bytes()}});
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const uint64_t size = 12 + 8 + json.size() + 8 + document.bytes();
  if (size > UINT32_MAX)
    failWork("the model needs more than the 4 GiB of a .glb file; reduce it, or write it with Draco");
  ByteSink sink(file);
  sink.text("glTF");
  for (const uint64_t number : {uint64_t{2}, size, uint64_t{json.size()}}) sink.little(uint32_t(number));
  sink.text("JSON");
  sink.text(json);
  sink.little(uint32_t(document.bytes()));
  sink.text({"BIN\0", 4});
  document.emit([&](Bytes bytes) { sink.text({reinterpret_cast<const char*>(bytes.data()), bytes.size()}); });
  sink.flush();
}

void writeGltf(AtomicFile& file, const ModelView& model, const WriteOptions& options, WriteReport& report, Job* job) {
  Document document(model, options, report, job);
  const std::string json = document.text(
      {{"byteLength", document.bytes()}, {"uri", std::string("data:application/octet-stream;base64,") + kHere}});
  const size_t split = json.rfind(kHere);  // the buffers come last
  ByteSink sink(file);
  sink.text(std::string_view(json).substr(0, split));
  Base64 letters(sink);
  document.emit([&](Bytes bytes) { letters.add(bytes); });
  letters.end();
  sink.text(std::string_view(json).substr(split + std::strlen(kHere)));
  sink.flush();
}

}  // namespace argil::io
