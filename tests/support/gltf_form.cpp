#include "tests/support/gltf_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

namespace argil::samples {

namespace {

using Json = nlohmann::json;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::string_view kDraco = "KHR_draco_mesh_compression";

// The form of the JSON, a row a property.
enum class Is : uint8_t { index, indices, integer, number, numbers, text, flag, one, many, texts, attributes };
struct Property {
  std::string_view owner, name;
  Is is;
  bool needed = false;
  // The list that an index goes into, the kind of the objects, or all values that are allowed.
  std::string_view of = {};
  double low = -kInfinite, high = kInfinite;
  size_t length = 0;  // Of numbers; 0: depends on others.
};
constexpr auto kProperties = std::to_array<Property>({
    {"root", "asset", Is::one, true, "asset"},
    {"root", "scene", Is::index, false, "scenes"},
    {"root", "scenes", Is::many, false, "scene"},
    {"root", "nodes", Is::many, false, "node"},
    {"root", "meshes", Is::many, false, "mesh"},
    {"root", "accessors", Is::many, false, "accessor"},
    {"root", "bufferViews", Is::many, false, "bufferView"},
    {"root", "buffers", Is::many, false, "buffer"},
    {"root", "materials", Is::many, false, "material"},
    {"root", "images", Is::many, false, "image"},
    {"root", "textures", Is::many, false, "texture"},
    {"root", "extensionsUsed", Is::texts},
    {"root", "extensionsRequired", Is::texts},
    {"asset", "version", Is::text, true},
    {"asset", "minVersion", Is::text},
    {"asset", "generator", Is::text},
    {"asset", "copyright", Is::text},
    {"scene", "name", Is::text},
    {"scene", "nodes", Is::indices, false, "nodes"},
    {"node", "name", Is::text},
    {"node", "mesh", Is::index, false, "meshes"},
    {"node", "children", Is::indices, false, "nodes"},
    {"node", "translation", Is::numbers, false, "", -kInfinite, kInfinite, 3},
    {"node", "rotation", Is::numbers, false, "", -1, 1, 4},
    {"node", "scale", Is::numbers, false, "", -kInfinite, kInfinite, 3},
    {"node", "matrix", Is::numbers, false, "", -kInfinite, kInfinite, 16},
    {"mesh", "name", Is::text},
    {"mesh", "primitives", Is::many, true, "primitive"},
    {"primitive", "attributes", Is::attributes, true, "accessors"},
    {"primitive", "indices", Is::index, false, "accessors"},
    {"primitive", "material", Is::index, false, "materials"},
    {"primitive", "mode", Is::integer, false, "0 1 2 3 4 5 6"},
    {kDraco, "bufferView", Is::index, true, "bufferViews"},
    {kDraco, "attributes", Is::attributes, true},
    {"accessor", "name", Is::text},
    {"accessor", "bufferView", Is::index, false, "bufferViews"},
    {"accessor", "byteOffset", Is::integer, false, "", 0},
    {"accessor", "componentType", Is::integer, true, "5120 5121 5122 5123 5125 5126"},
    {"accessor", "normalized", Is::flag},
    {"accessor", "count", Is::integer, true, "", 1},
    {"accessor", "type", Is::text, true, "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4"},
    {"accessor", "min", Is::numbers},
    {"accessor", "max", Is::numbers},
    {"bufferView", "name", Is::text},
    {"bufferView", "buffer", Is::index, true, "buffers"},
    {"bufferView", "byteOffset", Is::integer, false, "", 0},
    {"bufferView", "byteLength", Is::integer, true, "", 1},
    {"bufferView", "byteStride", Is::integer, false, "", 4, 252},
    {"bufferView", "target", Is::integer, false, "34962 34963"},
    {"buffer", "name", Is::text},
    {"buffer", "byteLength", Is::integer, true, "", 1},
    {"buffer", "uri", Is::text},
    {"material", "name", Is::text},
    {"material", "pbrMetallicRoughness", Is::one, false, "pbr"},
    {"material", "emissiveFactor", Is::numbers, false, "", 0, 1, 3},
    {"material", "alphaMode", Is::text, false, "OPAQUE MASK BLEND"},
    {"material", "alphaCutoff", Is::number, false, "", 0},
    {"material", "doubleSided", Is::flag},
    {"pbr", "baseColorFactor", Is::numbers, false, "", 0, 1, 4},
    {"material", "normalTexture", Is::one, false, "textureInfo"},
    {"pbr", "baseColorTexture", Is::one, false, "textureInfo"},
    {"textureInfo", "index", Is::index, true, "textures"},
    {"textureInfo", "texCoord", Is::integer, false, "", 0},
    {"texture", "source", Is::index, false, "images"},
    {"image", "name", Is::text},
    {"image", "bufferView", Is::index, false, "bufferViews"},
    {"image", "mimeType", Is::text, false, "image/png image/jpeg"},
    {"pbr", "metallicFactor", Is::number, false, "", 0, 1},
    {"pbr", "roughnessFactor", Is::number, false, "", 0, 1},
});

bool isCount(const Json& value) {
  return value.is_number_unsigned();
}
bool isWhole(const Json& value) {
  return value.is_number_integer() || (value.is_number() && value.get<double>() == std::floor(value.get<double>()));
}
bool listed(std::string_view all, const std::string& value) {
  return (" " + std::string(all) + " ").find(" " + value + " ") != std::string::npos;
}

class Form {
 public:
  Form(const Json& root, const GltfSay& say, std::set<std::string>& named) : root_(root), say_(say), named_(named) {
    object("root", root, "");
  }

