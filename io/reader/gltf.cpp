// glTF 2.0 (Khronos, ISO/IEC 12113) with KHR_draco_mesh_compression and KHR_mesh_quantization.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "clay/base/error.h"
#include "clay/base/vec.h"
#include "io/bytes/empty_objects.h"
#include "io/reader/gltf_file.h"
#include "io/reader/mesh_data.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

using Json = GltfFile::Json;

constexpr uint64_t kTriangles = 4, kFan = 6;  // and strips between them
constexpr Bytes4 kWhite = {255, 255, 255, 255};
constexpr double kRounding = 1e-6;  // of the last row of a matrix that a program multiplied in 32 bits

constexpr uint64_t kMostPixels = uint64_t{1} << 28;  // of all pictures

/// Everything of the scene, in all instances: more would not fit into the limits of the other end either.
constexpr uint64_t kMostTriangles = uint64_t{1} << 28;

/// Triangles as the file has them. Nothing of a primitive is copied but what Draco unpacked: a model is large, and read
/// once.
class Primitive {
 public:
  /// What was checked: corners name vertices, and colours are as many as vertices.
  GltfFile::Numbers positions;
  std::optional<GltfFile::Numbers> colours, corners;
  uint64_t mode = kTriangles;
  std::array<double, 4> factor = {1, 1, 1, 1};  // base colour, linear
  std::optional<MeshData> unpacked;             // in place of the numbers
  // A picture of the base colour: the number of its surface, and how its places are moved (KHR_texture_transform).
  std::optional<uint32_t> surface;
  std::optional<GltfFile::Numbers> texturePlaces;
  std::array<double, 6> placing = {1, 0, 0, 1, 0, 0};  // u' = a u + c v + e, v' = b u + d v + f

  /// What multiplies colours of vertices: with a picture, its surface has the factor.
  [[nodiscard]] std::array<double, 4> tint() const { return surface ? std::array<double, 4>{1, 1, 1, 1} : factor; }
  [[nodiscard]] Bytes4 base() const {
    const auto [red, green, blue, alpha] = tint();
    return {srgbByte(red), srgbByte(green), srgbByte(blue), plainByte(alpha)};
  }
  [[nodiscard]] bool coloured() const { return unpacked ? !unpacked->colours.empty() : colours.has_value(); }
  [[nodiscard]] std::array<float, 2> texturePlace(uint64_t i) const {
    std::array<double, 4> at{};
    if (unpacked)
      at = {double(unpacked->texturePlaces[i][0]), double(unpacked->texturePlaces[i][1])};
    else
      texturePlaces->get(i, at.data());
    const auto finite = [](double x) { return std::abs(x) < 1e30 ? float(x) : 0.0f; };
    return {finite(placing[0] * at[0] + placing[2] * at[1] + placing[4]),
            finite(placing[1] * at[0] + placing[3] * at[1] + placing[5])};
  }
  [[nodiscard]] uint64_t vertices() const { return unpacked ? unpacked->positions.size() : positions.count(); }
  [[nodiscard]] uint64_t triangles() const {
    if (unpacked) return unpacked->triangles.size();
    const uint64_t count = cornerCount();
    return mode == kTriangles ? count / 3 : count < 3 ? 0 : count - 2;
  }
  [[nodiscard]] uint64_t cornerCount() const { return corners ? corners->count() : positions.count(); }

  [[nodiscard]] std::array<double, 3> position(uint64_t i) const {
    std::array<double, 3> at{};
    if (unpacked) return unpacked->positions[i];
    positions.get(i, at.data());
    return at;
  }
  [[nodiscard]] std::array<uint32_t, 3> triangle(uint64_t i) const {
    if (unpacked) return unpacked->triangles[i];
    if (mode == kTriangles) return {corner(3 * i), corner(3 * i + 1), corner(3 * i + 2)};
    if (mode == kFan) return {corner(i + 1), corner(i + 2), corner(0)};
    return {corner(i), corner(i + 1 + i % 2), corner(i + 2 - i % 2)};
  }
  /// COLOR_0 multiplies the base colour, both linear.
  [[nodiscard]] Bytes4 colour(uint64_t i) const {
    if (!coloured()) return base();
    if (unpacked) return unpacked->colours[i];
    std::array<double, 4> linear = {0, 0, 0, 1};
    colours->get(i, linear.data());
    const auto by = tint();
    return {srgbByte(linear[0] * by[0]), srgbByte(linear[1] * by[1]), srgbByte(linear[2] * by[2]),
            plainByte(linear[3] * by[3])};
  }

