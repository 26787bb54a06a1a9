// glTF, Draco, STEP and IGES: what a reader process sends becomes a model.

#include <algorithm>
#include <cmath>
#include <cstring>
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
    if (vertices_ != 0 || triangles_ != 0 || colours_ != 0 || triangleColours_ != 0 || places_ != 0) failWire();
    if (picture_ && picture_->rgba.size() != 4 * size_t(picture_->width) * size_t(picture_->height)) failWire();
  }
  void takePicture(wire::Kind kind, std::span<const std::byte> payload);
  void addPlaces(ModelObject& object, const wire::Places& places) const;
  void keepUsedPictures(ModelObject& object) const;

  ModelFile model_;
  uint64_t count_ = 0;                                                         // vertices of the object
  uint64_t vertices_ = 0, triangles_ = 0, colours_ = 0, triangleColours_ = 0;  // still to come
  uint64_t faces_ = 0;                                                         // that may still come
  uint64_t places_ = 0;                                                        // still to come
  std::shared_ptr<ColourImage> picture_;                                       // the last one
  std::vector<std::shared_ptr<const ColourImage>> pictures_;
  std::vector<SurfacePicture> surfaces_;
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
      places_ = head.hasPlaces != 0 ? head.triangles : 0;
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
    case wire::Kind::picture:
    case wire::Kind::pixels:
    case wire::Kind::surface:
      return takePicture(kind, payload);
    case wire::Kind::places:
      if (object == nullptr) failWire();
      return each<wire::Places>(payload, places_, [&](const wire::Places& places) { addPlaces(*object, places); });
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

void ModelAssembler::takePicture(wire::Kind kind, std::span<const std::byte> payload) {
  if (kind == wire::Kind::pixels) {
    if (!picture_ || payload.size() % 4 != 0) failWire();
    const size_t whole = 4 * size_t(picture_->width) * size_t(picture_->height), first = picture_->rgba.size();
    if (payload.size() > whole - first) failWire();
    picture_->rgba.resize(first + payload.size());
    std::memcpy(picture_->rgba.data() + first, payload.data(), payload.size());
    return;
  }
  requireComplete();
  if (kind == wire::Kind::picture) {
    const auto head = wireStruct<wire::Picture>(payload);
    constexpr uint32_t kMost = wire::kMostPictureEdge;
    if (head.width < 1 || head.height < 1 || head.width > kMost || head.height > kMost) failWire();
    picture_ = std::make_shared<ColourImage>();
    picture_->width = int(head.width), picture_->height = int(head.height);
    pictures_.push_back(picture_);
    return;
  }
  const auto from = wireStruct<wire::Surface>(payload);
  if (from.picture >= pictures_.size() || from.wrapU > 2 || from.wrapV > 2 || from.alpha > 2) failWire();
  SurfacePicture surface;
  surface.picture = pictures_[from.picture];
  for (size_t k = 0; k < 4; ++k) surface.factor[k] = from.factor[k];
  const auto isPart = [](float part) { return part >= 0 && part <= 1; };
  if (!std::all_of(surface.factor.begin(), surface.factor.end(), isPart) || !std::isfinite(from.cutoff)) failWire();
  surface.cutoff = from.cutoff;
  surface.wrapU = SurfacePicture::Wrap(from.wrapU), surface.wrapV = SurfacePicture::Wrap(from.wrapV);
  surface.alpha = SurfacePicture::Alpha(from.alpha);
  surface.tinted = from.tinted != 0;
  surfaces_.push_back(std::move(surface));
}

void ModelAssembler::addPlaces(ModelObject& object, const wire::Places& places) const {
  PicturePlaces of;
  if (places.surface != wire::kNoSurface) {
    if (places.surface >= surfaces_.size()) failWire();
    of.picture = places.surface;
  }
  for (size_t k = 0; k < 6; ++k) {
    if (!std::isfinite(places.at[k])) failWire();
    of.corners[k / 2][k % 2] = places.at[k];
  }
  object.places.push_back(of);
}

void ModelAssembler::keepUsedPictures(ModelObject& object) const {
  std::vector<uint32_t> number(surfaces_.size(), PicturePlaces::kNone);
  for (PicturePlaces& each : object.places) {
    if (each.picture == PicturePlaces::kNone) continue;
    uint32_t& own = number[each.picture];
    if (own == PicturePlaces::kNone) {
      own = uint32_t(object.pictures.size());
      object.pictures.push_back(surfaces_[each.picture]);
    }
    each.picture = own;
  }
  if (object.pictures.empty()) object.places.clear();
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
    keepUsedPictures(object);
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
