#include "io/reader/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "clay/base/error.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

using Json = GltfFile::Json;

constexpr uint64_t kMostBytes = UINT32_MAX;  // as much as a .glb can hold
constexpr uint64_t kMostElements = uint64_t{1} << 28;
/// Elements at zero for each that a sparse accessor without bytes of its own sets: a few bytes must not ask for
/// gigabytes.
constexpr uint64_t kMostZeros = 1024;
constexpr uint64_t kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
                   kFloat = 5126;

[[noreturn]] void damaged(const std::string& what) {
  throw Error("is damaged: " + what + "; export it again");
}

uint32_t littleAt(std::span<const unsigned char> bytes, size_t at) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

size_t sizeOf(uint64_t componentType) {
  switch (componentType) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      damaged("an accessor has the unknown component type " + std::to_string(componentType));
  }
}

template <class T>
T loaded(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

double component(uint64_t type, const unsigned char* at, bool normalized) {
  const auto scaled = [&](double value, double most) { return normalized ? std::max(value / most, -1.0) : value; };
  switch (type) {
    case kByte:
      return scaled(loaded<int8_t>(at), 127);
    case kUnsignedByte:
      return scaled(loaded<uint8_t>(at), 255);
    case kShort:
      return scaled(loaded<int16_t>(at), 32767);
    case kUnsignedShort:
      return scaled(loaded<uint16_t>(at), 65535);
    case kUnsignedInt:
      return scaled(loaded<uint32_t>(at), 4294967295.0);
    default:
      return double(loaded<float>(at));
  }
}

std::vector<unsigned char> base64(std::string_view text) {
  std::vector<unsigned char> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (value < 0) damaged("an embedded buffer is no base64");
    word = word << 6 | uint32_t(value);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<unsigned char>(word >> bits));
  }
  return bytes;
}

std::string unescaped(std::string_view uri) {
  std::string path;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 2]))) {
      path += char(std::stoi(std::string(uri.substr(i + 1, 2)), nullptr, 16));
      i += 2;
    } else {
      path += uri[i];
    }
  }
  return path;
}

std::string brief(std::string text) {
  if (text.size() > 60) text = text.substr(0, 60) + "...";
  return text;
}

}  // namespace

void GltfFile::Numbers::get(uint64_t element, double* to) const {
  const unsigned char* from = first_ + element * stride_;
  if (!changed_.empty()) {
    const auto at = std::lower_bound(changed_.begin(), changed_.end(), element,
                                     [](const auto& change, uint64_t wanted) { return change.first < wanted; });
    if (at != changed_.end() && at->first == element) from = at->second;
  }
  const size_t size = sizeOf(type_);
  for (size_t c = 0; c < components_; ++c) to[c] = component(type_, from + c * size, normalized_);
}

uint32_t GltfFile::Numbers::index(uint64_t element) const {
  return uint32_t(component(type_, first_ + element * stride_, false));
}

GltfFile::GltfFile(const std::filesystem::path& file)
    : folder_(std::filesystem::absolute(file).parent_path()), content_(contentOf(file, kMostBytes)) {
  const std::span<const unsigned char> all(content_);
  std::span<const unsigned char> json = all;
  binary_ = all.size() >= 4 && std::memcmp(all.data(), "glTF", 4) == 0;
  if (binary_) {
    if (all.size() < 20) damaged("it is cut off");
    if (littleAt(all, 4) != 2)
      throw Error("is glTF of version " + std::to_string(littleAt(all, 4)) +
                  ", of which only 2 can be read; convert it");
    if (littleAt(all, 8) > all.size()) damaged("it is cut off");
    size_t at = 12;
    for (int chunk = 0; chunk < 2 && at + 8 <= all.size(); ++chunk) {
      const uint32_t bytes = littleAt(all, at), kind = littleAt(all, at + 4);
      if (bytes > all.size() - at - 8) damaged("it is cut off");
      if (kind != (chunk == 0 ? 0x4e4f534a : 0x004e4942)) {  // "JSON", "BIN"
        if (chunk == 0) damaged("it does not begin with JSON");
        break;
      }
      (chunk == 0 ? json : chunk_) = all.subspan(at + 8, bytes);
      at += 8 + ((size_t(bytes) + 3) & ~size_t{3});
    }
  }
  root_ = Json::parse(json.begin(), json.end(), nullptr, false);
  if (!binary_) std::vector<unsigned char>().swap(content_);  // Its buffers are in the JSON too.
  if (!root_.is_object()) throw Error("is no glTF, as its JSON cannot be read; export it again");
  const std::string version = text(member(root_, "asset"), "version");
  if (version.empty()) throw Error("is JSON but no glTF, as it has no asset version; export it as glTF 2");
  if (version.rfind("2.", 0) != 0)
    throw Error("is glTF of version " + brief(version) + ", of which only 2 can be read; convert it");
  buffers_.resize(list("buffers").size());
}