 private:
  [[nodiscard]] uint32_t corner(uint64_t i) const { return corners ? corners->index(i) : uint32_t(i); }
};

using Mesh = std::vector<Primitive>;

/// Sends as one array what `at` gives for 0 to `count`, a piece at a time.
template <class T, class At>
void sendArray(Sender& sender, wire::Kind kind, uint64_t count, const At& at) {
  constexpr uint64_t kPiece = 16384;
  std::vector<T> piece;
  for (uint64_t first = 0; first < count; first += kPiece) {
    piece.clear();
    for (uint64_t i = first; i < std::min(first + kPiece, count); ++i) piece.push_back(at(i));
    sender.array(kind, std::span<const T>(piece));
  }
}

class Scene {
 public:
  Scene(const std::filesystem::path& path, Sender& sender)
      : file_(path), sender_(sender), meshes_(file_.list("meshes").size()) {}
  void send();

 private:
  void refuseRequired() const;
  std::vector<uint64_t> roots();
  void sendNode(const Json& node, const Eigen::Affine3d& place);
  void sendPlaced(const Mesh& mesh, const Eigen::Affine3d& place, const std::string& name);
  std::vector<Eigen::Affine3d> instances(const Json& node, const std::string& name);
  const Mesh& mesh(uint64_t index);
  std::optional<Primitive> primitive(const Json& json, const std::string& name);
  std::array<double, 4> baseColour(const Json& primitive);
  const Json& basePicture(const Json& primitive) const;
  void usePicture(const Json& primitive, Primitive& part);
  std::optional<uint32_t> surfaceOf(uint64_t material);
  std::optional<uint32_t> sentSurface(uint64_t material);
  std::optional<uint32_t> pictureOf(uint64_t texture);
  void noteOnce(const std::string& sentence) {
    if (std::find(noted_.begin(), noted_.end(), sentence) == noted_.end()) noted_.push_back(sentence);
  }

  GltfFile file_;
  Sender& sender_;
  std::vector<std::optional<Mesh>> meshes_;
  std::vector<std::string> noted_, empty_;                           // sentences; names of objects without triangles
  std::map<uint64_t, std::optional<uint32_t>> pictures_, surfaces_;  // by images and materials: as they were sent
  uint32_t pictureCount_ = 0, surfaceCount_ = 0;
  uint64_t pixels_ = 0;
  bool draco_ = false;
  uint64_t triangles_ = 0, objects_ = 0;
};

/// The node's own transform: its matrix, or translation · rotation · scale.
Eigen::Affine3d transformOf(const Json& node, uint64_t index) {
  const std::string name = "node " + std::to_string(index);
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  const auto matrix = GltfFile::numbers(node, "matrix", 16);
  if (!matrix.empty()) {
    transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix.data());
    const Eigen::RowVector4d last(0, 0, 0, 1);
    if (!((transform.matrix().row(3) - last).cwiseAbs().maxCoeff() <= kRounding))
      throw Error(name + " has a matrix with perspective; export it again");
    transform.matrix().row(3) = last;
    return transform;
  }
  const auto translation = GltfFile::numbers(node, "translation", 3), rotation = GltfFile::numbers(node, "rotation", 4),
             scale = GltfFile::numbers(node, "scale", 3);
  if (!translation.empty()) transform.translate(Vec3d(translation[0], translation[1], translation[2]));
  if (!rotation.empty()) {
    const Eigen::Quaterniond turn(rotation[3], rotation[0], rotation[1], rotation[2]);
    if (!(turn.norm() > 1e-6 && turn.norm() < 1e6)) throw Error(name + " has a rotation that is none; export it again");
    transform.rotate(turn.normalized());
  }
  if (!scale.empty()) transform.scale(Vec3d(scale[0], scale[1], scale[2]));
  return transform;
}