 private:
  void say(const char* code, const std::string& pointer, const std::string& message = {}) {
    say_(code, pointer, message);
  }
  [[nodiscard]] size_t count(const std::string& list) const { return root_.contains(list) ? root_[list].size() : 0; }
  static std::string at(const std::string& pointer, size_t i) { return pointer + "/" + std::to_string(i); }

  void object(std::string_view kind, const Json& value, const std::string& pointer) {
    if (!value.is_object()) return say("TYPE_MISMATCH", pointer, "no object");
    for (const Property& row : kProperties) {
      if (row.owner != kind) continue;
      const auto found = value.find(row.name);
      if (found != value.end())
        property(row, *found, pointer + "/" + std::string(row.name));
      else if (row.needed)
        say("UNDEFINED_PROPERTY", pointer, std::string(row.name));
    }
    for (const auto& [key, each] : value.items()) {
      const std::string here = pointer + "/" + key;
      if (key == "extras") {
        if (!each.is_object()) say("NON_OBJECT_EXTRAS", here);
      } else if (key == "extensions") {
        if (!each.is_object()) {
          say("TYPE_MISMATCH", here);
          continue;
        }
        if (each.empty()) say("EMPTY_ENTITY", here);
        for (const auto& [name, extension] : each.items()) {
          named_.insert(name);
          if (name != kDraco || kind != "primitive")
            say("UNEXPECTED_EXTENSION_OBJECT", here + "/" + name);
          else
            object(kDraco, extension, here + "/" + name);
        }
      } else if (std::none_of(kProperties.begin(), kProperties.end(),
                              [&](const Property& row) { return row.owner == kind && row.name == key; })) {
        say("UNEXPECTED_PROPERTY", here);
      }
    }
  }

  void index(const Json& value, std::string_view of, const std::string& pointer) {
    if (!isCount(value))
      say("INVALID_INDEX", pointer);
    else if (!of.empty() && value.get<uint64_t>() >= count(std::string(of)))
      say("UNRESOLVED_REFERENCE", pointer, value.dump());
  }

  void property(const Property& row, const Json& value, const std::string& pointer) {
    const auto number = [&](const Json& each, const std::string& where) {
      if (!each.is_number() || (row.is == Is::integer && !isWhole(each))) return say("TYPE_MISMATCH", where);
      if (!(each.get<double>() >= row.low && each.get<double>() <= row.high))
        say("VALUE_NOT_IN_RANGE", where, each.dump());
    };
    const bool array = row.is == Is::indices || row.is == Is::numbers || row.is == Is::many || row.is == Is::texts;
    if (array) {
      if (!value.is_array()) return say("TYPE_MISMATCH", pointer, "no array");
      if (value.empty()) return say("EMPTY_ENTITY", pointer);
      if (row.is != Is::numbers && row.is != Is::many &&
          std::set<Json>(value.begin(), value.end()).size() != value.size())
        say("DUPLICATE_ELEMENTS", pointer);
      if (row.length != 0 && value.size() != row.length) say("ARRAY_LENGTH_NOT_IN_LIST", pointer);
    }
    switch (row.is) {
      case Is::index:
        return index(value, row.of, pointer);
      case Is::indices:
        for (size_t i = 0; i < value.size(); ++i) index(value[i], row.of, at(pointer, i));
        return;
      case Is::integer:
      case Is::number:
        number(value, pointer);
        if (!row.of.empty() && !listed(row.of, value.dump())) say("VALUE_NOT_IN_LIST", pointer, value.dump());
        return;
      case Is::numbers:
        for (size_t i = 0; i < value.size(); ++i) number(value[i], at(pointer, i));
        return;
      case Is::text:
        if (!value.is_string()) return say("TYPE_MISMATCH", pointer, "no text");
        if (!row.of.empty() && !listed(row.of, value.get<std::string>()))
          say("VALUE_NOT_IN_LIST", pointer, value.dump());
        return;
      case Is::flag:
        if (!value.is_boolean()) say("TYPE_MISMATCH", pointer, "neither true nor false");
        return;
      case Is::one:
        return object(row.of, value, pointer);
      case Is::many:
        for (size_t i = 0; i < value.size(); ++i) object(row.of, value[i], at(pointer, i));
        return;
      case Is::texts:
        for (size_t i = 0; i < value.size(); ++i)
          if (!value[i].is_string()) say("ARRAY_TYPE_MISMATCH", at(pointer, i));
        return;
      case Is::attributes:
        if (!value.is_object()) return say("TYPE_MISMATCH", pointer);
        if (value.empty()) say("EMPTY_ENTITY", pointer);
        for (const auto& [key, each] : value.items()) index(each, row.of, pointer + "/" + key);
        return;
    }
  }

  const Json& root_;
  const GltfSay& say_;
  std::set<std::string>& named_;
};

}  // namespace

void judgeGltfForm(const Json& root, const GltfSay& say, std::set<std::string>& named) {
  Form(root, say, named);
}

}  // namespace argil::samples