const Json& GltfFile::list(const char* name) const {
  static const Json kEmpty = Json::array();
  const auto at = root_.find(name);
  if (at == root_.end()) return kEmpty;
  if (!at->is_array()) damaged(std::string(name) + " is no list");
  return *at;
}

const Json& GltfFile::item(const char* name, uint64_t index) const {
  const Json& all = list(name);
  if (index >= all.size() || !all[index].is_object())
    damaged("it names number " + std::to_string(index) + " of its " + name + ", which is not there");
  return all[index];
}

std::optional<uint64_t> GltfFile::optionalIndex(const Json& object, const char* key) {
  if (!object.is_object()) return {};
  const auto at = object.find(key);
  if (at == object.end()) return {};
  if (!at->is_number_unsigned()) damaged(std::string(key) + " is no whole number");
  return at->get<uint64_t>();
}

uint64_t GltfFile::index(const Json& object, const char* key) {
  const auto value = optionalIndex(object, key);
  if (!value) damaged(std::string(key) + " is missing");
  return *value;
}

std::string GltfFile::text(const Json& object, const char* key) {
  if (!object.is_object()) return {};
  const auto at = object.find(key);
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::vector<double> GltfFile::numbers(const Json& object, const char* key, size_t count) {
  if (!object.is_object() || !object.contains(key)) return {};
  const Json& list = object.at(key);
  if (!list.is_array() || list.size() != count)
    damaged(std::string(key) + " is no list of " + std::to_string(count) + " numbers");
  std::vector<double> values;
  for (const Json& each : list) {
    if (!each.is_number() || !std::isfinite(each.get<double>()))
      damaged(std::string(key) + " has an item that is no finite number");
    values.push_back(each.get<double>());
  }
  return values;
}

const Json& GltfFile::member(const Json& object, const char* key) {
  static const Json kNull;
  if (!object.is_object()) return kNull;
  const auto at = object.find(key);
  return at != object.end() && (at->is_object() || at->is_array()) ? *at : kNull;
}

std::vector<unsigned char> GltfFile::external(const std::string& uri) const {
  const std::string name = "its buffer " + brief(uri);
  if (uri.find("://") != std::string::npos)
    throw Error(name + " lies elsewhere; put it beside the file or export as .glb");
  const std::filesystem::path path = unescaped(uri);
  bool inside = !path.is_absolute() && !path.empty();
  for (const auto& part : path) inside = inside && part != "..";
  if (!inside) throw Error(name + " lies outside of the file's folder; put it beside the file or export as .glb");
  if (!std::filesystem::exists(folder_ / path))
    throw Error(name + " is missing; put it beside the file or export as .glb");
  try {
    return contentOf(folder_ / path, kMostBytes);
  } catch (const Error& error) {
    throw Error(name + " " + error.what());
  }
}

std::vector<unsigned char> GltfFile::image(uint64_t at) {
  const Json& object = item("images", at);
  if (const auto inside = optionalIndex(object, "bufferView")) {
    const std::span<const unsigned char> bytes = view(*inside);
    return {bytes.begin(), bytes.end()};
  }
  const std::string uri = text(object, "uri");
  if (uri.rfind("data:", 0) != 0) return external(uri);
  const size_t comma = uri.find(',');
  if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos)
    damaged("an embedded image is no base64");
  return base64(std::string_view(uri).substr(comma + 1));
}

std::span<const unsigned char> GltfFile::buffer(uint64_t at) {
  const Json& object = item("buffers", at);
  const uint64_t bytes = index(object, "byteLength");
  const std::string uri = text(object, "uri");
  std::span<const unsigned char> found;
  if (uri.empty()) {
    if (!binary_ || at != 0)
      throw Error("its buffer " + std::to_string(at) +
                  " has no data; export it without extensions that compress buffers");
    found = chunk_;
  } else {
    auto& kept = buffers_[at];
    if (!kept) {
      const size_t comma = uri.rfind("data:", 0) == 0 ? uri.find(',') : std::string::npos;
      if (comma != std::string::npos && uri.substr(0, comma).find(";base64") == std::string::npos)
        damaged("an embedded buffer is no base64");
      kept = comma == std::string::npos ? external(uri) : base64(std::string_view(uri).substr(comma + 1));
    }
    found = *kept;
  }
  if (bytes > found.size())
    damaged("its buffer " + std::to_string(at) + " has " + std::to_string(found.size()) + " bytes of the " +
            std::to_string(bytes) + " it announces");
  return found.first(bytes);
}