void Scene::refuseRequired() const {
  for (const Json& each : file_.list("extensionsRequired")) {
    const std::string name = each.is_string() ? each.get<std::string>() : "?";
    const bool harmless = name == "KHR_draco_mesh_compression" || name == "KHR_mesh_quantization" ||
                          name.rfind("KHR_materials_", 0) == 0 || name.rfind("KHR_texture_", 0) == 0 ||
                          name.rfind("EXT_texture_", 0) == 0 || name == "KHR_lights_punctual" ||
                          name == "EXT_mesh_gpu_instancing" || name == "MSFT_texture_dds";
    if (!harmless)
      throw Error("needs the extension " + name.substr(0, 60) + ", which cannot be read; export it without");
  }
}

/// The nodes of the scene that the file opens with; without scenes those that are nobody's child.
std::vector<uint64_t> Scene::roots() {
  const auto listed = [&](const Json& owner, const char* key) {
    std::vector<uint64_t> nodes;
    for (const Json& each : GltfFile::member(owner, key)) {
      if (!each.is_number_unsigned()) throw Error("is damaged: it names a node by no number; export it again");
      nodes.push_back(each.get<uint64_t>());
    }
    return nodes;
  };
  const size_t scenes = file_.list("scenes").size();
  if (scenes > 1) noteOnce("the file has " + std::to_string(scenes) + " scenes: the one that it opens with was read");
  if (scenes > 0)
    return listed(file_.item("scenes", GltfFile::optionalIndex(file_.root(), "scene").value_or(0)), "nodes");
  const size_t count = file_.list("nodes").size();
  std::vector<bool> child(count);
  for (size_t i = 0; i < count; ++i) {
    for (const uint64_t each : listed(file_.item("nodes", i), "children")) {
      if (each < count) child[each] = true;
    }
  }
  std::vector<uint64_t> nodes;
  for (size_t i = 0; i < count; ++i) {
    if (!child[i]) nodes.push_back(i);
  }
  return nodes;
}

void Scene::send() {
  refuseRequired();
  struct Visit {
    uint64_t node;
    Eigen::Affine3d place;
  };
  // glTF is y-up and ours is z-up: its y is our z, its z is towards us.
  Eigen::Affine3d upright = Eigen::Affine3d::Identity();
  upright.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  std::vector<Visit> open;
  for (const uint64_t node : roots()) open.push_back({node, upright});
  std::reverse(open.begin(), open.end());
  std::vector<bool> seen(file_.list("nodes").size());
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    const Json& node = file_.item("nodes", visit.node);
    if (seen[visit.node])
      throw Error("is damaged: node " + std::to_string(visit.node) +
                  " lies below itself or below two nodes; export it again");
    seen[visit.node] = true;
    const Eigen::Affine3d place = visit.place * transformOf(node, visit.node);
    if (node.contains("mesh")) sendNode(node, place);
    const Json& children = GltfFile::member(node, "children");
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      if (!child->is_number_unsigned()) throw Error("is damaged: it names a node by no number; export it again");
      open.push_back({child->get<uint64_t>(), place});
    }
  }
  if (triangles_ == 0) {
    throw Error("holds no triangles (read as glTF" + std::string(noted_.empty() ? "" : "; " + noted_.front()) +
                "); check what was exported");
  }
  if (!file_.list("animations").empty()) noteOnce("animations are not kept");
  sender_.text(wire::Kind::format,
               std::string("glTF (") + (file_.binary() ? "binary" : "text") + (draco_ ? ", Draco)" : ")"));
  const Json& asset = GltfFile::member(file_.root(), "asset");
  for (const char* key : {"generator", "copyright"}) {
    const std::string value = GltfFile::text(asset, key);
    if (!value.empty()) sender_.text(wire::Kind::metadata, key + std::string(1, '\0') + value);
  }
  const Json& extras = asset.contains("extras") ? asset.at("extras") : asset;
  if (&extras != &asset && extras.is_object()) {
    for (const auto& [key, value] : extras.items()) {
      if (value.is_string() && key.size() < 100)
        sender_.text(wire::Kind::metadata, key + std::string(1, '\0') + value.get<std::string>());
    }
  }
  if (!empty_.empty()) sender_.note(emptyObjects(empty_));
  for (const std::string& sentence : noted_) sender_.note(sentence);
}

