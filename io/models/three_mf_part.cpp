// 3MF core specification 1.3, materials and properties 1.2, production 1.1: https://github.com/3MFConsortium
#include "io/models/three_mf_part.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "io/bytes/text_cursor.h"
#include "io/bytes/xml_scan.h"
#include "io/models/colour_list.h"

namespace argil::io::three_mf {

namespace {

using Colours = std::vector<Colour>;

constexpr double kFarthest = 1e30;  // of a place on a picture; what lies farther is no place

struct Unit {
  std::string_view name;
  double mm;
};
constexpr Unit kUnits[] = {{"micron", 0.001}, {"millimeter", 1}, {"centimeter", 10},
                           {"inch", 25.4},    {"foot", 304.8},   {"meter", 1000}};

struct Extension {
  std::string_view space;
  const char* name;  ///< Null: what it adds does not change the triangles.
};
constexpr Extension kExtensions[] = {
    {kCore, nullptr},
    {kMaterial, nullptr},
    {kProduction, nullptr},
    {"http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07", nullptr},
    {"http://schemas.microsoft.com/3dmanufacturing/slice/2015/07", "slices"},
    {"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02", "beam lattices"},
    {"http://schemas.microsoft.com/3dmanufacturing/securecontent/2019/04", "encrypted content"},
    {"http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01", "volumes"},
    {"http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07", "Boolean operations"},
    {"http://schemas.3mf.io/3dmanufacturing/displacement/2023/10", "displacement maps"},
};

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(' ');
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

double numberOf(const XmlScanner& xml, std::string_view text, std::string_view what) {
  double value = 0;
  if (!parseNumber(text, value) && !parseNumber(trimmed(text), value))
    xml.fail(shown(text) + " stands where " + std::string(what) + " should; a number is needed");
  if (!std::isfinite(value))
    xml.fail(std::string(what) + " is " + shown(text) + "; only finite numbers can be used, repair it");
  return value;
}

uint32_t indexOf(const XmlScanner& xml, std::string_view text, std::string_view what) {
  uint32_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && stop == text.data() + text.size()) return value;
  int64_t slowly = 0;
  if (!parseInteger(trimmed(text), slowly) || slowly < 0 || slowly > UINT32_MAX) {
    xml.fail(shown(text) + " stands where " + std::string(what) +
             " should; a whole number that is not negative is needed");
  }
  return static_cast<uint32_t>(slowly);
}

std::string_view required(const XmlScanner& xml, std::string_view name) {
  const std::string_view* value = xml.attribute(name);
  if (value == nullptr)
    xml.fail("<" + std::string(xml.name().substr(0, 40)) + "> has no " + std::string(name) + "; export it again");
  return *value;
}

Colour colourOf(const XmlScanner& xml, std::string_view text) {
  const std::string_view digits = text.substr(std::min<size_t>(text.size(), 1));
  uint32_t value = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  const bool whole = text.starts_with('#') && (digits.size() == 6 || digits.size() == 8) && error == std::errc() &&
                     stop == digits.data() + digits.size();
  if (!whole) xml.fail(shown(text) + " is no colour; write #RRGGBB or #RRGGBBAA");
  if (digits.size() == 6) value = value << 8 | 0xff;
  return {static_cast<uint8_t>(value >> 24), static_cast<uint8_t>(value >> 16), static_cast<uint8_t>(value >> 8),
          static_cast<uint8_t>(value)};
}

/// The colours of one mesh while it is read: nothing, until a triangle has a property of its own.
class CornerColours {
 public:
  explicit CornerColours(std::optional<Colour> common) : common_(common) {}
  void set(size_t triangle, const std::array<Colour, 3>& colours) {
    fill(triangle);
    corners_.push_back(colours);
  }
  void finish(ModelObject& object) {
    object.colour = common_;
    if (corners_.empty()) return;
    fill(object.mesh.triangles.size());
    setCornerColours(object, corners_);
  }

 private:
  void fill(size_t triangles) {
    const Colour plain = common_.value_or(Colour());
    if (corners_.size() < triangles) corners_.resize(triangles, {plain, plain, plain});
  }

