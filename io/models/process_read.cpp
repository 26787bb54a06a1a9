// glTF, Draco, STEP and IGES: what a reader process sends becomes a model.

#include <algorithm>
#include <cmath>
#include <new>
#include <string_view>

#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "io/models/colour_list.h"
#include "io/models/format_table.h"
#include "io/models/reader_process.h"

namespace argil::io {

namespace {

constexpr uint64_t kMemoryAByte = 5;

/// Puts messages together and believes none of them.
class ModelAssembler {
 public:
  void take(wire::Kind kind, std::span<const std::byte> payload);
  ModelFile finish();

 private:
  template <class T, class Use>
  static void each(std::span<const std::byte> payload, uint64_t& missing, const Use& use) {
    if (payload.size() % sizeof(T) != 0 || payload.size() / sizeof(T) > missing) failWire();
    missing -= payload.size() / sizeof(T);
    for (; !payload.empty(); payload = payload.subspan(sizeof(T))) use(wireStruct<T>(payload));
  }
  void requireComplete() const {
    if (vertices_ != 0 || triangles_ != 0 || colours_ != 0 || triangleColours_ != 0) failWire();
  }

  ModelFile model_;
  uint64_t count_ = 0;                                                         // vertices of the object
  uint64_t vertices_ = 0, triangles_ = 0, colours_ = 0, triangleColours_ = 0;  // still to come
  uint64_t faces_ = 0;                                                         // that may still come
};

ModelFace faceOf(const wire::Face& from) {
  constexpr double kUnit = 1e-6;
  ModelFace face;
  if (from.kind > uint32_t(ModelFace::Kind::middle)) failWire();
  face.kind = static_cast<ModelFace::Kind>(from.kind);
  face.at = Vec3d(from.at), face.along = Vec3d(from.along), face.across = Vec3d(from.across);
  face.width = from.width, face.depth = from.depth;
  const bool frame = std::abs(face.along.norm() - 1) < kUnit && std::abs(face.across.norm() - 1) < kUnit &&
                     std::abs(face.along.dot(face.across)) < kUnit;
  if (!face.at.allFinite() || !frame || !(face.width >= 0 && std::isfinite(face.width)) ||
      !(face.depth >= 0 && std::isfinite(face.depth)))
    failWire();
  return face;
}

void ModelAssembler::take(wire::Kind kind, std::span<const std::byte> payload) {
  ModelObject* object = model_.objects.empty() ? nullptr : &model_.objects.back();
  switch (kind) {
    case wire::Kind::note:
      model_.notes.push_back(wireText(payload));
      return;
    case wire::Kind::format:
      model_.format = wireText(payload);
      return;
    case wire::Kind::metadata: {
      const auto split = std::find(payload.begin(), payload.end(), std::byte{0});
      if (split == payload.end()) failWire();
      const auto key = size_t(split - payload.begin());
      model_.metadata.emplace_back(wireText(payload.first(key)), wireText(payload.subspan(key + 1)));
      return;
    }
    case wire::Kind::object: {
      requireComplete();
      std::span<const std::byte> name;
      const auto head = wireStruct<wire::Object>(payload, &name);
      if (head.vertices == 0 || head.vertices > UINT32_MAX || head.triangles == 0) failWire();
      count_ = vertices_ = head.vertices;
      triangles_ = head.triangles;
      colours_ = head.hasColours != 0 ? head.vertices : 0;
      triangleColours_ = head.hasTriangleColours != 0 ? head.triangles : 0;
      faces_ = wire::kMostFaces;
      ModelObject& next = model_.objects.emplace_back();
      next.name = wireText(name);
      if (head.hasColour != 0) next.colour = Colour{head.colour[0], head.colour[1], head.colour[2], head.colour[3]};
      return;
    }
    case wire::Kind::positions:
      if (object == nullptr) failWire();
      return each<std::array<double, 3>>(payload, vertices_, [&](const std::array<double, 3>& p) {
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) failWire();
        object->mesh.positions.emplace_back(p[0], p[1], p[2]);
      });
    case wire::Kind::triangles:
      if (object == nullptr) failWire();
      return each<std::array<uint32_t, 3>>(payload, triangles_, [&](const std::array<uint32_t, 3>& corners) {
        if (std::max({corners[0], corners[1], corners[2]}) >= count_) failWire();
        object->mesh.triangles.push_back(corners);
      });
    case wire::Kind::colours:
      if (object == nullptr) failWire();
      return each<std::array<uint8_t, 4>>(payload, colours_, [&](const std::array<uint8_t, 4>& c) {
        object->vertexColours.push_back({c[0], c[1], c[2], c[3]});
      });
    case wire::Kind::triangleColours:
      if (object == nullptr) failWire();
      return each<std::array<uint8_t, 4>>(payload, triangleColours_, [&](const std::array<uint8_t, 4>& c) {
        object->triangleColours.push_back({c[0], c[1], c[2], c[3]});
      });
    case wire::Kind::faces:
      if (object == nullptr) failWire();
      requireComplete();
      return each<wire::Face>(payload, faces_, [&](const wire::Face& face) { object->faces.push_back(faceOf(face)); });
    case wire::Kind::end:
      requireComplete();
      if (object == nullptr) failWire();
      return;
    default:
      failWire();
  }
}

/// Vertices of equal coordinates become one, unless they differ in colour and some triangle blends its corners.
void weld(ModelObject& object) {
  clay::VertexWelder welder;
  std::vector<uint32_t> place(object.mesh.positions.size());
  welder.add(object.mesh.positions, place);
  object.mesh.positions = welder.take();
  const std::vector<Colour> before = std::move(object.vertexColours);
  std::vector<Colour> colours(before.empty() ? 0 : object.mesh.positions.size());
  for (size_t i = 0; i < before.size(); ++i) colours[place[i]] = before[i];
  bool same = true;
  for (size_t i = 0; same && i < before.size(); ++i) same = colours[place[i]] == before[i];
  std::vector<std::array<Colour, 3>> corners;
  if (!same) {
    for (const auto& [a, b, c] : object.mesh.triangles) corners.push_back({before[a], before[b], before[c]});
  }
  for (auto& triangle : object.mesh.triangles) {
    for (uint32_t& corner : triangle) corner = place[corner];
  }
  if (same)
    object.vertexColours = std::move(colours);
  else
    setCornerColours(object, corners);
}

ModelFile ModelAssembler::finish() {
  for (ModelObject& object : model_.objects) {
    model_.faces += object.mesh.triangles.size();
    // These formats split vertices where normals or colours jump. What is closed as it is stays: in it equal places are
    // different vertices that were rounded together.
    if (clay::checkTopology(object.mesh).boundaryEdges == 0) continue;
    weld(object);
    model_.welded = true;
  }
  return std::move(model_);
}

ModelFile readModelInProcess(const char* what, const std::filesystem::path& path, Job* job) {
  ModelAssembler model;
  ReaderLimits limits;
  std::error_code failed;
  // The file itself, its numbers as doubles, and what is sent of them.
  if (const uint64_t size = std::filesystem::file_size(path, failed); !failed)
    limits.memoryBytes = std::max(limits.memoryBytes, kMemoryAByte * size);
  try {
    runReader(
        what, path, [&](wire::Kind kind, std::span<const std::byte> payload) { model.take(kind, payload); }, job,
        limits);
    return model.finish();
  } catch (const std::bad_alloc&) {
    fail(displayName(path), "does not fit into memory; reduce it first");
  }
}

}  // namespace