void Scene::sendNode(const Json& node, const Eigen::Affine3d& place) {
  const uint64_t index = GltfFile::index(node, "mesh");
  const Mesh& local = mesh(index);
  if (node.contains("skin")) noteOnce("skins are not kept: what they bend is as it was modelled");
  const std::string own = GltfFile::text(node, "name");
  const std::string name = own.empty() ? GltfFile::text(file_.item("meshes", index), "name") : own;
  if (local.empty()) {
    empty_.push_back(name);
    return;
  }
  for (const Eigen::Affine3d& instance : instances(node, name)) sendPlaced(local, place * instance, name);
}

/// Where the node has its mesh: once as it is, or where EXT_mesh_gpu_instancing repeats it.
std::vector<Eigen::Affine3d> Scene::instances(const Json& node, const std::string& name) {
  const Json& attributes =
      GltfFile::member(GltfFile::member(GltfFile::member(node, "extensions"), "EXT_mesh_gpu_instancing"), "attributes");
  if (attributes.is_null()) return {Eigen::Affine3d::Identity()};
  std::optional<size_t> count;
  const auto read = [&](const char* key, size_t wanted) {
    std::vector<double> values;
    if (!attributes.contains(key)) return values;
    const GltfFile::Numbers numbers = file_.values(GltfFile::index(attributes, key));
    bool good = numbers.components() == wanted && count.value_or(numbers.count()) == numbers.count();
    if (good) values.resize(numbers.count() * wanted);
    for (uint64_t i = 0; good && i < numbers.count(); ++i) numbers.get(i, values.data() + i * wanted);
    good = good && std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
    if (!good)
      throw Error("is damaged: the instances of " + (name.empty() ? std::string("a node") : name) +
                  " disagree in their " + key + "; export it again");
    count = numbers.count();
    return values;
  };
  const std::vector<double> moves = read("TRANSLATION", 3), turns = read("ROTATION", 4), scales = read("SCALE", 3);
  std::vector<Eigen::Affine3d> places(count.value_or(0), Eigen::Affine3d::Identity());
  for (size_t i = 0; i < places.size(); ++i) {
    Eigen::Affine3d& place = places[i];
    if (!moves.empty()) place.translate(Vec3d(moves[3 * i], moves[3 * i + 1], moves[3 * i + 2]));
    if (!turns.empty()) {
      const Eigen::Quaterniond turn(turns[4 * i + 3], turns[4 * i], turns[4 * i + 1], turns[4 * i + 2]);
      if (!(turn.norm() > 1e-6)) throw Error("has an instance with a rotation that is none; export it again");
      place.rotate(turn.normalized());
    }
    if (!scales.empty()) place.scale(Vec3d(scales[3 * i], scales[3 * i + 1], scales[3 * i + 2]));
  }
  return places;
}