  std::optional<Colour> common_;
  std::vector<std::array<Colour, 3>> corners_;
};

class PartReader {
 public:
  PartReader(const Input& input, const std::string& path, Losses& losses)
      : xml_(input, path), ticker_(input), losses_(losses) {
    part_.path = path;
  }

  Part read() {
    xml_.root();
    if (!xml_.is(kCore, "model")) xml_.fail("the root is no 3MF model; export it again");
    readUnit();
    checkExtensions();
    for (const size_t model = xml_.depth(); xml_.child(model);) {
      if (xml_.is(kCore, "metadata")) readMetadata();
      if (xml_.is(kCore, "resources")) readResources();
      if (xml_.is(kCore, "build")) readBuild();
    }
    xml_.finish();
    return std::move(part_);
  }

 private:
  void readUnit() {
    const std::string_view* name = xml_.attribute("unit");
    if (name == nullptr) return;
    const auto* unit =
        std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& each) { return each.name == *name; });
    if (unit == std::end(kUnits))
      xml_.fail("the unit " + shown(*name) +
                " is not known; 3MF has micron, millimeter, centimeter, inch, foot and meter");
    part_.unitMm = unit->mm;
  }

  void checkExtensions() {
    const std::string_view* list = xml_.attribute("requiredextensions");
    if (list == nullptr) return;
    for (std::string_view rest = trimmed(*list); !rest.empty();) {
      const std::string_view prefix = rest.substr(0, rest.find(' '));
      rest = trimmed(rest.substr(prefix.size()));
      const std::string_view space = xml_.spaceOf(prefix);
      const auto* known = std::find_if(std::begin(kExtensions), std::end(kExtensions),
                                       [&](const Extension& each) { return each.space == space; });
      if (known != std::end(kExtensions) && known->name == nullptr) continue;
      const std::string what = known != std::end(kExtensions) ? known->name
                                                              : "an extension of 3MF that is not known (" +
                                                                    shown(space.empty() ? prefix : space) + ")";
      xml_.fail("the model needs " + what + ", which cannot be read; export it as plain triangles");
    }
  }

  void readMetadata() {
    const std::string_view* given = xml_.attribute("name");
    if (given == nullptr) return;
    std::string name = xml_.utf8(*given);
    std::string value = xml_.text();
    if (!value.empty()) part_.metadata.emplace_back(std::move(name), std::move(value));
  }

  void readResources() {
    part_.hasResources = true;
    for (const size_t resources = xml_.depth(); xml_.child(resources);) {
      if (xml_.is(kCore, "object")) {
        readObject();
      } else if (xml_.is(kCore, "basematerials")) {
        readColours(kCore, "base", "displaycolor");
      } else if (xml_.is(kMaterial, "colorgroup")) {
        readColours(kMaterial, "color", "color");
      } else if (xml_.is(kMaterial, "texture2d")) {
        readTexture();
      } else if (xml_.is(kMaterial, "texture2dgroup")) {
        readTexturePlaces();
      } else if (xml_.space() == kMaterial) {
        const bool texture = xml_.name().starts_with("texture");
        (texture ? losses_.textures : losses_.mixtures) = true;
        if (const std::string_view* id = xml_.attribute("id"))
          unkept_.push_back(indexOf(xml_, *id, "the id of a property"));
      } else if (xml_.name() == "slicestack") {
        losses_.slices = true;
      }
    }
  }

  void readColours(std::string_view space, std::string_view element, std::string_view attribute) {
    const uint32_t id = indexOf(xml_, required(xml_, "id"), "the id of a property");
    Colours colours;
    for (const size_t group = xml_.depth(); xml_.child(group);) {
      if (xml_.is(space, element)) colours.push_back(colourOf(xml_, required(xml_, attribute)));
    }
    if (!groups_.emplace(id, std::move(colours)).second)
      xml_.fail("the id " + std::to_string(id) + " stands twice; export it again");
  }

  /// A picture that cannot be had is noted when it is looked for.
  void readTexture() {
    const uint32_t id = indexOf(xml_, required(xml_, "id"), "the id of a texture");
    Texture texture;
    if (const std::string_view* path = xml_.attribute("path")) texture.path = xml_.utf8(*path);
    // "none" leaves what lies beyond the edges to the material below, of which clay has one colour at most.
    const auto wrapOf = [&](std::string_view attribute) {
      const std::string_view* style = xml_.attribute(attribute);
      if (style == nullptr || *style == "wrap") return SurfacePicture::Wrap::repeat;
      return *style == "mirror" ? SurfacePicture::Wrap::mirror : SurfacePicture::Wrap::clamp;
    };
    texture.wrapU = wrapOf("tilestyleu"), texture.wrapV = wrapOf("tilestylev");
    textures_.emplace(id, uint32_t(part_.textures.size()));
    part_.textures.push_back(std::move(texture));
  }

  void readTexturePlaces() {
    const uint32_t id = indexOf(xml_, required(xml_, "id"), "the id of a property");
    const auto texture = textures_.find(indexOf(xml_, required(xml_, "texid"), "the id of a texture"));
    TexturePlaces group;
    if (texture == textures_.end())
      losses_.textures = true;
    else
      group.texture = texture->second;
    for (const size_t in = xml_.depth(); xml_.child(in);) {
      if (!xml_.is(kMaterial, "tex2coord")) continue;
      std::array<float, 2> place{};
      for (const size_t k : {0u, 1u}) {
        const std::string_view* text = xml_.attribute(k == 0 ? "u" : "v");
        double number = 0;
        if (text != nullptr && parseNumber(trimmed(*text), number) && std::abs(number) < kFarthest)
          place[k] = float(number);
      }
      group.places.push_back({place[0], 1 - place[1]});  // v points upwards there
    }
    unkept_.push_back(id);  // No colour of its own.
    texturePlaces_.emplace(id, std::move(group));
  }

  /// Where a triangle of these properties lies on a picture.
  std::optional<PicturePlaces> placesOf(uint32_t group, const std::array<uint32_t, 3>& properties) {
    const auto found = texturePlaces_.find(group);
    if (found == texturePlaces_.end() || found->second.texture == PicturePlaces::kNone) return std::nullopt;
    PicturePlaces places;
    places.picture = found->second.texture;
    for (size_t k = 0; k < 3; ++k) {
      if (properties[k] >= found->second.places.size()) {
        ++losses_.badColours;
        return std::nullopt;
      }
      places.corners[k] = found->second.places[properties[k]];
    }
    return places;
  }

  std::optional<Colour> property(uint32_t group, uint32_t index) {
    const auto found = groups_.find(group);
    if (found != groups_.end() && index < found->second.size()) return found->second[index];
    if (std::find(unkept_.begin(), unkept_.end(), group) == unkept_.end()) ++losses_.badColours;
    return std::nullopt;
  }

  void readObject() {
    const uint32_t id = indexOf(xml_, required(xml_, "id"), "the id of an object");
    Object object;
    if (const std::string_view* name = xml_.attribute("name")) object.content.name = xml_.utf8(*name);
    const std::string_view* type = xml_.attribute("type");
    object.printed = type == nullptr || *type == "model" || *type == "surface";
    if (!object.printed) ++losses_.supports;
    const std::string_view* pid = xml_.attribute("pid");
    std::optional<uint32_t> group;
    std::optional<Colour> colour;
    if (pid != nullptr) {
      group = indexOf(xml_, *pid, "the pid of an object");
      const std::string_view* index = xml_.attribute("pindex");
      colour = property(*group, index == nullptr ? 0 : indexOf(xml_, *index, "the pindex of an object"));
    }
    for (const size_t inObject = xml_.depth(); xml_.child(inObject);) {
      if (xml_.is(kCore, "mesh")) {
        if (!object.content.mesh.positions.empty()) xml_.fail("an object has two meshes; export it again");
        readMesh(object.content, group, colour);
      } else if (xml_.is(kCore, "components")) {
        for (const size_t components = xml_.depth(); xml_.child(components);) {
          if (xml_.is(kCore, "component")) object.components.push_back(readUse());
        }
      }
    }
    if (!object.content.mesh.triangles.empty() && !object.components.empty())
      xml_.fail("an object has a mesh and components; export it again");
    if (!part_.objects.emplace(id, std::move(object)).second)
      xml_.fail("the object " + std::to_string(id) + " stands twice; export it again");
  }

  void readMesh(ModelObject& object, std::optional<uint32_t> group, std::optional<Colour> colour) {
    CornerColours colours(colour);
    uint32_t highest = 0;
    for (const size_t mesh = xml_.depth(); xml_.child(mesh);) {
      if (xml_.is(kCore, "vertices")) {
        for (const size_t vertices = xml_.depth(); xml_.child(vertices);) {
          if (xml_.is(kCore, "vertex")) readVertex(object.mesh);
        }
      } else if (xml_.is(kCore, "triangles")) {
        for (const size_t triangles = xml_.depth(); xml_.child(triangles);) {
          if (xml_.is(kCore, "triangle")) highest = std::max(highest, readTriangle(object, group, colour, colours));
        }
      } else if (xml_.name() == "beamlattice") {
        losses_.beams = true;
      }
    }
    if (!object.mesh.triangles.empty() && highest >= object.mesh.positions.size()) {
      xml_.fail("a triangle names vertex " + std::to_string(highest) + " and the mesh has " +
                std::to_string(object.mesh.positions.size()) + "; repair it or export it again");
    }
    if (!object.places.empty()) object.places.resize(object.mesh.triangles.size());
    colours.finish(object);
  }

  void readVertex(clay::TriangleMesh& mesh) {
    Vec3d p;
    unsigned seen = 0;
    for (const XmlScanner::Attribute& each : xml_.attributes()) {
      if (each.name.size() != 1 || !each.space.empty()) continue;
      const int axis = each.name[0] - 'x';
      if (axis < 0 || axis > 2) continue;
      p[axis] = numberOf(xml_, each.value, "a coordinate");
      seen |= 1u << axis;
    }
    if (seen != 7) xml_.fail("a vertex has no x, y and z; repair it or export it again");
    if (mesh.positions.size() >= UINT32_MAX) xml_.fail("there are too many vertices; reduce the model first");
    mesh.positions.push_back(p);
    ticker_.at(xml_.offset());
  }

  uint32_t readTriangle(ModelObject& object, std::optional<uint32_t> group, std::optional<Colour> colour,
                        CornerColours& colours) {
    clay::TriangleMesh& mesh = object.mesh;
    std::array<uint32_t, 3> corners{}, properties{};
    unsigned seen = 0, seenProperties = 0;
    for (const XmlScanner::Attribute& each : xml_.attributes()) {
      if (!each.space.empty()) continue;
      const char kind = each.name[0];
      const auto corner = static_cast<size_t>(each.name.size() == 2 ? each.name[1] - '1' : 3);
      if (corner < 3 && kind == 'v') {
        corners[corner] = indexOf(xml_, each.value, "an index of a vertex");
        seen |= 1u << corner;
      } else if (corner < 3 && kind == 'p') {
        properties[corner] = indexOf(xml_, each.value, "an index of a property");
        seenProperties |= 1u << corner;
      } else if (each.name == "pid") {
        group = indexOf(xml_, each.value, "the pid of a triangle");
      }
    }
    if (seen != 7) xml_.fail("a triangle has no v1, v2 and v3; repair it or export it again");
    if (group && (seenProperties & 1)) {
      std::array<std::optional<Colour>, 3> found;
      for (size_t c = 0; c < 3; ++c) {
        // p2 and p3 stand together or not at all.
        const bool own = c == 0 || ((seenProperties & 6) == 6 && properties[c] != properties[0]);
        found[c] = own ? property(*group, properties[c]) : found[0];
      }
      const Colour other = colour.value_or(Colour());
      if (found[0] || found[1] || found[2])
        colours.set(mesh.triangles.size(),
                    {found[0].value_or(other), found[1].value_or(other), found[2].value_or(other)});
      const bool apart = (seenProperties & 6) == 6;
      if (const auto places =
              placesOf(*group, apart ? properties : std::array{properties[0], properties[0], properties[0]})) {
        object.places.resize(mesh.triangles.size());
        object.places.push_back(*places);
      }
    }
    mesh.triangles.push_back(corners);
    ticker_.at(xml_.offset());
    return std::max({corners[0], corners[1], corners[2]});
  }

  Use readUse() {
    Use use;
    use.object = indexOf(xml_, required(xml_, "objectid"), "the id of an object");
    if (const std::string_view* path = xml_.attribute("path", kProduction)) use.path = xml_.utf8(*path);
    if (const std::string_view* text = xml_.attribute("transform")) {
      std::string_view rest = trimmed(*text);
      for (double& number : use.transform.m) {
        const std::string_view word = rest.substr(0, rest.find(' '));
        number = numberOf(xml_, word, "a number of a transform");
        rest = trimmed(rest.substr(word.size()));
      }
      if (!rest.empty()) xml_.fail("a transform has more than 12 numbers; repair it or export it again");
    }
    return use;
  }

  void readBuild() {
    part_.hasBuild = true;
    for (const size_t build = xml_.depth(); xml_.child(build);) {
      if (xml_.is(kCore, "item")) part_.items.push_back(readUse());
    }
  }

  XmlScanner xml_;
  Ticker ticker_;
  Losses& losses_;
  Part part_;
  std::map<uint32_t, Colours> groups_;
  struct TexturePlaces {
    uint32_t texture = PicturePlaces::kNone;   ///< In Part::textures; kNone: the file does not have it.
    std::vector<std::array<float, 2>> places;  ///< u and v, v from the top down.
  };
  std::map<uint32_t, uint32_t> textures_;  ///< By ids: in Part::textures.
  std::map<uint32_t, TexturePlaces> texturePlaces_;
  std::vector<uint32_t> unkept_;  ///< Groups of properties that are no colours.
};

}  // namespace

