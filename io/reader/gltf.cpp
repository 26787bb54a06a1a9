// glTF 2.0 (Khronos, ISO/IEC 12113) with KHR_draco_mesh_compression and KHR_mesh_quantization.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "clay/error.h"
#include "clay/vec.h"
#include "io/reader/gltf_file.h"
#include "io/reader/mesh_data.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

using Json = GltfFile::Json;

constexpr uint64_t kTriangles = 4, kFan = 6;  // and strips between them
constexpr Bytes4 kWhite = {255, 255, 255, 255};
constexpr double kRounding = 1e-6;  // of the last row of a matrix that a program multiplied in 32 bits

/// Everything of the scene, in all instances: more would not fit into the limits of the other end either.
constexpr uint64_t kMostTriangles = uint64_t{1} << 28;

class Scene {
 public:
  Scene(const std::filesystem::path& path, Sender& sender)
      : file_(path), sender_(sender), meshes_(file_.list("meshes").size()) {}
  void send();

 private:
  void refuseRequired() const;
  std::vector<uint64_t> roots();
  void sendNode(const Json& node, const Eigen::Affine3d& place);
  void sendPlaced(const MeshData& local, const Eigen::Affine3d& place, const std::string& name);
  std::vector<Eigen::Affine3d> instances(const Json& node, const std::string& name);
  const MeshData& mesh(uint64_t index);
  MeshData primitiveData(const Json& primitive, const std::string& name);
  std::array<double, 4> baseColour(const Json& primitive);
  void noteOnce(const std::string& sentence) {
    if (std::find(noted_.begin(), noted_.end(), sentence) == noted_.end()) noted_.push_back(sentence);
  }

  GltfFile file_;
  Sender& sender_;
  std::vector<std::optional<MeshData>> meshes_;
  std::vector<std::string> noted_;
  bool draco_ = false;
  uint64_t triangles_ = 0;
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
  for (const std::string& sentence : noted_) sender_.note(sentence);
}