/// All primitives as one object, as they bound one body together. Each vertex belongs to one primitive, so colours of
/// primitives can be colours of vertices.
void Scene::sendPlaced(const Mesh& mesh, const Eigen::Affine3d& place, const std::string& name) {
  wire::Object object{};
  for (const Primitive& part : mesh) {
    object.vertices += part.vertices();
    object.triangles += part.triangles();
    if (part.coloured() || part.base() != mesh.front().base()) object.hasColours = 1;
    if (part.surface) object.hasPlaces = 1;
  }
  triangles_ += object.triangles;
  if (triangles_ > kMostTriangles)
    throw Error("places more than " + std::to_string(kMostTriangles) + " triangles; export fewer instances");
  if (++objects_ > wire::kMostObjects)
    throw Error("places more than " + std::to_string(wire::kMostObjects) + " objects; join some of them");
  if (object.vertices > UINT32_MAX) throw Error("has a mesh of more vertices than can be numbered; split it first");
  if (object.hasColours == 0 && object.hasPlaces == 0 && mesh.front().base() != kWhite) {
    object.hasColour = 1;
    const Bytes4 colour = mesh.front().base();
    std::copy(colour.begin(), colour.end(), object.colour);
  }
  sender_.named(wire::Kind::object, object, name);
  for (const Primitive& part : mesh) {
    sendArray<std::array<double, 3>>(sender_, wire::Kind::positions, part.vertices(), [&](uint64_t i) {
      const std::array<double, 3> p = part.position(i);
      const Vec3d at = place * Vec3d(p[0], p[1], p[2]);
      if (!at.allFinite()) throw Error("has a vertex whose coordinates are not finite; export it again");
      return std::array<double, 3>{at.x(), at.y(), at.z()};
    });
  }
  const bool mirrors = place.linear().determinant() < 0;
  uint32_t first = 0;
  for (const Primitive& part : mesh) {
    sendArray<std::array<uint32_t, 3>>(sender_, wire::Kind::triangles, part.triangles(), [&](uint64_t i) {
      auto [a, b, c] = part.triangle(i);
      if (mirrors) std::swap(b, c);
      return std::array<uint32_t, 3>{a + first, b + first, c + first};
    });
    first += uint32_t(part.vertices());
  }
  if (object.hasColours != 0) {
    for (const Primitive& part : mesh)
      sendArray<Bytes4>(sender_, wire::Kind::colours, part.vertices(), [&](uint64_t i) { return part.colour(i); });
  }
  if (object.hasPlaces == 0) return;
  for (const Primitive& part : mesh) {
    sendArray<wire::Places>(sender_, wire::Kind::places, part.triangles(), [&](uint64_t i) {
      wire::Places places{{}, wire::kNoSurface};
      if (!part.surface) return places;
      places.surface = *part.surface;
      auto [a, b, c] = part.triangle(i);
      if (mirrors) std::swap(b, c);
      size_t k = 0;
      for (const uint32_t corner : {a, b, c}) {
        const auto [u, v] = part.texturePlace(corner);
        places.at[k++] = u, places.at[k++] = v;
      }
      return places;
    });
  }
}

/// The primitives of a mesh that have triangles.
const Mesh& Scene::mesh(uint64_t index) {
  const Json& object = file_.item("meshes", index);
  if (meshes_[index]) return *meshes_[index];
  Mesh parts;
  for (const Json& json : GltfFile::member(object, "primitives")) {
    if (!json.is_object())
      throw Error("is damaged: mesh " + std::to_string(index) + " has a primitive that is none; export it again");
    std::optional<Primitive> part = primitive(json, "mesh " + std::to_string(index));
    if (part && part->triangles() > 0) parts.push_back(std::move(*part));
  }
  return meshes_[index].emplace(std::move(parts));
}

/// Linear.
std::array<double, 4> Scene::baseColour(const Json& primitive) {
  std::array<double, 4> factor = {1, 1, 1, 1};
  const auto material = GltfFile::optionalIndex(primitive, "material");
  if (!material) return factor;
  const Json& base = GltfFile::member(file_.item("materials", *material), "pbrMetallicRoughness");
  const auto values = GltfFile::numbers(base, "baseColorFactor", 4);
  if (!values.empty()) std::copy(values.begin(), values.end(), factor.begin());
  return factor;
}

/// The texture of a primitive's base colour; null when it has none.
const Json& Scene::basePicture(const Json& primitive) const {
  const auto material = GltfFile::optionalIndex(primitive, "material");
  static const Json kNone;
  if (!material) return kNone;
  return GltfFile::member(GltfFile::member(file_.item("materials", *material), "pbrMetallicRoughness"),
                          "baseColorTexture");
}

/// Without places on the picture the surface has one colour.
void Scene::usePicture(const Json& primitive, Primitive& part) {
  const Json& picture = basePicture(primitive);
  if (picture.is_null()) return;
  const bool placed = part.unpacked ? part.unpacked->texturePlaces.size() == part.unpacked->positions.size()
                                    : part.texturePlaces.has_value();
  if (!placed) {
    if (part.surface) noteOnce("a surface has a picture and no places on it: it has one colour");
    part.surface.reset();
    return;
  }
  const Json& moved = GltfFile::member(GltfFile::member(picture, "extensions"), "KHR_texture_transform");
  const auto offset = GltfFile::numbers(moved, "offset", 2), scale = GltfFile::numbers(moved, "scale", 2);
  double turn = 0;
  if (moved.is_object() && moved.contains("rotation") && moved.at("rotation").is_number())
    turn = moved.at("rotation").get<double>();
  const double su = scale.empty() ? 1 : scale[0], sv = scale.empty() ? 1 : scale[1];
  const double cosine = std::cos(turn), sine = std::sin(turn);
  // Translation · rotation · scale, as the extension has it: v points down, so it turns against the clock.
  part.placing = {
      cosine * su, -sine * su, sine * sv, cosine * sv, offset.empty() ? 0 : offset[0], offset.empty() ? 0 : offset[1]};
}