std::span<const unsigned char> GltfFile::view(uint64_t at) {
  const Json& object = item("bufferViews", at);
  const auto bytes = buffer(index(object, "buffer"));
  const uint64_t offset = optionalIndex(object, "byteOffset").value_or(0), length = index(object, "byteLength");
  if (offset > bytes.size() || length > bytes.size() - offset)
    damaged("buffer view " + std::to_string(at) + " reaches beyond its buffer");
  return bytes.subspan(offset, length);
}

GltfFile::Numbers GltfFile::located(uint64_t at, uint64_t offset, uint64_t count, uint64_t componentType,
                                    size_t components, bool tight) {
  const auto bytes = view(at);
  const size_t element = sizeOf(componentType) * components;
  const uint64_t stride = tight ? element : optionalIndex(item("bufferViews", at), "byteStride").value_or(element);
  if (stride < element || stride > 65536)
    damaged("buffer view " + std::to_string(at) + " has a stride of " + std::to_string(stride) + " bytes");
  if (count > kMostElements || offset > bytes.size() ||
      (count > 0 && (count - 1) * stride + element > bytes.size() - offset)) {
    damaged("an accessor reaches beyond buffer view " + std::to_string(at));
  }
  Numbers numbers;
  numbers.first_ = bytes.data() + offset;
  numbers.stride_ = size_t(stride);
  numbers.components_ = components;
  numbers.count_ = count;
  numbers.type_ = componentType;
  return numbers;
}

GltfFile::Numbers GltfFile::values(uint64_t at) {
  const Json& object = item("accessors", at);
  const std::string type = text(object, "type");
  const size_t components = type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
  if (components == 0) damaged("accessor " + std::to_string(at) + " has another type than its use asks for");
  const uint64_t count = index(object, "count"), componentType = index(object, "componentType");
  static_cast<void>(sizeOf(componentType));  // which refuses an unknown one
  if (count > kMostElements)
    damaged("accessor " + std::to_string(at) + " announces " + std::to_string(count) + " elements");
  const Json& sparse = member(object, "sparse");
  const auto view = optionalIndex(object, "bufferView");
  if (!view && sparse.is_null()) damaged("accessor " + std::to_string(at) + " has no data");
  Numbers all;
  if (view) {
    all = located(*view, optionalIndex(object, "byteOffset").value_or(0), count, componentType, components, false);
  } else {  // Zeros, where nothing changes them.
    static constexpr std::array<unsigned char, 16> kZeros = {};
    all.first_ = kZeros.data();
    all.components_ = components;
    all.count_ = count;
    all.type_ = componentType;
  }
  all.normalized_ = object.value("normalized", Json()) == Json(true);
  if (sparse.is_null()) return all;

  const Json &places = member(sparse, "indices"), &with = member(sparse, "values");
  const uint64_t changes = index(sparse, "count"), placeType = index(places, "componentType");
  if (placeType != kUnsignedByte && placeType != kUnsignedShort && placeType != kUnsignedInt)
    damaged("accessor " + std::to_string(at) + " has sparse indices of a wrong type");
  const Numbers where = located(index(places, "bufferView"), optionalIndex(places, "byteOffset").value_or(0), changes,
                                placeType, 1, true);
  const Numbers what = located(index(with, "bufferView"), optionalIndex(with, "byteOffset").value_or(0), changes,
                               componentType, components, true);
  if (!view && count / kMostZeros > changes)
    damaged("accessor " + std::to_string(at) + " announces " + std::to_string(count) + " elements");
  for (uint64_t i = 0; i < changes; ++i) {
    const uint64_t place = where.index(i);
    if (place >= count) damaged("accessor " + std::to_string(at) + " changes an element that is not there");
    all.changed_.emplace_back(place, what.first_ + i * what.stride_);
  }
  // They should rise; of several changes the last one counts.
  const auto before = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::stable_sort(all.changed_.begin(), all.changed_.end(), before);
  const auto first = std::unique(all.changed_.rbegin(), all.changed_.rend(),
                                 [](const auto& a, const auto& b) { return a.first == b.first; });
  all.changed_.erase(all.changed_.begin(), first.base());
  return all;
}

GltfFile::Numbers GltfFile::indices(uint64_t at) {
  const Json& object = item("accessors", at);
  const uint64_t count = index(object, "count"), componentType = index(object, "componentType");
  const bool whole = componentType == kUnsignedByte || componentType == kUnsignedShort || componentType == kUnsignedInt;
  if (!whole || text(object, "type") != "SCALAR")
    damaged("accessor " + std::to_string(at) + " has another type than indices have");
  if (object.contains("sparse")) throw Error("has sparse indices, which cannot be read; export it without them");
  return located(index(object, "bufferView"), optionalIndex(object, "byteOffset").value_or(0), count, componentType, 1,
                 false);
}

}  // namespace argil::io::reader