void Scene::sendNode(const Json& node, const Eigen::Affine3d& place) {
  const uint64_t index = GltfFile::index(node, "mesh");
  const MeshData& local = mesh(index);
  if (local.triangles.empty()) return;
  if (node.contains("skin")) noteOnce("skins are not kept: what they bend is as it was modelled");
  const std::string own = GltfFile::text(node, "name");
  const std::string name = own.empty() ? GltfFile::text(file_.item("meshes", index), "name") : own;
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
    size_t components = 0;
    values = file_.values(GltfFile::index(attributes, key), components);
    const auto isFinite = [](double v) { return std::isfinite(v); };
    if (components != wanted || !std::all_of(values.begin(), values.end(), isFinite) ||
        count.value_or(values.size() / wanted) != values.size() / wanted)
      throw Error("is damaged: the instances of " + (name.empty() ? std::string("a node") : name) +
                  " disagree in their " + key + "; export it again");
    count = values.size() / wanted;
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

void Scene::sendPlaced(const MeshData& local, const Eigen::Affine3d& place, const std::string& name) {
  triangles_ += local.triangles.size();
  if (triangles_ > kMostTriangles)
    throw Error("places more than " + std::to_string(kMostTriangles) + " triangles; export fewer instances");
  MeshData placed = local;
  for (auto& position : placed.positions) {
    const Vec3d at = place * Vec3d(position[0], position[1], position[2]);
    position = {at.x(), at.y(), at.z()};
  }
  if (place.linear().determinant() < 0) {
    for (auto& triangle : placed.triangles) std::swap(triangle[1], triangle[2]);
  }
  sendMesh(placed, name, sender_);
}

/// All primitives of a mesh as one, as they bound one body together. Each vertex belongs to one primitive, so colours
/// of primitives can be colours of vertices.
const MeshData& Scene::mesh(uint64_t index) {
  const Json& object = file_.item("meshes", index);
  if (meshes_[index]) return *meshes_[index];
  std::vector<MeshData> parts;
  for (const Json& primitive : GltfFile::member(object, "primitives")) {
    if (!primitive.is_object())
      throw Error("is damaged: mesh " + std::to_string(index) + " has a primitive that is none; export it again");
    MeshData part = primitiveData(primitive, "mesh " + std::to_string(index));
    if (!part.triangles.empty()) parts.push_back(std::move(part));
  }
  MeshData& all = meshes_[index].emplace();
  const bool coloured = std::any_of(parts.begin(), parts.end(), [&](const MeshData& part) {
    return !part.colours.empty() || part.colour != parts.front().colour;
  });
  if (!coloured && !parts.empty() && parts.front().colour != kWhite) all.colour = parts.front().colour;
  for (MeshData& part : parts) {
    const size_t first = all.positions.size();
    if (first + part.positions.size() > UINT32_MAX)
      throw Error("has a mesh of more vertices than can be numbered; split it first");
    if (coloured && part.colours.empty()) part.colours.resize(part.positions.size(), *part.colour);
    all.colours.insert(all.colours.end(), part.colours.begin(), part.colours.end());
    all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
    for (const auto& [a, b, c] : part.triangles)
      all.triangles.push_back({uint32_t(a + first), uint32_t(b + first), uint32_t(c + first)});
  }
  return all;
}

/// Linear.
std::array<double, 4> Scene::baseColour(const Json& primitive) {
  std::array<double, 4> factor = {1, 1, 1, 1};
  const auto material = GltfFile::optionalIndex(primitive, "material");
  if (!material) return factor;
  const Json& base = GltfFile::member(file_.item("materials", *material), "pbrMetallicRoughness");
  const auto values = GltfFile::numbers(base, "baseColorFactor", 4);
  if (!values.empty()) std::copy(values.begin(), values.end(), factor.begin());
  if (base.is_object() && base.contains("baseColorTexture")) noteOnce("textures are not kept");
  return factor;
}

MeshData Scene::primitiveData(const Json& primitive, const std::string& name) {
  MeshData data;
  const uint64_t mode = GltfFile::optionalIndex(primitive, "mode").value_or(kTriangles);
  if (mode > kFan)
    throw Error("is damaged: " + name + " has primitives of the unknown mode " + std::to_string(mode) +
                "; export it again");
  if (mode < kTriangles) {
    noteOnce("points and lines are not kept");
    return data;
  }
  if (primitive.contains("targets")) noteOnce("morph targets are not kept");
  const std::array<double, 4> factor = baseColour(primitive);
  const Bytes4 base = {srgbByte(factor[0]), srgbByte(factor[1]), srgbByte(factor[2]), plainByte(factor[3])};
  const Json& attributes = GltfFile::member(primitive, "attributes");
  const Json& packed = GltfFile::member(GltfFile::member(primitive, "extensions"), "KHR_draco_mesh_compression");
  // COLOR_0 multiplies the base colour, both linear.
  const auto tinted = [&](const double* linear, size_t components) {
    return Bytes4{srgbByte(linear[0] * factor[0]), srgbByte(linear[1] * factor[1]), srgbByte(linear[2] * factor[2]),
                  components == 4 ? plainByte(linear[3] * factor[3]) : plainByte(factor[3])};
  };
  if (!packed.is_null()) {
    draco_ = true;
    const Json& ids = GltfFile::member(packed, "attributes");
    data = decodeDraco(file_.view(GltfFile::index(packed, "bufferView")), GltfFile::index(ids, "POSITION"),
                       GltfFile::optionalIndex(ids, "COLOR_0"), factor);
    data.colour = base;
    return data;
  }
  data.colour = base;
  size_t components = 0;
  if (!attributes.is_object() || !attributes.contains("POSITION")) {
    noteOnce("meshes without positions were left out");
    return data;
  }
  const auto positions = file_.values(GltfFile::index(attributes, "POSITION"), components);
  if (components != 3)
    throw Error("is damaged: " + name + " has positions of " + std::to_string(components) +
                " coordinates; export it again");
  data.positions.resize(positions.size() / 3);
  for (size_t i = 0; i < data.positions.size(); ++i)
    data.positions[i] = {positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]};
  const size_t vertices = data.positions.size();
  if (attributes.contains("COLOR_0")) {
    const auto colours = file_.values(GltfFile::index(attributes, "COLOR_0"), components);
    if (colours.size() / components != vertices)
      throw Error("is damaged: " + name + " has another number of colours than of vertices; export it again");
    data.colours.reserve(vertices);
    for (size_t i = 0; i < vertices; ++i) {
      for (size_t c = 0; c < components; ++c) {
        if (!std::isfinite(colours[i * components + c]))
          throw Error("is damaged: " + name + " has a colour that is not finite; export it again");
      }
      data.colours.push_back(tinted(&colours[i * components], components));
    }
  }

  std::vector<uint32_t> corners;
  if (const auto indices = GltfFile::optionalIndex(primitive, "indices")) {
    corners = file_.indices(*indices);
    for (const uint32_t corner : corners) {
      if (corner >= vertices) {
        throw Error("is damaged: " + name + " names vertex " + std::to_string(corner) + " of " +
                    std::to_string(vertices) + "; export it again");
      }
    }
  } else {
    corners.resize(vertices);
    for (size_t i = 0; i < vertices; ++i) corners[i] = uint32_t(i);
  }
  if (mode == kTriangles) {
    if (corners.size() % 3 != 0)
      throw Error("is damaged: " + name + " has " + std::to_string(corners.size()) +
                  " corners, which are no whole triangles; export it again");
    for (size_t i = 0; i + 2 < corners.size(); i += 3)
      data.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  } else {
    for (size_t i = 0; i + 2 < corners.size(); ++i) {
      if (mode == kFan) {
        data.triangles.push_back({corners[i + 1], corners[i + 2], corners[0]});
      } else {
        data.triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
      }
    }
  }
  return data;
}

}  // namespace

void readGltf(const std::filesystem::path& file, Sender& sender) {
  Scene(file, sender).send();
}

}  // namespace argil::io::reader
