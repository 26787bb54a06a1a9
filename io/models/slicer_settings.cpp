#include "io/models/slicer_settings.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "io/bytes/xml_scan.h"

namespace argil::io {

namespace {

constexpr const char* kPrusa = "Metadata/Slic3r_PE_model.config";
constexpr const char* kBambu = "Metadata/model_settings.config";

// What a slicer calls a volume; one that it names and we do not know is taken for a solid.
struct KindName {
  std::string_view name;
  VolumeKind kind;
};
constexpr KindName kKinds[] = {
    {"ModelPart", VolumeKind::solid},
    {"NegativeVolume", VolumeKind::negative},
    {"ParameterModifier", VolumeKind::modifier},
    {"SupportBlocker", VolumeKind::support},
    {"SupportEnforcer", VolumeKind::support},
    {"normal_part", VolumeKind::solid},
    {"negative_part", VolumeKind::negative},
    {"modifier_part", VolumeKind::modifier},
    {"support_blocker", VolumeKind::support},
    {"support_enforcer", VolumeKind::support},
};

VolumeKind kindOf(std::string_view name) {
  const auto* row =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const KindName& each) { return each.name == name; });
  return row == std::end(kKinds) ? VolumeKind::solid : row->kind;
}

std::optional<uint64_t> number(const XmlScanner& xml, std::string_view attribute) {
  const std::string_view* text = xml.attribute(attribute);
  uint64_t value = 0;
  if (text == nullptr ||
      std::from_chars(text->data(), text->data() + text->size(), value).ptr != text->data() + text->size() ||
      value > UINT32_MAX)
    return {};
  return value;
}

// key and value of a <metadata>.
std::pair<std::string, std::string> metadata(const XmlScanner& xml) {
  const std::string_view *key = xml.attribute("key"), *value = xml.attribute("value");
  return key == nullptr || value == nullptr ? std::pair<std::string, std::string>()
                                            : std::pair(xml.utf8(*key), xml.utf8(*value));
}

void readVolume(XmlScanner& xml, std::vector<SlicerVolume>& volumes) {
  const auto first = number(xml, "firstid"), last = number(xml, "lastid");
  if (!first || !last || *last < *first) xml.fail("a volume names no triangles");
  SlicerVolume volume{*first, *last, VolumeKind::solid, {}};
  for (const size_t depth = xml.depth(); xml.child(depth);) {
    if (!xml.is({}, "metadata")) continue;
    const auto [key, value] = metadata(xml);
    if (key == "name") volume.name = value;
    if (key == "volume_type") volume.kind = kindOf(value);
    if (key == "modifier" && value == "1" && volume.kind == VolumeKind::solid)
      volume.kind = VolumeKind::modifier;  // Before there were types.
  }
  volumes.push_back(std::move(volume));
}

void readPart(XmlScanner& xml, uint32_t object, SlicerSettings& settings) {
  const auto id = number(xml, "id");
  if (!id) xml.fail("a part has no id");
  SlicerPart part;
  if (const std::string_view* kind = xml.attribute("subtype")) part.kind = kindOf(*kind);
  for (const size_t depth = xml.depth(); xml.child(depth);) {
    if (!xml.is({}, "metadata")) continue;
    if (const auto [key, value] = metadata(xml); key == "name") part.name = value;
  }
  settings.parts[{object, uint32_t(*id)}] = std::move(part);
}

void readConfig(ZipReader& zip, const Input& input, const char* path, SlicerSettings& settings) {
  const ZipReader::Part* found = zip.find(path);
  if (found == nullptr) return;
  const FileBytes bytes = zip.read(*found);
  const Input text{bytes.bytes(), input.name, input.job};
  XmlScanner xml(text, path);
  xml.root();
  for (const size_t root = xml.depth(); xml.child(root);) {
    if (!xml.is({}, "object")) continue;
    const auto id = number(xml, "id");
    if (!id) xml.fail("an object has no id");
    const auto object = uint32_t(*id);
    for (const size_t depth = xml.depth(); xml.child(depth);) {
      if (xml.is({}, "metadata")) {
        if (const auto [key, value] = metadata(xml); key == "name") settings.names[object] = value;
      } else if (xml.is({}, "volume")) {
        readVolume(xml, settings.volumes[object]);
      } else if (xml.is({}, "part")) {
        readPart(xml, object, settings);
      }
    }
  }
  xml.finish();
}

}  // namespace

SlicerSettings readSlicerSettings(ZipReader& zip, const Input& input) {
  SlicerSettings settings;
  try {
    readConfig(zip, input, kPrusa, settings);
    readConfig(zip, input, kBambu, settings);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    settings = {};
    settings.trouble =
        std::string("what the slicer says of its volumes could not be read, all came in as solid (") + e.what() + ")";
  }
  return settings;
}

}  // namespace argil::io