Vec3d Transform::operator()(const Vec3d& p) const {
  const auto part = [&](size_t k) { return p.x() * m[k] + p.y() * m[3 + k] + p.z() * m[6 + k] + m[9 + k]; };
  return {part(0), part(1), part(2)};
}

Transform Transform::then(const Transform& next) const {
  Transform result;
  for (size_t row = 0; row < 4; ++row) {
    for (size_t k = 0; k < 3; ++k) {
      double sum = row == 3 ? next.m[9 + k] : 0;
      for (size_t i = 0; i < 3; ++i) sum += m[3 * row + i] * next.m[3 * i + k];
      result.m[3 * row + k] = sum;
    }
  }
  return result;
}

bool Transform::mirrors() const {
  const auto row = [&](size_t r) { return Vec3d(m[3 * r], m[3 * r + 1], m[3 * r + 2]); };
  return row(0).dot(row(1).cross(row(2))) < 0;
}

std::vector<std::string> Losses::sentences() const {
  std::vector<std::string> all;
  const auto amount = [](uint64_t n, const char* one, const char* many) {
    return std::to_string(n) + (n == 1 ? one : many);
  };
  if (textures) all.emplace_back("some textures were not kept; colours of materials were");
  if (mixtures) all.emplace_back("mixtures of materials were not kept");
  if (badColours > 0)
    all.push_back(amount(badColours, " colour is", " colours are") +
                  " named that the file does not have; they were left out");
  if (supports > 0)
    all.push_back(amount(supports, " object is", " objects are") + " no model (support and the like) and not kept");
  if (beams) all.emplace_back("beam lattices were not kept");
  if (slices) all.emplace_back("slices were not kept");
  return all;
}

Part readPart(const Input& input, const std::string& path, Losses& losses) {
  return PartReader(input, path, losses).read();
}

}  // namespace argil::io::three_mf
