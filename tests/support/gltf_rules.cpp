#include "tests/support/gltf_rules.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "tests/support/gltf_form.h"

namespace argil::samples {

namespace {

using Json = nlohmann::json;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr const char* kDraco = "KHR_draco_mesh_compression";
// Of the length of a normal and of a rotation: what rounding to 32 bits leaves is far below.
constexpr double kUnit = 0.0005;

// Everything that is no error.
const std::map<std::string_view, Severity> kMilder = {
    {"UNEXPECTED_PROPERTY", Severity::warning},
    {"VALUE_NOT_IN_LIST", Severity::warning},
    {"MATERIAL_ALPHA_CUTOFF_INVALID_MODE", Severity::warning},
    {"MESH_PRIMITIVE_NO_POSITION", Severity::warning},
    {"MESH_PRIMITIVE_INCOMPATIBLE_MODE", Severity::warning},
    {"UNKNOWN_ASSET_MINOR_VERSION", Severity::warning},
    {"DATA_URI_GLB", Severity::warning},
    {"BUFFER_GLB_CHUNK_TOO_BIG", Severity::warning},
    {"GLB_EXTRA_DATA", Severity::warning},
    {"GLB_UNKNOWN_CHUNK_TYPE", Severity::warning},
    {"UNUSED_OBJECT", Severity::info},
    {"NODE_EMPTY", Severity::info},
    {"NODE_MATRIX_DEFAULT", Severity::info},
    {"NON_OBJECT_EXTRAS", Severity::info},
    {"ACCESSOR_INDEX_TRIANGLE_DEGENERATE", Severity::info},
    {"GLB_EMPTY_BIN_CHUNK", Severity::info},
    {"BUFFER_VIEW_TARGET_MISSING", Severity::hint},
};

struct Layout {
  uint64_t component = 0, components = 0;
  [[nodiscard]] uint64_t element() const { return component * components; }
};
Layout layoutOf(const Json& accessor) {
  static const std::map<int, uint64_t> sizes = {{5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}};
  static const std::map<std::string, uint64_t> counts = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                         {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  return {sizes.at(accessor["componentType"]), counts.at(accessor["type"])};
}

class Judge {
 public:
  std::vector<GltfIssue> take() { return std::move(issues_); }

  void file(std::string_view bytes) {
    binary_ = bytes.substr(0, 4) == "glTF";
    const std::string_view text = binary_ ? container(bytes) : bytes;
    if (errors() > 0) return;
    root_ = Json::parse(text, nullptr, false);
    if (root_.is_discarded() || !root_.is_object()) return say("INVALID_JSON", "", "no object");
    judgeGltfForm(
        root_, [this](const std::string& code, const std::string& at, const std::string& why) { say(code, at, why); },
        named_);
    if (errors() > 0) return;  // What follows trusts the form.
    asset();
    extensions();
    for (const char* each :
         {"buffers", "bufferViews", "accessors", "materials", "meshes", "nodes", "scenes", "images", "textures"})
      used_[each].resize(list(each).size());
    buffers();
    bufferViews();
    accessors();
    materials();
    images();
    meshes();
    nodes();
    unused();
  }

 private:
  void say(const std::string& code, const std::string& pointer, const std::string& message = {}) {
    const auto milder = kMilder.find(code);
    issues_.push_back({code, milder == kMilder.end() ? Severity::error : milder->second, pointer, message});
  }
  [[nodiscard]] size_t errors() const {
    return size_t(
        std::count_if(issues_.begin(), issues_.end(), [](const auto& i) { return i.severity == Severity::error; }));
  }
  [[nodiscard]] const Json& list(const std::string& name) const {
    static const Json none = Json::array();
    return root_.contains(name) ? root_[name] : none;
  }
  static std::string at(const std::string& pointer, size_t i) { return pointer + "/" + std::to_string(i); }

  // The bytes of the JSON chunk; the binary chunk is kept.
  std::string_view container(std::string_view bytes) {
    const auto word = [&](size_t where) {
      uint32_t value = 0;
      std::memcpy(&value, bytes.data() + where, 4);
      return value;
    };
    if (bytes.size() < 12) return say("GLB_UNEXPECTED_END_OF_HEADER", ""), "";
    if (word(4) != 2) say("GLB_INVALID_VERSION", "", std::to_string(word(4)));
    const uint64_t length = word(8);
    if (length < 20) say("GLB_LENGTH_TOO_SMALL", "", std::to_string(length));
    if (length > bytes.size()) say("GLB_LENGTH_MISMATCH", "", std::to_string(length));
    if (length < bytes.size()) say("GLB_EXTRA_DATA", "");
    std::string_view json;
    size_t chunk = 0;
    for (uint64_t where = 12; where < std::min<uint64_t>(length, bytes.size()); ++chunk) {
      if (bytes.size() - where < 8) return say("GLB_UNEXPECTED_END_OF_CHUNK_HEADER", ""), json;
      const uint64_t size = word(where);
      const uint32_t type = word(where + 4);
      where += 8;
      if (size % 4 != 0) say("GLB_CHUNK_LENGTH_UNALIGNED", "", std::to_string(size));
      if (where + size > length) say("GLB_CHUNK_TOO_BIG", "", std::to_string(size));
      if (where + size > bytes.size()) return say("GLB_UNEXPECTED_END_OF_CHUNK_DATA", ""), json;
      const std::string_view content = bytes.substr(where, size);
      where += size;
      constexpr uint32_t kJson = 0x4E4F534A, kBin = 0x004E4942;
      if (chunk == 0 && type != kJson) say("GLB_UNEXPECTED_FIRST_CHUNK", "", std::to_string(type));
      if (type == kJson) {
        if (chunk != 0) say("GLB_DUPLICATE_CHUNK", "", "JSON");
        if (size == 0) say("GLB_EMPTY_CHUNK", "", "JSON");
        json = content;
      } else if (type == kBin) {
        if (bin_) say("GLB_DUPLICATE_CHUNK", "", "BIN");
        if (chunk != 1) say("GLB_UNEXPECTED_BIN_CHUNK", "");
        if (size == 0) say("GLB_EMPTY_BIN_CHUNK", "");
        bin_ = content;
      } else {
        say("GLB_UNKNOWN_CHUNK_TYPE", "", std::to_string(type));
      }
    }
    return json;
  }

  void asset() {
    const std::string version = root_["asset"]["version"];
    const size_t dot = version.find('.');
    const auto digits = [](const std::string& s) {
      return !s.empty() && s.find_first_not_of("0123456789") == std::string::npos;
    };
    if (dot == std::string::npos || !digits(version.substr(0, dot)) || !digits(version.substr(dot + 1)))
      return say("PATTERN_MISMATCH", "/asset/version", version);
    if (version.substr(0, dot) != "2") return say("UNKNOWN_ASSET_MAJOR_VERSION", "/asset/version", version);
    if (version.substr(dot + 1) != "0") say("UNKNOWN_ASSET_MINOR_VERSION", "/asset/version", version);
    const std::string least = root_["asset"].value("minVersion", version);
    if (least > version) say("ASSET_MIN_VERSION_GREATER_THAN_VERSION", "/asset/minVersion", least);
  }

  void extensions() {
    const Json& used = list("extensionsUsed");
    for (const std::string& name : named_)
      if (std::find(used.begin(), used.end(), name) == used.end()) say("UNDECLARED_EXTENSION", "", name);
    for (size_t i = 0; i < used.size(); ++i)
      if (!named_.contains(used[i])) say("UNUSED_OBJECT", at("/extensionsUsed", i));
    const Json& required = list("extensionsRequired");
    for (size_t i = 0; i < required.size(); ++i)
      if (std::find(used.begin(), used.end(), required[i]) == used.end())
        say("UNUSED_EXTENSION_REQUIRED", at("/extensionsRequired", i));
  }

  void buffers() {
    for (size_t i = 0; i < list("buffers").size(); ++i) {
      const Json& buffer = list("buffers")[i];
      const std::string pointer = at("/buffers", i);
      const uint64_t length = buffer["byteLength"];
      std::optional<std::string> bytes;
      if (!buffer.contains("uri")) {
        if (!binary_ || i != 0 || !bin_) {
          say("BUFFER_MISSING_GLB_DATA", pointer);
        } else {
          if (bin_->size() > length + 3) say("BUFFER_GLB_CHUNK_TOO_BIG", pointer);
          bytes.emplace(*bin_);
        }
      } else {
        if (binary_) say("DATA_URI_GLB", pointer + "/uri");
        bytes = dataOf(buffer["uri"], pointer + "/uri");
      }
      if (bytes && bytes->size() < length) {
        say("BUFFER_BYTE_LENGTH_MISMATCH", pointer, std::to_string(bytes->size()));
        bytes.reset();
      }
      contents_.push_back(std::move(bytes));
    }
  }

  std::optional<std::string> dataOf(const std::string& uri, const std::string& pointer) {
    const size_t comma = uri.find(',');
    const std::string head = uri.substr(0, comma);
    if (head != "data:application/octet-stream;base64" && head != "data:application/gltf-buffer;base64") {
      say(head.starts_with("data:") ? "BUFFER_DATA_URI_MIME_TYPE_INVALID" : "IO_ERROR", pointer, head);
      return {};
    }
    static constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string_view letters = std::string_view(uri).substr(comma + 1);
    bool sound = letters.size() % 4 == 0;
    for (int k = 0; k < 2 && letters.ends_with('='); ++k) letters.remove_suffix(1);
    std::string bytes;
    uint32_t word = 0;
    int bits = 0;
    for (const char c : letters) {
      const size_t value = kLetters.find(c);
      sound = sound && value != std::string_view::npos;
      word = word << 6 | uint32_t(value & 63);
      if ((bits += 6) >= 8) bytes += char(word >> (bits -= 8) & 255);
    }
    if (sound) return bytes;
    say("INVALID_URI", pointer);
    return {};
  }

  void bufferViews() {
    for (size_t i = 0; i < list("bufferViews").size(); ++i) {
      const Json& view = list("bufferViews")[i];
      const std::string pointer = at("/bufferViews", i);
      const uint64_t length = view["byteLength"], offset = view.value("byteOffset", uint64_t{0});
      used_["buffers"][view["buffer"]] = true;
      if (offset + length > list("buffers")[view["buffer"].get<size_t>()]["byteLength"].get<uint64_t>())
        say("BUFFER_VIEW_TOO_LONG", pointer);
      if (!view.contains("byteStride")) continue;
      const uint64_t stride = view["byteStride"];
      if (stride % 4 != 0) say("VALUE_MULTIPLE_OF", pointer + "/byteStride");
      if (stride > length) say("BUFFER_VIEW_TOO_BIG_BYTE_STRIDE", pointer + "/byteStride");
      if (view.value("target", 34962) != 34962) say("BUFFER_VIEW_INVALID_BYTE_STRIDE", pointer + "/byteStride");
    }
  }

  void accessors() {
    for (size_t i = 0; i < list("accessors").size(); ++i) {
      const Json& accessor = list("accessors")[i];
      const std::string pointer = at("/accessors", i);
      const Layout layout = layoutOf(accessor);
      const uint64_t offset = accessor.value("byteOffset", uint64_t{0});
      if (accessor.value("normalized", false) && layout.component == 4)
        say("ACCESSOR_NORMALIZED_INVALID", pointer + "/normalized");
      for (const char* bound : {"min", "max"})
        if (accessor.contains(bound) && accessor[bound].size() != layout.components)
          say("ARRAY_LENGTH_NOT_IN_LIST", pointer + "/" + bound);
      if (!accessor.contains("bufferView")) {
        if (accessor.contains("byteOffset")) say("UNSATISFIED_DEPENDENCY", pointer + "/byteOffset", "bufferView");
        continue;
      }
      const size_t at = accessor["bufferView"];
      const Json& view = list("bufferViews")[at];
      used_["bufferViews"][at] = true;
      if (offset % layout.component != 0) say("ACCESSOR_OFFSET_ALIGNMENT", pointer + "/byteOffset");
      if ((offset + view.value("byteOffset", uint64_t{0})) % layout.component != 0)
        say("ACCESSOR_TOTAL_OFFSET_ALIGNMENT", pointer);
      const uint64_t stride = view.value("byteStride", layout.element());
      if (stride < layout.element()) say("ACCESSOR_SMALL_BYTESTRIDE", pointer);
      const uint64_t count = accessor["count"];
      if (count > (uint64_t{1} << 40) ||
          offset + (count - 1) * stride + layout.element() > view["byteLength"].get<uint64_t>())
        say("ACCESSOR_TOO_LONG", pointer);
    }
    readable_ = errors() == 0;  // Every element lies in the bytes that are there.
    for (size_t i = 0; i < list("accessors").size(); ++i) bounds(i);
  }

  // Calls `each(component as it is stored, element, which)`; nothing where there are no bytes.
  template <class Each>
  void values(size_t which, const Each& each) {
    const Json& accessor = list("accessors")[which];
    if (!readable_ || !accessor.contains("bufferView")) return;
    const Json& view = list("bufferViews")[accessor["bufferView"].get<size_t>()];
    const auto& bytes = contents_[view["buffer"].get<size_t>()];
    if (!bytes) return;
    const Layout layout = layoutOf(accessor);
    const uint64_t stride = view.value("byteStride", layout.element());
    const char* from =
        bytes->data() + view.value("byteOffset", uint64_t{0}) + accessor.value("byteOffset", uint64_t{0});
    const auto read = [&]<class T>(T value, const char* where) {
      std::memcpy(&value, where, sizeof value);
      return double(value);
    };
    for (uint64_t i = 0; i < accessor["count"].get<uint64_t>(); ++i, from += stride) {
      for (uint64_t k = 0; k < layout.components; ++k) {
        const char* where = from + k * layout.component;
        switch (accessor["componentType"].get<int>()) {
          case 5120:
            each(read(int8_t{}, where), i, k);
            break;
          case 5121:
            each(read(uint8_t{}, where), i, k);
            break;
          case 5122:
            each(read(int16_t{}, where), i, k);
            break;
          case 5123:
            each(read(uint16_t{}, where), i, k);
            break;
          case 5125:
            each(read(uint32_t{}, where), i, k);
            break;
          default:
            each(read(float{}, where), i, k);
        }
      }
    }
  }

  void bounds(size_t which) {
    const Json& accessor = list("accessors")[which];
    const std::string pointer = at("/accessors", which);
    const uint64_t components = layoutOf(accessor).components;
    std::vector<double> low(components, kInfinite), high(components, -kInfinite);
    bool any = false, finite = true;
    values(which, [&](double v, uint64_t, uint64_t k) {
      any = true;
      finite = finite && std::isfinite(v);
      low[k] = std::min(low[k], v), high[k] = std::max(high[k], v);
    });
    if (!any) return;
    if (!finite) return say("ACCESSOR_INVALID_FLOAT", pointer);
    for (uint64_t k = 0; k < components; ++k) {
      // Equal to the last bit: JSON has all digits that a 32-bit number needs.
      if (accessor.contains("min") && accessor["min"][k].get<double>() != low[k])
        say("ACCESSOR_MIN_MISMATCH", pointer, accessor["min"][k].dump());
      if (accessor.contains("max") && accessor["max"][k].get<double>() != high[k])
        say("ACCESSOR_MAX_MISMATCH", pointer, accessor["max"][k].dump());
    }
  }

  void materials() {
    for (size_t i = 0; i < list("materials").size(); ++i) {
      const Json& material = list("materials")[i];
      if (material.contains("alphaCutoff") && material.value("alphaMode", "OPAQUE") != "MASK")
        say("MATERIAL_ALPHA_CUTOFF_INVALID_MODE", at("/materials", i));
      const Json pbr = material.value("pbrMetallicRoughness", Json::object());
      for (const Json& info : {material.value("normalTexture", Json()), pbr.value("baseColorTexture", Json())}) {
        if (!info.is_object()) continue;
        used_["textures"][info["index"]] = true;
        pictured_.insert({i, info.value("texCoord", 0)});
      }
    }
  }

  // Only what lies in the buffer: a name of another file is UNEXPECTED_PROPERTY.
  void images() {
    for (const Json& texture : list("textures"))
      if (texture.contains("source")) used_["images"][texture["source"]] = true;
    for (size_t i = 0; i < list("images").size(); ++i) {
      const Json& image = list("images")[i];
      const std::string pointer = at("/images", i);
      if (!image.contains("bufferView")) {
        say("INVALID_JSON", pointer, "an image without bytes");
        continue;
      }
      const size_t which = image["bufferView"];
      const Json& view = list("bufferViews")[which];
      used_["bufferViews"][which] = true;
      if (!image.contains("mimeType")) say("IMAGE_BUFFER_VIEW_WITHOUT_MIME_TYPE", pointer);
      if (view.contains("target") || view.contains("byteStride"))
        say("IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE", pointer, "of vertices");
      const std::optional<std::string>& bytes = contents_[view["buffer"]];
      if (!bytes) continue;
      const std::string signature = image.value("mimeType", "") == "image/jpeg" ? "\xff\xd8\xff" : "\x89PNG\r\n\x1a\n";
      if (bytes->compare(view.value("byteOffset", size_t{0}), signature.size(), signature) != 0)
        say("IMAGE_UNRECOGNIZED_FORMAT", pointer);
    }
  }

  void meshes() {
    for (size_t i = 0; i < list("meshes").size(); ++i)
      for (size_t k = 0; k < list("meshes")[i]["primitives"].size(); ++k)
        primitive(list("meshes")[i]["primitives"][k], at(at("/meshes", i) + "/primitives", k));
    for (const auto& [view, users] : vertexUsers_)
      if (users.size() > 1 && !list("bufferViews")[view].contains("byteStride"))
        say("MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", at("/bufferViews", view));
  }

  // `target` is what a view of such contents says: 34962 of vertices, 34963 of indices.
  void use(size_t which, int target, const std::string& pointer) {
    used_["accessors"][which] = true;
    if (usage_.try_emplace(which, target).first->second != target) say("ACCESSOR_USAGE_OVERRIDE", pointer);
    const Json& accessor = list("accessors")[which];
    if (!accessor.contains("bufferView")) return;
    const size_t view = accessor["bufferView"];
    if (!list("bufferViews")[view].contains("target")) say("BUFFER_VIEW_TARGET_MISSING", at("/bufferViews", view));
    if (list("bufferViews")[view].value("target", target) != target ||
        viewUsage_.try_emplace(view, target).first->second != target)
      say("BUFFER_VIEW_TARGET_OVERRIDE", pointer);
    if (target == 34962) {
      vertexUsers_[view].insert(which);
      const Layout layout = layoutOf(accessor);
      const uint64_t stride = list("bufferViews")[view].value("byteStride", layout.element());
      if (stride % 4 != 0 || accessor.value("byteOffset", uint64_t{0}) % 4 != 0)
        say("MESH_PRIMITIVE_ACCESSOR_UNALIGNED", pointer);
    } else if (list("bufferViews")[view].contains("byteStride")) {
      say("MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE", pointer);
    }
  }

  void primitive(const Json& primitive, const std::string& pointer) {
    const Json& attributes = primitive["attributes"];
    std::optional<uint64_t> count;
    for (const auto& [name, value] : attributes.items()) {
      const size_t which = value;
      const std::string here = pointer + "/attributes/" + name;
      const Json& accessor = list("accessors")[which];
      use(which, 34962, here);
      if (count.value_or(accessor["count"]) != accessor["count"].get<uint64_t>())
        say("MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", here);
      count = accessor["count"].get<uint64_t>();
      attribute(name, which, here);
    }
    if (!attributes.contains("POSITION")) say("MESH_PRIMITIVE_NO_POSITION", pointer + "/attributes");
    const Json& draco = primitive.value("extensions", Json::object()).value(kDraco, Json());
    if (draco.is_object()) {
      used_["bufferViews"][draco["bufferView"]] = true;
      for (const auto& [name, value] : draco["attributes"].items())
        if (!attributes.contains(name)) say("UNRESOLVED_REFERENCE", pointer + "/attributes/" + name, "only in Draco");
    }
    if (primitive.contains("material")) {
      used_["materials"][primitive["material"]] = true;
      for (const auto& [material, set] : pictured_)
        if (material == primitive["material"] && !attributes.contains("TEXCOORD_" + std::to_string(set)))
          say("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", pointer + "/material");
    }
    uint64_t corners = count.value_or(0);
    if (primitive.contains("indices")) {
      const size_t which = primitive["indices"];
      corners = list("accessors")[which]["count"];
      use(which, 34963, pointer + "/indices");
      indices(which, count.value_or(0), primitive.value("mode", 4), pointer + "/indices");
    }
    const int mode = primitive.value("mode", 4);
    if ((mode == 4 && (corners == 0 || corners % 3 != 0)) || (mode == 1 && corners % 2 != 0) ||
        (mode > 4 && corners < 3))
      say("MESH_PRIMITIVE_INCOMPATIBLE_MODE", pointer, std::to_string(corners));
  }

  void attribute(const std::string& name, size_t which, const std::string& pointer) {
    const Json& accessor = list("accessors")[which];
    const int component = accessor["componentType"];
    const std::string type = accessor["type"];
    const bool normalized = accessor.value("normalized", false);
    const auto badFormat = [&](bool bad) {
      if (bad) say("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", pointer, type);
      return bad;
    };
    if (name == "POSITION") {
      if (badFormat(type != "VEC3" || component != 5126 || normalized)) return;
      if (!accessor.contains("min") || !accessor.contains("max"))
        say("MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS", pointer);
    } else if (name == "NORMAL") {
      if (badFormat(type != "VEC3" || component != 5126 || normalized)) return;
      double square = 0;
      uint64_t bad = 0;
      values(which, [&](double v, uint64_t, uint64_t k) {
        square = (k == 0 ? 0 : square) + v * v;
        if (k == 2 && !(std::abs(std::sqrt(square) - 1) <= kUnit)) ++bad;
      });
      if (bad > 0) say("ACCESSOR_VECTOR3_NON_UNIT", pointer, std::to_string(bad));
    } else if (name == "TANGENT") {
      if (badFormat(type != "VEC4" || component != 5126 || normalized)) return;
      double square = 0;
      uint64_t bad = 0, sides = 0;
      values(which, [&](double v, uint64_t, uint64_t k) {
        if (k == 3) {
          bad += std::abs(std::sqrt(square) - 1) <= kUnit ? 0 : 1;
          sides += v == 1 || v == -1 ? 0 : 1;
        }
        square = (k == 0 ? 0 : square) + v * v;
      });
      if (bad > 0) say("ACCESSOR_VECTOR3_NON_UNIT", pointer, std::to_string(bad));
      if (sides > 0) say("ACCESSOR_INVALID_SIGN", pointer, std::to_string(sides));
    } else if (name.starts_with("TEXCOORD_")) {
      if (name != "TEXCOORD_0") say("MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", pointer);
      const bool fraction = (component == 5121 || component == 5123) && normalized;
      if (badFormat(type != "VEC2" || !(fraction || (component == 5126 && !normalized)))) return;
    } else if (name.starts_with("COLOR_")) {
      if (name != "COLOR_0") say("MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", pointer);
      const bool fraction = (component == 5121 || component == 5123) && normalized;
      if (badFormat((type != "VEC3" && type != "VEC4") || !(fraction || (component == 5126 && !normalized)))) return;
      uint64_t bad = 0;
      if (component == 5126) values(which, [&](double v, uint64_t, uint64_t) { bad += v >= 0 && v <= 1 ? 0 : 1; });
      if (bad > 0) say("ACCESSOR_NON_CLAMPED", pointer, std::to_string(bad));
    } else if (!name.starts_with("_")) {
      say("MESH_PRIMITIVE_INVALID_ATTRIBUTE", pointer);
    } else if (component == 5125) {
      say("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", pointer);
    }
  }

  void indices(size_t which, uint64_t vertices, int mode, const std::string& pointer) {
    const Json& accessor = list("accessors")[which];
    const int component = accessor["componentType"];
    if (accessor["type"] != "SCALAR" || accessor.value("normalized", false) ||
        (component != 5121 && component != 5123 && component != 5125))
      return say("MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT", pointer);
    const double restart = component == 5121 ? 255 : component == 5123 ? 65535 : 4294967295.0;
    bool beyond = false, restarts = false;
    std::array<double, 3> corners{};
    uint64_t degenerate = 0;
    values(which, [&](double v, uint64_t i, uint64_t) {
      restarts = restarts || v == restart;
      beyond = beyond || (v != restart && v >= double(vertices));
      corners[i % 3] = v;
      if (mode == 4 && i % 3 == 2 && (corners[0] == corners[1] || corners[1] == corners[2] || corners[0] == corners[2]))
        ++degenerate;
    });
    if (restarts) say("ACCESSOR_INDEX_PRIMITIVE_RESTART", pointer);
    if (beyond) say("ACCESSOR_INDEX_OOB", pointer);
    if (degenerate > 0) say("ACCESSOR_INDEX_TRIANGLE_DEGENERATE", pointer, std::to_string(degenerate));
  }

  void nodes() {
    const Json& all = list("nodes");
    std::vector<std::optional<size_t>> parent(all.size());
    for (size_t i = 0; i < all.size(); ++i) {
      const Json& node = all[i];
      const std::string pointer = at("/nodes", i);
      if (node.contains("mesh")) used_["meshes"][node["mesh"]] = true;
      if (!node.contains("mesh") && !node.contains("children")) say("NODE_EMPTY", pointer);
      if (node.contains("matrix")) {
        for (const char* part : {"translation", "rotation", "scale"})
          if (node.contains(part)) say("NODE_MATRIX_TRS", pointer + "/" + part);
        Json unit = Json::array();
        for (int k = 0; k < 16; ++k) unit.push_back(k % 5 == 0 ? 1 : 0);
        if (node["matrix"] == unit) say("NODE_MATRIX_DEFAULT", pointer);
      }
      if (node.contains("rotation")) {
        double square = 0;
        for (const Json& part : node["rotation"]) square += part.get<double>() * part.get<double>();
        if (!(std::abs(std::sqrt(square) - 1) <= kUnit)) say("ROTATION_NON_UNIT", pointer + "/rotation");
      }
      for (const Json& child : node.value("children", Json::array())) {
        used_["nodes"][child] = true;
        if (parent[child]) say("NODE_PARENT_OVERRIDE", pointer + "/children", child.dump());
        parent[child] = i;
      }
    }
    for (size_t i = 0; i < all.size(); ++i) {
      size_t steps = 0;
      for (std::optional<size_t> up = parent[i]; up && steps <= all.size(); up = parent[*up]) ++steps;
      if (steps > all.size()) say("NODE_LOOP", at("/nodes", i));
    }
    for (size_t i = 0; i < list("scenes").size(); ++i) {
      for (const Json& root : list("scenes")[i].value("nodes", Json::array())) {
        used_["nodes"][root] = true;
        if (parent[root]) say("SCENE_NON_ROOT_NODE", at("/scenes", i), root.dump());
      }
    }
  }

  void unused() {
    used_.erase("scenes");
    for (const auto& [name, flags] : used_)
      for (size_t i = 0; i < flags.size(); ++i)
        if (!flags[i]) say("UNUSED_OBJECT", at("/" + name, i));
  }

  bool binary_ = false, readable_ = false;
  std::optional<std::string_view> bin_;
  Json root_;
  std::vector<std::optional<std::string>> contents_;  // of each buffer
  std::set<std::string> named_;                       // extensions that some object has
  std::map<std::string, std::vector<bool>> used_;
  std::set<std::pair<size_t, int>> pictured_;  // material, set of its places on pictures
  std::map<size_t, int> usage_, viewUsage_;
  std::map<size_t, std::set<size_t>> vertexUsers_;  // accessors of vertices by view
  std::vector<GltfIssue> issues_;
};

}  // namespace

std::vector<GltfIssue> gltfIssues(std::string_view bytes) {
  Judge judge;
  judge.file(bytes);
  return judge.take();
}

std::string errorsAndWarnings(const std::vector<GltfIssue>& issues) {
  std::string lines;
  for (const GltfIssue& issue : issues) {
    if (issue.severity > Severity::warning) continue;
    lines += std::string(issue.severity == Severity::error ? "error " : "warning ") + issue.code + " " + issue.pointer +
             " " + issue.message + "\n";
  }
  return lines;
}

}  // namespace argil::samples