bool recognizesGlb(const Input& input) {
  return input.text().starts_with("glTF");
}

bool recognizesGltf(const Input& input) {
  const std::string_view text = withoutMark(input.text());
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '{';
}

bool recognizesDraco(const Input& input) {
  return input.text().starts_with("DRACO");
}

bool recognizesStep(const Input& input) {
  return withoutMark(input.text()).starts_with("ISO-10303-21;");
}

bool recognizesIges(const Input& input) {
  // Cards of 80 columns, the last eight the section and its number: the first begins the section of the start.
  constexpr size_t kSection = 72, kNumber = 73, kCard = 80;
  const std::string_view text = withoutMark(input.text());
  if (text.size() < kCard || text[kSection] != 'S') return false;
  const std::string_view number = text.substr(kNumber, kCard - kNumber);
  return number.ends_with('1') && number.find_first_not_of(" 0") == number.size() - 1;
}

ModelFile readCad(const std::filesystem::path& path, Job* job) {
  if (!readsCad())
    fail(displayName(path),
         "is a CAD model, which is read by OpenCASCADE, and that is not part of this argil: export it "
         "as STL or 3MF in the program that made it");
  ModelFile model = readModelInProcess("cad", path, job);
  model.unitMm = 1;
  return model;
}

ModelFile readGltf(const std::filesystem::path& path, Job* job) {
  ModelFile model = readModelInProcess("gltf", path, job);
  model.unitMm = 1000;
  return model;
}

ModelFile readDraco(const std::filesystem::path& path, Job* job) {
  return readModelInProcess("draco", path, job);
}

}  // namespace argil::io