/// Sends how the picture of a material lies on surfaces, and the picture where it is a new one. What is wrong with
/// either is noted: then the surface has one colour.
std::optional<uint32_t> Scene::surfaceOf(uint64_t material) {
  try {
    return sentSurface(material);
  } catch (const Error& error) {
    noteOnce("a picture was left out and its surface has one colour: " + std::string(error.what()));
    return {};
  }
}

std::optional<uint32_t> Scene::sentSurface(uint64_t material) {
  const Json& object = file_.item("materials", material);
  const Json& base = GltfFile::member(object, "pbrMetallicRoughness");
  const uint64_t texture = GltfFile::index(GltfFile::member(base, "baseColorTexture"), "index");
  const auto picture = pictureOf(texture);
  if (!picture || surfaceCount_ == wire::kMostSurfaces) return {};
  wire::Surface surface{};
  const auto factor = GltfFile::numbers(base, "baseColorFactor", 4);
  for (size_t k = 0; k < 4; ++k) surface.factor[k] = factor.empty() ? 1.0f : float(std::clamp(factor[k], 0.0, 1.0));
  surface.cutoff = 0.5f;
  if (object.contains("alphaCutoff") && object.at("alphaCutoff").is_number())
    surface.cutoff = float(std::clamp(object.at("alphaCutoff").get<double>(), 0.0, 2.0));
  const std::string mode = GltfFile::text(object, "alphaMode");
  surface.alpha = mode == "MASK" ? 1 : mode == "BLEND" ? 2 : 0;
  surface.tinted = 1;
  surface.picture = *picture;
  constexpr uint64_t kClamp = 33071, kMirror = 33648;
  const auto wrap = [&](const char* key) -> uint8_t {
    const auto sampler = GltfFile::optionalIndex(file_.item("textures", texture), "sampler");
    const uint64_t how = sampler ? GltfFile::optionalIndex(file_.item("samplers", *sampler), key).value_or(0) : 0;
    return how == kMirror ? 1 : how == kClamp ? 2 : 0;
  };
  surface.wrapU = wrap("wrapS"), surface.wrapV = wrap("wrapT");
  sender_.named(wire::Kind::surface, surface, {});
  return surfaceCount_++;
}

/// Sends the picture of a texture, once; its number.
std::optional<uint32_t> Scene::pictureOf(uint64_t texture) {
  const Json& object = file_.item("textures", texture);
  const auto image = GltfFile::optionalIndex(object, "source");
  if (!image) {
    noteOnce("a picture of another kind than PNG and JPEG was left out: its surface has one colour");
    return {};
  }
  const auto known = pictures_.find(*image);
  if (known != pictures_.end()) return known->second;
  std::optional<uint32_t>& number = pictures_[*image];
  try {
    const DecodedPicture picture = decodePicture(file_.image(*image), int(wire::kMostPictureEdge));
    if (pictureCount_ == wire::kMostSurfaces || picture.pixels.size() > kMostPixels - pixels_)
      throw Error("the file has too many pictures");
    pixels_ += picture.pixels.size();
    sender_.named(wire::Kind::picture, wire::Picture{picture.width, picture.height}, {});
    sender_.array(wire::Kind::pixels, std::span<const std::array<uint8_t, 4>>(picture.pixels));
    number = pictureCount_++;
  } catch (const Error& error) {
    noteOnce("a picture was left out and its surface has one colour: " + std::string(error.what()));
  }
  return number;
}

std::optional<Primitive> Scene::primitive(const Json& json, const std::string& name) {
  Primitive part;
  part.mode = GltfFile::optionalIndex(json, "mode").value_or(kTriangles);
  if (part.mode > kFan)
    throw Error("is damaged: " + name + " has primitives of the unknown mode " + std::to_string(part.mode) +
                "; export it again");
  if (part.mode < kTriangles) {
    noteOnce("points and lines are not kept");
    return {};
  }
  if (json.contains("targets")) noteOnce("morph targets are not kept");
  part.factor = baseColour(json);
  const Json& picture = basePicture(json);
  std::string placesKey;
  if (!picture.is_null()) {
    const Json& moved = GltfFile::member(GltfFile::member(picture, "extensions"), "KHR_texture_transform");
    const uint64_t set = (moved.is_object() ? GltfFile::optionalIndex(moved, "texCoord") : std::nullopt)
                             .value_or(GltfFile::optionalIndex(picture, "texCoord").value_or(0));
    placesKey = "TEXCOORD_" + std::to_string(set);
    const uint64_t material = GltfFile::index(json, "material");
    const auto known = surfaces_.find(material);
    part.surface =
        known != surfaces_.end() ? known->second : surfaces_.emplace(material, surfaceOf(material)).first->second;
  }
  const Json& attributes = GltfFile::member(json, "attributes");
  const Json& packed = GltfFile::member(GltfFile::member(json, "extensions"), "KHR_draco_mesh_compression");
  if (!packed.is_null()) {
    draco_ = true;
    const Json& ids = GltfFile::member(packed, "attributes");
    part.unpacked = decodeDraco(file_.view(GltfFile::index(packed, "bufferView")), GltfFile::index(ids, "POSITION"),
                                GltfFile::optionalIndex(ids, "COLOR_0"), part.tint(),
                                placesKey.empty() ? std::nullopt : GltfFile::optionalIndex(ids, placesKey.c_str()));
    usePicture(json, part);
    return part;
  }
  if (!attributes.is_object() || !attributes.contains("POSITION")) {
    noteOnce("meshes without positions were left out");
    return {};
  }
  part.positions = file_.values(GltfFile::index(attributes, "POSITION"));
  if (part.positions.components() != 3)
    throw Error("is damaged: " + name + " has positions of " + std::to_string(part.positions.components()) +
                " coordinates; export it again");
  const uint64_t vertices = part.positions.count();
  if (attributes.contains("COLOR_0")) {
    const GltfFile::Numbers& colours = part.colours.emplace(file_.values(GltfFile::index(attributes, "COLOR_0")));
    if (colours.components() < 3) throw Error("is damaged: " + name + " has colours of two parts; export it again");
    if (colours.count() != vertices)
      throw Error("is damaged: " + name + " has another number of colours than of vertices; export it again");
    std::array<double, 4> colour{};
    for (uint64_t i = 0; i < vertices; ++i) {
      colours.get(i, colour.data());
      if (!std::all_of(colour.begin(), colour.end(), [](double v) { return std::isfinite(v); }))
        throw Error("is damaged: " + name + " has a colour that is not finite; export it again");
    }
  }
  if (!placesKey.empty() && attributes.contains(placesKey)) {
    GltfFile::Numbers places = file_.values(GltfFile::index(attributes, placesKey.c_str()));
    if (places.components() == 2 && places.count() == vertices) part.texturePlaces = std::move(places);
  }
  usePicture(json, part);
  if (const auto indices = GltfFile::optionalIndex(json, "indices")) {
    const GltfFile::Numbers& corners = part.corners.emplace(file_.indices(*indices));
    for (uint64_t i = 0; i < corners.count(); ++i) {
      if (const uint32_t corner = corners.index(i); corner >= vertices) {
        throw Error("is damaged: " + name + " names vertex " + std::to_string(corner) + " of " +
                    std::to_string(vertices) + "; export it again");
      }
    }
  }
  if (part.mode == kTriangles && part.cornerCount() % 3 != 0)
    throw Error("is damaged: " + name + " has " + std::to_string(part.cornerCount()) +
                " corners, which are no whole triangles; export it again");
  return part;
}

}  // namespace

void readGltf(const std::filesystem::path& file, Sender& sender) {
  Scene(file, sender).send();
}

}  // namespace argil::io::reader
